"""Pictures of a joint: loads, bounds, paths, zones. Each function draws one and returns its axes.

Every function takes ``ax``, the axes to draw on; without it a new figure is made, which
``plot.save(axes, path)`` writes to a file. Labels carry the units of the problem where they are
known. The report is drawn by the same functions.

From a result to a picture: ``drawn_path`` reads a result (its path, an instant, sums of each node along it),
a module below computes what is drawn, ``style`` holds what all pictures share (axes, colours, legends).

- the joint itself: ``joint`` (nodes, loads, what limits it), ``loops`` (the loading of a node)
- a number per node, lines along a contact, colours over a patch: ``over_contact``
- an arrow or a mark per node of a patch, at an instant: ``patch_arrows`` (on the places of
  ``patch_places``, where ``flat_patch`` unrolls them)
- loops of a node (hysteresis, orbits), reactions in time: ``loops``
- the loop of a load, damping and stiffness over its amplitude: ``over_amplitude``
- where and when a contact sticks, slips, opens: ``zone_map``
- slip space, reaction space: ``planes``
- limits on one scale, slips over the load or the cycle: ``load_factors``; design diagrams: ``regions``
- maps of initial states: ``basins``
- numbers against the mesh: ``refinement``
- inside a page: ``inline_svg``, ``patch_data`` (the view in three dimensions); without a window: ``backend``
"""

import shakedown.plot.backend  # noqa: F401  before matplotlib
from shakedown.plot.basins import basin, shakedown_share
from shakedown.plot.joint import contact, loads_along, loads_in_time, sensitivity
from shakedown.plot.load_factors import (
    load_factor_scale,
    slip_over_load,
    slip_per_cycle,
)
from shakedown.plot.loops import (
    hysteresis,
    load_loop,
    load_orbits,
    reaction_orbits,
    reactions_in_time,
    slip_orbits,
)
from shakedown.plot.over_amplitude import damping_curve, loop
from shakedown.plot.over_contact import (
    dissipation_along,
    friction_use,
    pressure,
    pressure_over_patch,
    slip_along,
    slip_over_patch,
    slip_range,
    welded_pressure_over_patch,
    work_over_patch,
)
from shakedown.plot.patch_arrows import (
    friction_use_at,
    loads_over_patch,
    slips_over_patch,
    tractions_at,
    zones_at,
)
from shakedown.plot.patch_places import patch_count
from shakedown.plot.planes import reaction_space, slip_space
from shakedown.plot.refinement import refinement
from shakedown.plot.regions import regions
from shakedown.plot.style import save
from shakedown.plot.zone_map import zones

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
    "slips_over_patch",
    "tractions_at",
    "welded_pressure_over_patch",
    "work_over_patch",
    "zones",
    "zones_at",
]
