"""Condensation against dense algebra, its laws, and what it must refuse."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse
from scipy.linalg import block_diag

from shakedown import LoadCase, ProblemError, condense
from shakedown.models.condensation.condense import condensed_stiffness
from shakedown.models.condensation.load_case import histories
from shakedown.models.condensation.stiffness_checks import check_against_run, check_condensed

NODES = 6
DOFS = np.array([(10 * k, d) for k in range(NODES) for d in (1, 2)])
CONTACT = [0, 10, 20]


def lattice(seed=0, n=NODES):
    """A supported random structure: springs in random directions between all nodes and to the ground."""
    rng = np.random.default_rng(seed)
    K = np.zeros((2 * n, 2 * n))
    for i in range(n):
        for j in range(i + 1):
            direction = rng.standard_normal(2)
            spring = np.outer(direction, direction)
            a, b = slice(2 * i, 2 * i + 2), slice(2 * j, 2 * j + 2)
            K[a, a] += spring + 0.1 * np.eye(2)
            if i != j:
                K[b, b] += spring
                K[a, b] -= spring
                K[b, a] -= spring
    return K


def dense_schur(K, kept):
    rest = np.setdiff1d(np.arange(len(K)), kept)
    return K[np.ix_(kept, kept)] - K[np.ix_(kept, rest)] @ np.linalg.solve(
        K[np.ix_(rest, rest)], K[np.ix_(rest, kept)]
    )


SLIPS, GAPS = [0, 2, 4], [1, 3, 5]  # rows of the contact nodes when the normal is (0, 1)


def test_a_b_c_are_the_schur_complement():
    K = lattice()
    found = condensed_stiffness(sparse.csr_matrix(K), DOFS, CONTACT, [0, 1])
    expected = dense_schur(K, SLIPS + GAPS)
    np.testing.assert_allclose(found.stiffness, expected, atol=1e-13 * np.abs(expected).max())
    np.testing.assert_allclose(found.B, expected[3:, :3], atol=1e-13)
    assert (found.n, found.interior, found.held, found.zero_modes, found.notes) == (3, 6, 0, 0, ())
    assert found.residual < 1e-13
    assert found.asymmetry < 1e-13


def test_welded_reactions_are_those_of_a_static_run():
    K, held = lattice(1), [10, 11]
    rng = np.random.default_rng(2)
    force, moved = rng.standard_normal(12), np.zeros(12)
    moved[held] = rng.standard_normal(2)
    found = condensed_stiffness(K, DOFS, CONTACT, [0, 1], fixed=held)
    u, free = moved.copy(), [6, 7, 8, 9]
    u[free] = np.linalg.solve(K[np.ix_(free, free)], force[free] - K[np.ix_(free, held)] @ moved[held])
    reaction = K @ u - force
    case = LoadCase(history=1.0, force=force, displacement=moved)
    np.testing.assert_allclose(
        found.welded(case).reactions, reaction[SLIPS + GAPS], atol=1e-13 * np.abs(reaction).max()
    )


def test_problem_reproduces_the_structure_with_contact_moved():
    """q = q_w + A v + Bᵀ w and p = p_w + B v + C w are the forces that hold v, w in the full structure."""
    K, rng = lattice(3), np.random.default_rng(4)
    force = rng.standard_normal(12)
    joint = condense(K, DOFS, CONTACT, [0, 1], [LoadCase(history=[1.0, 0.0], force=force)], f=0.3)
    v, w = rng.standard_normal(3), rng.standard_normal(3)
    u = np.zeros(12)
    u[SLIPS], u[GAPS] = v, w
    u[6:] = np.linalg.solve(K[6:, 6:], force[6:] - K[6:, :6] @ u[:6])
    external = K @ u - force
    np.testing.assert_allclose(joint.q_w[0] + joint.A @ v + joint.B.T @ w, external[SLIPS], atol=1e-12)
    np.testing.assert_allclose(joint.p_w[0] + joint.B @ v + joint.C @ w, external[GAPS], atol=1e-12)


@given(st.floats(-np.pi, np.pi), st.integers(0, 5))
def test_turning_model_and_normals_together_changes_nothing(angle, seed):
    K = lattice(seed)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    R = np.kron(np.eye(NODES), turn)
    flat = condensed_stiffness(K, DOFS, CONTACT, [0, 1])
    turned = condensed_stiffness(R @ K @ R.T, DOFS, CONTACT, turn @ [0, 1])
    np.testing.assert_allclose(turned.stiffness, flat.stiffness, atol=1e-11 * np.abs(flat.stiffness).max())


def test_every_node_has_its_own_normal():
    K, normals = lattice(11), np.array([[0.0, 2.0], [3.0, 4.0], [-1.0, 0.0]])
    unit = normals / np.linalg.norm(normals, axis=1)[:, None]
    frame = np.zeros((6, 6))  # rows (v, w) of every node in terms of (x, y)
    for j, (nx, ny) in enumerate(unit):
        frame[j, 2 * j : 2 * j + 2] = ny, -nx
        frame[3 + j, 2 * j : 2 * j + 2] = nx, ny
    expected = frame @ dense_schur(K, np.arange(6)) @ frame.T
    found = condensed_stiffness(K, DOFS, CONTACT, normals).stiffness
    np.testing.assert_allclose(found, expected, atol=1e-12 * np.abs(expected).max())


def test_the_plane_may_be_any_pair_of_directions():
    K, upright = lattice(12), DOFS.copy()
    upright[:, 1] = np.where(DOFS[:, 1] == 2, 3, 1)
    flat = condensed_stiffness(K, DOFS, CONTACT, [1, 2]).stiffness
    np.testing.assert_array_equal(
        condensed_stiffness(K, upright, CONTACT, [1, 2], axes=(1, 3)).stiffness, flat
    )


@given(st.permutations(range(12)), st.permutations(range(3)))
def test_relabelling_rows_and_nodes_permutes(rows, nodes):
    K = lattice(5)
    plain = condensed_stiffness(K, DOFS, CONTACT, [0, 1])
    other = condensed_stiffness(K[np.ix_(rows, rows)], DOFS[rows], [CONTACT[j] for j in nodes], [0, 1])
    np.testing.assert_allclose(other.B, plain.B[np.ix_(nodes, nodes)], atol=1e-12)


@given(st.floats(1e-12, 1e12))
def test_stiffness_scales(factor):
    plain = condensed_stiffness(lattice(6), DOFS, CONTACT, [0, 1]).stiffness
    scaled = condensed_stiffness(factor * lattice(6), DOFS, CONTACT, [0, 1]).stiffness
    np.testing.assert_allclose(scaled, factor * plain, rtol=0, atol=1e-11 * factor * np.abs(plain).max())


def two_bodies(first=7, second=8):
    K = sparse.csr_array(block_diag(lattice(first), lattice(second)))
    return K, np.vstack([DOFS, DOFS + np.array([1000, 0])]), [(node, node + 1000) for node in CONTACT]


def test_compliances_of_two_supported_bodies_add():
    K, dofs, pairs = two_bodies()
    one = [condensed_stiffness(lattice(seed), DOFS, CONTACT, [0, 1]).stiffness for seed in (7, 8)]
    together = condensed_stiffness(K, dofs, pairs, [0, 1]).stiffness
    np.testing.assert_allclose(np.linalg.inv(together), sum(map(np.linalg.inv, one)), atol=1e-10)


def test_swapping_the_bodies_turns_slip_and_gap_around():
    K, dofs, pairs = two_bodies()
    plain = condensed_stiffness(K, dofs, pairs, [0, 1])
    swapped = condensed_stiffness(K, dofs, [(b, a) for a, b in pairs], [0, -1])
    np.testing.assert_allclose(swapped.stiffness, plain.stiffness, atol=1e-12)
    push = LoadCase(history=1.0, force=np.random.default_rng(9).standard_normal(24))
    np.testing.assert_allclose(swapped.welded(push).reactions, plain.welded(push).reactions, atol=1e-12)


def test_a_loaded_second_body_presses_through_the_joint():
    """Two columns: a force on the top of either body's free end arrives at the interface unchanged."""
    spring = np.diag([2.0, 3.0])
    column = np.block([[spring, -spring], [-spring, spring]])
    K = block_diag(column, column)
    dofs = [(node, d) for node in (1, 2, 3, 4) for d in (1, 2)]
    load = np.zeros(8)
    load[3] = -5.0  # on the top of the upper body, held by nothing else
    joint = condense(K, dofs, [(1, 4)], [0, 1], [LoadCase(history=1.0, force=load)], f=0.5, fixed=[4, 5])
    assert joint.p_w.ravel() == pytest.approx([5.0])
    assert joint.q_w.ravel() == pytest.approx([0.0])


