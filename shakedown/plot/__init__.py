"""Pictures of a joint: loads, bounds, paths, zones. Each function draws one and returns its axes.

Every function takes ``ax``, the axes to draw on; without it a new figure is made, which
``plot.save(axes, path)`` writes to a file. Labels carry the units of the problem where they are
known. The report is drawn by the same functions.

Reading order: ``backend`` (none), ``style`` (axes, colours, units), ``joint`` (nodes, loads, what limits it),
``loops`` (hysteresis, loading), ``contact_line`` (what happens along the contact), ``zone_map``
(where and when it sticks, slips, opens), ``planes`` (slip space, reaction space), ``load_factors``
(limits on one scale, guarantee, interaction, slip per cycle), ``regions`` (design diagrams), ``basins``
(maps of initial states), ``motion`` (one instant, and animations); with two tangential directions the contact
is an area: ``patch_places``, ``patch_colours``, ``patch_arrows``, ``patch_zones``, ``patch_orbits``;
``inline_svg`` (pictures inside a page).
"""

import shakedown.plot.backend  # noqa: F401  before matplotlib
from shakedown.plot.basins import basin, shakedown_share
from shakedown.plot.contact_line import dissipation_along, friction_use, pressure, slip_along, slip_range
from shakedown.plot.joint import contact, loads_along, loads_in_time, sensitivity
from shakedown.plot.load_factors import (
    guarantee,
    interaction,
    load_factor_scale,
    slip_over_load,
    slip_per_cycle,
)
from shakedown.plot.loops import hysteresis, load_loop, reactions_in_time
from shakedown.plot.motion import animate_reactions, animate_slip_space, reactions_at, slip_space_at
from shakedown.plot.patch_arrows import friction_use_at, loads_over_patch, slips_over_patch, tractions_at
from shakedown.plot.patch_colours import (
    pressure_over_patch,
    slip_over_patch,
    welded_pressure_over_patch,
    work_over_patch,
)
from shakedown.plot.patch_orbits import load_orbits, reaction_orbits, slip_orbits
from shakedown.plot.patch_zones import zones_at
from shakedown.plot.planes import reaction_space, slip_space
from shakedown.plot.regions import regions
from shakedown.plot.style import save
from shakedown.plot.zone_map import zones

__all__ = [
    "animate_reactions",
    "animate_slip_space",
    "basin",
    "contact",
    "dissipation_along",
    "friction_use",
    "friction_use_at",
    "guarantee",
    "hysteresis",
    "interaction",
    "load_factor_scale",
    "load_loop",
    "load_orbits",
    "loads_along",
    "loads_in_time",
    "loads_over_patch",
    "pressure",
    "pressure_over_patch",
    "reaction_orbits",
    "reaction_space",
    "reactions_at",
    "reactions_in_time",
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
    "slip_space_at",
    "slips_over_patch",
    "tractions_at",
    "welded_pressure_over_patch",
    "work_over_patch",
    "zones",
    "zones_at",
]
