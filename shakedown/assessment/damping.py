"""Friction damping and stiffness over the amplitude of a load, from exact long-term states."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from math import inf, nan
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from shakedown.assessment.amplitude_curve import AmplitudePoint, DampingCurve, columns_of
from shakedown.assessment.loaded_joint import LoadedJoint
from shakedown.assessment.transient_limit import transient_limit
from shakedown.bounds.energy.energy_bound import energy_bound
from shakedown.ground.argument_kinds import check_count
from shakedown.ground.errors import UsageError, allowed, present
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import THREE_DIGITS
from shakedown.ground.shown_values import short
from shakedown.ground.size_limits import CYCLES
from shakedown.ground.status import OPEN, Outcome
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import (
    check_load_factor,
    checked,
    checked_initial_slip,
    node_numbers,
    real_array,
)
from shakedown.joint.conjugate_loads import load_units, require_loads
from shakedown.joint.problem import Problem
from shakedown.long_term.conjugate_displacement import load_loops
from shakedown.long_term.find_state import long_term_state
from shakedown.long_term.state import LongTermState

SCANNED = 2  # load factors between 0 and the first amplitude that damps


@checked
def damping(
    problem: Problem,
    amplitudes: ArrayLike,
    *,
    load: int | str = 0,
    initial_slip: ArrayLike | None = None,
    open_nodes: Iterable[int] | Literal["auto"] = "auto",
    from_zero: bool = False,
    max_cycles: int = CYCLES,
    progress: Callable[[int, int], None] | None = None,
    tolerances: Tolerances = DEFAULT,
) -> DampingCurve:
    """What a joint does over the amplitude of one of its loads: loop, dissipation, stiffness, damping.

    At every amplitude the exact long-term state is found, without fixed steps and without Masing's rule.
    Amplitudes increase, and each begins in the state before it, as in a test with rising amplitude. Below the
    limit there is no friction damping, which is said to be proved where it is (docs/damping.md).

    Parameters
    ----------
    problem
        The joint, with ``load_reactions`` and ``load_history``; for displacements ``load_compliance``.
    amplitudes : (k,)
        Factors on the history of the load, rising, ≥ 0.
    load
        Which load, by number or by its name in ``load_names``; the others are as they are.
    initial_slip : (dn,), optional
        Where the first amplitude begins [length]; zero by default.
    open_nodes
        Nodes that are open there; with ``"auto"`` the motion opens what has to open, and λ_E is that of
        the best zone of open nodes.
    from_zero
        Whether to find also what becomes of every amplitude from the state given, and where that differs.
    max_cycles
        Cycles after which an amplitude is undecided.
    progress
        Called with (amplitudes done, in all).
    tolerances
        What decides (:class:`Tolerances`).

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
    loaded = LoadedJoint.of(problem, load)
    values, opened = _checked_amplitudes(amplitudes), _checked_nodes(problem, open_nodes)
    check_count("max_cycles", max_cycles)
    start = checked_initial_slip(problem, initial_slip)
    work = _Amplitudes(loaded, values, start, opened, max_cycles, tolerances)
    count = 0

    def done(point: AmplitudePoint) -> AmplitudePoint:
        nonlocal count
        count += 1
        if progress is not None:
            progress(count, len(values) * (1 + from_zero))
        return point

    rising = [done(point) for point in work.rising()]
    fixed, other = _about(loaded, values), None
    if from_zero:
        other = DampingCurve(**fixed, **columns_of([done(work.from_start(one)) for one in values]))
    limits = _limits(work, rising, "auto" if isinstance(open_nodes, str) else opened)
    return DampingCurve(**(fixed | limits), **columns_of(rising), from_zero=other)