def test_1e36_diagonals_are_held_and_said():
    K = lattice()
    marked = K.copy()
    marked[[6, 7], [6, 7]] = 1e36
    found = condensed_stiffness(marked, DOFS, CONTACT, [0, 1])
    np.testing.assert_allclose(
        found.stiffness, condensed_stiffness(K, DOFS, CONTACT, [0, 1], fixed=[6, 7]).stiffness, atol=1e-13
    )
    assert found.held == 2
    assert "1e36" in found.notes[0]


def test_internal_nodes_with_negative_labels_are_condensed_not_dropped():
    """A multiplier that ties two interior rows: an indefinite matrix, and dropping it changes the result."""
    K = lattice()
    tied = np.zeros((13, 13))
    tied[:12, :12] = K
    tied[12, [7, 9]] = tied[[7, 9], 12] = [1.0, -1.0]
    found = condensed_stiffness(tied, [*map(tuple, DOFS.tolist()), (-16, 1)], CONTACT, [0, 1])
    join = np.delete(np.eye(12), 9, axis=1)
    join[9, 7] = 1.0
    expected = dense_schur(join.T @ K @ join, SLIPS + GAPS)
    np.testing.assert_allclose(found.stiffness, expected, atol=1e-12)
    dropped = condensed_stiffness(K, DOFS, CONTACT, [0, 1]).stiffness
    assert np.abs(dropped - expected).max() > 1e-3 * np.abs(expected).max()


