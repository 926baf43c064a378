"""The parts that a joint falls into: which nodes belong together, and the joint of each alone."""

import dataclasses

import numpy as np
import pytest
from joints import free_pair
from scipy.linalg import block_diag

import shakedown
from benchmarks.drawn_joints import drawn_joint_in_space
from shakedown.joint.contact_zone import coupled_parts, of_nodes, of_slips
from shakedown.joint.rigid_slips import rigid_slips

LOOP = {"f": 0.5, "q_w": np.ones((2, 3)), "p_w": np.ones((2, 3))}


@pytest.mark.parametrize("which", ["A", "B", "C"])
def test_one_entry_of_any_block_couples(which):
    blocks = {"A": 2.0 * np.eye(3), "B": np.zeros((3, 3)), "C": 2.0 * np.eye(3)}
    apart = shakedown.Problem(**blocks, **LOOP)
    assert [part.nodes.tolist() for part in coupled_parts(apart)] == [[0], [1], [2]]
    blocks[which][2, 0] = 0.5
    if which != "B":
        blocks[which][0, 2] = 0.5
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
    joint = shakedown.Problem(
        A=A, B=np.zeros((len(A) // 2, len(A))), f=0.5, q_w=np.ones((2, len(A))), p_w=np.ones((2, len(A) // 2))
    )
    assert len(coupled_parts(joint)) == 1


def test_rigid_slips_are_those_of_the_parts():
    floating = free_pair([1.0, 1.0])
    whole = shakedown.Problem(
        A=block_diag(floating.A, 1e-6 * floating.A),
        B=np.zeros((4, 4)),
        f=0.5,
        q_w=np.ones((2, 4)),
        p_w=np.ones((2, 4)),
    )
    found = [rigid_slips(part.joint).pinned for part in coupled_parts(whole)]
    assert found == [rigid_slips(floating).pinned] * 2
