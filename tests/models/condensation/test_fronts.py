"""Large solids: nested dissection and Cholesky by fronts against dense algebra and SuperLU."""

import numpy as np
import pytest
from scipy import sparse
from scipy.linalg import LinAlgError

from shakedown import ProblemError
from shakedown.models.condensation import factorised_interior
from shakedown.models.condensation.condense import condensed_stiffness
from shakedown.models.condensation.factorised_interior import (
    dissection,
    elimination,
    factorised,
)

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