def test_rows_without_stiffness_are_held_and_said():
    K = np.zeros((13, 13))
    K[:12, :12] = lattice()
    found = condensed_stiffness(K, [*map(tuple, DOFS.tolist()), (0, 6)], CONTACT, [0, 1])
    assert "1 rows without any stiffness" in found.notes[0]


def test_a_floating_body_works_and_is_said():
    spring = np.array([[1.0, 0.5], [0.5, 2.0]])
    K = np.block([[spring, -spring], [-spring, spring]])
    found = condensed_stiffness(K, [(1, 1), (1, 2), (2, 1), (2, 2)], [1], [0, 1])
    assert found.zero_modes == 2
    assert "floating: 2" in found.notes[0]
    np.testing.assert_allclose(found.stiffness, 0.0, atol=1e-15)


def test_a_node_on_a_plane_of_symmetry_keeps_its_slip():
    K = lattice()
    found = condensed_stiffness(K, DOFS, CONTACT, [0, 1], fixed=[0])
    np.testing.assert_array_equal(found.A[0, 1:], 0.0)
    np.testing.assert_array_equal(found.B[:, 0], 0.0)
    assert found.A[0, 0] > 0
    np.testing.assert_allclose(
        found.stiffness[1:, 1:], dense_schur(np.delete(np.delete(K, 0, 0), 0, 1), [1, 3, 0, 2, 4]), atol=1e-12
    )
    assert "plane of symmetry" in found.notes[0]


