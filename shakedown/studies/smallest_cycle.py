"""The adversary: the smallest load factors at which a cycle and separation are found, whatever the state."""

import functools
import hashlib
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from math import inf, isfinite, nan
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from shakedown.assessment.every_limit import JointLimits
from shakedown.campaign.recorded_steps import RecordedSteps, recorded_steps, run_header
from shakedown.ground.argument_kinds import check_count, check_seed
from shakedown.ground.errors import Missing, UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import PER_CENT
from shakedown.ground.shown_values import plain
from shakedown.ground.size_limits import MANY
from shakedown.ground.status import Guarantee, Outcome, Search, Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import check_load_factor, checked, is_finite
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.long_term.many_states import checked_initial_slips
from shakedown.long_term.state import LongTermState
from shakedown.motion.checked_law import admissible, length_scales, path_accuracy
from shakedown.studies.cycle_search import AttackingStates, CycleSearch
from shakedown.studies.descent import Simulator

Progress = Callable[[int, int], None]

DEPTHS = (0.02, 0.1, 0.3, 0.6, 0.9)  # how far down towards λ_U the rounds look, one after the other
PROVED = (0.999, 0.9)  # of λ_U: where nothing may be found


@dataclass(frozen=True, eq=False, repr=False)
class SmallestCycle(Result):
    """Result of :func:`smallest_cycle`.

    Attributes
    ----------
    status
        Found a cycle, none found, or contradiction (:class:`Search`).
    load_factor
        λ_cycle, the smallest at which a cycle (:class:`Outcome` cyclic slip or ratchetting)
        was found; inf where none was.
    separation_load_factor
        The smallest at which separation was met: from an admissible state a node opens and
        closes in every period without slip in contact, or contact is lost; inf where none was.
    separation_slip : (dn,)
        A slip at the first load step from which it does [length]; NaN where none was met.
    initial_slip : (dn,)
        A slip at the first load step from which the joint goes through that cycle [length].
    period
        Its period in cycles of the loading; 0 where none was found.
    dissipation_per_cycle
        What it takes per cycle [force × length].
    least_dissipation
        What friction must take per cycle for a cycle to be one: below, at ``load_factor`` (or where the
        search began), the round-off of the data hides it [force × length].
    slipping_nodes
        The nodes that slip in it.
    state
        The long-term state from ``initial_slip`` at ``load_factor``; None where none was found.
    limits
        The limits of the joint with all nodes closed and without transient load steps: λ_U, below which
        shakedown from every state is proved, λ_1, with its ``guarantee``, and λ_max.
    tried_up_to
        The load factor at which the search began.
    below_first_collapse
        Whether the cycle lies below λ_1, which then is no guarantee.
    tries
        How many long-term states were simulated.
    undecided
        How many of them came to no verdict.
    seed
        Seed of the random states.
    contradiction
        What is contradicted, in words; else empty.
    """

    DOCUMENT: ClassVar[str] = (
        "status load_factor interval initial_slip outcome period dissipation_per_cycle least_dissipation "
        "slipping_nodes below_first_collapse separation_load_factor separation_slip tried_up_to tries "
        "undecided seed contradiction"
    )
    TABLE: ClassVar[str] = "initial_slip slip_per_cycle"

    status: Search
    load_factor: float
    separation_load_factor: float
    separation_slip: FloatArray = field(repr=False)
    initial_slip: FloatArray
    period: int
    dissipation_per_cycle: float
    least_dissipation: float
    slipping_nodes: tuple[int, ...]
    state: LongTermState | None = field(repr=False)
    limits: JointLimits = field(repr=False)
    tried_up_to: float
    below_first_collapse: bool
    tries: int
    undecided: int
    seed: int
    contradiction: str

    @property
    def interval(self) -> tuple[float, float]:
        """Where the largest load factor lies up to which every state shakes down.

        From λ_U to the smaller of λ_cycle and the smallest separation.
        """
        return self.limits.universal.load_factor, min(self.load_factor, self.separation_load_factor)

    @property
    def outcome(self) -> Outcome | None:
        """Cyclic slip or ratchetting; None where no cycle was found."""
        return None if self.state is None else self.state.outcome

    @property
    def slip_per_cycle(self) -> FloatArray:
        """Σ|Δv| of every node over one period, (n,) [length]; NaN where no cycle was found."""
        return np.full(len(self.initial_slip), nan) if self.state is None else self.state.slip_per_cycle

    def to_dict(self) -> dict[str, Any]:
        """The cycle as JSON knows it, with the bounds beside it as ``shakedown-bounds solve`` writes them."""
        limits = self.limits
        lower = None
        if limits.lower:
            lower = {key: getattr(limits.lower, key) for key in ("load_factor", "node", "guarantee")}
        upper = {key: getattr(limits.upper, key) for key in ("status", "load_factor")}
        bounds = {**limits.universal.document(), "lower": lower, "upper": upper}
        return super().to_dict() | {word: plain(bounds[word]) for word in ("universal", "lower", "upper")}


