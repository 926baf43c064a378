"""A picture of what an import has read: the mesh, the contact nodes, their normals and tangents."""

from typing import TYPE_CHECKING, Any

import numpy as np

from shakedown.ground.argument_kinds import checked
from shakedown.ground.errors import UsageError
from shakedown.models.importing.import_model import Import
from shakedown.models.readers.mesh import CORNERS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_ARROW = 0.7  # length of an arrow, by the mean distance of the nodes
_HALF = 1.8  # half the width of a letter of a name [points]
_MOST_NAMED = 20  # nodes with names; of more some, evenly spread


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
    if contact.directions > 1:
        _in_space(made, ax)
        return ax
    a, b = contact.axes[0] - 1, contact.axes[1] - 1
    for shape, nodes in mesh.elements.values():
        if shape in ("triangle", "quadrilateral"):
            ring = mesh.at([*nodes[: CORNERS[shape]], nodes[0]])
            ax.plot(ring[:, a], ring[:, b], color="0.8", linewidth=0.5, zorder=1)
    ax.plot(mesh.coordinates[:, a], mesh.coordinates[:, b], ".", color="0.6", markersize=2, zorder=2)
    place = contact.coordinates[:, [a, b]]
    normals = contact.unit_normals[:, [a, b]]
    ax.quiver(*place.T, *normals.T, angles="xy", color="tab:red", width=0.004)
    ax.plot(place[:, 0], place[:, 1], "o", color="tab:red", markersize=3, zorder=3)
    paper = {"facecolor": "white", "edgecolor": "none", "pad": 0.5, "alpha": 0.8}
    style: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 6, "bbox": paper}
    named = list(zip(contact.names, place.tolist(), normals, strict=True))
    for name, at, normal in named[:: -(-len(named) // _MOST_NAMED)]:  # behind the node, off its arrow
        away, turned = -(6.0 + _HALF * len(name)) * normal, 90.0 * (abs(normal[1]) > abs(normal[0]))
        ax.annotate(name, at, away, textcoords="offset points", rotation=turned, **style)
    ax.set_aspect("equal")
    ax.set(xlabel="xyz"[a], ylabel="xyz"[b])
    ax.set_title("contact nodes and normals into the first body", fontsize=9)
    return ax


def _in_space(made: Import, ax: Any) -> None:
    """Normals and both tangents at the contact nodes, on the faces that the nodes span."""
    contact, frame = made.contact, made.condensation.frame
    assert contact.coordinates is not None
    assert made.mesh is not None
    if getattr(ax, "name", "") != "3d":
        raise UsageError("picture: expected axes in three dimensions (projection='3d'), found plane ones")
    place = contact.coordinates
    for facet in made.mesh.boundary(set(contact.first.tolist())):
        ax.plot(*made.mesh.at([*facet.corners, facet.corners[0]]).T, color="0.75", linewidth=0.5)
    length = _ARROW * float(np.ptp(place, axis=0).max() or 1.0) / max(np.sqrt(len(place)) - 1, 1)
    first, second = frame.slip_axes.transpose(1, 0, 2)
    for vectors, colour, label in (
        (frame.normals, "tab:red", "normal, into the first body"),
        (first, "tab:blue", "first tangent"),
        (second, "tab:green", "second tangent"),
    ):
        style = {"color": colour, "label": label, "linewidth": 0.8, "arrow_length_ratio": 0.2}
        ax.quiver(*place.T, *(length * vectors).T, **style)
    low, high = place.min(axis=0) - length, place.max(axis=0) + length
    limits = dict(zip(("xlim", "ylim", "zlim"), zip(low, high, strict=True), strict=True))
    ax.set(**limits, xlabel="x", ylabel="y", zlabel="z")
    ax.set_box_aspect(high - low, zoom=0.9)
    ax.locator_params(nbins=4)
    ax.legend(loc="upper left", fontsize=7)
    ax.set_title("contact nodes, normals and tangents", fontsize=9)