def break_symmetry(K):
    K[0, 5] *= 1.001


def make_infinite(K):
    K[3, 3] = np.inf


def loosen(K):
    K[10:, :] = 0
    K[:, 10:] = 0
    K[10, 10] = K[11, 11] = 1.0
    K[10, 11] = K[11, 10] = 1.0


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (break_symmetry, r"symmetric matrix, found .* at row \(0, 1\), column \(20, 2\)"),
        (make_infinite, "finite"),
        (loosen, "found that it can move"),
    ],
)
def test_a_spoilt_matrix_is_refused(spoil, message):
    K = lattice()
    spoil(K)
    with pytest.raises(ProblemError, match=message):
        condensed_stiffness(K, DOFS, CONTACT, [0, 1])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"contact": [0, 10, 99]}, r"found none for 2 of 6, first \(node, direction\) \(99, 1\), \(99, 2\)"),
        ({"contact": [0, 10, 10]}, "node 10 twice"),
        ({"contact": [0.0]}, "node labels"),
        ({"normals": [0, 0]}, "length > 0"),
        ({"normals": [[0, 1]] * 2}, r"shape \(2,\) or \(3, 2\)"),
        ({"dofs": DOFS[:-1]}, "one row per dof"),
        ({"dofs": np.vstack([DOFS[:-1], DOFS[:1]])}, r"\(0, 1\) twice"),
        ({"dofs": DOFS.astype(float)}, "integer pairs"),
        ({"fixed": [0, 1]}, "found direction 1 of node 0 held"),
        ({"fixed": [1]}, "found direction 2 of node 0 held"),
        ({"fixed": [12]}, "row numbers 0 to 11"),
        ({"fixed": np.ones(3, bool)}, r"shape \(12,\)"),
        ({"axes": (1, 3)}, r"\(0, 3\)"),
        ({"K": 1j * lattice()}, "real numbers"),
        ({"K": np.zeros((12, 12))}, "only zeros"),
    ],
)
def test_one_thing_wrong_is_named(change, message):
    arguments = {"K": lattice(), "dofs": DOFS, "contact": CONTACT, "normals": [0, 1]} | change
    with pytest.raises(ProblemError, match=message):
        condensed_stiffness(**arguments)


def test_a_third_direction_is_refused_or_set_free():
    K = np.zeros((15, 15))
    K[:12, :12] = lattice()
    K[12:, 12:] = 5 * np.eye(3)
    K[:3, 12:] = K[12:, :3] = 0.3
    dofs = [*map(tuple, DOFS.tolist()), (0, 3), (10, 3), (20, 3)]
    with pytest.raises(ProblemError, match="node 0 free in direction 3 too"):
        condensed_stiffness(K, dofs, CONTACT, [0, 1])
    free = condensed_stiffness(K, dofs, CONTACT, [0, 1], free_out_of_plane=True)
    np.testing.assert_allclose(free.stiffness, dense_schur(K, SLIPS + GAPS), atol=1e-12)
    held = condensed_stiffness(K, dofs, CONTACT, [0, 1], fixed=[12, 13, 14])
    np.testing.assert_allclose(held.stiffness, dense_schur(K[:12, :12], SLIPS + GAPS), atol=1e-12)


def chain(n):
    return 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)


def test_a_sub_block_passed_as_condensed_is_refused():
    K = np.kron(chain(5), np.eye(2))
    dofs, nodes = [(k, d) for k in range(5) for d in (1, 2)], list(range(5))
    with pytest.raises(ProblemError, match=r"found 12 of 25 node pairs .*CalculiX 2.20"):
        condensed_stiffness(K, dofs, nodes, [0, 1])
    assert condensed_stiffness(K, dofs, nodes, [0, 1], allow_sparse=True).n == 5
    with pytest.raises(ProblemError, match="3 nodes without any coupling"):
        check_condensed(sparse.csr_array(np.eye(6)), np.repeat([1, 2, 3], 2))


