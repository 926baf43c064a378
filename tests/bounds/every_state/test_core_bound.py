"""What is proved away from the edges, against motions in which these rest or slip."""

import re
from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown.bounds.every_state.admissible_states import StateProgram, admissible_states
from shakedown.bounds.every_state.core_bound import core_bound, edge_distances
from shakedown.bounds.every_state.universal_bound import universal_bound
from shakedown.ground.errors import Missing
from shakedown.ground.shown_values import down
from shakedown.report.assessment_words import certain_in_words, numbers_in_words


def test_off_the_edges_forward_and_backward_slip_are_apart_below_it():
    """Against linear programs in the states themselves."""
    problem = shakedown.example("block-33")
    found = core_bound(problem, universal_bound(problem))
    program = StateProgram(admissible_states(problem))
    program.set_load_factors(0.999 * found.load_factor, 0.999 * found.load_factor)
    apart = np.array([program.swing(i, problem.A[i]).apart(1e-9) for i in range(problem.n)])
    assert np.flatnonzero(~apart).tolist() == list(found.near_edge)


def test_in_space_it_is_what_the_inner_nodes_would_go_by_themselves():
    problem = replace(shakedown.example("block-3x3"), x=np.argwhere(np.ones((3, 3))).astype(float))
    every = universal_bound(problem)
    found = core_bound(problem, every)
    assert len(found.near_edge) == 8
    assert found.load_factor == every.pressures.of_nodes[4] > every.load_factor
    assert every.pressures.of_nodes.min() == pytest.approx(every.load_factor)
    heavy = replace(problem, p_w=problem.p_w * np.where(np.arange(9) == 0, 0.01, 1.0))
    lifted = universal_bound(heavy)
    assert lifted.load_factor == 0.0
    assert core_bound(heavy, lifted).load_factor > 0.0


def test_of_a_floating_body_it_exceeds_what_its_edge_allows():
    problem = shakedown.example("bolted-flange")
    every = universal_bound(problem)
    found = core_bound(problem, every)
    assert every.node in found.near_edge
    assert found.load_factor > every.load_factor
    assert shakedown.assess(problem).details.core is None  # more than λ_max counts as λ_max


def test_nothing_is_said_without_places_or_edges():
    problem = shakedown.example("block-33")
    every = universal_bound(problem)
    for other in (replace(problem, x=None, coordinates=None), problem):
        inner = replace(every, node=16)
        assert isinstance(core_bound(other, inner), Missing)


def test_distances_from_the_edges():
    grid = np.argwhere(np.ones((5, 3))).astype(float)
    turned = (
        np.column_stack([grid, np.zeros(15)]) @ np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    )
    expected = np.minimum(np.minimum(grid[:, 0], 4 - grid[:, 0]), np.minimum(grid[:, 1], 2 - grid[:, 1]))
    for places in (grid, turned):
        np.testing.assert_allclose(edge_distances(places), expected, atol=1e-12)
    np.testing.assert_allclose(
        edge_distances(np.outer(np.arange(4.0), [1.0, 1.0])), np.sqrt(2) * np.array([0, 1, 1, 0])
    )


def test_holes_and_notches_have_edges_too():
    x, y = np.argwhere(np.ones((13, 13))).T
    for left_out in ((abs(x - 6) < 3) & (abs(y - 6) < 4), (x > 6) & (y > 6)):
        grid, out = np.column_stack([x, 0.5 * y]), np.column_stack([x, 0.5 * y])[left_out]
        found = edge_distances(grid[~left_out].astype(float))
        to_outer = edge_distances(grid.astype(float))[~left_out]
        to_inner = np.linalg.norm(grid[~left_out][:, None] - out, axis=2).min(axis=1)
        assert (found <= to_outer + 1e-12).all()
        assert found[to_inner <= 0.5].max() < 1e-12  # the rim itself
        assert found[to_inner > 4.0] == pytest.approx(to_outer[to_inner > 4.0])
    angle, radius = (
        each.ravel() for each in np.meshgrid(np.arange(48) * np.pi / 24, np.linspace(3.0, 5.0, 9))
    )
    ring = radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    np.testing.assert_allclose(edge_distances(ring), np.minimum(radius - 3.0, 5.0 - radius), atol=0.05)


def test_what_an_engineer_is_told():
    found = shakedown.assess(shakedown.example("block-33"))
    assert numbers_in_words(found)[0][1:] == (
        "nothing proved",
        "while all nodes stay in contact; 2.816 if edge nodes do not slip",
    )
    told = certain_in_words(found.details)[1]
    assert "λ_U is determined at an edge of the contact, by node 0" in told
    proved = down(max(found.details.energy.load_factor, found.details.accumulated.load_factor))
    assert re.search(f"since assembly, shakedown is proved up to λ_[ES] = {proved}", told)
    assert (
        "below λ = 2.816 no slip goes on while the 4 nodes nearer than 0.1875 mm to an edge do not slip"
        in told
    )
