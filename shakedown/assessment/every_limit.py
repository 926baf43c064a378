"""Every limit of the load factor of one joint, each computed when it is first read, and once.

What joins them to three numbers: which refute each other, which states the loads admit. From one mesh it is
judged whether the edge of the mesh determines a limit (docs/mesh.md).
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from math import inf, isfinite, isinf, isnan, nan
from threading import RLock
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from shakedown.assessment.sensitivities import Sensitivities, sensitivities
from shakedown.bounds.bound_result import Bound
from shakedown.bounds.critical import subset_count
from shakedown.bounds.energy.energy_ball import NO_SAFE_SLIP, EnergyBall, energy_ball
from shakedown.bounds.friction_thresholds import FrictionThresholds, friction_thresholds
from shakedown.bounds.onset import Onset, first_opening, first_slip, leaves_cone
from shakedown.bounds.registry import BOUNDS, BoundKind, Claim, kinds_of, takes_long
from shakedown.bounds.upper import upper_bound
from shakedown.ground.constants import CONE, EACH_SHOWN, FOUR_DIGITS, NOTABLE, FloatArray
from shakedown.ground.errors import Missing, SolverError, attempt, attempt_any, present
from shakedown.ground.shown_values import plain, short
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.ground.work_limit import limited_work
from shakedown.joint.arguments import checked, checked_initial_slip
from shakedown.joint.constraints import Side, constraints, step_loads, through_transient
from shakedown.joint.contact_surface import surface_of
from shakedown.joint.hat_functions import coarsened
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result

if TYPE_CHECKING:
    from shakedown.assessment.transient_limit import SlipLimit
    from shakedown.long_term.simulation import Simulation


WORK_BEYOND = 4e10  # multiplications and additions that a run may take which is proved to slip for ever
ONE_AT_A_TIME = RLock()  # two threads that want the same long run, for λ_T and for its comparison, make one
THREE_NUMBERS = "impossible_above", "proved_from_this_state", "proved_from_every_state"
REFUTED = "round-off decides: its load factor is {:.7g}, although no slip is safe above {:.7g}"


def not_refuted(load_factor: float, upper: Bound, tolerances: Tolerances = DEFAULT) -> float:
    """What is proved, unless λ_max of closed nodes refutes it: NaN then.

    What is above it by ``agreement`` at most, as round-off in either may put it, is rounded down.

    Examples
    --------
    >>> import shakedown
    >>> upper = shakedown.upper_bound(shakedown.example("two-node"))
    >>> [not_refuted(share * upper.certified[1], upper) / upper.certified[0] for share in (1.0 + 1e-12, 1.1)]
    [1.0, nan]
    """
    if upper.open_nodes or upper.status not in (Status.OPTIMAL, Status.INFEASIBLE):
        return load_factor
    low, high = np.nan_to_num(upper.certified or (upper.load_factor, upper.load_factor)).tolist()
    if not load_factor > high:
        return load_factor
    return low if load_factor <= (1.0 + tolerances.agreement) * high else nan


def admitted_up_to(problem: Problem, slip: FloatArray, tolerances: Tolerances = DEFAULT) -> float:
    """The load factor up to which the first load step admits a slip with all nodes closed; 0 where none.

    The slip stays as it is, also at nodes without friction: λ_U is about states that are admissible so.
    :func:`~shakedown.bounds.onset.first_slip` is about a motion, in which those nodes follow the load.

    Examples
    --------
    >>> import shakedown
    >>> round(admitted_up_to(shakedown.example("two-node"), np.zeros(2)), 4)
    0.9998
    """
    rows, first = constraints(problem), step_loads(problem)[0]
    if rows.relative_excess(slip, 0.0).max() > tolerances.feasibility:
        return 0.0
    slack, law, in_discs = rows.g - rows.G @ slip, problem.law, np.inf
    if problem.directions > 1:
        heads = rows.heads[np.unique(rows.node[rows.heads], return_index=True)[1]]
        limits = slack[heads[:, None] + np.arange(CONE)]
        in_discs = leaves_cone(limits, -law.of_nodes(first)).min()
        slack, first = slack[rows.side != Side.DISC], first[law.rows * problem.n :]
    rising = first > 0
    return max(float(np.min(slack[rising] / first[rising], initial=in_discs)), 0.0)


@dataclass(frozen=True, eq=False, repr=False)
class MeshCheck(Result):
    """How far limits depend on a single element.

    Attributes
    ----------
    edge_share
        Of the multipliers y with yᵀd = 1 that prove λ_max, the share of nodes at an end of the contact, in
        space at its rim; NaN where there are none, or the joint does not know where its nodes are.
    edge_nodes
        Those that have more than a tenth each.
    coarser
        The limits on every second node (:func:`averaged` says how) over those on all, less 1: by the words of
        :meth:`Assessment.to_dict`, inf where a limit is 0 on all. Empty where the joint has too few nodes
        or some are open.
    warning
        What decides, and the change of the limits, where one changes by more than a tenth; else None.
    """

    DOCUMENT: ClassVar[str] = "edge_share coarser warning"

    edge_share: float
    edge_nodes: tuple[int, ...]
    coarser: dict[str, float]
    warning: str | None


def mesh_check(limits: "JointLimits") -> MeshCheck:
    """Check limits on one mesh: whether its edge determines λ_max, and their values on a coarser mesh."""
    problem = limits.problem
    surface = surface_of(problem)
    # nodes, in the plane or in space; fewer cannot be coarsened
    if surface is None or problem.n < (9 if surface.in_plane else 16) or limits.open_nodes:
        return MeshCheck(nan, (), {}, None)
    edge = _shares(limits) * surface.edge
    ranked = np.argsort(-edge, kind="stable")
    deciding = tuple(int(node) for node in ranked[:EACH_SHOWN] if edge[node] > NOTABLE)
    coarser = _coarser(limits)
    share = float(edge.sum())
    return MeshCheck(share, deciding, coarser, _warning(share, sorted(deciding), coarser))


def on_mesh(limits: "JointLimits", problem: Problem) -> "JointLimits":
    """The same limits for an averaged joint; its first initial slip is the state in question."""
    start = None if problem.initial_slip is None else problem.initial_slip[0]
    zone = limits.zone if isinstance(limits.zone, str) else ()
    return replace(limits, problem=problem, initial_slip=start, zone=zone)


def _shares(limits: "JointLimits") -> FloatArray:
    """The share of every node in the multipliers that prove λ_max, (n,); NaN where there are none."""
    problem, upper = limits.problem, limits.upper
    rows = constraints(problem)
    if upper.status != Status.OPTIMAL:
        return np.full(problem.n, nan)
    parts = np.abs(np.bincount(rows.node, upper.multipliers * rows.d, minlength=problem.n))
    return np.asarray(parts / parts.sum())


def _coarser(limits: "JointLimits") -> dict[str, float]:
    """Ratios, less 1, of the known limits on every second node to those on all nodes."""
    start = limits.energy.initial_slip
    between = coarsened(replace(limits.problem, initial_slip=start if np.isfinite(start).all() else None))
    assert between is not None  # its surface is known
    coarse = replace(on_mesh(limits, between), certify=False)
    found = {}
    for name in THREE_NUMBERS:
        try:
            one = getattr(limits, name)
            if one == 0 and name == "proved_from_this_state":  # the costliest, and nothing to compare with
                continue
            other = getattr(coarse, name)
        except SolverError:
            continue
        if isfinite(one) and isfinite(other):
            found[name] = other / one - 1.0 if one > 0 else (inf if other > 0 else 0.0)
    return found


def _warning(share: float, nodes: Sequence[int], coarser: dict[str, float]) -> str | None:
    """Two sentences, where a limit changes by more than a tenth."""
    changed = {name.replace("_", " "): _change(by) for name, by in coarser.items() if abs(by) > NOTABLE}
    if not changed:
        return None
    named = f" (node {', '.join(map(str, nodes))})" if nodes else ""
    edge = f"The edge determines λ_max{named}. " if share >= 0.5 else ""  # it has most multipliers
    changes = ", ".join(f"{name} is {change}" for name, change in changed.items())
    if len(changed) > len(set(changed.values())) == 1 and len(changed) == len(THREE_NUMBERS):
        changes = f"all three limits are {changed.popitem()[1]}"
    which = "them" if min(coarser.values()) > 0 else "those that are higher"
    finer = f"; a finer mesh may lower {which}" * any(NOTABLE < by < inf for by in coarser.values())
    return f"{edge}On the coarser mesh (every second node) {changes}{finer}."


def _change(by: float) -> str:
    """The change of a limit on the coarser mesh."""
    if isinf(by):
        return "positive, here 0"
    if by > 2.0:  # a larger relative change is given as a factor
        return f"{1 + by:.3g} times as high"
    return f"{100 * abs(by):.0f} % {'higher' if by > 0 else 'lower'}"


REFUTED_BY_ALL = "round-off decides: it is {:.7g} in floats, although shakedown is proved up to {:.7g}"


@dataclass(frozen=True, eq=False, repr=False)
class ShakedownBounds(Result):
    """Both bounds of a problem: between them the initial state decides; below λ_1 it may too, unless proved.

    The lower bound is that of the joint with all nodes closed; the upper one names the nodes
    that are open (``upper.open_nodes``), and is then no bound but of that zone. Both are about
    the loop, and so about slips that are locked in when transient load steps are over.
    ``through_transient`` is the largest load factor at which one slip is safe under these too;
    None where there are none, or where nodes are open.

    With two tangential directions ``lower`` is ``Missing``, with the reason: a disc has no sides that a node
    could lose its range of safe slips between. What is proved there is λ_U and λ_E (:func:`assess`).
    """

    DOCUMENT: ClassVar[str] = "lower upper through_transient"

    lower: Bound | Missing
    upper: Bound
    tolerances: Tolerances = field(default=DEFAULT, repr=False)
    through_transient: Bound | None = None

    def columns(self) -> dict[str, Any]:
        """The safe slip, the critical slip state, and the load factor at which each node collapses."""
        lower, safe = self.lower, {"safe_slip": self.upper.slip}
        if isinstance(lower, Missing):
            return safe
        return safe | {"witness": lower.slip, "collapses_at": lower.per_node}


@dataclass(frozen=True, eq=False, repr=False)
class JointLimits(Result):
    """The limits of one joint, the only place where they are computed.

    The limits are attributes by their names in ``BOUNDS`` (:mod:`shakedown.bounds.registry`), each a
    :class:`Bound`. One that joints with two tangential directions do not have is ``Missing``, with the reason
    (``absent``), and null in documents.

    A limit whose program does not finish raises ``SolverError`` where it is an answer (λ_1, λ_max) and is a
    status where it is a proof; evidence beside the answers (λ_T) is ``Missing`` then, and λ_T is None without
    a finite λ_max to scan up to.

    Attributes
    ----------
    problem
        The joint and its loading.
    initial_slip : (dn,) or None
        The state that is asked about [length]; None for slip zero.
    distance
        How far the state may be from it, in the energy norm [√(force · length)]; for λ_E.
    zone
        The nodes that stay open, for λ_max and λ_E, or ``"auto"`` (:func:`upper_bound`).
    certify
        Whether to check in exact arithmetic; None: each limit where that is quick.
    accuracy
        Of λ_T, relative to where its scan ends; None: six digits, four of a joint whose runs take long.
    tolerances
        The tolerances that decide.
    """

    problem: Problem
    initial_slip: ArrayLike | None = None
    distance: float = 0.0
    zone: Iterable[int] | Literal["auto"] = "auto"
    certify: bool | None = None
    accuracy: float | None = None
    tolerances: Tolerances = DEFAULT

    def _shown(self) -> Iterator[tuple[str, str]]:
        """Settings that differ from the defaults, and every limit that has been read so far."""
        usual = {field.name: field.default for field in fields(self)}
        for name, value in super()._shown():
            if name == "problem" or value != short(usual[name]):
                yield name, value
        known = self.absent | vars(self)
        for name in BOUNDS:
            value = known.get(name, Missing("not read yet"))
            yield name, value.reason if isinstance(value, Missing) else short(value)

    def __getattr__(self, name: str) -> Any:
        """A limit that was not computed yet, by its name in ``BOUNDS``."""
        if name not in BOUNDS:
            raise AttributeError(f"the limits of a joint have no {name!r}")
        vars(self)[name] = found = self._bound(BOUNDS[name])
        return found

    def _bound(self, kind: BoundKind) -> "Bound | Missing | None":
        """A limit; undecided where another one refutes it."""
        if not kind.exists_for(self.problem):
            return Missing(kind.absent)
        found = kind.of(self)
        if kind.claim == Claim.THIS_STATE:
            proved, upper, why = found, present(attempt(lambda: self.upper)), REFUTED
        elif kind.claim == Claim.IMPOSSIBLE and found.uncertified and not found.open_nodes:
            proved, upper, why = present(attempt(lambda: self.universal)), found, REFUTED_BY_ALL
        else:
            return found
        if proved is None or upper is None or not proved.load_factor > 0.0:
            return found
        at = not_refuted(proved.load_factor, upper, self.tolerances)
        if isnan(at):
            other = upper if found is proved else proved
            reason = why.format(found.load_factor, other.load_factor)
            return found.but(status=Status.UNDECIDED, load_factor=nan, reason=reason)
        return found.but(load_factor=at) if found is proved and at != found.load_factor else found

    @cached_property
    def absent(self) -> dict[str, Missing]:
        """The limits that joints of this kind do not have, by name, and why."""
        kinds = [kind for kind in BOUNDS.values() if not kind.exists_for(self.problem)]
        return {kind.name: Missing(kind.absent) for kind in kinds}

    @cached_property
    def open_nodes(self) -> tuple[int, ...]:
        """The nodes that are open in the zone of λ_max; none where that is not found."""
        upper = present(attempt(lambda: self.upper))
        return () if upper is None else upper.open_nodes

    @cached_property
    def through_transient(self) -> Bound | None:
        """λ_max for slips that the transient load steps do not move either; None without such steps."""
        problem = self.problem
        if self.open_nodes or through_transient(problem) is constraints(problem):
            return None
        return upper_bound(problem, transient=True, tolerances=self.tolerances)

    @cached_property
    def bounds(self) -> ShakedownBounds:
        """λ_1, where there is one, and λ_max together."""
        return ShakedownBounds(self.lower, self.upper, self.tolerances, self.through_transient)

    @cached_property
    def first_slip(self) -> Onset:
        """Up to where no node slips, from this state with all nodes closed."""
        return first_slip(self.problem, self.initial_slip, tolerances=self.tolerances)

    @cached_property
    def first_opening(self) -> Onset:
        """Up to where no node would open if none slipped, from the same state."""
        return first_opening(self.problem, self.initial_slip, tolerances=self.tolerances)

    def ball_at(self, load_factor: float) -> EnergyBall | Missing:
        """An energy ball at this load factor, sought once; Missing above λ_max, where there is none.

        In the plane the largest. In space, where one that holds a slip is found sooner, the one that holds
        this state best where λ_E proves it, above λ_E a slip that is safe there.
        """
        if load_factor not in self._balls:
            above = not self.open_nodes and load_factor > self.upper.load_factor
            self._balls[load_factor] = Missing(NO_SAFE_SLIP) if above else attempt(self._ball_at, load_factor)
        return self._balls[load_factor]

    def slip_beyond(self, load_factor: float, start: FloatArray, cycles: int) -> "tuple[Simulation, float]":
        """The simulation above λ_max from a start, made once, to three digits, and the work that it took.

        That it slips in every cycle is proved, while all nodes stay in contact. It is given up where it takes
        long; from another start than the one asked about it takes no more than that one has left, but a
        quarter in any case.
        """
        from shakedown.long_term.simulation import simulate  # loads compiled code

        key, rough = (load_factor, start.tobytes(), cycles), replace(self.tolerances, slip_change=FOUR_DIGITS)
        own = checked_initial_slip(self.problem, self.initial_slip)
        with ONE_AT_A_TIME:
            if key not in self._runs:
                spent = 0.0 if np.array_equal(start, own) else self.slip_beyond(load_factor, own, cycles)[1]
                with limited_work(max(WORK_BEYOND - spent, 0.25 * WORK_BEYOND)) as limit:
                    found = simulate(self.problem, load_factor, start, cycles=cycles, tolerances=rough)
                self._runs[key] = found, limit.taken
        return self._runs[key]

    @cached_property
    def _balls(self) -> dict[float, EnergyBall | Missing]:
        return {}

    @cached_property
    def _runs(self) -> dict[tuple[float, bytes, int], "tuple[Simulation, float]"]:
        return {}

    def _ball_at(self, load_factor: float) -> EnergyBall:
        problem, around, split = self.problem, None, True
        # in space a ball that holds a given slip is found sooner than the largest one
        if problem.directions > 1 and not self.open_nodes:
            proved, upper = self.energy, self.upper
            split = False
            if proved.least_load_factor <= load_factor < proved.load_factor:
                around, split = proved.initial_slip, not takes_long(problem)
            elif proved.load_factor <= load_factor < upper.load_factor < inf:
                # between a slip safe at λ_E and one safe at λ_max all slips are safe in between
                share = (load_factor - proved.load_factor) / (upper.load_factor - proved.load_factor)
                around = (1.0 - share) * proved.slip + share * upper.slip
        return energy_ball(problem, load_factor, around=around, split=split, tolerances=self.tolerances)

    def note_what_is_known(self) -> None:
        """Pass λ_max and the proved limits on to simulations; nothing where nodes stay open."""
        from shakedown.long_term.motion_start import MotionStart, known_limits, store_bound

        if self.open_nodes:
            return
        found, _ = self.energy, self.upper
        origin = MotionStart(self.problem, 0.0, self.tolerances, found.initial_slip, ())
        for name, limit in vars(self).items():
            kind = BOUNDS.get(name)
            if kind is None or not isinstance(limit, Bound):
                continue
            if kind.claim in (Claim.IMPOSSIBLE, Claim.EVERY_STATE):
                known_limits(self.problem)[name] = limit
            elif kind.claim == Claim.THIS_STATE and self.distance == 0.0 and not limit.undecided:
                store_bound(origin, limit)

    @cached_property
    def mesh(self) -> MeshCheck:
        """Whether the edge of the mesh determines λ_max, and the limits on every second node."""
        return mesh_check(self)

    def slip(self, below: float) -> "SlipLimit | Missing":
        """The load factor up to which every slip range of this history stays below a length."""
        from shakedown.assessment.transient_limit import scan_end, slip_limit  # loads compiled code

        upper = present(attempt(lambda: self.upper))
        end = (upper and scan_end(upper)) or 1.0
        return attempt(
            slip_limit, self.problem, below, self.initial_slip, largest=end, tolerances=self.tolerances
        )

    @property
    def pinned(self) -> tuple[int, ...]:
        """The slips, by number, that are set to zero where the joint can move as a whole.

        Of closed nodes: with one tangential direction they are the nodes that slips are given relative to.
        """
        return self.upper.pinned if self.open_nodes else constraints(self.problem).pinned

    @property
    def from_state(self) -> Bound:
        """The largest limit proved from this state; those that may be larger are computed.

        Where nodes are open, or the state is known only up to a distance, it is the first kind, λ_E.
        """
        first, *others = kinds_of(Claim.THIS_STATE)
        best: Bound = getattr(self, first.name)
        for kind in others if not self.open_nodes and self.distance == 0.0 else ():
            if self._may_exceed(kind, best):
                found = getattr(self, kind.name)
                more = best.least_load_factor > 0.0 or not found.load_factor <= best.load_factor
                best = found if more and not isnan(found.load_factor) else best
        return best

    def _may_exceed(self, kind: BoundKind, known: Bound) -> bool:
        """Whether another proof may reach farther than a known one."""
        if kind.name in vars(self) or known.least_load_factor > 0.0 or not known.load_factor > 0.0:
            return True
        if known.load_factor >= (1.0 - self.tolerances.agreement) * self.upper.load_factor:
            return False
        return kind.may_exceed(self, known.load_factor)

    @property
    def proved_from_every_state(self) -> float:
        """The largest proof from every state; 0 where nothing is proved, NaN where a program did not end."""
        known = [getattr(self, kind.name) for kind in kinds_of(Claim.EVERY_STATE)]
        proved = [each.load_factor for each in known if not isnan(each.load_factor)]
        if proved:
            return not_refuted(max(proved), self.upper, self.tolerances)
        return nan if any(each.undecided for each in known) else 0.0

    @property
    def proved_from_this_state(self) -> float:
        """The largest limit proved for the state in question; NaN where a program did not end."""
        here = self.from_state
        own = nan if here.least_load_factor > 0 else here.load_factor
        proved = float(np.fmax(own, self._as_one_of_all))
        return 0.0 if isnan(proved) and not here.undecided else proved

    @property
    def _as_one_of_all(self) -> float:
        """Up to where this state is among those that are proved with every state; NaN where not known."""
        if self.open_nodes or self.distance > 0 or self.universal.after_transient:
            return nan
        start = self.energy.initial_slip
        return min(self.proved_from_every_state, admitted_up_to(self.problem, start, self.tolerances))

    @property
    def impossible_above(self) -> float:
        """The upper end of what encloses λ_max; inf where nodes are open, 0 where no slip is safe."""
        upper = self.upper
        if upper.open_nodes:
            return inf
        if upper.status == Status.INFEASIBLE:
            return 0.0
        return float(
            upper.load_factor if upper.certified is None else max(upper.load_factor, upper.certified[1])
        )

    def to_dict(self) -> dict[str, Any]:
        """Every limit as JSON knows it; what is not there any more is null for one version."""
        found = {name: getattr(self, name) for name, kind in BOUNDS.items() if not kind.simulated}
        words = ("through_transient", "first_slip", "first_opening")
        gone = dict.fromkeys(("box", "closing_box", "core"))
        return {word: plain(getattr(self, word)) for word in words} | plain(found) | gone

    @cached_property
    def friction(self) -> FrictionThresholds | Missing:
        """The friction at which the motion stops being unique, and at which the joint wedges."""
        return attempt_any(friction_thresholds, self.problem, tolerances=self.tolerances)

    @cached_property
    def sensitivities(self) -> dict[str, Sensitivities | Missing]:
        """How λ_max ("upper") and λ_E ("energy") depend on friction and loads at every node."""
        return {
            name: attempt_any(sensitivities, self.problem, getattr(self, name), tolerances=self.tolerances)
            for name in ("upper", "energy")
        }

    @property
    def subsets(self) -> int | None:
        """How many (n+1)-subsets of rows there are to enumerate; None where there is no first collapse."""
        problem = self.problem
        return None if "lower" in self.absent else subset_count(problem.n, len(problem.law.frictionless))


@checked
def shakedown_bounds(
    problem: Problem,
    *,
    open_nodes: Iterable[int] | Literal["auto"] = (),
    certify: bool | None = None,
    tolerances: Tolerances = DEFAULT,
) -> ShakedownBounds:
    """The first collapse λ_1 and the upper bound λ_max; with two tangential directions λ_max alone.

    Shakedown below λ_1 is proved only where its ``guarantee`` says so.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    open_nodes
        The nodes that stay open, for the upper bound (:func:`upper_bound`).
    certify
        Whether to check both in exact arithmetic; by default each where that is quick.
    tolerances
        The tolerances that decide.

    Raises
    ------
    SolverError
        If a linear program ends without an answer.

    Examples
    --------
    >>> import shakedown
    >>> bounds = shakedown.shakedown_bounds(shakedown.example("two-node"))
    >>> round(bounds.lower.load_factor, 6), round(bounds.upper.load_factor, 6)
    (0.657373, 0.739146)
    """
    return JointLimits(problem, zone=open_nodes, certify=certify, tolerances=tolerances).bounds
