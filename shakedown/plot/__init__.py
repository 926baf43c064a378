"""Pictures of a joint: loads, bounds, paths, zones. Each function draws one and returns its axes.

Every function takes ``ax``, the axes to draw on; without it a new figure is made, which
``plot.save(axes, path)`` writes to a file. Labels carry the units of the problem where they are
known. The report is drawn by the same functions.

From a result to a picture: ``paths`` reads a result (its path, an instant, sums of each node along it),
a module below computes what is drawn, ``style`` holds what all pictures share (axes, colours, legends).

- the joint itself: ``joint`` (nodes, loads, what limits it)
- along a contact in the plane, numbers and zones, limits on one scale, slips over the load: ``along``
- over a patch in space, colours, arrows and marks: ``over_patch``, on the places of ``patch_places``
- loops of nodes and of loads, reactions in time, damping: ``loops``
- slip space, reaction space: ``planes``
- design diagrams, maps of initial states: ``regions``
- inside a page: ``inline_svg``, ``patch_places`` (the view in three dimensions)
- without a window: ``backend``
"""

import shakedown.plot.backend  # noqa: F401  before matplotlib
from shakedown.plot.along import (
    dissipation_along,
    friction_use,
    load_factor_scale,
    pressure,
    refinement,
    slip_along,
    slip_over_load,
    slip_per_cycle,
    slip_range,
    zones,
)
from shakedown.plot.joint import contact, loads_along, loads_in_time, sensitivity
from shakedown.plot.loops import (
    damping_curve,
    hysteresis,
    load_loop,
    load_orbits,
    loop,
    reaction_orbits,
    reactions_in_time,
    slip_orbits,
)
from shakedown.plot.over_patch import (
    friction_use_at,
    loads_over_patch,
    pressure_over_patch,
    slip_over_patch,
    welded_pressure_over_patch,
    work_over_patch,
    zones_at,
)
from shakedown.plot.patch_places import patch_count
from shakedown.plot.planes import reaction_space, slip_space
from shakedown.plot.regions import basin, regions, shakedown_share
from shakedown.plot.style import save

__all__ = [
    "basin",
    "contact",
    "damping_curve",
    "dissipation_along",
    "friction_use",
    "friction_use_at",
    "hysteresis",
    "load_factor_scale",
    "load_loop",
    "load_orbits",
    "loads_along",
    "loads_in_time",
    "loads_over_patch",
    "loop",
    "patch_count",
    "pressure",
    "pressure_over_patch",
    "reaction_orbits",
    "reaction_space",
    "reactions_in_time",
    "refinement",
    "regions",
    "save",
    "sensitivity",
    "shakedown_share",
    "slip_along",
    "slip_orbits",
    "slip_over_load",
    "slip_over_patch",
    "slip_per_cycle",
    "slip_range",
    "slip_space",
    "welded_pressure_over_patch",
    "work_over_patch",
    "zones",
    "zones_at",
]