@given(st.integers(2, 6), st.integers(0, 100))
def test_true_schur_complements_of_one_or_two_bodies_pass(n, seed):
    body = lattice(seed, n)
    check_condensed(sparse.csr_array(block_diag(body, body)), np.repeat(np.arange(2 * n), 2))


def test_static_run_agrees_or_the_difference_is_explained():
    stiffness = condensed_stiffness(lattice(), DOFS, CONTACT, [0, 1]).stiffness
    move = np.array([0.0, 1.0, 0.0, 0.2, 0.0, 0.0])
    reaction = stiffness @ move
    assert check_against_run(stiffness, move, reaction * (1 + 1e-7)) < 1e-6
    with pytest.raises(ProblemError, match=r"factor -1 \(wrong sign\)"):
        check_against_run(stiffness, move, -reaction)
    with pytest.raises(ProblemError, match="factor 2"):
        check_against_run(stiffness, move, reaction / 2)
    with pytest.raises(ProblemError, match="relative difference of"):
        check_against_run(stiffness, move, reaction + np.eye(6)[0])


def test_a_static_run_is_compared_in_global_axes():
    K = lattice()
    reduced = condensed_stiffness(K, DOFS, CONTACT, [1, 1])
    moved = np.random.default_rng(3).standard_normal((3, 2))
    forces = (dense_schur(K, np.arange(6)) @ moved.ravel()).reshape(3, 2)
    assert reduced.check_against_run(moved, forces) < 1e-12
    with pytest.raises(ProblemError, match=r"shape \(3, 2\), found \(2, 2\)"):
        reduced.check_against_run(moved[:2], forces)
    with pytest.raises(ProblemError, match="wrong sign"):
        reduced.check_against_run(moved, -forces)


def test_load_cases_are_checked():
    reduced = condensed_stiffness(lattice(), DOFS, CONTACT, [0, 1], fixed=[10])
    for case, message in (
        (LoadCase(history=1.0, force=np.ones(3)), r"force: expected shape \(12,\)"),
        (LoadCase(history=1.0, displacement=np.ones(12)), "found free row 0"),
        (LoadCase(history=1.0, reactions=np.ones((2, 2))), r"reactions: expected shape \(3, 2\)"),
    ):
        with pytest.raises(ProblemError, match=message):
            reduced.welded(case)
    with pytest.raises(ProblemError, match="found none"):
        LoadCase(history=1.0)
    with pytest.raises(ProblemError, match="finite numbers, found nan"):
        LoadCase(history=1.0, force=[np.nan])
    with pytest.raises(ProblemError, match="real numbers"):
        LoadCase(history="sin", force=[1.0])
    with pytest.raises(ProblemError, match="axis"):
        LoadCase(history=np.ones((2, 2)), force=[1.0])
    with pytest.raises(ProblemError, match="at least one load case"):
        histories([])
    with pytest.raises(ProblemError, match="lengths 2, 3"):
        histories([LoadCase(history=np.ones(2), force=[1.0]), LoadCase(history=np.ones(3), force=[1.0])])


def test_mean_and_transient_are_combined_per_case():
    reactions = [np.array([[1.0, 0.0]]), np.array([[0.0, 1.0]])]
    dead = LoadCase(history=2.0, reactions=reactions[1], transient=[1.0])
    live = LoadCase(history=[1.0, -3.0], reactions=reactions[0], mean=0.0)
    joint = condense(np.diag([1.0, 2.0]), [(1, 1), (1, 2)], [1], [0, 1], [dead, live], f=0.1)
    assert joint.q_w.ravel().tolist() == [1.0, -3.0]
    assert joint.p_w.ravel().tolist() == [2.0, 2.0]
    assert (joint.q_mean.item(), joint.p_mean.item()) == (0.0, 2.0)
    assert (joint.q_transient.item(), joint.p_transient.item()) == (0.0, 1.0)
