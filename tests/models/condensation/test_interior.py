"""Interiors of bodies: elimination by fronts against dense algebra and SuperLU; what can move is named."""

import numpy as np
import pytest
from scipy import sparse
from scipy.linalg import LinAlgError

from shakedown import ProblemError
from shakedown.fem import ElasticBody, Material, block_mesh
from shakedown.models.condensation import factorised_interior
from shakedown.models.condensation.condense import condensed_stiffness
from shakedown.models.condensation.factorised_interior import (
    dissection,
    elimination,
    factorised,
)
from shakedown.models.condensation.stiffness_checks import loose_motion

KEPT = 12


def grid(counts, seed=0):
    """A Laplacian on a grid with random couplings, and where its nodes are."""
    rng = np.random.default_rng(seed)
    places = (
        np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, 3).astype(float)
    )
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
    K = sparse.kron(
        sparse.diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(count, count)), np.eye(3)
    )
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
    with pytest.raises(
        ProblemError, match=r"K: expected a model that fits into .* GiB of memory, found that"
    ):
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
