"""Critical load factors: every (n+1)-subset of the 2n rows taken as equalities (thesis (5.11), (5.12))."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import combinations, islice
from math import comb, inf, nan
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.collapse.lower import lower_bound
from shakedown.ground.argument_kinds import check_count
from shakedown.ground.constants import BATCH, NEGLIGIBLE, FloatArray
from shakedown.ground.errors import BudgetExceeded, UsageError
from shakedown.ground.shown_values import plain
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked, require_plane
from shakedown.joint.constraints import Constraints, constraints, rows_named
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.programs.program import equilibration

Progress = Callable[[int, int], None]
SMALL = 20_000  # up to here batches are done before compiled code is loaded, and all values are kept
COUNTABLE = 10**21  # from so many subsets on, neither their number nor a time is given exactly
MOST_NODES = 10_000  # nodes; limits the digits of the number of subsets


Candidate = tuple[float, tuple[int, ...]]
NONE: Candidate = (inf, ())


@dataclass(frozen=True, eq=False, repr=False)
class Intersection(Result):
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

    DOCUMENT: ClassVar[str] = "load_factor slip rows residual"
    TABLE: ClassVar[str] = "slip"

    load_factor: float
    slip: FloatArray
    rows: tuple[tuple[int, int], ...]
    residual: float
    excess: float


@dataclass(frozen=True)
class ScaledRows:
    """The 2n rows with every row and column near the size 1.

    Attributes
    ----------
    matrix : (2n, n + 1)
        [G | d], equilibrated.
    right : (2n,)
        g, scaled like the rows.
    column_scale : (n + 1,)
        Unscaled unknowns = scaled ones times this.
    """

    matrix: FloatArray
    right: FloatArray
    column_scale: FloatArray


def scaled_rows(rows: Constraints) -> ScaledRows:
    """Equilibrate the rows of a problem by powers of two, the same way in all units."""
    stiffness, force = _power(rows.coefficients), _power(np.column_stack([rows.d, rows.g]))
    matrix = np.column_stack([np.ldexp(rows.coefficients, -stiffness), np.ldexp(rows.d, -force)])
    row_scale, column_scale = equilibration(matrix)
    unit = np.append(np.full(rows.n, np.ldexp(1.0, force - stiffness)), 1.0)
    right = np.ldexp(rows.g, -force) * row_scale
    return ScaledRows(matrix * row_scale[:, None] * column_scale, right, column_scale * unit)


def _power(values: FloatArray) -> int:
    """The exponent of the largest: dividing by that power of two gives the same bits in all units."""
    return int(np.frexp(np.abs(values).max(initial=0.0))[1])


def intersection(rows: Constraints, subset: Iterable[int]) -> Intersection:
    """One intersection, solved in its own scale, with its residuals; NaN for the empty subset."""
    chosen = list(subset)
    if not chosen:
        return Intersection(nan, np.full(rows.n, nan), (), nan, nan)
    scaled = scaled_rows(rows)
    row_scale, column_scale = equilibration(scaled.matrix[chosen])
    matrix = scaled.matrix[chosen] * row_scale[:, None] * column_scale
    x = np.linalg.solve(matrix, scaled.right[chosen] * row_scale) * column_scale * scaled.column_scale
    excess = rows.relative_excess(x[:-1], x[-1])
    return Intersection(
        load_factor=float(x[-1]),
        slip=x[:-1],
        rows=rows_named(rows, np.array(chosen)),
        residual=float(np.abs(excess[chosen]).max()),
        excess=float(excess.max()),
    )


@dataclass(frozen=True)
class SubtreeFindings:
    """The findings of a part of the tree.

    Attributes
    ----------
    subsets, regular
        Number of subsets worked through, and of those with a load factor.
    smallest_positive, smallest_feasible
        (load factor, rows) of the smallest positive one, and of the smallest on the safe region.
    load_factors
        Of all regular ones, where asked for.
    """

    subsets: int
    regular: int
    smallest_positive: Candidate
    smallest_feasible: Candidate
    load_factors: FloatArray


def solve_subsets(
    subsets: NDArray[np.intp], rows: ScaledRows, tolerances: Tolerances, *, values: bool
) -> SubtreeFindings:
    """What subsets (b, n + 1) of the rows give; those that are singular to the tolerance give nothing."""
    square, target = rows.matrix[subsets], rows.right[subsets]
    spectrum = np.linalg.svd(square, compute_uv=False)
    condition = spectrum[:, -1] / np.where(spectrum[:, 0] > 0, spectrum[:, 0], 1.0)
    regular = condition > tolerances.degeneracy
    x = np.full(subsets.shape, nan)
    x[regular] = np.linalg.solve(square[regular], target[regular][..., None])[..., 0]
    with np.errstate(invalid="ignore", divide="ignore"):
        size = np.abs(x).max(axis=1)
        blur = np.finfo(float).eps * size / condition  # round-off of a zero load factor
        excess = (x @ rows.matrix.T - rows.right).max(axis=1)
        reach = np.maximum(size * np.abs(rows.matrix).max(), np.abs(rows.right).max())
    load_factors = x[:, -1] * rows.column_scale[-1]
    positive = regular & (x[:, -1] > blur)
    feasible = positive & (excess <= tolerances.feasibility * reach)

    def smallest(admitted: NDArray[np.bool_]) -> Candidate:
        if not admitted.any():
            return NONE
        i = int(np.argmin(np.where(admitted, load_factors, inf)))
        return float(load_factors[i]), tuple(subsets[i].tolist())

    return SubtreeFindings(
        subsets=len(subsets),
        regular=int(regular.sum()),
        smallest_positive=smallest(positive),
        smallest_feasible=smallest(feasible),
        load_factors=load_factors[regular] if values else np.empty(0),
    )


def in_batches(subsets: Iterator[tuple[int, ...]]) -> Iterator[list[tuple[int, ...]]]:
    """The same subsets, ``BATCH`` at a time."""
    return iter(lambda: list(islice(subsets, BATCH)), [])


def joined(parts: list[SubtreeFindings]) -> SubtreeFindings:
    """Several findings combined."""
    return SubtreeFindings(
        subsets=sum(part.subsets for part in parts),
        regular=sum(part.regular for part in parts),
        smallest_positive=min((part.smallest_positive for part in parts), default=NONE),
        smallest_feasible=min((part.smallest_feasible for part in parts), default=NONE),
        load_factors=np.concatenate([part.load_factors for part in parts]) if parts else np.empty(0),
    )


@dataclass(frozen=True, eq=False, repr=False)
class CriticalLoadFactors(Result):
    """All critical load factors of a problem.

    Attributes
    ----------
    total
        Number of subsets, C(2n, n + 1).
    regular
        Subsets whose rows meet in one point, as counted.
    degenerate
        Subsets whose rows do not, to the tolerance ``degeneracy``, as counted: they have
        no load factor. With ``regular`` they make up ``total``.
    smallest_positive
        The smallest positive critical load factor, the thesis's λ_min. For more
        than two nodes it grossly underestimates the first collapse, because most
        intersections lie outside the safe region.
    smallest_feasible
        The smallest positive one that lies on the safe region: the first collapse
        λ_1, where that is positive.
    load_factors : (regular,)
        All of them, sorted, where asked for, else None.
    """

    DOCUMENT: ClassVar[str] = "total regular degenerate smallest_positive smallest_feasible"
    TABLE: ClassVar[str] = "load_factors"

    total: int
    regular: int
    degenerate: int
    smallest_positive: Intersection
    smallest_feasible: Intersection
    load_factors: FloatArray | None = None

    def to_dict(self) -> dict[str, Any]:
        """As :meth:`Result.to_dict`; the load factors are in it where they were asked for."""
        listed = {} if self.load_factors is None else {"load_factors": plain(self.load_factors)}
        return super().to_dict() | listed


@checked
def subset_count(n: int, smooth: int = 0) -> int:
    """Number of (n+1)-subsets of 2n rows, and of one more for each of so many nodes without friction.

    Examples
    --------
    >>> subset_count(9)
    43758
    """
    if not 0 <= n <= MOST_NODES:
        raise UsageError(f"n: expected a number of nodes from 0 to {MOST_NODES:,}, found {n}")
    if not 0 <= smooth <= n:
        raise UsageError(f"smooth: expected a number from 0 to {n:,}, found {smooth}")
    return comb(2 * n + smooth, n + 1)


@checked
def critical_load_factors(
    problem: Problem,
    *,
    budget: int = 200_000_000,
    values: bool | None = None,
    progress: Progress | None = None,
    threads: int | None = None,
    tolerances: Tolerances = DEFAULT,
) -> CriticalLoadFactors:
    """Every intersection of n + 1 frictional constraints (thesis (5.11), (5.12)).

    Parameters
    ----------
    problem
        The contact and its loading loop.
    budget
        Largest number of subsets to work through.
    values
        Whether to keep, and sort, all load factors (8 bytes each); by default where there are at most 20,000.
    progress
        Called as ``progress(done, total)`` from time to time.
    threads
        Number of threads; all cores by default.
    tolerances
        What counts as degenerate and as safe.

    Raises
    ------
    BudgetExceeded
        If there are more subsets than the budget; says how long they would take.
    UsageError
        If the number of threads is not a whole number ≥ 1.

    Examples
    --------
    >>> import shakedown
    >>> critical = shakedown.critical_load_factors(shakedown.example("two-node"))
    >>> critical.total, critical.degenerate, critical.load_factors.round(6)
    (4, 0, array([0.657373, 0.739146, 1.05252 , 2.93485 ]))
    """
    require_plane("critical load factors", problem, "there are no (n+1)-subsets of cones")
    if threads is not None:
        check_count("threads", threads)
    rows = constraints(problem)
    scaled, total = scaled_rows(rows), subset_count(rows.n, len(rows.g) - 2 * rows.n)
    if not isinstance(budget, int):
        raise UsageError(f"budget: expected a whole number, found {budget!r}")
    _check_budget(rows, total, budget)
    if total <= SMALL:
        values = True if values is None else values
        batches = in_batches(combinations(range(len(rows.g)), rows.n + 1))
        parts = (solve_subsets(np.array(batch), scaled, tolerances, values=values) for batch in batches)
    else:
        from shakedown.bounds.enumeration.walk_kernel import Tree, pieces  # compiled, loaded where it is used

        first = lower_bound(problem, certify=False, tolerances=tolerances).load_factor
        # just above λ_1, where there is one: no smaller positive load factor lies on the safe region
        below, values = first * (1.0 + NEGLIGIBLE) if first > 0.0 else inf, bool(values)
        parts = pieces(Tree(scaled, values, below, tolerances), threads)
    pieces_found = list[SubtreeFindings]()
    for part in parts:
        pieces_found.append(part)
        if progress is not None:
            progress(sum(each.subsets for each in pieces_found), total)
    found = joined(pieces_found)
    return CriticalLoadFactors(
        total=total,
        regular=found.regular,
        degenerate=total - found.regular,
        smallest_positive=intersection(rows, found.smallest_positive[1]),
        smallest_feasible=intersection(rows, found.smallest_feasible[1]),
        load_factors=np.sort(found.load_factors) if values else None,
    )


def _check_budget(rows: Constraints, total: int, budget: int) -> None:
    """Refuse more subsets than the budget, and say about how long they would take."""
    if total > budget:
        shown = f"{total:,}" if total < COUNTABLE else f"about 10^{len(str(total)) - 1}"
        # seconds of one core for a subset, as the study `enumeration` measured from 10 nodes on
        seconds = 4e-8 * min(total, COUNTABLE)
        time = f"{seconds:.2g} seconds" if seconds < 3600 else f"{seconds / 3600:.2g} hours"
        raise BudgetExceeded(
            f"{shown} subsets of {rows.n + 1} rows are more than the budget of {budget:,}; "
            f"they would take {'about' if total < COUNTABLE else 'more than'} {time} on one core"
        )
