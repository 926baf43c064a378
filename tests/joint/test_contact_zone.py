"""Zones, what is left of a joint where nodes are open; the parts that a joint falls into; initial gaps."""

import dataclasses
from dataclasses import replace

import numpy as np
import pytest
from difficult_joints import floating_block
from joints import free_pair
from joints_in_space import random_joint
from scipy.linalg import block_diag

import shakedown
from benchmarks.drawn_joints import drawn_joint_in_space
from shakedown import Problem, ProblemError, UsageError
from shakedown.joint.constraints import constraints, first_load, loading, ramp_start, with_initial_gap
from shakedown.joint.contact_zone import contact_zone, coupled_parts, of_nodes, of_slips
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.joint.units import without_loads

BLOCK = without_loads(shakedown.example("block-9"))
OPEN = (0, 3, 8)
MEANS = {"q_mean": 0.3 * BLOCK.q_w[0], "p_mean": 0.7 * BLOCK.p_w[1]}
JOINTS = BLOCK, replace(BLOCK, **MEANS), random_joint(np.random.default_rng(2), 9)


def reactions(problem, u, load_factor):
    q_w, p_w = loading(problem).at(load_factor)
    return problem.layout.split(np.hstack([q_w, p_w]) + u @ problem.kappa)


@pytest.mark.parametrize("problem", JOINTS)
def test_open_nodes_carry_nothing_and_closed_ones_feel_the_condensed_joint(problem):
    zone, closed = contact_zone(problem, OPEN), np.setdiff1d(np.arange(problem.n), OPEN)
    slip = np.random.default_rng(0).normal(size=zone.joint.layout.slip_size) * 1e-3
    q, p = reactions(problem, zone.displacements(slip, *loading(problem).at(0.7)), 0.7)
    size = max(np.abs(q).max(), np.abs(p).max())
    assert np.abs(q[:, problem.layout.slips_of(OPEN)]).max() < 1e-13 * size
    assert np.abs(p[:, OPEN]).max() < 1e-13 * size
    kept_q, kept_p = loading(zone.joint).at(0.7)
    q_closed = q[:, problem.layout.slips_of(closed)]
    assert kept_q + slip @ zone.joint.A == pytest.approx(q_closed, abs=1e-13 * size)
    assert kept_p + slip @ zone.joint.B.T == pytest.approx(p[:, closed], abs=1e-13 * size)


