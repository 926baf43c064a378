"""Limits of joints in uncoupled parts are the least of their parts', in whatever units each part is."""

from dataclasses import replace

import numpy as np
import pytest
from bounds.energy.joints import space_joint, strong_joint
from hostile.laws import other_labels
from uncoupled_parts import joined, pair, with_mean

import shakedown
from benchmarks.problems import in_units
from shakedown.bounds.coupling import difference_gauge
from shakedown.joint.contact_zone import coupled_parts

LIMITS = {
    "λ_U": shakedown.universal_bound,
    "λ_E": lambda problem: shakedown.energy_bound(problem, certify=False),
    "λ_max": lambda problem: shakedown.upper_bound(problem, certify=False),
}


def limit(name, problem):
    """A limit; below zero where nothing is proved, or no slip is safe."""
    return np.nan_to_num(LIMITS[name](problem).load_factor, nan=-1.0)


@pytest.mark.parametrize("name", LIMITS)
@pytest.mark.parametrize(
    ("kind", "number", "decades"),
    [("plane", 9, 0), ("plane", 15, 3), ("plane", 26, 3), ("space", 14, 3), ("space", 15, 0), ("space", 20, 3)],
)  # fmt: skip
def test_a_limit_is_the_least_of_the_parts(name, kind, number, decades):
    parts = pair(kind, number, decades)
    assert limit(name, joined(parts)) == pytest.approx(min(limit(name, part) for part in parts), rel=1e-9)


@pytest.mark.parametrize("decades", [-4, 0, 4])
def test_units_of_one_part_change_no_limit_of_the_joint(decades):
    """Two like joints, one of them in other lengths: from every state, too, it is the limit of the weaker."""
    joint = with_mean(shakedown.example("three-node"))
    whole = joined([replace(joint, f=joint.f * (1 + 1e-10)), in_units(joint, 1.0, 10.0**decades)])
    for name in LIMITS:
        assert limit(name, whole) == pytest.approx(limit(name, joint), rel=1e-9)
    lower, alone = (shakedown.lower_bound(each) for each in (whole, joint))
    assert lower.load_factor == pytest.approx(alone.load_factor, rel=1e-13)
    assert (lower.node, lower.guarantee) == (joint.n + alone.node, alone.guarantee)
    total, own = (shakedown.accumulated_bound(each).load_factor for each in (whole, joint))
    assert total == pytest.approx(own, rel=1e-6)


@pytest.mark.parametrize(
    "joint",
    [strong_joint(0, 4), strong_joint(6, 4, floating=True), space_joint(0, 3), space_joint(1, 3, floating=True)],
)  # fmt: skip
def test_units_of_each_node_change_no_limit(joint):
    sizes = 2.0 ** (7 * np.arange(joint.n) - 9)
    other = in_units(joint, 1.0 / sizes, sizes)
    for name in LIMITS:
        assert limit(name, other) == pytest.approx(limit(name, joint), rel=1e-8)
    if joint.directions == 1:
        lower, there = (shakedown.lower_bound(each) for each in (joint, other))
        assert there.load_factor == pytest.approx(lower.load_factor, rel=1e-9)
        assert (there.guarantee, difference_gauge(other)) == (lower.guarantee, difference_gauge(joint))


@pytest.mark.parametrize(("kind", "number"), [("plane", 15), ("plane", 17), ("space", 14), ("space", 15)])
def test_couplings_of_round_off_are_none(kind, number):
    """Of nodes in any order, in parts of different units: no limit nor friction threshold depends on them."""
    whole, rng = joined(pair(kind, number, 4)), np.random.default_rng(number)
    whole = other_labels(whole, rng)
    slips = np.sqrt(np.diag(whole.A))  # in units of which the stiffness of each is one
    gaps = slips[:: whole.directions] if whole.C is None else np.sqrt(np.diag(whole.C))

    def noisy(matrix, rows, columns):
        noise = 1e-15 * rng.uniform(-1.0, 1.0, matrix.shape) * np.outer(rows, columns)
        return matrix + noise * (matrix == 0.0)

    A, C = noisy(whole.A, slips, slips), None if whole.C is None else noisy(whole.C, gaps, gaps)
    C = None if C is None else (C + C.T) / 2
    found = replace(whole, A=(A + A.T) / 2, B=noisy(whole.B, gaps, slips), C=C)
    parts, known = ([part.nodes.tolist() for part in coupled_parts(each)] for each in (found, whole))
    assert parts == known
    for name in LIMITS:
        assert limit(name, found) == pytest.approx(limit(name, whole), rel=1e-9)
    if kind == "plane":
        one, other = (shakedown.friction_thresholds(joint).wedging for joint in (found, whole))
        assert one.high == pytest.approx(other.high, rel=1e-9)


def test_what_is_said_of_a_node_names_it_in_the_whole_joint():
    parts = [with_mean(shakedown.example(name), normal=False) for name in ("three-node", "pair-cycle")]
    parts = [with_mean(part, min(each.m for each in parts)) for part in parts]
    alone = [shakedown.universal_bound(part) for part in parts]
    least = int(np.argmin([each.load_factor for each in alone]))
    found, first = shakedown.universal_bound(joined(parts)), 3 * least
    assert found.node == alone[least].node + first
    assert f"node {found.node}" in found.reason
    of_parts, whole = shakedown.energy_bound(parts[least]), shakedown.energy_bound(joined(parts))
    assert {node for node, _ in whole.active} <= set(range(joined(parts).n))
    assert whole.certified is not None
    assert whole.certified == pytest.approx(whole.load_factor)
    assert len(of_parts.parts) == 0
