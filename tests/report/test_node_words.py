"""Nodes by their labels, zeros without round-off, and where the nominal load lies."""

import dataclasses

import numpy as np
import pytest

import shakedown
from shakedown.bounds.accumulated.accumulated_bound import total_slip_bound
from shakedown.joint.loading import loading
from shakedown.report.bound_words import bounds_in_words
from shakedown.report.node_words import (
    bound_columns,
    label_column,
    node_in_words,
    open_in_words,
    slipping_nodes,
    total_slip_in_words,
)

NAMED = dataclasses.replace(shakedown.example("two-node"), label=["4711/12", "4712/13"], units="N, mm")


def said(problem) -> str:
    return " ".join(bounds_in_words(shakedown.assess(problem, open_nodes=()).details))


def test_a_node_is_called_the_same_everywhere():
    assert node_in_words(NAMED, 1) == "node 1 (FE 4712/13)"
    assert "where node 1 (FE 4712/13) has lost its range of safe slips" in said(NAMED)
    assert open_in_words((0, 1), NAMED) == "nodes 0, 1 (FE 4711/12, 4712/13)"
    assert open_in_words(tuple(range(9)), shakedown.example("press-fit")) == "nodes 0–8"
    assert label_column(NAMED) == {"FE": ["4711/12", "4712/13"]}


@pytest.mark.parametrize("name", ["block-9", "receding-block", "one-node-3d", "four-node-3d"])
def test_columns_of_the_bounds_name_the_limits_that_are_reached(name):
    joint = shakedown.example(name)
    upper = shakedown.upper_bound(joint, open_nodes="auto")
    *slips, reached = bound_columns(joint, upper, str).values()
    shown = np.array([[float(text) for text in column] for column in slips])
    np.testing.assert_array_equal(shown.T, joint.layout.by_node(upper.slip))
    named = {node for node, text in enumerate(reached) if text != "nan"}
    assert named == {node for node, _ in upper.active} | set(upper.open_nodes)


def test_round_off_is_no_slip():
    assert slipping_nodes(np.array([1e-16, 0.0])) == (0,)  # alone it is all there is
    assert slipping_nodes(np.array([1e-16, 1.0])) == (1,)
    assert slipping_nodes(np.zeros(2)) == ()


def test_a_constant_load_has_no_load_factor_to_speak_of():
    text = said(shakedown.example("jump"))
    assert "the load factor makes no difference" in text
    for contradiction in (
        "no load factor is safe",
        "any load factor is safe",
        "lies between",
        "from the safe slip",
    ):
        assert contradiction not in text


def scaled(factor: float):
    """The two-node system with its periodic part multiplied: λ = 1 moves along the bounds."""
    joint, loop = shakedown.example("two-node"), loading(shakedown.example("two-node"))
    q, p = loop.at(factor)
    return dataclasses.replace(joint, q_w=q, p_w=p, q_mean=loop.q0, p_mean=loop.p0)


@pytest.mark.parametrize(
    ("factor", "words"),
    [
        (
            0.5,
            "lies below λ_U: proved from every initial state with all nodes in contact and within their friction limits.",
        ),
        (0.7, "lies between λ_1 and λ_max; starting without slip the joint is proved to shake down there."),
        (0.735, "lies between λ_1 and λ_max; starting without slip no bound proves shakedown there."),
        (0.8, "lies at or above λ_max."),
    ],
)
def test_the_loading_as_given_lies_where_it_lies(factor, words):
    assert words in said(scaled(factor))


def test_where_only_the_energy_proves_the_loading_as_given_it_is_said_so():
    words = (
        "lies between λ_U and λ_1, and below λ_E: starting without slip the joint is proved to shake down."
    )
    near = shakedown.assess(shakedown.example("three-node"), distance=0.01)  # no other bound is about a ball
    assert words in " ".join(bounds_in_words(near.details))


def test_an_unlimited_upper_bound_is_no_end_of_an_interval():
    text = said(shakedown.example("one-node-separation"))
    assert "Above λ_1 the slip that is locked in when the transient is over decides: from a safe slip" in text
    assert "Between λ_1 and λ_max" not in text


def test_how_far_no_node_will_ever_slip_is_said_where_it_is_proved():
    joint = shakedown.example("two-node")
    below, above = (shakedown.node_results(shakedown.long_term_state(joint, x)) for x in (0.7, 0.9))
    bound = total_slip_bound(joint, 0.7).total_slip
    assert np.array_equal(below.total_slip_bound, bound)
    said = total_slip_in_words(below, joint)
    assert said.startswith("Proved: at λ = 0.7, from this initial state on, no node ever slips more than ")
    assert float(said.partition("more than ")[2].split()[0]) >= bound.max()
    assert np.isnan(above.total_slip_bound).all()
    assert total_slip_in_words(above, joint) == ""
