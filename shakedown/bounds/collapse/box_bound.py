"""The load factor up to which a joint is proved to shake down from a state, by the box that it stays in."""

from dataclasses import dataclass, field, replace
from math import inf, isfinite, nan
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from shakedown.bounds.collapse.collapse_programs import collapse_in_box, collapse_limits
from shakedown.bounds.collapse.least_box import Box, BoxMap
from shakedown.bounds.collapse.lift_off import lift_off_bound
from shakedown.bounds.results import UpperBound
from shakedown.bounds.row_programs import load_factor_program
from shakedown.bounds.uniqueness.coupling import coupling
from shakedown.bounds.upper import upper_bound
from shakedown.ground.errors import Missing, UsageError, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import HALVINGS, ITERATIONS, ROUND_OFF
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import NO_SIDES, checked, checked_initial_slip, require_plane
from shakedown.joint.constraints import rows_of
from shakedown.joint.loading import loading, transient_path
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.programs.program import INF
from shakedown.programs.simplex import Simplex

WORK = 4 * 10**9  # programs times the cube of their size: about 250 at 250 nodes, no limit up to 100
ACCURACY = 100 * ROUND_OFF  # relative accuracy of the load factor
# Of what is proved, in steps by which that rose last: the first collapse hardly changes with the box.
AHEAD = 8.0
UNLIMITED: dict[str, Any] = {
    "status": Status.UNBOUNDED,
    "load_factor": inf,
    "reason": "no load factor widens the box, and in it no node collapses or lifts off",
}
REASONS = {
    "solver": "a linear program ended without an answer",
    "coupling": "the coupling ratio is not below 1: no box of slips is known to keep its motions",
    "load domain": "the proof follows a loop that returns to every load step, not any path inside a domain",
    "mean load": "no slip that the joint can reach from there is safe under the mean load",
    "transient": "in the transient load steps some slip in the box takes the pressure from a node",
    "start": "the first load step does not admit the slip, and there some slip in the box takes the pressure "
    "from a node",
}


@dataclass(frozen=True, eq=False, repr=False)
class BoxBound(Result):
    """Load factor below which every motion from an initial slip is proved to shake down, by a box.

    At every smaller load factor a motion that is at some instant closed at all nodes, admissible and
    inside the box never leaves it, no node ever opens, and slip ceases (docs/guarantee.md,
    statement 7). The initial slip is in the box, and where the first load step does not admit it the
    rise of the load to that step leads to an admissible slip in the box.

    Attributes
    ----------
    status
        ``"optimal"``; ``"infeasible"`` (nothing is proved at any load factor);
        ``"unbounded"`` (proved at every load factor); ``"undecided"`` (a linear program ended without
        an answer).
    load_factor
        Where the proof ends; NaN where infeasible, inf where unbounded.
    low, high : (n,)
        The box at that load factor [length]; NaN where infeasible.
    limited_by
        ``"first collapse"`` (a node loses its range of slips at some slip in the box),
        ``"search cut short"`` (it may, but in a large joint that is not sought to the end),
        ``"lift-off"`` (some slip in the box lifts a node off), ``"transient"`` (some slip in the box
        relieves a node of its pressure before the first period), or why nothing is proved:
        ``"coupling"`` (ρ* ≥ 1), ``"load domain"``, ``"mean load"``, ``"solver"``; ``"start"`` (the
        first load step does not admit v₀, and some slip in the box relieves a node of its pressure
        there); empty where unbounded, or not found up to the largest load factor tried.
    node
        The node that collapses; −1 where none does.
    slip : (n,)
        The slip in the box at which it does [length]; NaN where none does.
    initial_slip : (n,)
        v₀ [length].
    reason
        The status in words; empty where optimal.
    """

    DOCUMENT: ClassVar[str] = "load_factor status limited_by low high node reason initial_slip"
    TABLE: ClassVar[str] = "initial_slip low high slip"

    status: Status
    load_factor: float
    low: FloatArray
    high: FloatArray
    limited_by: str
    node: int
    slip: FloatArray = field(repr=False)
    initial_slip: FloatArray = field(repr=False)
    reason: str = ""


