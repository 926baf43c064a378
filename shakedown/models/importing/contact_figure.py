"""A picture of what an import has read: the mesh, the contact nodes, their normals and tangents."""

from typing import TYPE_CHECKING, Any

import numpy as np

from shakedown.ground.argument_kinds import checked
from shakedown.ground.errors import UsageError
from shakedown.models.importing.import_model import Import
from shakedown.models.readers.mesh import CORNERS, FACES

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@checked
def contact_picture(made: Import, ax: "Axes | None" = None) -> "Axes":
    """Draw the contact nodes of an import with normals (and tangents), on the mesh where it is known.

    Parameters
    ----------
    made
        What :func:`shakedown.import_model` returns.
    ax
        Where to draw (with two tangents, axes in three dimensions); without it a new figure is made.

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

        projection = "3d" if contact.directions > 1 else None
        ax = Figure(figsize=(6.0, 4.6), layout="constrained").add_subplot(projection=projection)
    axes = [axis - 1 for axis in contact.axes]
    if ax.name != ("3d" if len(axes) == 3 else "rectilinear"):
        raise UsageError(f"picture: expected axes in {len(axes)} dimensions, found '{ax.name}' ones")
    plot: Any = ax
    flat = [nodes[: CORNERS[shape]] for shape, nodes in mesh.elements.values() if len(FACES[shape][0]) == 2]
    for ring in flat or [facet.corners for facet in mesh.boundary(set(contact.first.tolist()))]:
        plot.plot(*mesh.at([*ring, ring[0]]).T[axes], color="0.75", linewidth=0.5)
    place, frame = contact.coordinates, made.condensation.frame
    arrow = 0.7 * float(np.ptp(place, axis=0).max() or 1.0) / max(len(place) ** (1 / frame.directions) - 1, 1)
    vectors = (frame.normals, *frame.slip_axes.swapaxes(0, 1))
    labels = ("normal, into the first body", "first tangent", "second tangent")
    for along, label, colour in zip(vectors, labels, ("tab:red", "tab:blue", "tab:green"), strict=False):
        start = place[:, axes]
        lines = np.stack([start, start + arrow * along, np.full_like(start, np.nan)], axis=1)
        plot.plot(*lines.reshape(-1, len(axes)).T, color=colour, linewidth=0.8, label=label)
    plot.plot(*place.T[axes], "o", color="tab:red", markersize=3)
    behind = place[:, axes] - arrow * frame.normals
    for k in range(0, len(place), -(-len(place) // 20)):  # of more than 20 names some, evenly spread
        upright = len(axes) == 2 and abs(frame.normals[k, 1]) > abs(frame.normals[k, 0])
        turned = {"rotation": 90.0} if upright else {}
        plot.text(*behind[k], contact.names[k], ha="center", va="center", fontsize=6, **turned)
    ax.set_aspect("equal")
    ax.set(**dict(zip(("xlabel", "ylabel", "zlabel"), ("xyz"[a] for a in axes), strict=False)))
    ax.legend(loc="upper left", fontsize=7)
    return ax
