"""Friction damping and stiffness versus the amplitude of a load, from exact long-term states."""

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from math import inf, isnan, nan
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.assessment.transient_limit import transient_limit
from shakedown.bounds.energy.energy_bound import energy_bound
from shakedown.bounds.every_state.universal_bound import universal_bound
from shakedown.bounds.named_start import named_start
from shakedown.files.atomic_write import write_table
from shakedown.files.pieces import finished
from shakedown.ground.argument_kinds import check_count, check_seed
from shakedown.ground.constants import CYCLES, MOST_ENTRIES, NEGLIGIBLE, THREE_DIGITS, FloatArray, Mask
from shakedown.ground.errors import UsageError, attempt_any
from shakedown.ground.shown_values import plain, short, shortened, with_unit
from shakedown.ground.status import OPEN, Outcome
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import (
    check_load_factor,
    checked,
    checked_initial_slip,
    node_numbers,
    real_array,
)
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.rigid_slips import can_creep
from shakedown.joint.units import LoadUnit, load_units, require_loads, units_of
from shakedown.long_term.conjugate_displacement import load_loops
from shakedown.long_term.find_state import long_term_state
from shakedown.long_term.motion_start import slip_after_transient
from shakedown.long_term.state import LongTermState

# of another amplitude
UNSTATED: dict[str, Any] = dict.fromkeys(("load_mean", "load_amplitude", "load_units"))