@dataclass(frozen=True)
class _Amplitudes:
    """What a curve follows: every amplitude from the state before it, or from the state given."""

    loaded: LoadedJoint
    values: FloatArray
    start: FloatArray
    open_nodes: tuple[int, ...]
    max_cycles: int
    tolerances: Tolerances

    def rising(self) -> Iterator[AmplitudePoint]:
        """The amplitudes one after the other, each from the state before it."""
        begun, after = (self.loaded, self.start, self.open_nodes), self.loaded.past_transient()
        for amplitude in self.values:
            point = self.point(begun[0], amplitude, *begun[1:])
            yield point
            if point.closes:
                begun = after, point.slip, tuple(point.open_nodes.tolist())

    def from_start(self, amplitude: float) -> AmplitudePoint:
        """One amplitude from the state given."""
        return self.point(self.loaded, amplitude, self.start, self.open_nodes)

    def point(
        self, loaded: LoadedJoint, amplitude: float, slip: FloatArray, open_nodes: tuple[int, ...]
    ) -> AmplitudePoint:
        """What becomes of the joint at one amplitude from one state."""
        problem, load_factor = loaded.at(float(amplitude))
        settings: dict[str, Any] = {"max_cycles": self.max_cycles, "tolerances": self.tolerances}
        try:
            state = long_term_state(problem, load_factor, slip, open_nodes=open_nodes, **settings)
        except UsageError:
            if open_nodes == self.open_nodes:
                raise
            state = long_term_state(problem, load_factor, slip, **settings)  # open nodes would overlap
        closes = state.period > 0 and state.outcome != Outcome.RATCHETTING
        rests = state.outcome == Outcome.SHAKEDOWN
        start = state.history.at(np.ceil(state.history.cycle[:1])) if closes else state.history
        slips = state.slip_per_cycle > self.tolerances.periodicity * np.abs(state.final_slip).max()
        return AmplitudePoint(
            displacement=self._displacement(problem, state) if closes else nan,
            dissipation=0.0 if rests else float(state.dissipation_per_cycle) if closes else nan,
            outcome=str(state.outcome),
            proved=state.proved,
            slides_away=state.slides_away,
            share=0.0 if rests else float(slips.mean()) if state.period else nan,
            slip=start.v[0] if closes else state.final_slip,
            open_nodes=np.flatnonzero(start.state[0] == OPEN) if closes else np.zeros(0, dtype=np.int64),
        )

    def _displacement(self, problem: Problem, state: LongTermState) -> float:
        if problem.load_compliance is None:
            return nan
        moved = float(np.ptp(load_loops(problem, state).displacement[:, self.loaded.load]))
        return 0.5 * moved / abs(load_units(self.loaded.problem)[self.loaded.load].size)


def _checked_amplitudes(amplitudes: ArrayLike) -> FloatArray:
    values = real_array("amplitudes", amplitudes)
    if values.ndim != 1 or not len(values) or not (np.diff(values) > 0).all() or values[0] < 0:
        raise UsageError(f"amplitudes: expected numbers >= 0 that rise, at least one, found {short(values)}")
    check_load_factor(float(values[-1]))
    return values


def _checked_nodes(problem: Problem, nodes: Iterable[int] | Literal["auto"]) -> tuple[int, ...]:
    if not isinstance(nodes, str):
        return node_numbers("open nodes", nodes, problem.n)
    if nodes != "auto":
        raise UsageError(f"open nodes: expected node numbers or 'auto', found {short(nodes)}")
    return ()


def _about(loaded: LoadedJoint, values: FloatArray) -> dict[str, Any]:
    """The fields of a curve that are known before anything is computed."""
    problem, load = loaded.problem, loaded.load
    history = require_loads(problem)[1]
    names, frequency, unit = problem.load_names or (), problem.load_frequency, load_units(problem)[load]
    return {
        "problem": problem,
        "load": load,
        "load_name": names[load] if len(names) == history.shape[1] else "",
        "amplitude": values,
        "unit": unit,
        "force": 0.5 * np.ptp(history[:, load]) * abs(unit.size) * values,
        "load_frequency": nan if frequency is None else float(frequency[load]),
        "proved_limit": nan,
        "simulated_limit": nan,
    }


def _limits(
    work: _Amplitudes, rising: list[AmplitudePoint], zone: Iterable[int] | Literal["auto"]
) -> dict[str, float]:
    """λ_E and λ_T as amplitudes; NaN where they do not exist or are not found."""
    joint = work.loaded.alone
    if joint is None:
        return {}
    proved = present(allowed(energy_bound, joint, work.start, open_nodes=zone, tolerances=work.tolerances))
    known = float(proved.load_factor) if proved is not None and proved.load_factor > 0 else nan
    damped = [a for a, point in zip(work.values, rising, strict=True) if point.outcome != Outcome.SHAKEDOWN]
    if not damped or damped[0] == 0:
        return {"proved_limit": known, "simulated_limit": nan if damped else inf}
    found = allowed(
        transient_limit,
        joint,
        work.start,
        open_nodes=work.open_nodes,
        largest=float(damped[0]),
        steps=SCANNED,
        accuracy=THREE_DIGITS,
        tolerances=work.tolerances,
    )
    return {"proved_limit": known, "simulated_limit": found.load_factor if found else nan}
