"""λ_c: up to which load factor a joint that friction alone holds is not seen to creep, and what is proved."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from math import inf, isfinite, nan
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.assessment.every_limit import JointLimits
from shakedown.assessment.transient_limit import History, bisected, check_scan, history_of
from shakedown.bounds.bound_result import Bound, Evidence
from shakedown.bounds.every_state.universal_bound import least_pressure_bound
from shakedown.bounds.registry import takes_long
from shakedown.ground.constants import FOUR_DIGITS, SIX_DIGITS, FloatArray
from shakedown.ground.errors import Missing, attempt, attempt_any, present
from shakedown.ground.shown_values import down
from shakedown.ground.status import Outcome, Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.ground.work_limit import on_one_thread
from shakedown.joint.arguments import checked, checked_initial_slip
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import can_creep
from shakedown.long_term.creep_proofs import SIDES, SlidingBody, sliding_bodies, steps_back
from shakedown.long_term.state import LongTermState

SCANNED = 25  # load factors, in equal ratios
BEYOND = 1.01  # times gross slip: where a scan ends
AT = 1.01  # times λ_c: where the drift is given
CLIMBS = 0.75, 0.95  # shares of the way to λ_c at which motions are followed for the programs of Theorem 3
# nodes times load steps of these programs: a tenth of a second each, and minutes in all
QUICK, MOST_UNKNOWNS = 500, 4000

ANY_ORDER, EVERY, THIS = "every state, any order", "every state", "this state"


@dataclass(frozen=True, eq=False, repr=False)
class Creep(Evidence):
    """What only λ_c has, the least load factor at which one history is seen to drift from cycle to cycle.

    Drift may vanish again above λ_c. Below ``proved`` it is excluded, not above.

    Attributes
    ----------
    proved
        The largest load factor below which creep is proved to be impossible while all nodes stay closed;
        inf without a rigid slip, 0 where nothing is proved.
    proved_from
        From where: ``"every state, any order"`` (of the loads), ``"every state"``, ``"this state"``; empty
        where nothing is proved.
    wedge, path, held
        What Theorems 1 (λ_w), 3 and 6 (λ_H) of docs/creep.md prove; NaN where they say nothing.
    closed_up_to
        Below this load factor no admissible state lifts a node off, so that all of them do stay closed; NaN
        where not known.
    drift : (dn,)
        Growth of the slip per cycle at 1.01 λ_c [length]; NaN where none is known.
    grid : (s,)
        Load factors at which the history was followed, in increasing order.
    creeps : (s,)
        Whether it was seen to drift at each.
    certain
        The load factors between which creep is certain, where slip changes no friction limit (Theorem 5).
    force_to_creep
        Constant tangential forces along the rigid slip, the second in its own direction, beyond which the
        motion under the nominal load creeps (Theorem 4) [force]; NaN where slip changes friction limits.
    """

    DOCUMENT: ClassVar[str] = (
        "load_factor proved proved_from drift status reason wedge path held closed_up_to grid creeps certain "
        "force_to_creep"
    )

    proved: float
    proved_from: str
    wedge: float = nan
    path: float = nan
    held: float = nan
    closed_up_to: float = nan
    drift: FloatArray = field(default_factory=lambda: np.zeros(0))
    grid: FloatArray = field(default_factory=lambda: np.zeros(0))
    creeps: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=bool))
    certain: tuple[float, float] = (nan, nan)
    force_to_creep: tuple[float, float] = (nan, nan)

    def remark(self, bound: Bound) -> str:
        """Up to where creep is excluded, and from which states."""
        if not self.proved_from or self.proved == inf:
            return bound.reason
        open_too = "" if self.proved <= self.closed_up_to else ", while all nodes stay in contact"
        return f"no creep below {down(self.proved)}: {self.proved_from}{open_too}"


def of_joint(limits: Any) -> Bound | Missing:
    """λ_c of a joint whose limits are computed (:data:`shakedown.bounds.registry.BOUNDS`)."""
    return attempt(_Search(limits, QUICK).found)


@checked
@on_one_thread
def creep_limit(
    problem: Problem,
    initial_slip: ArrayLike | None = None,
    *,
    accuracy: float | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Bound:
    """The least load factor λ_c at which the simulated motion creeps, and up to where creep is excluded.

    Creep is a rigid slip that grows from cycle to cycle; only a body that friction alone holds can creep.
    Load factors are tried in geometric steps, from the largest that is proved free of creep to gross slip,
    and the first interval in which creep appears is bisected with exact long-term states.
    Between λ_max and ``proved`` the joint slips for ever without creep.

    Parameters
    ----------
    problem
        The joint, its transient load steps and its loading loop.
    initial_slip : (dn,), optional
        Slip at the start [length]; zero by default.
    accuracy
        Width of the final interval, relative to the end of the scan; by default six digits, four of a joint
        whose runs take long.
    tolerances
        The tolerances that decide.

    Returns
    -------
    Bound
        With the evidence of :class:`Creep`; inf where no slip is rigid, or no drift was seen.

    Raises
    ------
    UsageError
        If an argument is out of range.

    Examples
    --------
    >>> import shakedown
    >>> limit = creep_limit(shakedown.example("two-node"))
    >>> limit.load_factor, limit.proved_from, limit.reason
    (inf, 'every state, any order', 'no slip is rigid: nothing can creep')
    """
    start = None if initial_slip is None else checked_initial_slip(problem, initial_slip)
    if accuracy is not None:
        check_scan(1.0, SCANNED, accuracy)
    limits = JointLimits(problem, start, accuracy=accuracy, tolerances=tolerances)
    return _Search(limits, MOST_UNKNOWNS).found()


@dataclass(frozen=True, eq=False)
class _Search:
    """The proofs, the scan, and the programs that follow it."""

    limits: JointLimits
    most_unknowns: int  # of the programs of Theorem 3

    @property
    def problem(self) -> Problem:
        """The joint."""
        return self.limits.problem

    @cached_property
    def bodies(self) -> tuple[SlidingBody, ...]:
        """Every body that may creep; none where something about one is not known."""
        found = sliding_bodies(self.problem)
        return () if None in found else found  # type: ignore[return-value]

    @cached_property
    def history(self) -> History:
        """The long-term states from the slip that is asked about."""
        return history_of(self.limits)

    def found(self) -> Bound:
        """λ_c with its evidence."""
        if not can_creep(self.problem):
            reason = "no slip is rigid: nothing can creep"
            return Bound("creep", Status.UNBOUNDED, inf, Creep(inf, ANY_ORDER), reason=reason)
        if self.limits.open_nodes:
            reason = "some nodes are open: nothing is proved of creep, and nothing was followed"
            return Bound("creep", Status.UNDECIDED, nan, Creep(0.0, ""), reason=reason)
        known = dict(self._proofs())
        proved = max((each for each, _ in known.values()), default=0.0)
        seen, end = self._scanned(proved)
        path = self._climbed(seen)
        if path > proved:
            known["path"] = path, EVERY
            proved = path
        by = {source for each, source in known.values() if each >= proved > 0}
        grid = sorted(self.history.runs)
        evidence = Creep(
            proved=proved,
            proved_from=next((source for source in (ANY_ORDER, EVERY, THIS) if source in by), ""),
            wedge=known.get("wedge", (nan, ""))[0],
            path=path,
            held=known.get("held", (nan, ""))[0],
            closed_up_to=self._closed_up_to(),
            drift=self._drift(seen),
            grid=np.array(grid),
            creeps=np.array([self._creeps(x) for x in grid], dtype=bool),
            certain=self.bodies[0].certain_creep if len(self.bodies) == 1 else (nan, nan),
            force_to_creep=self._force_to_creep(seen),
        )
        if seen < inf:
            return Bound("creep", Status.OPTIMAL, seen, evidence)
        reason = f"no drift was seen up to {down(end)}"
        return Bound("creep", Status.UNDECIDED, inf, evidence, reason=reason)

    def _proofs(self) -> Iterator[tuple[str, tuple[float, str]]]:
        """The load factors below which nothing creeps, and from which states."""
        for word, source in (("proved_from_every_state", EVERY), ("proved_from_this_state", THIS)):
            found = attempt_any(getattr, self.limits, word)
            if isinstance(found, float) and found > 0:
                yield word, (found, source)
        if not self.bodies:
            return
        wedge = min(min(body.wedge_bounds) if all(body.monotone) else 0.0 for body in self.bodies)
        if wedge > 0:
            yield "wedge", (wedge, ANY_ORDER)
            return
        body = self.bodies[0]
        if len(self.bodies) == 1 and body.problem is self.problem and self.problem.q_transient is None:
            held = body.held_bound(self.history.start)[0]
            if held > 0:
                yield "held", (held, THIS)

    def _closed_up_to(self) -> float:
        """Below it no admissible slip lifts a node off; NaN where no bound was found."""
        every = present(attempt(lambda: self.limits.universal))
        found = (every and every.pressures) or attempt_any(least_pressure_bound, self.problem)
        return found.lift_off_bound if found else nan

    def _scanned(self, proved: float) -> tuple[float, float]:
        """The least load factor with drift, inf where none was seen, and where the scan ends."""
        upper = self.limits.upper.load_factor
        ends = [body.gross_slip for body in self.bodies]
        end = BEYOND * min(ends) if ends and isfinite(min(ends)) else 10.0 * max(upper, proved)
        if not 0 < end < inf:
            return inf, 0.0
        low = min(proved, end / BEYOND)
        first = max(low, FOUR_DIGITS * end)
        grid = np.geomspace(first, end, SCANNED + 1)[int(low == first) :]
        wanted = self.limits.accuracy or (FOUR_DIGITS if takes_long(self.problem) else SIX_DIGITS)
        for below, high in pairwise([low, *grid.tolist()]):
            if self._creeps(high):
                return bisected(lambda x: not self._creeps(x), below, high, lambda x: wanted * x)[1], end
        return inf, end

    def _creeps(self, load_factor: float) -> bool:
        """Whether the slip is seen to grow from cycle to cycle, or the body slides away."""
        return is_creeping(self.history.at(load_factor))

    def _drift(self, seen: float) -> FloatArray:
        """The drift per cycle a little above λ_c."""
        if not seen < inf:
            return np.full(self.problem.layout.slip_size, nan)
        state = self.history.followed(AT * seen)
        return np.asarray(state.drift / max(state.period, 1))

    def _climbed(self, seen: float) -> float:
        """Up to where the programs of Theorem 3 exclude creep; NaN where there are none."""
        problem = self.problem
        if not self.bodies or problem.is_domain or problem.n * problem.m > self.most_unknowns:
            return nan
        if len(self.bodies) > 1 or self.bodies[0].problem is not problem or not all(self.bodies[0].monotone):
            return nan
        body, ends = self.bodies[0], list[float]()
        goal = min(seen, body.gross_slip)
        for side in SIDES:
            end = body.wedge_bounds[side]
            for share in CLIMBS:
                if not 0 < end < (1.0 - SIX_DIGITS) * goal or goal == inf:
                    break
                state = self.history.followed(end + share * (goal - end))
                if len(state.history) and not is_creeping(state) and not state.opened.any():
                    back = steps_back(body, side, state.history)
                    end = body.interval_proved(side, back, (1.0 - SIX_DIGITS) * end, goal)
            ends.append(max(end, body.wedge_bounds[side]))
        return min(ends)

    def _force_to_creep(self, seen: float) -> tuple[float, float]:
        """The constant forces that make the nominal motion creep."""
        if len(self.bodies) != 1 or not self.bodies[0].uncoupled or not seen > 1.0:
            return nan, nan
        state = self.history.followed(1.0)
        if is_creeping(state) or state.opened.any() or not len(state.history):
            return nan, nan
        against, along = self.bodies[0].reactions_left(state.history).sum(axis=1).tolist()
        return -against, along


def is_creeping(state: LongTermState) -> bool:
    """Whether a long-term state drifts by more than a millionth of its slip per cycle, or slides away."""
    if state.outcome != Outcome.RATCHETTING:
        return state.slides_away
    largest = float(np.abs(state.slip_per_cycle).max())
    return bool(np.abs(state.drift).max() > SIX_DIGITS * largest)
