"""Condensation with two tangents per node: against dense algebra, its laws, and what it must refuse."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse
from scipy.linalg import block_diag

from shakedown import LoadCase, ProblemError, condense
from shakedown.models.condensation.condense import condensed_stiffness
from shakedown.models.condensation.contact_frame import tangent_pairs

NODES = 5
DOFS = np.array([(10 * k, d) for k in range(NODES) for d in (1, 2, 3)])
CONTACT = [0, 10, 20]
SLIPS, GAPS = [0, 1, 3, 4, 6, 7], [2, 5, 8]  # rows of the contact nodes when the normal is z


def lattice(seed=0, ground=0.1):
    """A structure of springs in random directions between all nodes, and to the ground."""
    rng = np.random.default_rng(seed)
    places = np.random.default_rng(99).normal(size=(NODES, 3))
    K = ground * np.eye(3 * NODES)
    for i in range(NODES):
        for j in range(i):
            along = places[i] - places[j]
            spring = (1 + rng.random()) * np.outer(along, along)
            a, b = slice(3 * i, 3 * i + 3), slice(3 * j, 3 * j + 3)
            K[a, a] += spring
            K[b, b] += spring
            K[a, b] -= spring
            K[b, a] -= spring
    return K


def dense_schur(K, kept):
    rest = np.setdiff1d(np.arange(len(K)), kept)
    return K[np.ix_(kept, kept)] - K[np.ix_(kept, rest)] @ np.linalg.solve(
        K[np.ix_(rest, rest)], K[np.ix_(rest, kept)]
    )


def test_a_b_c_are_the_schur_complement_and_reactions_those_of_a_static_run():
    K, force = lattice(), np.random.default_rng(1).normal(size=15)
    load = LoadCase(history=[1.0, 0.0], force=force)
    joint = condense(sparse.csr_matrix(K), DOFS, CONTACT, [0, 0, 2.0], [load], f=0.3)
    expected = dense_schur(K, SLIPS + GAPS)
    assert (joint.n, joint.directions) == (3, 2)
    np.testing.assert_allclose(joint.kappa, expected, atol=1e-13 * np.abs(expected).max())
    np.testing.assert_array_equal(joint.tangents, np.tile(np.eye(3)[:2], (3, 1, 1)))
    np.testing.assert_array_equal(joint.normal, np.tile([0.0, 0.0, 1.0], (3, 1)))
    u = np.r_[np.zeros(9), np.linalg.solve(K[9:, 9:], force[9:])]
    reaction = K @ u - force
    np.testing.assert_allclose(np.r_[joint.q_w[0], joint.p_w[0]], reaction[SLIPS + GAPS], atol=1e-12)


def test_every_node_has_its_own_frame():
    rng = np.random.default_rng(2)
    K, normals, towards = lattice(2), rng.normal(size=(3, 3)), rng.normal(size=(3, 3))
    found = condensed_stiffness(K, DOFS, CONTACT, normals, tangent=towards)
    frame = np.zeros((9, 9))  # rows (v, w) of every node in terms of x, y, z
    for j, (normal, t) in enumerate(zip(normals, towards, strict=True)):
        n = normal / np.linalg.norm(normal)
        first = t - (t @ n) * n
        first /= np.linalg.norm(first)
        frame[2 * j : 2 * j + 2, 3 * j : 3 * j + 3] = first, np.cross(n, first)
        frame[6 + j, 3 * j : 3 * j + 3] = n
    expected = frame @ dense_schur(K, np.arange(9)) @ frame.T
    np.testing.assert_allclose(found.stiffness, expected, atol=1e-12 * np.abs(expected).max())
    vectors = rng.normal(size=(3, 3))
    np.testing.assert_allclose(found.frame.to_local(vectors), frame @ vectors.ravel(), atol=1e-14)


@given(st.integers(0, 50))
def test_pairs_are_orthonormal_and_right_handed(seed):
    rng = np.random.default_rng(seed)
    normals = rng.normal(size=(6, 3))
    normals[:3] = rng.permutation(np.eye(3)) * rng.choice([-1.0, 1.0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    pairs = tangent_pairs(normals)
    frames = np.concatenate([pairs, normals[:, None]], axis=1)
    np.testing.assert_allclose(frames @ frames.transpose(0, 2, 1), np.tile(np.eye(3), (6, 1, 1)), atol=1e-15)
    np.testing.assert_allclose(np.linalg.det(frames), 1.0)
    np.testing.assert_array_equal(tangent_pairs(normals[::-1])[::-1], pairs)


def test_a_flat_patch_has_one_pair_and_a_given_pair_its_own_side():
    tilted = np.tile([0.6, 0.0, 0.8], (4, 1)) + 1e-15 * np.arange(4)[:, None]
    np.testing.assert_allclose(
        tangent_pairs(tilted), np.tile([[0, 1, 0], [-0.8, 0, 0.6]], (4, 1, 1)), atol=1e-12
    )
    given = np.array([[[1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]])
    np.testing.assert_array_equal(tangent_pairs(np.array([[0.0, 0.0, 1.0]]), given), given)


def two_bodies():
    K = sparse.csr_array(block_diag(lattice(7), lattice(8)))
    return K, np.vstack([DOFS, DOFS + np.array([1000, 0])]), [(node, node + 1000) for node in CONTACT]


def test_compliances_of_two_bodies_add_and_bodies_may_be_swapped():
    K, dofs, pairs = two_bodies()
    one = [condensed_stiffness(lattice(seed), DOFS, CONTACT, [0, 0, 1]).stiffness for seed in (7, 8)]
    together = condensed_stiffness(K, dofs, pairs, [0, 0, 1])
    np.testing.assert_allclose(np.linalg.inv(together.stiffness), sum(map(np.linalg.inv, one)), atol=1e-9)
    backwards = -together.frame.tangents
    other = [(b, a) for a, b in pairs]
    swapped = condensed_stiffness(K, dofs, other, [0, 0, -1], tangent=backwards)
    np.testing.assert_allclose(swapped.stiffness, together.stiffness, atol=1e-11)


def test_a_body_that_nothing_holds_has_six_rigid_motions():
    assert condensed_stiffness(lattice(), DOFS, CONTACT, [0, 0, 1]).zero_modes == 0
    floating = condensed_stiffness(lattice(ground=0.0), DOFS, CONTACT, [0, 0, 1])
    assert floating.zero_modes == 6
    assert "floating: 6" in floating.notes[0]


@pytest.mark.parametrize("tangent", [None, [1.0, 1.0, 0.0]])
def test_slips_across_planes_of_symmetry_stay_zero(tangent):
    """Node 0 is held along x, node 10 along x and y: their pairs lead along what is held."""
    K = lattice(3)
    found = condensed_stiffness(K, DOFS, CONTACT, [0, 0, 1], fixed=[0, 3, 4], tangent=tangent)
    held = [0, 2, 3]
    frame = found.frame.slip_axes
    np.testing.assert_array_equal(np.abs(frame[:2]), np.tile(np.eye(3)[:2], (2, 1, 1)))
    free = [k for k in range(9) if k not in held]
    np.testing.assert_array_equal(found.stiffness[np.ix_(held, free)], 0.0)
    turned = np.eye(15)
    turned[6:9, 6:9] = np.vstack([frame[2], found.frame.normals[2]])
    supported = np.delete(np.arange(15), [0, 3, 4])
    rest = (turned @ K @ turned.T)[np.ix_(supported, supported)]
    expected = dense_schur(rest, [0, 3, 4, 1, 2, 5])  # slips y of 0, both of 20; gaps
    np.testing.assert_allclose(found.stiffness[np.ix_(free, free)], expected, atol=1e-12)
    assert "2 contact node(s) are held along a tangent" in found.notes[0]


def test_a_static_run_is_compared_in_three_directions():
    K = lattice(4)
    found = condensed_stiffness(K, DOFS, CONTACT, [1, 2, 3])
    moved = np.random.default_rng(5).normal(size=(3, 3))
    reactions = (dense_schur(K, np.arange(9)) @ moved.ravel()).reshape(3, 3)
    assert found.check_against_run(moved, reactions) < 1e-12
    case = LoadCase(history=1.0, reactions=reactions)
    np.testing.assert_allclose(found.welded(case).reactions, found.frame.to_local(reactions))
    opened = LoadCase(history=1.0, opened=-moved)
    np.testing.assert_allclose(found.welded(opened).reactions, found.welded(case).reactions, atol=1e-12)
    with pytest.raises(ProblemError, match="they differ by the factor -1 "):
        found.check_against_run(moved, -reactions)
    with pytest.raises(ProblemError, match=r"reactions: expected shape \(3, 3\), found \(3, 2\)"):
        found.welded(LoadCase(history=1.0, reactions=reactions[:, :2]))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"normals": [0, 0, 0]}, "vectors of finite length > 0"),
        (
            {"normals": [0, 1]},
            r"free in direction 3 too; ask for friction in both directions \(normals of three",
        ),
        ({"normals": [0, 1], "tangent": [1, 0, 0]}, "tangent: expected only beside normals of three comp"),
        ({"axes": (1, 3)}, "axes: expected normals of two components, along directions 1 and 3, found three"),
        ({"tangent": [0, 0, 2]}, r"tangent: expected a finite direction across the normal \[0.0, 0.0, 1.0\]"),
        (
            {"tangent": [[1, 0, 0]] * 2},
            r"tangent: expected shape \(3,\), \(3, 3\) or \(3, 2, 3\), found \(2, 3",
        ),
        ({"fixed": [2]}, "expected free contact nodes, found direction 3 of node 0 held"),
        ({"fixed": [0, 1, 2]}, "expected free contact nodes, found direction 1 of node 0 held"),
        (
            {"dofs": DOFS[:, [0, 1]] + [[0, 1]]},
            r"in directions 1, 2 and 3, found none for 3 of 9, .*two comp",
        ),
    ],
)
def test_one_thing_wrong_is_named(change, message):
    given = {"dofs": DOFS, "contact": CONTACT, "normals": [0, 0, 1]} | change
    with pytest.raises(ProblemError, match=message):
        condensed_stiffness(lattice(), **given)
