"""Pictures of a joint: loads, bounds, paths, zones. Each function draws one and returns its axes.

Every function takes ``ax``, the axes to draw on; without it a new figure is made, which
``plot.save(axes, path)`` writes to a file. Labels carry the units of the problem where they are
known. The report is drawn by the same functions.

From a result to a picture: ``paths`` reads a result (its path, an instant, sums of each node along it),
a module below computes what is drawn, ``style`` holds what all pictures share (axes, colours, legends).

- the joint itself: ``joint`` (nodes, loads, what limits it)
- along a contact in the plane, numbers and zones, limits on one scale, slips versus the load: ``along``
- over a patch in space, colours, arrows and marks: ``over_patch``, on the places of ``patch_places``
- loops of nodes and of loads, reactions in time, damping: ``loops``
- slip space, reaction space: ``planes``
- design diagrams, maps of initial states: ``designs``
- inside a page: ``inline_svg``, ``patch_places`` (the view in three dimensions)
"""

import os
import sys
from contextlib import suppress

import lazy_loader

if "matplotlib" not in sys.modules and "MPLBACKEND" in os.environ:
    # pictures need no window, so a name that matplotlib does not know must not stop its import
    wanted = os.environ.pop("MPLBACKEND")
    import matplotlib

    os.environ["MPLBACKEND"] = wanted
    with suppress(ValueError):
        matplotlib.rcParams["backend"] = wanted

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
