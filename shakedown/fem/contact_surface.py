"""The faces of a body that make up its contact: for pictures, and to couple them with others."""

import numpy as np
from numpy.typing import NDArray

from shakedown.fem.body import ElasticBody, IntArray
from shakedown.joint.places import faces_among, split_face
from shakedown.models.condensation.surface_mesh import ContactSurface


def contact_faces(body: ElasticBody, boundary: str, nodes: IntArray) -> NDArray[np.intp] | None:
    """The faces of a boundary whose corners are all among ``nodes``, (k, 4); a triangle ends with −1.

    A plane body has none (None). Faces with nodes on their sides are split at these.
    """
    if body.dimension == 2:
        return None
    found: list[tuple[int, ...]] = []
    for facet in body.facets(boundary):
        every = np.unique(body.dofs[body.basis.get_dofs(np.array([facet])).flatten(), 0])
        corners = _around(body, body.mesh.facets[:, facet])
        others = every[~np.isin(every, corners)]
        found += split_face(
            corners.tolist(), others.tolist(), body.positions(np.concatenate([corners, others]))
        )
    return faces_among(np.array(found), nodes.tolist())


def meshed_surface(body: ElasticBody, boundary: str, shift: int = 0) -> ContactSurface:
    """Nodes and facets of a boundary; labels are the numbers of the nodes plus ``shift``."""
    mesh, facets, inside = body.mesh, [], []
    for facet in body.facets(boundary):
        corners = np.asarray(mesh.facets[:, facet])
        if body.dimension == 3:
            corners = _around(body, corners)
        facets.append([*corners.tolist(), *(_between(body, int(facet), corners) if body.order == 2 else ())])
        inside.append(mesh.p[:, mesh.t[:, mesh.f2t[0, facet]]].mean(axis=1))
    labels = np.unique(np.concatenate([np.array(nodes) for nodes in facets]))
    shifted = [[node + shift for node in nodes] for nodes in facets]
    return ContactSurface(labels + shift, body.positions(labels), shifted, np.array(inside))


def _between(body: ElasticBody, facet: int, corners: IntArray) -> list[int]:
    """Nodes on the sides of a second-order facet, in order around it, then the one in its middle, if any."""
    every = np.unique(body.dofs[body.basis.get_dofs(np.array([facet])).flatten(), 0])
    others = every[~np.isin(every, corners)]
    if body.dimension == 2:
        return [int(node) for node in others]
    at = body.positions(corners)
    middles = np.vstack([0.5 * (at + np.roll(at, -1, axis=0)), at.mean(axis=0)])
    apart = np.linalg.norm(body.positions(others)[None] - middles[:, None], axis=2)
    return [int(others[k]) for k in apart[: len(others)].argmin(axis=1)]


def _around(body: ElasticBody, corners: IntArray) -> IntArray:
    """Corners of a face in order around it."""
    arms = body.positions(corners) - body.positions(corners).mean(axis=0)
    first, second = np.linalg.svd(arms)[2][:2]
    return corners[np.argsort(np.arctan2(arms @ second, arms @ first))]