class _End(NamedTuple):
    """The first failure in a box: the load factor, the reason, the node and the slip."""

    load_factor: float
    limited_by: str
    node: int
    slip: FloatArray


@checked
def box_bound(
    problem: Problem,
    initial_slip: ArrayLike | None = None,
    *,
    upper: UpperBound | None = None,
    tolerances: Tolerances = DEFAULT,
) -> BoxBound:
    """The load factor up to which the box around an initial slip proves shakedown, for ρ* < 1.

    The least box that no motion leaves grows with the load factor. The load factor is sought at which
    the first node collapses, or lifts off, at some slip inside the box of that very load factor: one
    linear program per node and step of the search, fewer where earlier ones tell enough.

    Parameters
    ----------
    problem
        The joint and its loading; transient load steps are those after ``initial_slip``.
    initial_slip : (n,), optional
        v₀ [length]; zero by default, a joint assembled without locked-in slip.
    upper
        λ_max with all nodes in contact, where it has been computed already.
    tolerances
        ``feasibility`` is used (:class:`Tolerances`).

    Raises
    ------
    UsageError
        If an argument has the wrong shape.

    Examples
    --------
    >>> import shakedown
    >>> bound = shakedown.box_bound(shakedown.example("two-node"))
    >>> round(bound.load_factor, 5), bound.limited_by, bound.node
    (0.73159, 'first collapse', 1)
    """
    require_plane("box bound", problem, NO_SIDES)
    start = checked_initial_slip(problem, initial_slip)
    if upper is not None and upper.open_nodes:
        raise UsageError(f"upper: expected all nodes in contact, found {len(upper.open_nodes)} open")
    found = sought(_box_bound, problem, start, upper, tolerances)
    if isinstance(found, Missing):
        return replace(_nothing(start, "solver"), status=Status.UNDECIDED, reason=found.reason)
    return found


def _box_bound(
    problem: Problem, start: FloatArray, upper: UpperBound | None, tolerances: Tolerances
) -> BoxBound:
    if problem.is_domain:
        return _nothing(start, "load domain")
    if not coupling(problem).bound < 1.0:
        return _nothing(start, "coupling")
    boxes = _Boxes(problem, start, tolerances, transient=problem.q_transient is not None)
    if not boxes.safe_at_mean(boxes.at(0.0)):
        return _nothing(start, "mean load")
    if not boxes.pressed_before(boxes.at(0.0), 0.0):
        return _nothing(start, boxes.before)
    if np.all(boxes.map.rows.d <= 0.0) and boxes.first_end(boxes.at(0.0), inf).load_factor == inf:
        return replace(_bound(boxes, 0.0, _End(inf, "", -1, np.full(problem.n, nan))), **UNLIMITED)
    if upper is None:
        upper = upper_bound(problem, certify=False, tolerances=tolerances)
    return _farthest(boxes, _beyond(upper, boxes))


def box_proves(problem: Problem, slip: FloatArray, load_factor: float, tolerances: Tolerances) -> bool:
    """Whether shakedown is proved from a closed, admissible slip after the transient, at one load factor.

    Of smaller load factors nothing is said. Where all limits stay apart over the whole box no program
    is needed; else one per node: how near its limits come to each other in the box, the
    other nodes within theirs.
    """
    if problem.is_domain or not coupling(problem).bound < 1.0:
        return False
    boxes = _Boxes(problem, slip, tolerances, transient=False)
    box = boxes.at(load_factor)
    if not boxes.all_apart(box, load_factor):
        return False
    return lift_off_bound(problem, load_factor, within=box, tolerances=tolerances) > load_factor