BANDS = "dissipation", "secant_stiffness", "loss_factor", "damping_ratio", "frequency"


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class DampingCurve(Result):
    """Result of :func:`damping`: one entry per amplitude; NaN where no loop of the load closes.

    Attributes
    ----------
    load
        Which load, by its number.
    load_name
        Its name; empty where the problem names none.
    unit
        The units of force, displacement and stiffness (:class:`~shakedown.joint.units.LoadUnit`).
    amplitude : (k,)
        Factors on the history of the load [–].
    force : (k,)
        Half the range of the load [force, where ``load_units`` says one; else units of ``load_history``].
    displacement : (k,)
        Half the range of the displacement conjugate to it [length; else work per unit of the load]; NaN
        without a ``load_compliance``.
    dissipation : (k,)
        What friction and jumps take per cycle [force × length]; exactly 0 where the joint shakes down.
    outcome : k times
        Long-term state (:class:`Outcome`).
    proved : (k,)
        Whether the absence of friction damping is proved, not only found by simulation.
    slides_away : (k,)
        Whether it is undecided because the body slides away: gross slip, which nothing holds.
    slipping_share : (k,)
        Share of the nodes that slip in every period.
    load_frequency
        Circular frequency of the mode that the load has the shape of; NaN where it is none.
    proved_limit
        λ_E: the amplitude below which there is no friction damping from the state given, proved; NaN where
        another load varies as well, and no amplitude is a load factor.
    simulated_limit
        λ_T: the largest amplitude found to shake down from the state given, to a thousandth, below the
        smallest one here that does not; infinite where all do, NaN as before.
    unique : (k,)
        Where the limit cycle is proved to be the only one: the band is a line there. Sought with ``states``.
    states : (s, dn)
        Other initial slips that every amplitude was followed from [length]: all but where it is proved that
        these do not matter.
    of_states : (2, s, k)
        Displacement and dissipation from these; NaN where no loop closes, or they were not followed.
    """

    DOCUMENT: ClassVar[str] = (
        "load load_name amplitude force displacement dissipation secant_stiffness loss_factor frequency "
        "damping_ratio outcome proved slides_away slipping_share load_frequency proved_limit simulated_limit"
    )
    TABLE: ClassVar[str] = (
        "amplitude force displacement dissipation secant_stiffness loss_factor frequency damping_ratio "
        "outcome proved slipping_share"
    )

    problem: Problem = field(repr=False, compare=False)
    load: int
    load_name: str
    unit: LoadUnit
    amplitude: FloatArray
    force: FloatArray
    displacement: FloatArray
    dissipation: FloatArray
    outcome: tuple[Outcome, ...]
    proved: NDArray[np.bool_]
    slides_away: NDArray[np.bool_]
    slipping_share: FloatArray
    load_frequency: float
    proved_limit: float = nan
    simulated_limit: float = nan
    unique: NDArray[np.bool_]
    states: FloatArray
    of_states: FloatArray

    @property
    def least(self) -> dict[str, FloatArray]:
        """The least dissipation, stiffness, … (k,) of all states; without other states those of the curve."""
        return {word: np.fmin.reduce(runs) for word, runs in self._runs.items()}

    @property
    def largest(self) -> dict[str, FloatArray]:
        """The largest likewise."""
        return {word: np.fmax.reduce(runs) for word, runs in self._runs.items()}

    @cached_property
    def _runs(self) -> dict[str, FloatArray]:
        """The words of ``BANDS``, (1 + s, k), of the curve and of all states."""
        others = self.of_states.swapaxes(0, 1)
        runs = [self, *(replace(self, displacement=x, dissipation=D) for x, D in others)]
        return {word: np.array([getattr(run, word) for run in runs]) for word in BANDS}

    @property
    def secant_stiffness(self) -> FloatArray:
        """Load over displacement amplitude, (k,) [force/length]; NaN of a load that does not vary."""
        return _ratio(np.where(self.force > 0, self.force, np.nan), self.displacement)

    @property
    def loss_factor(self) -> FloatArray:
        """η = D / (2π · ½ · load amplitude · displacement amplitude), (k,)."""
        return _ratio(self.dissipation, np.pi * self.force * self.displacement)

    @property
    def frequency(self) -> FloatArray:
        """Circular frequency √(secant stiffness) of a load that is M φ of a mode of unit modal mass, (k,)."""
        return np.sqrt(self.secant_stiffness) * self._of_a_mode

    @property
    def damping_ratio(self) -> FloatArray:
        """ζ = D / (2π · load amplitude · displacement amplitude) of such a load, (k,)."""
        return 0.5 * self.loss_factor * self._of_a_mode

    @property
    def _of_a_mode(self) -> float:
        """1 for a load that has the shape of a mode, else NaN."""
        return np.nan if isnan(self.load_frequency) else 1.0

    def to_dict(self) -> dict[str, Any]:
        """The words of ``DOCUMENT``, units; with other initial slips the least and the largest of all."""
        found = super().to_dict() | {"units": self.units}
        if len(self.states):
            ends = ("least", "largest", "unique")
            found |= {"states": len(self.states)} | {word: plain(getattr(self, word)) for word in ends}
        return found

    @property
    def units(self) -> dict[str, str]:
        """The units of columns, by their words; empty where the problem does not say them."""
        return {
            "force": self.unit.load,
            "displacement": self.unit.moved(self.problem),
            "dissipation": units_of(self.problem).work,
            "secant_stiffness": self.unit.stiffness,
        }

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write one row per amplitude: CSV in full precision, or Parquet where the name ends in .parquet.

        Headings have the units in brackets where the problem says that of the load.

        Raises
        ------
        UsageError
            If the file cannot be written, or its name ends in neither.
        """
        columns = self.columns()
        if len(self.states):
            for end in ("least", "largest"):
                columns |= {f"{end}_{word}": values for word, values in getattr(self, end).items()}
            columns["unique"] = self.unique
        units = self.units if self.unit.load else {}
        of = {word: units.get(word.removeprefix("least_").removeprefix("largest_"), "") for word in columns}
        write_table(path, {with_unit(word, of[word]): column for word, column in columns.items()})


@checked
def damping(
    problem: Problem,
    amplitudes: ArrayLike,
    *,
    load: int | str | None = None,
    initial_slip: ArrayLike | None = None,
    open_nodes: Iterable[int] | Literal["auto"] = "auto",
    states: int | ArrayLike | None = None,
    seed: int = 0,
    executor: Executor | None = None,
    workers: int = 1,
    max_cycles: int = CYCLES,
    progress: Callable[[int, int], None] | None = None,
    tolerances: Tolerances = DEFAULT,
) -> DampingCurve:
    """Dissipation, stiffness and damping of a joint versus the amplitude of one of its loads.

    At every amplitude the exact long-term state is found, without fixed steps and without Masing's rule.
    Amplitudes increase, and each run starts from the final state of the previous one, as in a stepped test.
    Below the limit there is no friction damping, proved where ``proved`` is true (docs/damping.md).

    Parameters
    ----------
    problem
        The joint, with ``load_reactions`` and ``load_history``; for displacements also ``load_compliance``.
    amplitudes : (k,)
        Factors on the history of the load, rising, ≥ 0.
    load
        Which load, by number or by its name in ``load_names``; by default the first that varies. The others
        are as they are.
    initial_slip : (dn,), optional
        Where the first amplitude begins [length]; zero by default.
    open_nodes
        Nodes that are open there; with ``"auto"`` the motion opens what has to open, and λ_E is that of
        the best zone of open nodes.
    states : int or (s, dn), optional
        Further initial slips, from each of which every amplitude is followed, for the least and the largest
        damping (:attr:`DampingCurve.least`). A number s: slip zero, the given and the critical state, and s
        states that random load histories leave behind, at one amplitude after the other.
    seed
        Seed of the random states.
    executor, workers
        What follows the states: an executor of ``concurrent.futures``, or this number of processes.
    max_cycles
        Cycles after which an amplitude is undecided.
    progress
        Called with (amplitudes done, in all); of other initial slips, with (states done, in all).
    tolerances
        What decides (:class:`Tolerances`).

    Notes
    -----
    The range found from some states is not a bound for all states, unless the limit cycle is proved to be
    the only one. That is so at amplitudes below λ_U, where no state goes on slipping, and for B = 0 without a
    rigid slip: two periodic motions then have the same reactions wherever either slips, so v̇ − v̇′ changes
    no reaction and is 0.

    Raises
    ------
    ProblemError
        If the problem does not know its loads.
    UsageError
        If an argument is out of range, there is no such load, or the load steps are a load domain's.

    Examples
    --------
    A spring of stiffness 2 to a node with the friction limit 1 (a Jenkins element): the dissipation is
    4 f p (F − f p) / k, and nothing below F = 1:

    >>> joint = Problem(
    ...     A=[[2.0]], B=[[0.0]], f=0.5, q_w=[[-1.0], [1.0]], p_w=[[2.0], [2.0]],
    ...     load_reactions=[[-1.0, 0.0]], load_history=[[1.0], [-1.0]], load_compliance=[[0.1]],
    ... )
    >>> curve = damping(joint, [0.5, 1.5, 2.0])
    >>> curve.dissipation.tolist(), curve.displacement.round(9).tolist(), curve.proved.tolist()
    ([0.0, 1.0, 2.0], [0.05, 0.4, 0.7], [True, False, False])
    """
    values = _checked_amplitudes(amplitudes)
    opened = () if isinstance(open_nodes, str) else node_numbers("open nodes", open_nodes, problem.n)
    check_count("max_cycles", max_cycles)
    number, start = load_number(problem, load), checked_initial_slip(problem, initial_slip)
    check_seed(seed)
    alone = _alone_varying(problem, number)
    loaded = _LoadedJoint(problem, number, alone, start, opened, max_cycles, tolerances)
    rows, say = list[_Row](), progress or (lambda done, total: None)
    for row in loaded.rising(values):
        rows.append(row)
        say(len(rows), len(values))
    limits = _limits(loaded, values, rows, "auto" if isinstance(open_nodes, str) else opened)
    slips, unique = np.zeros((0, len(start))), np.zeros(len(values), dtype=bool)
    if states is not None:
        slips, unique = _states(loaded, values, states, seed), _proved_unique(loaded, values)
    of_states = np.full((2, len(slips), len(values)), nan)
    work = partial(loaded.followed, values, slips, unique)
    for done, (which, runs) in enumerate(finished(work, range(len(slips)), executor, workers), start=1):
        of_states[:, which] = runs
        say(done, len(slips))
    return _curve(loaded, values, rows, limits | {"unique": unique, "states": slips, "of_states": of_states})


_Row = dict[str, Any]
"""The columns of :class:`DampingCurve` that are found at one amplitude."""


@dataclass(frozen=True)
class _LoadedJoint:
    """A joint under one load of any amplitude, and how its long-term states are found.

    Attributes
    ----------
    problem
        The joint as it was given.
    load
        The number of the load.
    alone
        The same joint with all but this load in its constant part, so that a load factor is an amplitude, and
        loads in units of their histories; None where another load varies, too.
    start, open_nodes
        Where the first amplitude begins.
    max_cycles, tolerances
        As for :func:`damping`.
    """

    problem: Problem
    load: int
    alone: Problem | None
    start: FloatArray
    open_nodes: tuple[int, ...]
    max_cycles: int
    tolerances: Tolerances

    def past_transient(self) -> "_LoadedJoint":
        """The joint after its transient load steps."""
        if self.problem.q_transient is None:
            return self
        over: dict[str, Any] = {"q_transient": None, "p_transient": None}
        alone = None if self.alone is None else replace(self.alone, **over)
        return replace(self, problem=replace(self.problem, **over), alone=alone)

    def at(self, amplitude: float) -> tuple[Problem, float]:
        """The joint and the load factor at an amplitude."""
        if self.alone is not None:
            return self.alone, amplitude
        unit, history = require_loads(self.problem)
        more = (amplitude - 1.0) * np.outer(history[:, self.load], unit[self.load])
        q, p = self.problem.layout.split(more)
        scaled = history.copy()
        scaled[:, self.load] *= amplitude
        q_w, p_w = self.problem.q_w + q, self.problem.p_w + p
        changed = UNSTATED | {"q_w": q_w, "p_w": p_w, "load_history": scaled, "q_mean": None, "p_mean": None}
        return replace(self.problem, **changed), 1.0  # the mean does not matter then

    def rising(self, values: FloatArray) -> Iterator[_Row]:
        """The amplitudes one after the other, each from the state before it whose loop closes."""
        joint, slip, opened, after = self, self.start, self.open_nodes, self.past_transient()
        for amplitude in values.tolist():
            row, ends_at = joint.point(amplitude, slip, opened)
            yield row
            if ends_at is not None:
                joint, (slip, opened) = after, ends_at

    def point(
        self, amplitude: float, slip: FloatArray, open_nodes: tuple[int, ...]
    ) -> tuple[_Row, tuple[FloatArray, tuple[int, ...]] | None]:
        """What becomes of the joint at one amplitude from one state.

        Also slip and open nodes at the first load step of a period, where the loop closes.
        """
        problem, load_factor = self.at(amplitude)
        settings: dict[str, Any] = {"max_cycles": self.max_cycles, "tolerances": self.tolerances}
        try:
            state = long_term_state(problem, load_factor, slip, open_nodes=open_nodes, **settings)
        except UsageError:
            if open_nodes == self.open_nodes:
                raise
            state = long_term_state(problem, load_factor, slip, **settings)  # open nodes would overlap
        closes = state.period > 0 and state.outcome != Outcome.RATCHETTING
        rests = state.outcome == Outcome.SHAKEDOWN
        slips = state.slip_per_cycle > self.tolerances.periodicity * np.abs(state.final_slip).max()
        row: _Row = {
            "displacement": self._displacement(problem, state) if closes else nan,
            "dissipation": 0.0 if rests else float(state.dissipation_per_cycle) if closes else nan,
            "outcome": state.outcome,
            "proved": state.proved,
            "slides_away": state.slides_away,
            "slipping_share": 0.0 if rests else float(slips.mean()) if state.period else nan,
        }
        if not closes:
            return row, None
        begins = state.history.at(np.ceil(state.history.cycle[:1]))
        return row, (begins.v[0], tuple(np.flatnonzero(begins.state[0] == OPEN).tolist()))

    def followed(self, values: FloatArray, states: FloatArray, skipped: Mask, k: int) -> FloatArray:
        """Displacement and dissipation at all amplitudes but some from a state, (2, k); else NaN."""
        found = np.full((2, len(values)), nan)
        for at in np.flatnonzero(~skipped).tolist():
            row, _ = self.point(float(values[at]), states[k], self.open_nodes)
            found[:, at] = row["displacement"], row["dissipation"]
        return found

    def _displacement(self, problem: Problem, state: LongTermState) -> float:
        if problem.load_compliance is None:
            return nan
        moved = float(np.ptp(load_loops(problem, state).displacement[:, self.load]))
        return 0.5 * moved / abs(load_units(self.problem)[self.load].size)


def _states(loaded: _LoadedJoint, values: FloatArray, states: Any, seed: int) -> FloatArray:
    """Initial slips (s, dn): those given, or those with a name and what random transients leave."""
    problem = loaded.problem
    if not isinstance(states, int | np.integer):
        given = real_array("states", states)
        if given.ndim != 2:
            raise UsageError(
                f"states: expected a number or slips ({problem.layout.slip_size} a row), found {given.shape}"
            )
        return np.array([checked_initial_slip(problem, slip, "states") for slip in given])
    check_count("states", int(states), MOST_ENTRIES)
    named = (attempt_any(named_start, problem, 0.0, word) for word in ("zero", "given", "witness"))
    found = [slip for slip in named if isinstance(slip, np.ndarray)]
    for k in range(int(states)):
        at, generator = loaded.at(float(values[k % len(values)])), np.random.default_rng([seed, k])
        left = slip_after_transient(*at, generator, tolerances=loaded.tolerances)
        found += [left] if np.isfinite(left).all() else []
    return np.array(found)


def _proved_unique(loaded: _LoadedJoint, values: FloatArray) -> NDArray[np.bool_]:
    """Where the limit cycle is proved to be the same from every state, (k,)."""
    problem = loaded.problem
    if not problem.B.any() and not can_creep(problem):
        return np.ones(len(values), dtype=bool)
    alone = loaded.alone
    found = None if alone is None else attempt_any(universal_bound, alone, tolerances=loaded.tolerances)
    return np.asarray(values < (found.load_factor if found else 0.0))


def _checked_amplitudes(amplitudes: ArrayLike) -> FloatArray:
    values = real_array("amplitudes", amplitudes)
    if values.ndim != 1 or not len(values) or not (np.diff(values) > 0).all() or values[0] < 0:
        raise UsageError(f"amplitudes: expected numbers >= 0 that rise, at least one, found {short(values)}")
    check_load_factor(float(values[-1]))
    return values


def _curve(loaded: _LoadedJoint, values: FloatArray, rows: list[_Row], known: _Row) -> DampingCurve:
    """The columns of some amplitudes, with what else is known."""
    problem, load = loaded.problem, loaded.load
    history, unit = require_loads(problem)[1], load_units(problem)[load]
    names, frequency = problem.load_names or (), problem.load_frequency
    words = "displacement dissipation proved slides_away slipping_share"
    columns = known | {word: np.array([row[word] for row in rows]) for word in words.split()}
    return DampingCurve(
        problem=problem,
        load=load,
        load_name=names[load] if len(names) == history.shape[1] else "",
        unit=unit,
        amplitude=values,
        force=0.5 * np.ptp(history[:, load]) * abs(unit.size) * values,
        outcome=tuple(row["outcome"] for row in rows),
        load_frequency=nan if frequency is None else float(frequency[load]),
        **columns,
    )


def _limits(
    loaded: _LoadedJoint, values: FloatArray, rising: list[_Row], zone: Iterable[int] | Literal["auto"]
) -> dict[str, float]:
    """λ_E and λ_T as amplitudes, where they exist and are found."""
    joint, tolerances, limits = loaded.alone, loaded.tolerances, dict[str, float]()
    if joint is None:
        return limits
    proved = attempt_any(energy_bound, joint, loaded.start, open_nodes=zone, tolerances=tolerances)
    if proved and proved.load_factor > 0:
        limits["proved_limit"] = float(proved.load_factor)
    damped = [a for a, row in zip(values, rising, strict=True) if row["outcome"] != Outcome.SHAKEDOWN]
    if not damped:
        return limits | {"simulated_limit": inf}
    scan: dict[str, Any] = {"largest": float(damped[0]), "steps": 2, "accuracy": THREE_DIGITS}
    if damped[0] > 0:  # two steps between 0 and the first amplitude that damps
        scan |= {"open_nodes": loaded.open_nodes, "tolerances": tolerances}
        found = attempt_any(transient_limit, joint, loaded.start, **scan)
        limits["simulated_limit"] = found.load_factor if found else nan
    return limits


def _alone_varying(problem: Problem, load: int) -> Problem | None:
    """The joint with all but one load in its constant part; None where another load varies, too."""
    unit, history = require_loads(problem)
    others = np.delete(history, load, axis=1)
    if (np.ptp(others, axis=0) > NEGLIGIBLE * np.abs(others).max(axis=0, initial=0.0)).any():
        return None
    rest = problem.layout.joined(problem.q_w, problem.p_w) - np.outer(history[:, load], unit[load])
    q_mean, p_mean = problem.layout.split(rest[0])
    return replace(problem, q_mean=q_mean, p_mean=p_mean, **UNSTATED)


def load_number(problem: Problem, load: int | str | None) -> int:
    """The number of a load that is called by number or name; by default the first that varies, else 0.

    Raises ``ProblemError`` where the joint does not know its loads, ``UsageError`` where there is no such
    load or the load steps are a load domain's.
    """
    history = require_loads(problem)[1]
    if problem.is_domain:
        raise UsageError("problem: expected load steps in their order, found corners of a load domain")
    if load is None:
        return int(np.argmax(np.ptp(history, axis=0) > NEGLIGIBLE * np.abs(history).max(axis=0)))
    count, names = history.shape[1], problem.load_names or ()
    named = names if len(names) == count else count * ("",)
    found = [k for k, own in enumerate(named) if own == load != ""]
    found = found or [k for k in range(count) if load in (k, str(k))]
    if len(found) == 1:
        return found[0]
    known = f"0 to {count - 1}" + "".join(f", '{name}'" for name in named if named.count(name) == 1 and name)
    raise UsageError(f"load: expected one of {shortened(known, 200)}, found {shortened(repr(load))}")


def _ratio(one: FloatArray, other: FloatArray) -> FloatArray:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(other > 0, one / other, np.nan)
