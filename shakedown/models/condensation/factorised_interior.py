"""The interior of an elastic model: one sparse factorization, many right-hand sides.

A large one is factorised front by front, with some unknowns kept to the end. The unknowns of each piece of a
dissection are eliminated in a dense matrix, the front. It holds them and the later unknowns that they are
coupled to; what remains of it is added to the front of the piece above. The kept unknowns are never
eliminated: what remains at the end is their Schur complement, and no right-hand side had to be solved for.
The order of elimination is a nested dissection by the positions of the nodes.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.linalg import LinAlgError
from scipy.linalg.blas import dsyrk, dtrsm
from scipy.linalg.lapack import dpotrf
from scipy.sparse.linalg import ArpackError, SuperLU, splu

from shakedown.ground.constants import FloatArray, IntArray, Mask, memory
from shakedown.ground.errors import ProblemError
from shakedown.ground.tolerances import DEFAULT
from shakedown.ground.work_limit import all_cores, threads_of_blas
from shakedown.models.condensation.contact_frame import ContactFrame
from shakedown.models.condensation.load_case import LoadCase
from shakedown.models.condensation.stiffness_checks import PlacesByNode, loose_motion

Piece = tuple[IntArray, tuple[int, ...]]  # nodes eliminated together; the places of the pieces beneath it


def dissection(graph: sparse.csr_array, where: FloatArray) -> list[Piece]:
    """Cut a graph in two again and again; every cut comes after both of its sides.

    Each part is cut across its longest side through the middle of its nodes. The cut is
    the nodes of one side that are coupled to the other: whichever are fewer.

    Parameters
    ----------
    graph : (k, k)
        Which nodes are coupled; symmetric pattern.
    where : (k, 3)
        Positions of the nodes [length].

    Examples
    --------
    >>> chain = sparse.csr_array(np.eye(200, k=1) + np.eye(200, k=-1))
    >>> pieces = dissection(chain, np.arange(200.0)[:, None])
    >>> [len(nodes) for nodes, _ in pieces], pieces[-1][0]
    ([48, 50, 1, 49, 50, 1, 1], array([99]))
    """
    found: list[Piece] = []
    mark = np.zeros(graph.shape[0], dtype=np.int8)

    def cut(nodes: IntArray) -> tuple[int, ...]:
        """Pieces of these nodes below no other: one, or those of parts that nothing couples."""
        if not nodes.size:
            return ()
        # nodes eliminated together without further dissection
        if len(nodes) <= 60:
            return (made(nodes, ()),)
        axis = int(np.argmax(np.ptp(where[nodes], axis=0)))
        order = nodes[np.argsort(where[nodes, axis], kind="stable")]
        one, other = order[: len(order) // 2], order[len(order) // 2 :]
        between, own = min((facing(one, other), 0), (facing(other, one), 1), key=lambda side: len(side[0]))
        sides = [one, other]
        sides[own] = np.setdiff1d(sides[own], between, assume_unique=True)
        children = cut(sides[0]) + cut(sides[1])
        return (made(between, children),) if between.size else children

    def facing(side: IntArray, beyond: IntArray) -> IntArray:
        """Nodes of one side that are coupled to the other."""
        mark[beyond] = 1
        rows = graph[side]
        touching = np.add.reduceat(np.append(mark[rows.indices], 0), rows.indptr[:-1].clip(max=rows.nnz))
        mark[beyond] = 0
        return side[(touching > 0) & (np.diff(rows.indptr) > 0)]

    def made(nodes: IntArray, children: tuple[int, ...]) -> int:
        found.append((np.sort(nodes), children))
        return len(found) - 1

    cut(np.arange(graph.shape[0]))
    return found


class Front(NamedTuple):
    """One step of the elimination; unknowns are numbered in its order.

    Attributes
    ----------
    start, stop
        The unknowns that are eliminated.
    beyond : (u,)
        Later unknowns that they are coupled to by then, in increasing order.
    children
        The fronts whose remainder is added to this one.
    """

    start: int
    stop: int
    beyond: IntArray
    children: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class FrontElimination:
    """The plan of an elimination: order of the unknowns, and its cost.

    Attributes
    ----------
    order : (N,)
        Unknowns in the order of elimination, the kept ones last.
    count
        How many are eliminated.
    fronts
        In order, each after its children.
    """

    order: IntArray
    count: int
    fronts: list[Front]

    @property
    def cost(self) -> tuple[float, float]:
        """Multiplications of the factorisation, about, and the largest memory at one time [bytes].

        That are factors, the fronts that wait, and the one in work.
        """
        operations = factors = waiting = most = 0.0
        for front in self.fronts:
            own, beyond = float(front.stop - front.start), float(len(front.beyond))
            operations += own**3 / 3 + own**2 * beyond + own * beyond**2
            factors += own * own + own * beyond
            most = max(most, factors + waiting + 2 * beyond * beyond)
            waiting += beyond * beyond - sum(len(self.fronts[child].beyond) ** 2 for child in front.children)
        return operations, 8 * (most + 2 * float(len(self.order) - self.count) ** 2)


@dataclass(eq=False)
class FrontFactors:
    """Factors of the eliminated unknowns, and the Schur complement of the others.

    Attributes
    ----------
    plan : FrontElimination
        The order.
    schur : (k, k)
        Schur complement of the kept unknowns, in the order given.
    """

    plan: FrontElimination
    schur: FloatArray
    _parts: list[tuple[FloatArray, FloatArray]] = field(default_factory=list)

    @property
    def pivots(self) -> FloatArray:
        """The pivots, (N − k,)."""
        return np.concatenate([np.diagonal(L) ** 2 for L, _ in self._parts])

    def solve(self, right: FloatArray) -> FloatArray:
        """K_ii⁻¹ b for right sides (N − k,) or (N − k, r), in the order of the unknowns."""
        places = np.empty(self.plan.count, dtype=np.intp)
        places[self.plan.order[: self.plan.count]] = np.arange(self.plan.count)
        x = np.zeros((len(self.plan.order), 1 if right.ndim == 1 else right.shape[1]))
        x[: self.plan.count] = right.reshape(self.plan.count, -1)[self.plan.order[: self.plan.count]]
        for front, (L, below) in zip(self.plan.fronts, self._parts, strict=True):
            own = slice(front.start, front.stop)
            x[own] = dtrsm(1.0, L, x[own], lower=1)
            x[front.beyond] -= below @ x[own]
        x[self.plan.count :] = 0.0
        for front, (L, below) in zip(reversed(self.plan.fronts), reversed(self._parts), strict=True):
            own = slice(front.start, front.stop)
            x[own] = dtrsm(1.0, L, x[own] - below.T @ x[front.beyond], lower=1, trans_a=1)
        return x[: self.plan.count][places].reshape(right.shape)


def elimination(
    K: sparse.csr_array, pieces: Sequence[Piece], unknowns: Sequence[IntArray]
) -> FrontElimination:
    """Plan the elimination of all unknowns of the pieces; those of no piece are kept.

    Parameters
    ----------
    K : (N, N)
        Symmetric matrix, kept unknowns last.
    pieces
        The pieces into which the nodes are dissected.
    unknowns
        The unknowns of every node.
    """
    parts = [np.concatenate([unknowns[node] for node in nodes.tolist()]) for nodes, _ in pieces]
    count = sum(map(len, parts))
    order = np.concatenate([*parts, np.arange(count, K.shape[0])])
    place = np.empty(len(order), dtype=np.intp)
    place[order] = np.arange(len(order))
    fronts: list[Front] = []
    stop = 0
    for (_, children), part in zip(pieces, parts, strict=True):
        start, stop = stop, stop + len(part)
        coupled = [place[K[part].indices], *(fronts[child].beyond for child in children)]
        later = np.unique(np.concatenate(coupled))
        fronts.append(Front(start, stop, later[later >= stop], children))
    return FrontElimination(order, count, fronts)


def factorised(K: sparse.csr_array, plan: FrontElimination) -> FrontFactors:
    """Eliminate as planned.

    Raises
    ------
    LinAlgError
        If what is eliminated is not positive definite.
    """
    permuted = sparse.csc_array(K[plan.order][:, plan.order])
    permuted.sort_indices()
    last = slice(plan.count, None)
    factors = FrontFactors(plan, np.asfortranarray(permuted[last, last].toarray()))
    rests: dict[int, FloatArray] = {}
    roots = set(range(len(plan.fronts))) - {c for front in plan.fronts for c in front.children}
    for number, front in enumerate(plan.fronts):
        L, below, rest = _assembled(permuted, front, [(plan.fronts[c], rests.pop(c)) for c in front.children])
        L, info = dpotrf(L, lower=1, clean=1, overwrite_a=1)
        if info:
            raise LinAlgError(f"not positive definite at unknown {front.start + info - 1}")
        below = dtrsm(1.0, L, below, side=1, lower=1, trans_a=1, overwrite_b=1)
        if len(front.beyond):
            rest = dsyrk(-1.0, below, 1.0, rest, lower=1, overwrite_c=1)
        factors._parts.append((L, below))
        if number in roots:
            _add(factors.schur, rest, front.beyond - plan.count)
        else:
            rests[number] = rest
    lower = np.tril(factors.schur)
    factors.schur = lower + np.tril(lower, -1).T
    return factors


def _assembled(
    K: sparse.csc_array, front: Front, children: Sequence[tuple[Front, FloatArray]]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A front before its elimination, in parts: own unknowns, their coupling to later ones, the later ones.

    Of the square parts only the lower triangles count.
    """
    own, size = front.stop - front.start, len(front.beyond)
    corner, below = np.zeros((own, own), order="F"), np.zeros((size, own), order="F")
    rest = np.zeros((size, size), order="F")
    columns = K[:, front.start : front.stop].tocoo()
    row, column = columns.coords
    inside = (row >= front.start) & (row < front.stop)
    corner[row[inside] - front.start, column[inside]] = columns.data[inside]
    later = row >= front.stop
    below[np.searchsorted(front.beyond, row[later]), column[later]] = columns.data[later]
    for child, part in children:
        split = int(np.searchsorted(child.beyond, front.stop))
        first = child.beyond[:split] - front.start
        second = np.searchsorted(front.beyond, child.beyond[split:])
        _add(corner, part[:split, :split], first)
        for k, place in enumerate(first.tolist()):
            below.T[place][second] += part[split:, k]
        _add(rest, part[split:, split:], second)
    return corner, below, rest