class _Boxes:
    """The boxes around one start and the first failures in them; remembers bounds for the nodes."""

    def __init__(
        self, problem: Problem, start: FloatArray, tolerances: Tolerances, *, transient: bool
    ) -> None:
        self.problem, self.start, self._tolerances = problem, start, tolerances
        self.map, self._transient = BoxMap(problem, transient=transient), transient
        self._program = Simplex(load_factor_program(self.map.rows, towards=+1.0, tolerances=tolerances))
        self._anywhere = collapse_limits(self.map.rows).load_factors  # no node collapses anywhere below
        self._left = max(WORK // problem.n**3, 2)  # number of programs that may still be solved
        self._known = self._anywhere  # a node does not collapse below, in boxes no larger than …
        self._largest = inf  # … that of this load factor

    def at(self, load_factor: float) -> Box:
        return self.map.around(self.start, load_factor)

    def safe_at_mean(self, box: Box) -> bool:
        """Whether some slip in a box is safe under the mean load."""
        self._program.set_columns(np.arange(self.problem.n), box.low, box.high)
        found = self._program.solve()
        feasible = self._tolerances.feasibility
        return found.optimal and bool(self.map.rows.relative_excess(found.x[:-1], 0.0).max() <= feasible)

    def all_apart(self, box: Box, load_factor: float) -> bool:
        """Whether some slip in a box is safe at a load factor, and all limits are apart at every one."""
        rows, n, free = self.map.rows, self.problem.n, np.full(2, INF)
        near = np.flatnonzero(self.map.apart_below(box) <= load_factor)
        if not near.size:  # then some slip in the box is safe as well, as the box is mapped into itself
            return True
        program = Simplex(load_factor_program(rows, towards=+1.0, tolerances=self._tolerances))
        program.set_columns(np.arange(n), box.low, box.high)
        program.set_columns(np.array([n]), np.array([load_factor]), np.array([load_factor]))
        if not program.solve().optimal:
            return False
        right = rows.g - load_factor * rows.d
        for node in near.tolist():
            pair = rows_of(node)
            own = np.abs(rows.G[pair, node])
            cost = -(rows.G[pair] / own[:, None]).sum(axis=0)  # U − L = right / own + cost · v
            program.set_rows(pair, -free, free)
            program.set_cost(np.append(cost, 0.0))
            found = program.solve()
            program.set_rows(pair, -free, rows.g[pair])
            if not found.optimal:
                return False
            terms = np.concatenate([right[pair] / own, cost * found.x[:-1]])
            if not terms.sum() > self._tolerances.feasibility * np.abs(terms).max():
                return False
        return True

    def first_end(self, box: Box, load_factor: float) -> _End:
        """The first collapse or lift-off in the box of a load factor."""
        if load_factor > self._largest:
            self._known = self._anywhere
        found = _End(inf, "", -1, np.full(self.problem.n, nan))
        known = np.maximum(self._known, self.map.apart_below(box))
        self._program.set_columns(np.arange(self.problem.n), box.low, box.high)
        for node in np.argsort(known, kind="stable").tolist():
            if known[node] >= found.load_factor:
                break  # no later node collapses earlier
            if not self._left:  # use the known bound of the node without its program
                found = _End(float(known[node]), "search cut short", node, np.full(self.problem.n, nan))
                break
            self._left -= 1
            x = collapse_in_box(self._program, self.map.rows, node, box.low, box.high)
            known[node] = inf if x is None else max(known[node], float(x[-1]))
            if x is not None and x[-1] < found.load_factor:
                found = _End(float(x[-1]), "first collapse", node, x[:-1])
        self._known, self._largest = known, load_factor
        reached = min(found.load_factor, load_factor)
        nowhere = np.full(self.problem.n, nan)
        if not self.pressed_before(box, load_factor):
            return _End(0.0, self.before, -1, nowhere)
        lift = lift_off_bound(self.problem, reached, within=box, tolerances=self._tolerances)
        return _End(lift, "lift-off", -1, nowhere) if lift < reached else found

    @property
    def before(self) -> str:
        """The failure of :meth:`pressed_before`, as a reason."""
        return "transient" if self._transient else "start"

    def _admitted(self, load_factor: float) -> bool:
        """Whether the first load step admits the initial slip, at all load factors up to this one."""
        joint, loop = self.problem, loading(self.problem)
        q, p = loop.q0 + joint.A @ self.start, loop.p0 + joint.B @ self.start
        changes = [(0.0, 0.0)]
        if loop.q1[0].any() or loop.p1[0].any():
            if load_factor == inf:
                return False
            changes.append((load_factor * loop.q1[0], load_factor * loop.p1[0]))
        return all(self._within(q + q1, p + p1) for q1, p1 in changes)

    def _within(self, q: FloatArray, p: FloatArray) -> bool:
        """Whether reactions keep to the law of friction, but for round-off."""
        most = self.problem.law.limit(p)
        off = self._tolerances.feasibility * np.maximum(np.abs(q), np.abs(most))
        return bool(np.all(np.abs(q) <= most + off) and np.all(p > 0.0))

    def pressed_before(self, box: Box, load_factor: float) -> bool:
        """Whether no slip in a box relieves a node of its pressure before the first period.

        That matters where load steps come before it, or the rise to its first one moves the initial slip.
        """
        if not self._transient and self._admitted(load_factor):
            return True
        loop, before = loading(self.problem), transient_path(self.problem)[:, self.problem.layout.gaps]
        before = before[: len(before) * self._transient]
        fall = np.minimum(loop.p1[0], 0.0)
        first = loop.p0 + np.multiply(load_factor, fall, out=np.zeros_like(fall), where=fall < 0)
        p = np.minimum(before.min(axis=0, initial=inf), first)
        return bool(np.all(p + box.least(self.problem.B) > 0.0))


def _beyond(upper: UpperBound, boxes: _Boxes) -> float:
    """A load factor that cannot be proved, or the largest one tried."""
    largest = float(upper.in_floats[-1])
    if isfinite(largest):
        return largest
    load_factor = 1.0
    for _ in range(HALVINGS):
        if boxes.first_end(boxes.at(load_factor), load_factor).load_factor <= load_factor:
            break
        load_factor *= 2.0
    return load_factor


def _farthest(boxes: _Boxes, beyond: float) -> BoxBound:
    """The load factor that equals the first failure in its own box.

    What happens first at λ' < λ in the box of λ happens no earlier in that of λ', which is
    smaller: so λ' is proved. And where λ is proved, nothing beyond what happens in its box is. Both
    ends of the bracket move; between them by the secant, by steps ahead of what is proved, or by halves.
    """
    end = boxes.first_end(boxes.at(beyond), beyond)
    if end.load_factor >= beyond:
        return _bound(boxes, beyond, end)
    proved, at, known = max(end.load_factor, 0.0), nan, [(beyond, end.load_factor - beyond)]
    at = proved
    for _ in range(ITERATIONS):  # the bracket at least halves every second time
        found, before = boxes.first_end(boxes.at(at), at), proved
        late = found.load_factor - at
        proved, end = max(proved, min(found.load_factor, at)), found if found.limited_by else end
        beyond = min(beyond, max(found.load_factor, at))
        if beyond - proved <= ACCURACY * beyond:
            break
        known = [*known[-1:], (at, late)]
        ahead = min(proved + AHEAD * (proved - before), 0.5 * (proved + beyond)) if late < 0 else nan
        at = next(x for x in (_vanishing(*known), ahead, 0.5 * (proved + beyond)) if proved < x < beyond)
    return _bound(boxes, proved, end)


def _vanishing(first: tuple[float, float], second: tuple[float, float]) -> float:
    """Where a falling line through two points (place, value) vanishes; NaN where there is none."""
    (a, at_a), (b, at_b) = first, second
    if not np.isfinite(at_a - at_b) or (at_a - at_b) * (b - a) <= 0:
        return nan
    return a + at_a * (b - a) / (at_a - at_b)


def _bound(boxes: _Boxes, load_factor: float, end: _End) -> BoxBound:
    box = boxes.at(load_factor)
    return BoxBound(
        status=Status.OPTIMAL,
        load_factor=load_factor,
        low=box.low,
        high=box.high,
        limited_by=end.limited_by,
        node=end.node,
        slip=end.slip,
        initial_slip=boxes.start,
    )


def _nothing(start: FloatArray, limited_by: str) -> BoxBound:
    missing = np.full(len(start), nan)
    return BoxBound(
        Status.INFEASIBLE, nan, missing, missing, limited_by, -1, missing, start, REASONS[limited_by]
    )