@checked
def smallest_cycle(
    problem: Problem,
    *,
    states: int = 64,
    rounds: int = 10,
    seed: int = 0,
    initial_slips: ArrayLike | None = None,
    largest: float | None = None,
    accuracy: float = 1e-6,
    partial: str | os.PathLike[str] | None = None,
    resume: bool = False,
    save: Callable[[SmallestCycle], None] | None = None,
    progress: Progress | None = None,
    tolerances: Tolerances = DEFAULT,
) -> SmallestCycle:
    """The smallest load factor at which a cycle is found, sought over initial states and periods.

    Separation, which is neither a cycle of slip nor rest in contact, is kept apart: the smallest
    load factor at which it is met on the way, or just above the first collapse from its critical slip state.

    Every round draws initial slips that are admissible under the first load, extreme and
    random, and simulates them at a load factor between λ_U and the smallest cycle known. What
    cycles is followed down: of the sequence of contact states of a cycle the smallest load
    factor follows from a linear program, and below it another sequence may go on. Two more
    rounds are spent below λ_U, where nothing may be found. The smallest cycle is simulated
    again from its own state. What dissipates less than the data resolve (``least_dissipation``) is
    not called a cycle, unless only nodes without friction slip. Transient load steps are left
    out: a cycle does not know of them. With two tangential directions there are no such programs: there
    a cycle is followed down from its own slip, half as far each time it dies, to 1e-4 of λ.

    Parameters
    ----------
    problem
        The joint and its loading loop.
    states
        Initial slips per round.
    rounds
        Number of rounds.
    seed
        Seed of the random slips; the same seed gives the same answer.
    initial_slips : (s, n), optional
        Further slips to try [length].
    largest
        Where the search begins; by default a little above λ_max; where that is no positive
        number, above λ_1, or that of the best zone of open nodes, or 1.
    accuracy
        To which the end of a sequence of contact states is approached, relative to λ.
    partial
        Where simulations are recorded, batch by batch, until the search is over; valid after a kill at any
        instant. None: nowhere.
    resume
        Whether to go on with what a killed search has recorded there, if one has.
    save
        Called with the result before what is recorded is removed: what writes it to a file.
    progress
        Called with (rounds done, rounds in all).
    tolerances
        What decides (:class:`Tolerances`).

    Raises
    ------
    UsageError
        If an argument is out of range, ``partial`` cannot be written, or what is recorded there is of
        another search.

    Examples
    --------
    The first collapse is no guarantee of this joint: a node cycles from 2.4442 on.

    >>> import shakedown
    >>> found = smallest_cycle(shakedown.example("three-node"), rounds=2)
    >>> round(found.load_factor, 4), found.slipping_nodes, found.below_first_collapse
    (2.4442, (0,), True)
    """
    check_count("states", states, MANY)
    check_count("rounds", rounds, MANY)
    if not (is_finite(accuracy) and 0 < accuracy < 1):
        raise UsageError(f"accuracy: expected a number between 0 and 1, found {accuracy!r}")
    seed = check_seed(seed)
    joint = replace(problem, q_transient=None, p_transient=None)
    given = _given(joint, initial_slips)
    asked = _Query(states, rounds, seed, given, largest, accuracy)
    header = {} if partial is None else asked.header(joint, tolerances)
    with recorded_steps(partial, header, joint, resume=resume) as steps:
        found = _searched(joint, asked, steps, progress, tolerances)
        if save is not None:
            save(found)
        steps.remove()
    return found


class _Query(NamedTuple):
    """What a search is asked."""

    states: int
    rounds: int
    seed: int
    initial_slips: FloatArray
    largest: float | None
    accuracy: float

    def header(self, joint: Problem, tolerances: Tolerances) -> dict[str, str]:
        """All that a search depends on, by name."""
        words = self._asdict() | {"initial_slips": hashlib.sha256(self.initial_slips.tobytes()).hexdigest()}
        return run_header("adversary", joint, tolerances, words)


def _searched(
    joint: Problem, asked: _Query, steps: RecordedSteps, progress: Progress | None, tolerances: Tolerances
) -> SmallestCycle:
    """The search itself."""
    limits = JointLimits(joint, zone=(), certify=False, tolerances=tolerances)
    for name in ("upper", "lower", "universal"):
        limits.keep(name, steps.done(functools.partial(getattr, limits, name)))
    top = steps.done(lambda: _top(limits, asked.largest))
    known = [*_known_slips(limits), *asked.initial_slips]
    simulator = Simulator(joint, tolerances, steps)
    attack = AttackingStates(joint, np.array(known), np.random.default_rng(asked.seed), tolerances)
    search = CycleSearch(simulator, attack, asked.accuracy, asked.accuracy * top)
    proved = limits.universal.load_factor
    floor = proved if isfinite(proved) else 0.0
    search.try_witness(limits)
    levels = [
        top,
        *(None for _ in range(asked.rounds - 1)),
        *(share * floor for share in PROVED if floor > 0),
    ]
    for done, level in enumerate(levels):
        if progress is not None:
            progress(done, len(levels))
        if level is None:
            highest = top if search.best is None else min(search.best.load_factor, top)
            if highest <= floor * (1.0 + asked.accuracy):
                continue  # nothing lies between
            level = highest - DEPTHS[done % len(DEPTHS)] * (highest - floor)
        search.look_at(level, asked.states)
    search.lower_separation()
    if progress is not None:
        progress(len(levels), len(levels))
    return _result(search, limits, top, asked.seed)


