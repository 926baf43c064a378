"""The loop of a load, and what a joint does over its amplitude: damping and stiffness."""

from typing import Any, Protocol

import numpy as np
from matplotlib.axes import Axes

from shakedown.assessment.amplitude_curve import DampingCurve
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import down, sized
from shakedown.ground.status import Outcome
from shakedown.ground.visible_text import shortened, with_unit
from shakedown.joint.arguments import checked
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.long_term.conjugate_displacement import load_loops
from shakedown.plot.style import BLUE, GREEN, GREY, LINES, LONGEST_LABEL, RED, axes_for, finished

DECADE = 10.0  # ratio of the largest to the smallest amplitude from which on the axis is logarithmic


SLIDES_AWAY = "slides away"
MARKS = {Outcome.RATCHETTING: "x", Outcome.SEPARATION: "o", SLIDES_AWAY: "v", Outcome.UNDECIDED: "d"}


class OfJoint(Protocol):
    """A long-term state, or a simulation."""

    @property
    def problem(self) -> Problem: ...

    @property
    def history(self) -> object: ...


def load_title(problem: Problem, load: int) -> str:
    """How a load is called: by its name where the problem has one for each."""
    names = problem.load_names or ()
    count = 0 if problem.load_reactions is None else len(problem.load_reactions)
    name = names[load] if len(names) == count else ""
    return f"load {load}" + (f" ({shortened(name, LONGEST_LABEL)})" if name else "").replace("$", r"\$")


@checked
def loop(state: OfJoint, *, load: int = 0, ax: Axes | None = None) -> Axes:
    """A load against the displacement that it works along, over one period of a long-term state.

    The areas of the loops of all loads are together what friction (and the damping of jumps) dissipates.

    Parameters
    ----------
    state
        A long-term state, or a simulation that found one.
    load
        Which load of the problem, by number.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    ProblemError
        If the problem does not know its loads or their compliance.
    UsageError
        If no events were recorded, or there is no such load.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> joint = shakedown.Problem(
    ...     A=[[2.0]], B=[[0.0]], f=0.5, q_w=[[-3.0], [3.0]], p_w=[[2.0], [2.0]],
    ...     load_reactions=[[-1.0, 0.0]], load_history=[[3.0], [-3.0]], load_compliance=[[0.1]],
    ... )
    >>> plot.loop(shakedown.long_term_state(joint, 1.0)).get_title()
    'load 0, area 4 in one period'
    """
    problem = state.problem
    loops = load_loops(problem, getattr(state, "settled", state))
    if not 0 <= load < loops.load.shape[1]:
        raise UsageError(f"load: expected a number from 0 to {loops.load.shape[1] - 1}, found {load}")
    axes = axes_for(ax)
    axes.plot(loops.displacement[:, load], loops.load[:, load], ".-", color=LINES[0], lw=1.3, ms=3)
    axes.ticklabel_format(scilimits=(-2, 3))
    area = sized(float(loops.areas[load]), units_of(problem).work)
    title = f"{load_title(problem, load)}, area {area} in one period"
    unit = loops.units[load]
    moved = with_unit("displacement conjugate to the load", unit.moved(problem))
    return finished(axes, moved, with_unit("load", unit.load or "units of it"), title=title)


@checked
def damping_curve(curve: DampingCurve, *, ax: Axes | None = None) -> Axes:
    """Damping and stiffness over the amplitude of a load, with the limit below which nothing damps.

    The loss factor (of a mode the damping ratio) on the left, the secant stiffness (the frequency) on the
    right, each in absolute terms, as computed. Amplitudes without a closed loop are marked below.

    Parameters
    ----------
    curve
        What :func:`shakedown.damping` found.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> joint = shakedown.Problem(
    ...     A=[[2.0]], B=[[0.0]], f=0.5, q_w=[[-1.0], [1.0]], p_w=[[2.0], [2.0]],
    ...     load_reactions=[[-1.0, 0.0]], load_history=[[1.0], [-1.0]], load_compliance=[[0.1]],
    ... )
    >>> plot.damping_curve(shakedown.damping(joint, [0.5, 1.5, 2.0])).get_ylabel()
    'loss factor η [–]'
    """
    axes = axes_for(ax)
    modal = not np.isnan(curve.load_frequency)
    left = curve.damping_ratio if modal else curve.loss_factor
    right = curve.frequency / (2 * np.pi) if modal else curve.secant_stiffness
    names = ("damping ratio ζ [–]", "frequency") if modal else ("loss factor η [–]", "secant stiffness")
    (one,) = axes.plot(curve.amplitude, left, ".-", color=BLUE, lw=1.3, label=names[0].removesuffix(" [–]"))
    beside = axes.twinx()
    (other,) = beside.plot(curve.amplitude, right, ".--", color=RED, lw=1.1, label=names[1])
    unit = "1/time" if modal else curve.unit.stiffness or "load/displacement"
    beside.set_ylabel(with_unit(names[1], unit), color=RED)
    handles = [one, other, *_limits_marked(axes, curve), *_without_loop(axes, curve)]
    positive = curve.amplitude[curve.amplitude > 0]
    if len(positive) > 1 and positive[-1] >= DECADE * positive[0]:
        axes.set_xscale("log")
    axes.set_ylim(bottom=0.0)
    name = load_title(curve.problem, curve.load)
    finished(axes, f"amplitude of {name} [–]", names[0])
    axes.legend(handles=handles, fontsize="small", loc="center left")
    return axes


def _limits_marked(axes: Axes, curve: DampingCurve) -> list[Any]:
    """Lines at λ_E and λ_T."""
    found = []
    if 0 < curve.proved_limit < np.inf:
        label = f"λ_E = {down(curve.proved_limit, 6)}: none below, proved"
        found.append(axes.axvline(curve.proved_limit, color=GREEN, lw=1.2, label=label))
    if 0 < curve.simulated_limit < np.inf:
        label = f"λ_T = {down(curve.simulated_limit, 6)}: none found below"
        found.append(axes.axvline(curve.simulated_limit, color=GREY, lw=1.2, ls=":", label=label))
    return found


def _without_loop(axes: Axes, curve: DampingCurve) -> list[Any]:
    """Marks on the axis at amplitudes whose loop does not close."""
    words = np.where(curve.slides_away, SLIDES_AWAY, [str(outcome) for outcome in curve.outcome])
    found, low = [], axes.get_xaxis_transform()
    for word, mark in MARKS.items():
        chosen = curve.amplitude[words == word]
        if len(chosen):
            height = np.full(len(chosen), 0.02)
            found += axes.plot(chosen, height, mark, color=GREY, transform=low, label=word)
    return found
