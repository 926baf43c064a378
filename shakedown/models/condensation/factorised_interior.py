"""The interior of an elastic model: one sparse factorization, many right-hand sides."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import LinAlgError
from scipy.sparse.linalg import ArpackError, SuperLU, splu

from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import ProblemError
from shakedown.ground.tolerances import DEFAULT
from shakedown.ground.work_limit import all_cores, threads_of_blas
from shakedown.models.condensation.contact_frame import ContactFrame
from shakedown.models.condensation.fronts import FrontFactors, announced, dissection, elimination, factorised
from shakedown.models.condensation.load_case import LoadCase
from shakedown.models.condensation.stiffness_checks import Places, loose_motion

_COLUMNS = 64  # right-hand sides solved at a time, which limits the dense workspace to 64 vectors
_WORTH_THREADS = 1e12  # multiplications, a minute of one core; in fewer, threads wait for each other
# From so many rows on a solid interior is dissected by the positions of its nodes (``fronts``). SuperLU,
# which does not know these, needs larger factors, and a right-hand side for every contact displacement.
_LARGE = 4000


class WeldedCase(NamedTuple):
    """What a load case at factor 1 does while all contact nodes are welded.

    The reactions (q_w, p_w) at the contact, ((d + 1) n,) [force]; the nodal forces F and prescribed
    displacements of the load, the displacements u, and the forces K u − F that hold the model, (N,). All but
    the reactions are NaN where the load was run elsewhere.
    """

    reactions: FloatArray
    force: FloatArray
    prescribed: FloatArray
    u: FloatArray
    left: FloatArray

    def conjugate(self, other: "WeldedCase") -> float:
        """The displacement conjugate to this load under the other: forces times the other's displacements.

        Less prescribed displacements times the forces that hold the model under the other; NaN where a load
        was run elsewhere.
        """
        return float(self.force @ other.u - self.prescribed @ other.left)


@dataclass(frozen=True, eq=False)
class Interior:
    """The model in slips and gaps (v, w), its interior and its held rows, with the interior factorised.

    Attributes
    ----------
    K : (N, N)
        Stiffness of the model [force/length].
    T_c, T_i, T_h : (N, (d + 1) n), (N, i), (N, h)
        Displacements u = T_c (v, w) + T_i u_i + T_h u_h.
    free, held : (i,), (h,)
        Rows of the interior, and rows that are held.
    lu
        Factors of K_ii = T_iᵀ K T_i, for a large solid together with κ; None where nothing is condensed.
    """

    K: sparse.csr_array
    T_c: sparse.csr_array
    T_i: sparse.csr_array
    T_h: sparse.csr_array
    free: NDArray[np.intp]
    held: NDArray[np.intp]
    lu: SuperLU | FrontFactors | None

    def schur(self) -> tuple[FloatArray, float]:
        """κ, not yet made symmetric, and the largest force left on the interior, relative to max |κ|.

        For a large solid only a sample of unit displacements is checked, as many as are solved for at a time;
        the difference of κ from their reactions counts as well.
        """
        if isinstance(self.lu, FrontFactors):
            return self.lu.schur, self._left_over(self.lu)
        K_cc = (self.T_c.T @ self.K @ self.T_c).toarray()
        if self.lu is None:
            return K_cc, 0.0
        K_ii, K_ic = self.T_i.T @ self.K @ self.T_i, (self.T_i.T @ self.K @ self.T_c).tocsc()
        residual = 0.0
        for start in range(0, K_cc.shape[1], _COLUMNS):
            block = slice(start, start + _COLUMNS)
            load = K_ic[:, block].toarray()
            u = self.lu.solve(load)
            residual = max(residual, float(np.abs(K_ii @ u - load).max()))
            K_cc[:, block] -= K_ic.T @ u
        return K_cc, residual / max(float(np.abs(K_cc).max()), np.finfo(float).tiny)

    def _left_over(self, factors: FrontFactors) -> float:
        size = self.T_c.shape[1]
        chosen = np.unique(np.linspace(0, size - 1, min(_COLUMNS, size)).astype(int))
        moved = self.T_c[:, chosen]
        load = (self.T_i.T @ self.K @ moved).toarray()
        u = factors.solve(load)
        left = np.abs(self.T_i.T @ (self.K @ (self.T_i @ u)) - load).max()
        reaction = self.T_c.T @ (self.K @ (moved.toarray() - self.T_i @ u))
        wrong = np.abs(factors.schur[:, chosen] - reaction).max()
        return float(max(left, wrong) / max(np.abs(factors.schur).max(), np.finfo(float).tiny))

    def loosest(self, dofs: NDArray[np.intp], places: Places | None) -> str:
        """The motion of the interior with the least resistance, in words."""
        K_ii = (self.T_i.T @ self.K @ self.T_i).tocsc()
        return loose_motion(K_ii, dofs[self.free], places)

    def contact_motions(self, motions: FloatArray) -> FloatArray:
        """The slips and gaps ((d + 1) n, k) in motions (N, k) of the model."""
        apart = motions - self.T_i @ motions[self.free] - self.T_h @ motions[self.held]
        gram = (self.T_c.T @ self.T_c).tocsc()
        empty = gram.diagonal() == 0  # slips that are guided
        return np.asarray(splu(gram + sparse.diags_array(empty.astype(float))).solve(self.T_c.T @ apart))

    def welded(self, case: LoadCase) -> WeldedCase:
        """What a load case at factor 1 does with slip and gap zero and the interior in equilibrium."""
        size = self.K.shape[0]
        force, displacement = np.zeros(size), np.zeros(size)
        for key, target in (("force", force), ("displacement", displacement)):
            given = getattr(case, key)
            if given is None:
                continue
            if given.shape != (size,):
                raise ProblemError(f"{case.name}: {key}: expected shape ({size},), found {given.shape}")
            target[:] = given
        moved = np.setdiff1d(np.flatnonzero(displacement), self.held)
        if moved.size:
            raise ProblemError(
                f"{case.name}: displacement: expected it only at held rows, found free row {moved[0]}"
            )
        u = self.T_h @ displacement[self.held]
        if self.lu is not None:
            u = u + self.T_i @ self.lu.solve(self.T_i.T @ (force - self.K @ u))
        left = self.K @ u - force
        return WeldedCase(np.asarray(self.T_c.T @ left), force, displacement, np.asarray(u), np.asarray(left))


def interior_of(
    matrix: sparse.csr_array,
    dofs: NDArray[np.intp],
    frame: ContactFrame,
    held: NDArray[np.bool_],
    guided: NDArray[np.bool_],
    places: Places | None = None,
    announce: Callable[[str], None] | None = None,
) -> Interior:
    """Split a model into contact, interior and held rows and factorise its interior.

    ``announce`` is told beforehand what a large one will take.

    Raises
    ------
    ProblemError
        If the interior can move without resistance; the message says which nodes, and how. If a large
        one takes more memory than there is.
    """
    T_c, T_r, rest = frame.transformation(matrix.shape[0])
    T_c = T_c @ sparse.diags_array(np.concatenate([~guided, np.ones(frame.n, bool)]).astype(float))
    T_i, T_h = T_r[:, ~held[rest]], T_r[:, held[rest]]
    free = rest[~held[rest]]
    own, lu = dofs[free], None
    if frame.directions > 1 and len(own) >= _LARGE:
        lu = _by_fronts(matrix, sparse.hstack([T_i, T_c], format="csr"), own, places, announce)
    if lu is None:
        lu = _factorised((T_i.T @ matrix @ T_i).tocsc(), own, places)
    return Interior(matrix, T_c, T_i, T_h, free, rest[held[rest]], lu)


def _by_fronts(
    matrix: sparse.csr_array,
    T: sparse.csr_array,
    dofs: NDArray[np.intp],
    places: Places | None,
    announce: Callable[[str], None] | None,
) -> FrontFactors | None:
    """Factors of the interior, the first rows of Tᵀ K T; None where it is not clearly positive definite."""
    K, count = sparse.csr_array(T.T @ matrix @ T), len(dofs)
    nodes, index = np.unique(dofs[:, 0], return_inverse=True)
    of_node = sparse.csr_array((np.ones(count), (index, np.arange(count))))
    graph = sparse.csr_array(of_node @ abs(K[:count, :count]) @ of_node.T)
    pieces = dissection(graph, _known(nodes, places))
    unknowns = np.split(np.argsort(index, kind="stable"), np.cumsum(np.bincount(index))[:-1])
    plan = elimination(K, pieces, unknowns)
    announced(plan, announce)
    try:
        with threads_of_blas(all_cores() if plan.operations > _WORTH_THREADS else 1):
            factors = factorised(K, plan)
    except LinAlgError:
        return None
    pivots = factors.pivots
    return None if pivots.min() < DEFAULT.singular_pivot * pivots.max() else factors


def _known(nodes: NDArray[np.intp], places: Places | None) -> FloatArray | None:
    """Positions of nodes, (k, 3), a few unknown ones (rigid boundaries) in the middle; None without most."""
    found = [] if places is None else [places.get(node) for node in nodes.tolist()]
    there = [place for place in found if place is not None]
    if 2 * len(there) < len(nodes):
        return None
    middle = np.mean(there, axis=0)
    return np.array([middle if place is None else place for place in found], dtype=float)


def _factorised(K_ii: sparse.csc_array, dofs: NDArray[np.intp], places: Places | None) -> SuperLU | None:
    if K_ii.shape[0] == 0:
        return None
    try:
        lu = splu(K_ii, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.01, options={"SymmetricMode": True})
    except RuntimeError as error:
        if "singular" not in str(error):
            raise
        raise ProblemError(_loose(K_ii, dofs, places)) from None
    pivots = lu.U.diagonal()
    ratio = np.abs(pivots).min() / np.abs(pivots).max()
    signs_count = _elastic(K_ii, dofs) and np.array_equal(lu.perm_r, lu.perm_c)
    negative = (pivots < 0) & signs_count
    if negative.any() and np.abs(pivots[negative]).max() > DEFAULT.zero_mode * np.abs(pivots).max():
        raise ProblemError(
            f"K: expected an elastic interior, positive definite, found {negative.sum()} negative pivot(s) "
            f"in {len(dofs)} rows (a damaged file, a wrong sign, an unstable state?)"
        )
    if negative.any() or ratio < DEFAULT.singular_pivot:
        raise ProblemError(f"{_loose(K_ii, dofs, places)} (pivot ratio {ratio:.1e})")
    return lu


def _elastic(K_ii: sparse.csc_array, dofs: NDArray[np.intp]) -> bool:
    """Whether all rows are displacements; multipliers and pressures have pivots of either sign."""
    return bool((dofs[:, 0] > 0).all() and np.isin(dofs[:, 1], range(1, 7)).all() and K_ii.diagonal().all())


def _loose(K_ii: sparse.csc_array, dofs: NDArray[np.intp], places: Places | None) -> str:
    """The description of an interior that is not held, for a message."""
    expected = "K: expected an interior that the supports and the welded contact hold, found that it can move"
    try:
        return f"{expected}: {loose_motion(K_ii, dofs, places)}"
    except (ArpackError, RuntimeError, np.linalg.LinAlgError):  # the message then goes without a description
        return expected
