"""What becomes of a joint's numbers as its mesh is refined."""

from collections.abc import Mapping
from typing import Protocol

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from shakedown.ground.argument_kinds import checked
from shakedown.ground.float_array import FloatArray
from shakedown.plot.style import BLACK, FARTHEST, LINES, axes_for, finished

MARKS = "os^Dvx*"


class _Refinement(Protocol):
    """Numbers of one joint on several meshes."""

    @property
    def nodes(self) -> NDArray[np.intp]: ...
    @property
    def numbers(self) -> Mapping[str, FloatArray]: ...
    @property
    def verdict(self) -> Mapping[str, str]: ...
    @property
    def limit(self) -> Mapping[str, float]: ...


@checked
def refinement(found: _Refinement, *, ax: Axes | None = None) -> Axes:
    """Every number over the nodes of its mesh, relative to the finest: a level line has converged.

    Where that is zero, relative to the largest. Dashed: the extrapolated limits.

    Parameters
    ----------
    found
        From ``shakedown.refine``.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Examples
    --------
    >>> import shakedown
    >>> joints = {9: shakedown.example("block-9"), 33: shakedown.example("block-33")}
    >>> refinement(shakedown.refine(joints, [9, 33])).get_xscale()
    'log'
    """
    axes = axes_for(ax, (7.5, 4.6))
    for k, (name, values) in enumerate(found.numbers.items()):
        limit = found.limit[name]
        known = values[np.isfinite(values)]
        if not known.size or not known.max() > 0:
            continue
        unit = values[-1] if np.isfinite(values[-1]) and values[-1] > 0 else known.max()
        label, colour = f"{name.replace('_', ' ')}: {found.verdict[name]}", (*LINES, BLACK)[k]
        axes.plot(found.nodes, values / unit, f"{MARKS[k]}-", color=colour, label=label, ms=5)
        if np.isfinite(limit):
            axes.plot(found.nodes[-1] * np.array([1.0, 1.6]), 2 * [limit / unit], "--", color=colour)
    axes.set_xscale("log")
    axes.set_xticks(found.nodes, labels=[str(n) for n in found.nodes])
    axes.minorticks_off()
    axes.set_ylim(0.0, min(FARTHEST, axes.get_ylim()[1]))
    return finished(axes, "contact nodes", "share of the number on the finest mesh")