@pytest.mark.parametrize("problem", JOINTS)
def test_open_nodes_follow_every_change_of_slip(problem):
    zone = contact_zone(problem, OPEN)
    slip, *changes = np.random.default_rng(3).normal(size=(4, zone.joint.layout.slip_size)) * 1e-3
    moved = [zone.slips(slip + change) - zone.slips(slip) for change in changes]
    for found in (zone.follow(np.array(changes)), [zone.follow(change) for change in changes]):
        np.testing.assert_allclose(found, moved, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("problem", JOINTS)
def test_rows_of_open_nodes_are_their_gaps_and_the_others_are_limits(problem):
    zone, rng = contact_zone(problem, OPEN), np.random.default_rng(1)
    rows, slip = zone.constraints, rng.normal(size=zone.joint.layout.slip_size) * 1e-3
    assert rows.node[rows.heads][-3:].tolist() == [*OPEN]
    assert set(rows.node[rows.heads][:-3]) == set(zone.closed_nodes)
    assert rows.side[rows.heads][-3:].tolist() == [0, 0, 0]
    gaps = zone.displacements(slip, *loading(problem).at(0.7))[:, problem.layout.gaps_of(OPEN)]
    assert rows.excess(slip, 0.7)[-3:] == pytest.approx(-gaps.min(axis=0), rel=1e-12)
    assert gaps.argmin(axis=0).tolist() == rows.step[rows.heads][-3:].tolist()


def test_a_zone_without_open_nodes_is_the_joint():
    zone = contact_zone(BLOCK, ())
    assert zone.joint is BLOCK
    assert np.array_equal(zone.constraints.G, constraints(BLOCK).G)


@pytest.mark.parametrize("problem", JOINTS)
@pytest.mark.parametrize("gap", [0.0, 1e-3])
def test_the_load_rises_from_where_friction_bears_nothing_and_pressures_are_as_large(problem, gap):
    start, first = np.random.default_rng(4).normal(size=problem.layout.size) * 1e-3, first_load(problem, 0.7)
    start[problem.layout.gaps] *= gap
    q, p = problem.layout.split(ramp_start(problem, first, start) + start @ problem.kappa)
    pressed = (first + start @ problem.kappa)[problem.layout.gaps]
    np.testing.assert_allclose(q, 0.0, atol=1e-13 * np.abs(first).max())
    np.testing.assert_allclose(p, np.abs(pressed), atol=1e-13 * np.abs(pressed).max())


@pytest.mark.parametrize(("nodes", "message"), [([9], "0 to 8, found 9"), (range(9), "found all 9 open")])
def test_wrong_nodes_are_refused(nodes, message):
    with pytest.raises(UsageError, match=message):
        contact_zone(BLOCK, nodes)


def test_what_the_body_does_not_hold_cannot_be_open():
    free = free_pair([0.0], C=np.zeros((2, 2)))
    rods = [replace(free, A=np.eye(2), B=np.diag([0, s]), C=np.diag([1, s**2])) for s in (0.3, 0.5, 0.7)]
    for joint in (free, *rods):  # a rod holds a node along itself alone
        with pytest.raises(UsageError, match="the body holds when open, found 1 free to move"):
            contact_zone(joint, [1])
    with pytest.raises(ProblemError, match="key 'C'"):
        contact_zone(replace(free, C=None), [1])


def test_open_nodes_that_the_body_holds_may_have_units_of_their_own():
    sizes = np.diag([1.0, 1e10, 1.0])
    joint = Problem(A=sizes, B=0.1 * sizes, C=sizes, f=0.5, q_w=np.zeros((1, 3)), p_w=np.ones((1, 3)))
    zone = contact_zone(joint, [0, 1])
    assert (zone.joint.n, zone.joint.A.tolist()) == (1, [[1.0]])


def test_what_a_spring_between_two_nodes_leaves_of_one_is_nothing_not_round_off():
    spring, along = np.array([[20.0, 4.0], [4.0, 30.0]]) / 3, [[1.0, -1.0], [-1.0, 1.0]]
    A, B, C = (stiffness * np.array(along) for stiffness in (spring[0, 0], spring[1, 0], spring[1, 1]))
    joint = Problem(A=A, B=B, C=C, f=0.3, q_w=[[1, 1], [-1, -1]], p_w=[[-1, -1], [-1, -1]])
    assert not contact_zone(joint, [1]).joint.kappa.any()
    assert shakedown.assess(joint).as_given.value == "undecided"


def test_an_initial_gap_is_a_displacement_of_the_welded_state():
    gap = np.linspace(-1e-3, 2e-3, 9)
    shifted = with_initial_gap(BLOCK, gap)
    v, w = np.random.default_rng(2).normal(size=(2, 9)) * 1e-3
    before = np.hstack(reactions(BLOCK, np.concatenate([v, w - gap]), 1.0))
    after = np.hstack(reactions(shifted, np.concatenate([v, w]), 1.0))
    assert after == pytest.approx(before, abs=1e-12 * np.abs(before).max())
    assert loading(shifted).q1 == pytest.approx(loading(BLOCK).q1, abs=1e-12 * np.abs(BLOCK.q_w).max())
    with pytest.raises(UsageError, match=r"one number or shape \(9,\), found \(2,\)"):
        with_initial_gap(BLOCK, [1.0, 2.0])


@pytest.mark.parametrize("closed", range(5))
def test_of_a_floating_block_one_closed_node_holds_no_open_one_whatever_round_off_says(closed):
    """Rotations about it meet 1e-12 of the stiffness."""
    joint = floating_block(5, 0.5)
    noise = np.random.default_rng(0).uniform(-1e-12, 1e-12, (5, 5))
    A, C = (stiffness * (1 + noise + noise.T) for stiffness in (joint.A, joint.C))
    with pytest.raises(UsageError, match="free to move"):
        contact_zone(replace(joint, A=A, B=joint.B * (1 + noise), C=C), set(range(5)) - {closed})
    with pytest.raises(UsageError, match="found 0, 1, 2, 3, 4, 5, 6, 7 free to move"):
        contact_zone(floating_block(12, 0.5), range(11))


LOOP = {"f": 0.5, "q_w": np.ones((2, 3)), "p_w": np.ones((2, 3))}


@pytest.mark.parametrize("size", [1e-20, 1.0, 1e20])
@pytest.mark.parametrize("which", ["A", "B", "C"])
def test_one_entry_of_any_block_couples_unless_it_is_round_off(which, size):
    blocks = {"A": 2.0 * size * np.eye(3), "B": np.zeros((3, 3)), "C": 2.0 * size * np.eye(3)}
    blocks[which] += 1e-17 * size * np.ones((3, 3))
    apart = shakedown.Problem(**blocks, **LOOP)
    assert [part.nodes.tolist() for part in coupled_parts(apart)] == [[0], [1], [2]]
    blocks[which][2, 0] = 0.5 * size
    if which != "B":
        blocks[which][0, 2] = 0.5 * size
    found = coupled_parts(shakedown.Problem(**blocks, **LOOP))
    assert [part.nodes.tolist() for part in found] == [[0, 2], [1]]


def test_a_part_has_all_that_belongs_to_its_nodes():
    """Nodes in any order in the whole joint: two joints in space shuffled into each other, and taken out again."""
    two = [shakedown.example("two-node-3d"), shakedown.example("four-node-3d")]
    m, n = min(each.m for each in two), sum(each.n for each in two)
    two = [
        shakedown.Problem(
            A=each.A, B=each.B, f=each.f, q_w=each.q_w[:m], p_w=each.p_w[:m], q_mean=each.q_w[0], p_mean=each.p_w[0],
            initial_slip=np.arange(2.0 * each.n), label=[f"{each.name} {k}" for k in range(each.n)],
        )
        for each in two
    ]  # fmt: skip
    order = np.random.default_rng(1).permutation(n)
    slips = np.stack([2 * order, 2 * order + 1], axis=1).ravel()

    def joined(key, places):
        return np.concatenate([getattr(each, key) for each in two], axis=-1)[..., places]

    whole = shakedown.Problem(
        A=block_diag(*[each.A for each in two])[np.ix_(slips, slips)],
        B=block_diag(*[each.B for each in two])[np.ix_(order, slips)],
        label=[[*two[0].label, *two[1].label][k] for k in order],
        **{key: joined(key, slips) for key in ("q_w", "q_mean", "initial_slip")},
        **{key: joined(key, order) for key in ("f", "p_w", "p_mean")},
    )
    parts = coupled_parts(whole)
    assert [part.nodes[0] for part in parts] == sorted(part.nodes[0] for part in parts)
    for part in parts:
        own = two[0] if part.joint.label[0] in two[0].label else two[1]
        places = [own.label.index(label) for label in part.joint.label]
        of_slip = own.layout.slips_of(places)
        assert (own.A[np.ix_(of_slip, of_slip)] == part.joint.A).all()
        assert (own.B[np.ix_(places, of_slip)] == part.joint.B).all()
        for key in ("q_w", "q_mean", "initial_slip"):
            assert (getattr(part.joint, key) == getattr(own, key)[..., of_slip]).all()
        for key in ("f", "p_w", "p_mean"):
            assert (getattr(part.joint, key) == getattr(own, key)[..., places]).all()
    assert (of_nodes(parts, (part.joint.f for part in parts)) == whole.f).all()
    assert (of_slips(parts, (part.joint.q_w for part in parts)) == whole.q_w).all()


def test_a_part_whose_nodes_are_all_open_is_no_joint():
    blocks = {"A": 2.0 * np.eye(3), "B": np.zeros((3, 3)), "C": 2.0 * np.eye(3)}
    blocks["A"][0, 1] = blocks["A"][1, 0] = 0.5
    joint = shakedown.Problem(**blocks, **LOOP)
    assert len(coupled_parts(joint, [0])) == 2
    assert len(coupled_parts(joint, [2])) == len(coupled_parts(joint, [0, 1])) == 1


def test_what_round_off_leaves_of_a_stiffness_is_no_joint():
    """Beside a stiffness of 1e20 that of −1 is round-off; alone it would be refused."""
    stiff = dataclasses.replace(drawn_joint_in_space(0, 0), C=None, load_path="loop")
    A = block_diag(1e20 * stiff.A, -np.eye(2))
    ones = np.ones((2, len(A)))
    joint = Problem(A=A, B=np.zeros((len(A) // 2, len(A))), f=0.5, q_w=ones, p_w=ones[:, ::2])
    assert len(coupled_parts(joint)) == 1


def test_rigid_slips_are_those_of_the_parts():
    floating = free_pair([1.0, 1.0])
    ones, A = np.ones((2, 4)), block_diag(floating.A, 1e-6 * floating.A)
    whole = Problem(A=A, B=np.zeros((4, 4)), f=0.5, q_w=ones, p_w=ones)
    found = [rigid_slips(part.joint).pinned for part in coupled_parts(whole)]
    assert found == [rigid_slips(floating).pinned] * 2