def _add(target: FloatArray, part: FloatArray, places: IntArray) -> None:
    """Add a lower triangle to places of a larger one, column by column, as both lie in memory."""
    for k, place in enumerate(places.tolist()):
        target.T[place][places[k:]] += part[k:, k]


def check_memory(plan: FrontElimination, needed: float) -> None:
    """Raise ``ProblemError`` if an elimination takes more memory [bytes] than the machine has."""
    kept = len(plan.order) - plan.count
    needed += 8 * 8 * float(kept) ** 2  # matrices like κ held at one time by the problem and the bounds
    # share of the machine's memory that may be used
    if needed > 0.9 * (there := memory()):
        raise ProblemError(
            f"K: expected a model that fits into {there / 2**30:.3g} GiB of memory, found that condensing "
            f"{plan.count} rows to {kept // 3} contact nodes takes about {needed / 2**30:.2g} GiB; take "
            "fewer contact nodes or a coarser mesh"
        )


_COLUMNS = 64  # right-hand sides solved at a time, which limits the dense workspace to 64 vectors
# From so many rows on a solid interior is dissected by the positions of its nodes. SuperLU, which does not
# know these, needs larger factors, and a right-hand side for every contact displacement.
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
    free: IntArray
    held: IntArray
    lu: SuperLU | FrontFactors | None

    def schur(self) -> tuple[FloatArray, float]:
        """κ, not yet made symmetric, and the largest force left on the interior, relative to max |κ|.

        For a large solid only a sample of unit displacements is checked, as many as are solved for at a time;
        the difference of κ from their reactions counts as well.
        """
        if isinstance(self.lu, FrontFactors):
            return self.lu.schur, self._sampled_residual(self.lu)
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

    def _sampled_residual(self, factors: FrontFactors) -> float:
        size = self.T_c.shape[1]
        chosen = np.unique(np.linspace(0, size - 1, min(_COLUMNS, size)).astype(int))
        moved = self.T_c[:, chosen]
        load = (self.T_i.T @ self.K @ moved).toarray()
        u = factors.solve(load)
        left = np.abs(self.T_i.T @ (self.K @ (self.T_i @ u)) - load).max()
        reaction = self.T_c.T @ (self.K @ (moved.toarray() - self.T_i @ u))
        wrong = np.abs(factors.schur[:, chosen] - reaction).max()
        return float(max(left, wrong) / max(np.abs(factors.schur).max(), np.finfo(float).tiny))

    def loosest(self, dofs: IntArray, places: PlacesByNode | None) -> str:
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
    dofs: IntArray,
    frame: ContactFrame,
    held: Mask,
    guided: Mask,
    places: PlacesByNode | None = None,
) -> Interior:
    """Split a model into contact, interior and held rows and factorise its interior.

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
        lu = _by_fronts(matrix, sparse.hstack([T_i, T_c], format="csr"), own, places)
    if lu is None:
        lu = _factorised((T_i.T @ matrix @ T_i).tocsc(), own, places)
    return Interior(matrix, T_c, T_i, T_h, free, rest[held[rest]], lu)


def _by_fronts(
    matrix: sparse.csr_array,
    T: sparse.csr_array,
    dofs: IntArray,
    places: PlacesByNode | None,
) -> FrontFactors | None:
    """Factors of the interior, the first rows of Tᵀ K T.

    None where it is not clearly positive definite, or most places are not known.
    """
    K, count = sparse.csr_array(T.T @ matrix @ T), len(dofs)
    nodes, index = np.unique(dofs[:, 0], return_inverse=True)
    known = [] if places is None else [places.get(node) for node in nodes.tolist()]
    there = [place for place in known if place is not None]
    if 2 * len(there) < len(nodes):
        return None
    middle = np.mean(there, axis=0)  # for the few others (rigid boundaries)
    of_node = sparse.csr_array((np.ones(count), (index, np.arange(count))))
    graph = sparse.csr_array(of_node @ abs(K[:count, :count]) @ of_node.T)
    pieces = dissection(graph, np.array([middle if place is None else place for place in known], float))
    unknowns = np.split(np.argsort(index, kind="stable"), np.cumsum(np.bincount(index))[:-1])
    plan = elimination(K, pieces, unknowns)
    operations, needed = plan.cost
    check_memory(plan, needed)
    try:
        # in fewer multiplications, threads wait for each other
        with threads_of_blas(all_cores() if operations > 1e12 else 1):
            factors = factorised(K, plan)
    except LinAlgError:
        return None
    pivots = factors.pivots
    return None if pivots.min() < DEFAULT.singular_pivot * pivots.max() else factors


def _factorised(K_ii: sparse.csc_array, dofs: IntArray, places: PlacesByNode | None) -> SuperLU | None:
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
    # multipliers and pressures have pivots of either sign
    elastic = (dofs[:, 0] > 0).all() and np.isin(dofs[:, 1], range(1, 7)).all() and K_ii.diagonal().all()
    negative = (pivots < 0) & bool(elastic and np.array_equal(lu.perm_r, lu.perm_c))
    if negative.any() and np.abs(pivots[negative]).max() > DEFAULT.zero_mode * np.abs(pivots).max():
        raise ProblemError(
            f"K: expected an elastic interior, positive definite, found {negative.sum()} negative pivot(s) "
            f"in {len(dofs)} rows (a damaged file, a wrong sign, an unstable state?)"
        )
    if negative.any() or ratio < DEFAULT.singular_pivot:
        raise ProblemError(f"{_loose(K_ii, dofs, places)} (pivot ratio {ratio:.1e})")
    return lu


def _loose(K_ii: sparse.csc_array, dofs: IntArray, places: PlacesByNode | None) -> str:
    """The description of an interior that is not held, for a message."""
    expected = "K: expected an interior that the supports and the welded contact hold, found that it can move"
    try:
        return f"{expected}: {loose_motion(K_ii, dofs, places)}"
    except (ArpackError, RuntimeError, np.linalg.LinAlgError):  # the message then goes without a description
        return expected
