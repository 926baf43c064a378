"""Critical load factors: every (n+1)-subset of the 2n rows taken as equalities (thesis (5.11), (5.12))."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import combinations
from math import comb, inf
from typing import Any, ClassVar

import numpy as np

from shakedown.bounds import intersection
from shakedown.bounds.intersection import Intersection, SubtreeFindings
from shakedown.bounds.lower import lower_bound
from shakedown.ground.argument_kinds import check_count
from shakedown.ground.constants import NEGLIGIBLE, FloatArray
from shakedown.ground.errors import BudgetExceeded, UsageError
from shakedown.ground.shown_values import plain
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked, require_plane
from shakedown.joint.constraints import Constraints, constraints
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result

Progress = Callable[[int, int], None]
SMALL = 20_000  # up to here batches are done before compiled code is loaded, and all values are kept
COUNTABLE = 10**21  # from so many subsets on, neither their number nor a time is given exactly
MOST_NODES = 10_000  # nodes; limits the digits of the number of subsets


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
def subset_count(n: int, frictionless: int = 0) -> int:
    """Number of (n+1)-subsets of 2n rows, and of one more for each of so many nodes without friction.

    Examples
    --------
    >>> subset_count(9)
    43758
    """
    if not 0 <= n <= MOST_NODES:
        raise UsageError(f"n: expected a number of nodes from 0 to {MOST_NODES:,}, found {n}")
    if not 0 <= frictionless <= n:
        raise UsageError(f"frictionless: expected a number from 0 to {n:,}, found {frictionless}")
    return comb(2 * n + frictionless, n + 1)


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
    scaled, total = intersection.scaled_rows(rows), subset_count(rows.n, len(rows.g) - 2 * rows.n)
    _check_budget(rows, total, budget)
    if total <= SMALL:
        values = True if values is None else values
        batches = intersection.in_batches(combinations(range(len(rows.g)), rows.n + 1))
        parts: Iterator[SubtreeFindings] = (
            intersection.solve_subsets(np.array(each), scaled, tolerances, values=values) for each in batches
        )
    else:
        from shakedown.bounds.walk_kernel import Tree, pieces  # compiled, loaded where it is used

        first = lower_bound(problem, certify=False, tolerances=tolerances).load_factor
        # just above λ_1, where there is one: no smaller positive load factor lies on the safe region
        below, values = first * (1.0 + NEGLIGIBLE) if first > 0.0 else inf, bool(values)
        parts = pieces(Tree(scaled, values, below, tolerances), threads)
    pieces_found = list[SubtreeFindings]()
    for part in parts:
        pieces_found.append(part)
        if progress is not None:
            progress(sum(each.subsets for each in pieces_found), total)
    found = intersection.joined(pieces_found)
    return CriticalLoadFactors(
        total=total,
        regular=found.regular,
        degenerate=total - found.regular,
        smallest_positive=intersection.intersection(rows, found.smallest_positive[1]),
        smallest_feasible=intersection.intersection(rows, found.smallest_feasible[1]),
        load_factors=np.sort(found.load_factors) if values else None,
    )


def _check_budget(rows: Constraints, total: int, budget: int) -> None:
    """Refuse more subsets than the budget, and say about how long they would take."""
    if not isinstance(budget, int):
        raise UsageError(f"budget: expected a whole number, found {budget!r}")
    if total > budget:
        shown = f"{total:,}" if total < COUNTABLE else f"about 10^{len(str(total)) - 1}"
        # seconds of one core for a subset, as the study `enumeration` measured from 10 nodes on
        seconds = 4e-8 * min(total, COUNTABLE)
        time = f"{seconds:.2g} seconds" if seconds < 3600 else f"{seconds / 3600:.2g} hours"
        raise BudgetExceeded(
            f"{shown} subsets of {rows.n + 1} rows are more than the budget of {budget:,}; "
            f"they would take {'about' if total < COUNTABLE else 'more than'} {time} on one core"
        )
