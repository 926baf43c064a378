"""A picture of what an import has read: the mesh, the contact nodes and their normals."""

from typing import TYPE_CHECKING, Any

import numpy as np

from shakedown.ground.argument_kinds import checked
from shakedown.ground.errors import UsageError
from shakedown.importing.import_model import Import
from shakedown.readers.mesh import CORNERS

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@checked
def contact_picture(made: Import, ax: "Axes | None" = None) -> "Axes":
    """Draw the contact nodes of an import with their normals, on the mesh where it is known.

    Parameters
    ----------
    made
        What :func:`shakedown.import_model` returns.
    ax
        Where to draw; without it a new figure is made.

    Raises
    ------
    UsageError
        If no coordinates are known (``[model]`` in the configuration).
    """
    contact, mesh = made.contact, made.mesh
    if contact.coordinates is None or mesh is None:
        raise UsageError("picture: expected coordinates ([model] with a deck or a list of nodes), found none")
    if ax is None:
        from matplotlib.figure import Figure

        ax = Figure(figsize=(6.0, 4.2), layout="constrained").add_subplot()
    a, b = contact.axes[0] - 1, contact.axes[1] - 1
    for shape, nodes in mesh.elements.values():
        if CORNERS[shape] <= 4 and "hedron" not in shape:
            ring = mesh.at([*nodes[: CORNERS[shape]], nodes[0]])
            ax.plot(ring[:, a], ring[:, b], color="0.8", linewidth=0.5, zorder=1)
    ax.plot(mesh.coordinates[:, a], mesh.coordinates[:, b], ".", color="0.6", markersize=2, zorder=2)
    place = contact.coordinates[:, [a, b]]
    normals = contact.normals / np.hypot(*contact.normals.T)[:, None]
    ax.quiver(
        place[:, 0], place[:, 1], normals[:, 0], normals[:, 1], angles="xy", color="tab:red", width=0.004
    )
    ax.plot(place[:, 0], place[:, 1], "o", color="tab:red", markersize=3, zorder=3)
    style: dict[str, Any] = {"ha": "center", "va": "top", "fontsize": 6, "rotation": 90}
    for name, (x, y) in zip(contact.names, place, strict=True):
        ax.annotate(name, (x, y), xytext=(0, -4), textcoords="offset points", **style)
    ax.set_aspect("equal")
    ax.set_xlabel("xyz"[a])
    ax.set_ylabel("xyz"[b])
    ax.set_title("contact nodes and normals into the first body", fontsize=9)
    return ax
