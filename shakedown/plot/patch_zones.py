"""Which nodes of a patch stick, slip and are open at one instant."""

import numpy as np
from matplotlib.axes import Axes

from shakedown.joint.arguments import checked
from shakedown.joint.problem import Problem
from shakedown.motion.event_history import EventHistory
from shakedown.plot.patch_colours import at_instant
from shakedown.plot.patch_places import numbered, patch_axes, places_of, require_space
from shakedown.plot.style import BLUE, GREY, RED, Recorded, path_of

KINDS = ((0, "stick", "s", BLUE), (1, "slip", "o", RED), (2, "open", "o", "none"))
LARGEST, SMALLEST, SHARE = 8.0, 2.5, 75.0  # of a marker [points]: about SHARE of them in a row fill a panel


@checked
def zones_at(
    result: Recorded | EventHistory, problem: Problem, cycle: float | None = None, *, ax: Axes | None = None
) -> Axes:
    """Stick, slip and open nodes of a patch at one instant, told apart by colour and shape.

    Parameters
    ----------
    result
        A long-term state, or a recorded simulation or evolution, of a joint with two directions.
    problem
        The joint: places of its nodes.
    cycle
        The time in cycles; by default when the total pressure is largest.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If no events were recorded, the time lies outside them, or the joint has one direction.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> joint = shakedown.example("four-node-3d")
    >>> plot.zones_at(shakedown.long_term_state(joint, 0.5), joint, 0.0).get_title()
    't = 0 cycles: 4 stick, 0 slip, 0 open'
    """
    require_space("picture of a patch", problem)
    now, title = at_instant(path_of(result), cycle)
    places, state = places_of(problem), np.abs(now.state[0])
    axes = patch_axes(places, ax, 0.5 * places.spacing)
    size = float(np.clip(SHARE / np.sqrt(problem.n), SMALLEST, LARGEST))
    for number, name, shape, colour in KINDS:
        here = places.points[state == number]
        edge = GREY if colour == "none" else colour
        axes.scatter(here[:, 0], here[:, 1], s=size**2, marker=shape, fc=colour, ec=edge, lw=0.8, label=name)
    numbered(axes, places)
    counts = ", ".join(f"{int((state == number).sum())} {name}" for number, name, *_ in KINDS)
    axes.set_title(f"{title}: {counts}", fontsize="medium")
    axes.grid(alpha=0.3)
    axes.set_axisbelow(True)
    axes.legend(fontsize="small")
    return axes
