"""Pictures of a joint: loads, bounds, paths, zones. Each function draws one and returns its axes.

Every function takes ``ax``, the axes to draw on; without it a new figure is made. Labels carry
the units of the problem where they are known. The report is drawn by the same functions.

Reading order: ``style`` (axes, colours, units), ``loops`` (hysteresis, loading), ``contact_line``
(what happens along the contact), ``planes`` (slip space, reaction space), ``load_factors``
(guarantee, interaction, slip per cycle).
"""

from shakedown.plot.contact_line import friction_use, pressure, slip_along, zones
from shakedown.plot.load_factors import guarantee, interaction, slip_per_cycle
from shakedown.plot.loops import hysteresis, load_loop
from shakedown.plot.planes import reaction_space, slip_space

__all__ = [
    "friction_use",
    "guarantee",
    "hysteresis",
    "interaction",
    "load_loop",
    "pressure",
    "reaction_space",
    "slip_along",
    "slip_per_cycle",
    "slip_space",
    "zones",
]
