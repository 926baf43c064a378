"""Critical load factors: every (n+1)-subset of the 2n rows taken as equalities (thesis (5.11), (5.12))."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import combinations, islice
from math import comb, inf, nan
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from shakedown.constraints import Constraints, constraints
from shakedown.errors import BudgetExceeded
from shakedown.linear_program import equilibration
from shakedown.problem import FloatArray, Problem
from shakedown.tolerances import DEFAULT

Progress = Callable[[int, int], None]
Candidate = tuple[float, tuple[int, ...]]
BATCH = 4096
LISTED = 1000


@dataclass(frozen=True)
class Intersection:
    """The point in slip space and load factor where n + 1 rows meet.

    Attributes
    ----------
    load_factor
        λ; NaN where there is no such point.
    slip : (n,)
        v [length].
    rows
        (node, side) of the n + 1 rows.
    residual
        Largest distance from one of these rows, relative to its terms.
    excess
        Largest violation of any of the 2n rows, relative to its terms; ≤ 0 (to round-off)
        where the point lies on the safe region.
    """

    load_factor: float
    slip: FloatArray
    rows: tuple[tuple[int, int], ...]
    residual: float
    excess: float


@dataclass(frozen=True)
class CriticalLoadFactors:
    """All critical load factors of a problem.

    Attributes
    ----------
    total
        Number of subsets, C(2n, n + 1) = ``regular`` + ``degenerate``.
    regular
        Subsets whose rows meet in one point.
    degenerate
        Subsets whose rows do not, to the tolerance ``degeneracy``: they have no load factor.
    degenerate_rows
        (node, side) of the rows of each degenerate subset, the first ``LISTED`` of them.
    smallest_positive
        The smallest positive critical load factor, the thesis's λ_min. For more
        than two nodes it grossly underestimates the first collapse, because most
        intersections lie outside the safe region.
    smallest_feasible
        The smallest positive one that lies on the safe region: the first collapse λ_1.
    load_factors : (regular,)
        All of them, sorted, where asked for, else None.
    """

    total: int
    regular: int
    degenerate: int
    degenerate_rows: tuple[tuple[tuple[int, int], ...], ...]
    smallest_positive: Intersection
    smallest_feasible: Intersection
    load_factors: FloatArray | None = None


def subset_count(n: int) -> int:
    """Number of (n+1)-subsets of 2n rows.

    Examples
    --------
    >>> subset_count(9)
    43758
    """
    return comb(2 * n, n + 1)


def critical_load_factors(
    problem: Problem,
    *,
    budget: int = 1_000_000,
    values: bool = False,
    progress: Progress | None = None,
) -> CriticalLoadFactors:
    """Every intersection of n + 1 frictional constraints (thesis (5.11), (5.12)).

    Parameters
    ----------
    problem
        The contact and its loading loop.
    budget
        Largest number of subsets to work through.
    values
        Whether to keep, and sort, all load factors.
    progress
        Called as ``progress(done, total)`` from time to time.

    Raises
    ------
    BudgetExceeded
        If there are more subsets than the budget; says how long they would take.

    Examples
    --------
    >>> import shakedown
    >>> critical = shakedown.critical_load_factors(shakedown.example("two-node"), values=True)
    >>> critical.total, critical.degenerate, critical.load_factors.round(6)
    (4, 0, array([0.657373, 0.739146, 1.05252 , 2.93485 ]))
    """
    rows = constraints(problem)
    total = subset_count(rows.n)
    _check_budget(rows, total, budget)
    best: Candidate = (inf, ())
    safest: Candidate = (inf, ())
    kept: list[FloatArray] = []
    listed: list[tuple[tuple[int, int], ...]] = []
    degenerate = done = 0
    for batch in intersections(rows):
        best = min(best, _smallest(batch, batch.positive), key=_first)
        safest = min(safest, _smallest(batch, batch.positive & batch.feasible), key=_first)
        singular = np.flatnonzero(~batch.regular)
        degenerate += singular.size
        listed += [_named(rows, batch.subsets[i]) for i in singular[: LISTED - len(listed)]]
        if values:
            kept.append(batch.load_factor[batch.regular])
        done += len(batch.subsets)
        if progress is not None:
            progress(done, total)
    return CriticalLoadFactors(
        total=total,
        regular=total - degenerate,
        degenerate=degenerate,
        degenerate_rows=tuple(listed),
        smallest_positive=_intersection(rows, best[1]),
        smallest_feasible=_intersection(rows, safest[1]),
        load_factors=np.sort(np.concatenate(kept)) if values else None,
    )


@dataclass(frozen=True)
class Batch:
    """Some subsets and what they give: (b, n+1) row indices, (b,) values, (b, n) slips, (b,) verdicts."""

    subsets: NDArray[np.intp]
    load_factor: FloatArray
    slip: FloatArray
    regular: NDArray[np.bool_]
    positive: NDArray[np.bool_]
    feasible: NDArray[np.bool_]


def intersections(rows: Constraints, size: int = BATCH) -> Iterator[Batch]:
    """Work through all (n+1)-subsets of the rows in lexicographic order, batch by batch."""
    matrix = np.column_stack([rows.G, rows.d])
    row_scale, column_scale = equilibration(matrix)
    scaled = matrix * row_scale[:, None] * column_scale
    right = rows.g * row_scale
    candidates = combinations(range(2 * rows.n), rows.n + 1)
    while chunk := list(islice(candidates, size)):
        yield _solved(np.array(chunk), scaled, right, column_scale)


def _solved(
    subsets: NDArray[np.intp], matrix: FloatArray, right: FloatArray, column_scale: FloatArray
) -> Batch:
    square, target = matrix[subsets], right[subsets]
    spectrum = np.linalg.svd(square, compute_uv=False)
    condition = spectrum[:, -1] / np.where(spectrum[:, 0] > 0, spectrum[:, 0], 1.0)
    regular = condition > DEFAULT.degeneracy
    x = np.full(subsets.shape, nan)
    x[regular] = np.linalg.solve(square[regular], target[regular][..., None])[..., 0]
    with np.errstate(invalid="ignore", divide="ignore"):
        size = np.abs(x).max(axis=1)
        blur = np.finfo(float).eps * size / condition  # what round-off leaves of a zero load factor
        excess = (x @ matrix.T - right).max(axis=1)
        reach = np.maximum(size * np.abs(matrix).max(), np.abs(right).max())
    return Batch(
        subsets=subsets,
        load_factor=x[:, -1] * column_scale[-1],
        slip=x[:, :-1] * column_scale[:-1],
        regular=regular,
        positive=regular & (x[:, -1] > blur),
        feasible=regular & (excess <= DEFAULT.feasibility * reach),
    )


def _smallest(batch: Batch, admitted: NDArray[np.bool_]) -> Candidate:
    """(load factor, rows) of the smallest admitted value of a batch."""
    if not admitted.any():
        return inf, ()
    i = int(np.argmin(np.where(admitted, batch.load_factor, inf)))
    return float(batch.load_factor[i]), tuple(batch.subsets[i].tolist())


def _first(candidate: Candidate) -> float:
    return candidate[0]


def _intersection(rows: Constraints, subset: tuple[int, ...]) -> Intersection:
    if not subset:
        return Intersection(nan, np.full(rows.n, nan), (), nan, nan)
    chosen = list(subset)
    matrix = np.column_stack([rows.G, rows.d])[chosen]
    row_scale, column_scale = equilibration(matrix)
    x = np.linalg.solve(matrix * row_scale[:, None] * column_scale, rows.g[chosen] * row_scale) * column_scale
    excess = rows.relative_excess(x[:-1], x[-1])
    return Intersection(
        load_factor=float(x[-1]),
        slip=x[:-1],
        rows=_named(rows, chosen),
        residual=float(np.abs(excess[chosen]).max()),
        excess=float(excess.max()),
    )


def _named(rows: Constraints, subset: NDArray[np.intp] | list[int]) -> tuple[tuple[int, int], ...]:
    return tuple((int(rows.node[i]), int(rows.side[i])) for i in subset)


def _check_budget(rows: Constraints, total: int, budget: int) -> None:
    """Refuse more subsets than the budget, with the time that a first batch lets one expect."""
    if total <= budget:
        return
    start = perf_counter()
    next(intersections(rows, size=256))
    seconds = (perf_counter() - start) * total / 256
    raise BudgetExceeded(
        f"{total:,} subsets of {rows.n + 1} rows are more than the budget of {budget:,}; "
        f"they would take about {_duration(seconds)} on this machine"
    )


def _duration(seconds: float) -> str:
    for unit, size in (("years", 3.156e7), ("days", 86400.0), ("hours", 3600.0), ("minutes", 60.0)):
        if seconds >= 2 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.2g} seconds"
