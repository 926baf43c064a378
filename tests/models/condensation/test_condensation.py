"""Condensation against dense algebra, its laws, what it must refuse; load domains; interiors by fronts, what can move in them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse
from scipy.linalg import LinAlgError, block_diag

from shakedown import LoadCase, ProblemError, condense
from shakedown.fem import ElasticBody, Material, block_mesh
from shakedown.models.condensation import factorised_interior
from shakedown.models.condensation.condense import condensed_stiffness
from shakedown.models.condensation.contact_frame import tangent_pairs
from shakedown.models.condensation.factorised_interior import dissection, elimination, factorised
from shakedown.models.condensation.load_case import LARGEST_DOMAIN, histories
from shakedown.models.condensation.stiffness_checks import loose_motion, uncoupled

NODES = 5
CONTACT = [0, 10, 20]
BOTH = pytest.mark.parametrize("d", [1, 2])  # tangents per node


def dofs(d):
    return np.array([(10 * k, direction) for k in range(NODES) for direction in range(1, d + 2)])


def up(d):
    return [0.0] * d + [1.0]


def lattice(d, seed=0, ground=0.1, nodes=NODES):
    """A structure of springs in random directions between all nodes, and to the ground."""
    rng, size = np.random.default_rng(seed), d + 1
    places = np.random.default_rng(99).normal(size=(nodes, size))
    K = ground * np.eye(size * nodes)
    for i in range(nodes):
        for j in range(i):
            along = places[i] - places[j]
            spring = (1 + rng.random()) * np.outer(along, along)
            a, b = slice(size * i, size * i + size), slice(size * j, size * j + size)
            K[a, a] += spring
            K[b, b] += spring
            K[a, b] -= spring
            K[b, a] -= spring
    return K


def places(d):
    """Rows of slips and of gaps of the contact nodes, in this order, when the normal is the last direction."""
    rows = np.arange(3 * (d + 1)).reshape(3, d + 1)
    return np.concatenate([rows[:, :d].ravel(), rows[:, d]])


def dense_schur(K, kept):
    rest = np.setdiff1d(np.arange(len(K)), kept)
    return K[np.ix_(kept, kept)] - K[np.ix_(kept, rest)] @ np.linalg.solve(
        K[np.ix_(rest, rest)], K[np.ix_(rest, kept)]
    )


@BOTH
def test_problem_reproduces_the_structure_with_contact_moved(d):
    """q = q_w + A v + Bᵀ w and p = p_w + B v + C w are the forces that hold v, w in the full structure."""
    K, rng, kept = lattice(d, 3), np.random.default_rng(4), 3 * (d + 1)
    force, moved = rng.standard_normal(len(K)), np.zeros(len(K))
    held = len(K) - 1
    moved[held] = rng.standard_normal()
    load = LoadCase(history=[1.0, 0.0], force=force, displacement=moved)
    joint = condense(K, dofs(d), CONTACT, np.array(up(d)) * 2.0, [load], f=0.3, fixed=[held])
    assert (joint.n, joint.directions) == (3, d)
    v, w = rng.standard_normal(3 * d), rng.standard_normal(3)
    u = moved.copy()
    u[places(d)] = np.r_[v, w]
    free = np.arange(kept, held)
    u[free] = np.linalg.solve(
        K[np.ix_(free, free)], force[free] - np.delete(K[free], free, axis=1) @ np.delete(u, free)
    )
    external = (K @ u - force)[places(d)]
    np.testing.assert_allclose(joint.q_w[0] + joint.A @ v + joint.B.T @ w, external[: 3 * d], atol=1e-12)
    np.testing.assert_allclose(joint.p_w[0] + joint.B @ v + joint.C @ w, external[3 * d :], atol=1e-12)


@BOTH
def test_every_node_has_its_own_frame(d):
    rng = np.random.default_rng(2)
    K, normals, towards = lattice(d, 2), rng.normal(size=(3, d + 1)), rng.normal(size=(3, 3))
    found = condensed_stiffness(K, dofs(d), CONTACT, normals, tangent=towards if d == 2 else None)
    frame = np.zeros((3 * (d + 1),) * 2)  # rows (v, w) of every node in terms of its directions
    for j, (normal, t) in enumerate(zip(normals, towards, strict=True)):
        n, at = normal / np.linalg.norm(normal), slice((d + 1) * j, (d + 1) * (j + 1))
        if d == 2:
            first = t - (t @ n) * n
            first /= np.linalg.norm(first)
            frame[2 * j : 2 * j + 2, at] = first, np.cross(n, first)
        else:
            frame[j, at] = n[1], -n[0]
        frame[3 * d + j, at] = n
    expected = frame @ dense_schur(K, np.arange(len(frame))) @ frame.T
    np.testing.assert_allclose(found.stiffness, expected, atol=1e-12 * np.abs(expected).max())
    vectors = rng.normal(size=(3, d + 1))
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


@given(st.permutations(range(10)), st.permutations(range(3)), st.floats(1e-12, 1e12))
def test_relabelling_permutes_and_stiffness_scales(rows, nodes, factor):
    K, own = lattice(1, 5), dofs(1)
    plain = condensed_stiffness(K, own, CONTACT, [0, 1])
    other = condensed_stiffness(
        factor * K[np.ix_(rows, rows)], own[rows], [CONTACT[j] for j in nodes], [0, 1]
    )
    size = 1e-11 * np.abs(plain.stiffness).max()
    np.testing.assert_allclose(other.B / factor, plain.B[np.ix_(nodes, nodes)], atol=size)
    np.testing.assert_allclose(other.A / factor, plain.A[np.ix_(nodes, nodes)], atol=size)


@BOTH
def test_compliances_of_two_bodies_add_and_bodies_may_be_swapped(d):
    K = sparse.csr_array(block_diag(lattice(d, 7), lattice(d, 8)))
    own, pairs = (
        np.vstack([dofs(d), dofs(d) + np.array([1000, 0])]),
        [(node, node + 1000) for node in CONTACT],
    )
    one = [condensed_stiffness(lattice(d, seed), dofs(d), CONTACT, up(d)).stiffness for seed in (7, 8)]
    together = condensed_stiffness(K, own, pairs, up(d))
    np.testing.assert_allclose(np.linalg.inv(together.stiffness), sum(map(np.linalg.inv, one)), atol=1e-9)
    backwards = {"tangent": -together.frame.tangents} if d == 2 else {}
    swapped = condensed_stiffness(K, own, [(b, a) for a, b in pairs], -np.array(up(d)), **backwards)
    np.testing.assert_allclose(swapped.stiffness, together.stiffness, atol=1e-11)
    push = LoadCase(history=1.0, force=np.random.default_rng(9).standard_normal(K.shape[0]))
    np.testing.assert_allclose(swapped.welded(push).reactions, together.welded(push).reactions, atol=1e-11)


def test_internal_nodes_with_negative_labels_are_condensed_not_dropped():
    """A multiplier that ties two interior rows: an indefinite matrix, and dropping it changes the result."""
    K = lattice(1)
    tied = np.zeros((11, 11))
    tied[:10, :10] = K
    tied[10, [7, 9]] = tied[[7, 9], 10] = [1.0, -1.0]
    found = condensed_stiffness(tied, [*map(tuple, dofs(1).tolist()), (-16, 1)], CONTACT, [0, 1])
    join = np.delete(np.eye(10), 9, axis=1)
    join[9, 7] = 1.0
    expected = dense_schur(join.T @ K @ join, places(1))
    np.testing.assert_allclose(found.stiffness, expected, atol=1e-12)
    dropped = condensed_stiffness(K, dofs(1), CONTACT, [0, 1]).stiffness
    assert np.abs(dropped - expected).max() > 1e-3 * np.abs(expected).max()


def test_rows_without_stiffness_are_held_and_said():
    K = np.zeros((11, 11))
    K[:10, :10] = lattice(1)
    found = condensed_stiffness(K, [*map(tuple, dofs(1).tolist()), (0, 6)], CONTACT, [0, 1])
    assert "1 rows without any stiffness" in found.notes[0]


@pytest.mark.parametrize(("d", "motions"), [(1, 3), (2, 6)])
def test_a_body_that_nothing_holds_has_its_rigid_motions(d, motions):
    floating = condensed_stiffness(lattice(d, ground=0.0), dofs(d), CONTACT, up(d))
    assert floating.zero_modes == motions
    assert f"floating: {motions}" in floating.notes[0]


def test_a_pair_on_a_plane_of_symmetry_is_held_on_both_sides():
    """Else the second body slips on the first without friction, and no slip says so."""
    K = np.diag(np.full(8, 8.0)) - 1.0
    rows = [(node, direction) for node in (1, 2, 11, 12) for direction in (1, 2)]
    pairs = [(1, 11), (2, 12)]
    with pytest.raises(ProblemError, match=r"found direction 1 of node 1 held .*those of both bodies"):
        condensed_stiffness(K + np.eye(8), rows, pairs, [0, 1], fixed=[0])
    found = condensed_stiffness(K + np.eye(8), rows, pairs, [0, 1], fixed=[0, 4])
    np.testing.assert_array_equal(found.A[0, 1:], 0.0)


@pytest.mark.parametrize("tangent", [None, [1.0, 1.0, 0.0]])
def test_slips_across_planes_of_symmetry_stay_zero(tangent):
    """Node 0 is held along x, node 10 along x and y: their pairs lead along what is held."""
    K = lattice(2, 3)
    found = condensed_stiffness(K, dofs(2), CONTACT, [0, 0, 1], fixed=[0, 3, 4], tangent=tangent)
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


PLANE, SPACE = dofs(1), dofs(2)


@pytest.mark.parametrize(
    ("d", "change", "message"),
    [
        (1, {"contact": [0, 10, 10]}, "node 10 twice"),
        (1, {"contact": [0.0]}, "node labels"),
        (1, {"normals": [0, 0]}, "length > 0"),
        (1, {"normals": [[0, 1]] * 2}, r"shape \(2,\) or \(3, 2\)"),
        (1, {"dofs": PLANE[:-1]}, "one row per dof"),
        (1, {"dofs": np.vstack([PLANE[:-1], PLANE[:1]])}, r"\(0, 1\) twice"),
        (1, {"dofs": PLANE.astype(float)}, "integer pairs"),
        (1, {"fixed": [10]}, "row numbers 0 to 9"),
        (1, {"fixed": np.ones(3, bool)}, "a flag for each"),
        (1, {"axes": (1, 3)}, r"\(0, 3\)"),
        (1, {"stiffness": 1j * lattice(1)}, "real numbers"),
        (1, {"stiffness": np.zeros((10, 10))}, "only zeros"),
        (1, {"stiffness": np.diag(np.full(10, np.inf))}, "finite"),
        (1, {"stiffness": np.eye(10) + 0.1 * np.eye(10, k=5)}, r"symmetric matrix, found .* at row \(0, 1\), column"),
        (2, {"normals": [0, 1], "tangent": [1, 0, 0]}, "tangent: expected only beside normals of three comp"),
        (2, {"axes": (1, 3)}, "axes: expected normals of two components, along directions 1 and 3, found three"),
        (2, {"tangent": [[1, 0, 0]] * 2}, r"tangent: expected shape \(3,\), \(3, 3\) or \(3, 2, 3\), found \(2, 3"),
    ],
)  # fmt: skip
def test_one_thing_wrong_is_named(d, change, message):
    given = {"stiffness": lattice(d), "dofs": dofs(d), "contact": CONTACT, "normals": up(d)} | change
    with pytest.raises(ProblemError, match=message):
        condensed_stiffness(given.pop("stiffness"), **given)


def test_a_sub_block_passed_as_condensed_is_refused():
    chain = 2 * np.eye(5) - np.eye(5, k=1) - np.eye(5, k=-1)
    K, own, nodes = np.kron(chain, np.eye(2)), [(k, d) for k in range(5) for d in (1, 2)], list(range(5))
    with pytest.raises(ProblemError, match=r"found 12 of 25 node pairs .*CalculiX 2.20"):
        condensed_stiffness(K, own, nodes, [0, 1])
    assert condensed_stiffness(K, own, nodes, [0, 1], allow_sparse=True).n == 5
    found = uncoupled(sparse.csr_array(np.eye(6)), np.repeat([1, 2, 3], 2))
    assert "of one body without coupling, or none with any" in found


@given(st.integers(2, 6), st.integers(0, 100))
def test_true_schur_complements_of_one_or_two_bodies_pass(n, seed):
    body = lattice(1, seed, nodes=n)
    assert not uncoupled(sparse.csr_array(block_diag(body, body)), np.repeat(np.arange(2 * n), 2))


@BOTH
def test_a_static_run_agrees_or_the_difference_is_explained(d):
    """In global axes, whatever the normals are."""
    K, size = lattice(d, 4), 3 * (d + 1)
    found = condensed_stiffness(K, dofs(d), CONTACT, np.arange(1.0, d + 2))
    moved = np.random.default_rng(5).normal(size=(3, d + 1))
    reactions = (dense_schur(K, np.arange(size)) @ moved.ravel()).reshape(3, d + 1)
    assert found.check_against_run(moved, reactions) < 1e-12
    assert found.check_against_run(moved, reactions * (1 + 1e-7)) < 1e-6
    case = LoadCase(history=1.0, reactions=reactions)
    np.testing.assert_allclose(found.welded(case).reactions, found.frame.to_local(reactions))
    opened = LoadCase(history=1.0, opened=-moved)
    np.testing.assert_allclose(found.welded(opened).reactions, found.welded(case).reactions, atol=1e-12)
    other = reactions + np.eye(3, d + 1), "relative difference of"
    for wrong, said in ((-reactions, r"factor -1 \(wrong sign\)"), (reactions / 2, "factor 2"), other):
        with pytest.raises(ProblemError, match=said):
            found.check_against_run(moved, wrong)
    with pytest.raises(ProblemError, match=rf"shape \(3, {d + 1}\), found \(2, {d + 1}\)"):
        found.check_against_run(moved[:2], reactions)
    with pytest.raises(ProblemError, match=rf"reactions: expected shape \(3, {d + 1}\), found \(3, {d}\)"):
        found.welded(LoadCase(history=1.0, reactions=reactions[:, :d]))


@pytest.mark.parametrize(
    ("case", "message"),
    [
        (LoadCase(history=1.0, force=np.ones(3)), r"force: expected shape \(10,\)"),
        (LoadCase(history=1.0, displacement=np.ones(10)), "found free row 0"),
        (LoadCase(history=1.0, reactions=np.ones((2, 2))), r"reactions: expected shape \(3, 2\)"),
    ],
)
def test_a_load_case_that_does_not_fit_is_refused(case, message):
    reduced = condensed_stiffness(lattice(1), dofs(1), CONTACT, [0, 1], fixed=[8])
    with pytest.raises(ProblemError, match=message):
        reduced.welded(case)


ONE = [1.0]


def ranged(low, high, **more):
    return LoadCase(range=(low, high), force=ONE, **more)


def test_three_ranges_give_every_corner_once_along_the_edges():
    found = histories([ranged(-1, 2), LoadCase(history=5.0, force=ONE), ranged(0, 1), ranged(3, 4)]).period
    assert found.shape == (8, 4)
    assert {tuple(row) for row in found} == {(a, 5.0, b, c) for a in (-1, 2) for b in (0, 1) for c in (3, 4)}
    steps = np.vstack([found, found[:1]])
    assert (np.count_nonzero(np.diff(steps, axis=0), axis=1) == 1).all()


def test_the_mean_is_the_middle_of_the_domain_unless_given():
    assert histories([ranged(-1, 2), ranged(0, 1)]).period.mean(axis=0) == pytest.approx([0.5, 0.5])
    assert histories([ranged(-1, 2, mean=0.0), ranged(0, 1)]).mean == pytest.approx([0.0, 0.5])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: LoadCase(history=1.0), "found none"),
        (lambda: LoadCase(history=1.0, force=[np.nan]), "finite numbers, found nan"),
        (lambda: LoadCase(history="sin", force=ONE), "real numbers"),
        (lambda: LoadCase(history=np.ones((2, 2)), force=ONE), "axis"),
        (lambda: histories([]), "at least one load case"),
        (lambda: histories([LoadCase(history=np.ones(n), force=ONE) for n in (2, 3)]), "lengths 2, 3"),
        (lambda: LoadCase(force=ONE), "a history or a range, found neither"),
        (lambda: LoadCase(history=1.0, range=(0, 1), force=ONE), "a history or a range, found both"),
        (lambda: LoadCase(range=(1, 0), force=ONE), r"expected \[low, high\], found"),
        (lambda: LoadCase(range=(1,), force=ONE), r"expected \[low, high\], found"),
        (lambda: LoadCase(range=(0, 1, 2), force=ONE), r"expected \[low, high\], found"),
        (lambda: histories([ranged(0, 1), LoadCase(history=[0, 1], force=ONE, name="live")]), "found a history of 'live'"),
        (lambda: histories([ranged(0, 1)] * (LARGEST_DOMAIN + 1)), f"at most {LARGEST_DOMAIN} ranges"),
    ],
)  # fmt: skip
def test_what_is_no_load_is_refused(make, message):
    with pytest.raises(ProblemError, match=message):
        make()


KEPT = 12


def grid(counts, seed=0):
    """A Laplacian on a grid with random couplings, and where its nodes are."""
    rng = np.random.default_rng(seed)
    places = np.stack(np.meshgrid(*map(np.arange, map(float, counts)), indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(places)).reshape(counts)
    ends = [np.stack([np.delete(number, -1, a).ravel(), np.delete(number, 0, a).ravel()]) for a in range(3)]
    i, j = np.hstack(ends)
    K = sparse.coo_array((rng.uniform(0.5, 1.5, len(i)), (i, j)), shape=(len(places),) * 2).tocsr()
    K = -(K + K.T)
    return sparse.csr_array(K + sparse.diags_array(0.01 - K.sum(axis=1))), places


def planned(K, places, kept=KEPT):
    count = K.shape[0] - kept
    pieces = dissection(K[:count, :count], places[:count])
    return elimination(K, pieces, list(np.arange(count)[:, None])), pieces


@pytest.mark.parametrize("counts", [(9, 8, 7), (30, 4, 3), (2, 3, 4)])
def test_what_is_left_is_the_schur_complement(counts):
    K, places = grid(counts)
    plan, pieces = planned(K, places)
    found, dense = factorised(K, plan), K.toarray()
    ii, ic = dense[:-KEPT, :-KEPT], dense[:-KEPT, -KEPT:]
    expected = dense[-KEPT:, -KEPT:] - ic.T @ np.linalg.solve(ii, ic)
    np.testing.assert_allclose(found.schur, expected, atol=1e-13 * np.abs(expected).max())
    right = np.random.default_rng(1).normal(size=(len(ii), 3))
    np.testing.assert_allclose(ii @ found.solve(right), right, atol=1e-11)
    np.testing.assert_allclose(found.solve(right[:, 0]), found.solve(right)[:, 0], atol=1e-12)
    assert np.prod(found.pivots[:20]) > 0
    nodes = np.sort(np.concatenate([own for own, _ in pieces]))
    np.testing.assert_array_equal(nodes, np.arange(len(ii)))


def test_an_indefinite_matrix_is_not_factorised():
    K, places = grid((5, 5, 4))
    with pytest.raises(LinAlgError, match="not positive definite at unknown"):
        factorised(sparse.csr_array(K - 3.0 * sparse.eye_array(100)), planned(K, places)[0])


ROW = {k: (float(k), 0.0, 0.0) for k in range(200)}


def chain_of(count):
    """A row of nodes on springs, each held a little; the first is in contact."""
    K = sparse.kron(sparse.diags_array([-1, 2.0, -1], offsets=[-1, 0, 1], shape=(count, count)), np.eye(3))
    return sparse.csr_array(K), np.array([(k, d) for k in range(count) for d in (1, 2, 3)])


def test_what_can_move_is_named_as_before(monkeypatch):
    K, dofs = chain_of(200)
    loose = K.tolil()
    for k in (3 * 150, 3 * 151):  # along x, the chain is cut before node 150 and after node 151
        loose[k, k] = 1.0
    loose[450, 447] = loose[447, 450] = loose[453, 456] = loose[456, 453] = 0.0
    monkeypatch.setattr(factorised_interior, "_LARGE", 1)
    with pytest.raises(ProblemError, match="nodes 150, 151 along x"):
        condensed_stiffness(sparse.csr_array(loose), dofs, [0], [0, 0, 1], places=ROW)


def test_what_takes_too_much_memory_is_refused(monkeypatch):
    K, dofs = chain_of(200)
    monkeypatch.setattr(factorised_interior, "_LARGE", 1)
    found = condensed_stiffness(K, dofs, [0], [0, 0, 1], places=ROW)
    np.testing.assert_allclose(found.stiffness, (1 + 1 / 200) * np.eye(3), atol=1e-12)  # 2 − 199/200
    monkeypatch.setattr(factorised_interior, "memory", lambda: 1e4)
    with pytest.raises(ProblemError, match=r"K: .* a model that fits into .* GiB of memory, found that"):
        condensed_stiffness(K, dofs, [0], [0, 0, 1], places=ROW)


def block(columns=2, rows=2):
    """A free block: stiffness, (node, direction) of its rows, places of its nodes."""
    body = ElasticBody(block_mesh(2.0, 1.0, columns, rows), Material(200e3, 0.3))
    dofs = np.asarray(body.dofs)
    nodes = np.unique(dofs[:, 0])
    places = {int(n): (*xy, 0.0) for n, xy in zip(nodes, body.positions(nodes).tolist(), strict=True)}
    return body.stiffness.tocsc(), dofs, places


LEFT, RIGHT = (0.0, 0.0), (2.0, 0.0)  # lower corners


@pytest.mark.parametrize(
    ("held", "expected"),
    [
        ((), "along x and along y and turning about z"),
        (((LEFT, 1), (LEFT, 2)), "turning about z"),
        (((LEFT, 2),), "along x and turning about z"),
        (((LEFT, 2), (RIGHT, 2)), "along x"),
    ],
)
@pytest.mark.parametrize(("columns", "rows"), [(2, 2), (20, 15)])
def test_free_motions_of_a_block(columns, rows, held, expected):
    K, dofs, places = block(columns, rows)
    kept = [k for k, (node, d) in enumerate(dofs.tolist()) if (places[node][:2], d) not in held]
    said = loose_motion(K[kept][:, kept], dofs[kept], places)
    moving = len(set(dofs[kept, 0].tolist()))
    assert said.startswith("nodes ")
    assert said.endswith(f" ({moving} in all) {expected}")


@pytest.mark.parametrize("factor", [2.0**-40, 1.0, 2.0**40])
def test_parts_are_told_apart_and_units_do_not_matter(factor):
    pair = np.array([[1.0, -1.0], [-1.0, 1.0]])
    K = np.zeros((7, 7))
    K[:2, :2] = K[2:4, 2:4] = pair
    K[4:6, 4:6], K[6, 6] = 2 * pair, 1.0
    dofs = np.array([(1, 1), (2, 1), (5, 1), (6, 1), (5, 3), (6, 3), (9, 2)])
    said = loose_motion(sparse.csc_array(factor * K), dofs)
    assert said == "nodes 1, 2, 5, 6 along x; nodes 5, 6 along z"