def _top(limits: JointLimits, largest: float | None) -> float:
    """Where the search begins."""
    joint = limits.problem
    if largest is not None:
        if not (is_finite(largest) and largest > 0):
            raise UsageError(f"largest: expected a positive load factor, found {largest!r}")
        check_load_factor(largest, joint)
        return float(largest)
    for found in (limits.upper.load_factor, _first_collapse(limits)):
        if isfinite(found) and found > 0:
            return (1.0 + PER_CENT) * found  # there every state slips for ever, or opens
    if limits.upper.status == Status.INFEASIBLE and joint.C is not None:
        zone = replace(limits, zone="auto").upper.load_factor
        if isfinite(zone) and zone > 0:
            return (1.0 + PER_CENT) * zone
    return 1.0


def _first_collapse(limits: JointLimits) -> float:
    """λ_1; NaN with two tangential directions, where there is none."""
    return limits.lower.load_factor if limits.lower else nan


def _known_slips(limits: JointLimits) -> Iterator[FloatArray]:
    """Slips from which a cycle may well begin: of the bounds, and those of the joint itself."""
    joint, lower, swing = limits.problem, limits.lower, limits.universal.swing
    yield np.zeros(joint.layout.slip_size)
    found = [limits.upper.slip]
    if lower:
        alone = lower.evidence.alone
        found = [lower.slip, *found, *([] if isinstance(alone, Missing) else [alone.slip])]
    found += [] if swing is None else [swing.forward_slip, swing.backward_slip]
    yield from (slip for slip in found if np.isfinite(slip).all())
    if joint.initial_slip is not None:
        yield from joint.initial_slip


def _given(joint: Problem, initial_slips: ArrayLike | None) -> FloatArray:
    if initial_slips is None:
        return np.empty((0, joint.layout.slip_size))
    return checked_initial_slips(joint, initial_slips)


def _result(search: CycleSearch, limits: JointLimits, top: float, seed: int) -> SmallestCycle:
    best, joint = search.best, search.simulator.problem
    nowhere = np.full(joint.layout.slip_size, nan)
    state = None if best is None else best.state
    load_factor = inf if best is None else best.load_factor
    contradiction = _contradiction(search, limits)
    status = Search.CONTRADICTION if contradiction else Search.NONE_FOUND if best is None else Search.FOUND
    return SmallestCycle(
        status=status,
        load_factor=load_factor,
        separation_load_factor=inf if search.apart is None else search.apart.load_factor,
        separation_slip=nowhere if search.apart is None else search.apart.slip,
        initial_slip=nowhere if best is None else best.slip,
        period=0 if state is None else state.period,
        dissipation_per_cycle=nan if state is None else state.dissipation_per_cycle,
        least_dissipation=search.simulator.least_dissipation(load_factor if isfinite(load_factor) else top),
        slipping_nodes=() if state is None else _slipping(state, limits.tolerances),
        state=state,
        limits=limits,
        tried_up_to=top,
        below_first_collapse=load_factor / (1.0 - limits.tolerances.agreement) < _first_collapse(limits),
        tries=search.simulator.tries,
        undecided=search.simulator.undecided,
        seed=seed,
        contradiction=contradiction,
    )


def _slipping(state: LongTermState, tolerances: Tolerances) -> tuple[int, ...]:
    """The nodes that slip, in space by more than the path resolves."""
    none = 10.0 * path_accuracy(state.problem, tolerances) * length_scales(state.problem, state.load_factor)
    return tuple(np.flatnonzero(state.slip_per_cycle > none).tolist())


def _contradiction(search: CycleSearch, limits: JointLimits) -> str:
    """What is called proved above a cycle or a separation that was found from an admissible state."""
    joint, tolerances, found = limits.problem, limits.tolerances, [search.best, search.apart]
    real = [
        x.load_factor
        for x in found
        if x is not None and admissible(joint, x.load_factor, x.slip[None], tolerances)[0]
    ]
    sure = min(real, default=inf) / (1.0 - tolerances.agreement)
    if sure < limits.universal.load_factor:
        return f"λ_U = {limits.universal.load_factor:.9g} is called proved from every state"
    if limits.lower and limits.lower.guarantee == Guarantee.PROVED and sure < limits.lower.load_factor:
        return f"λ_1 = {limits.lower.load_factor:.9g} is called a proved guarantee"
    return ""
