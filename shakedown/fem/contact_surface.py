"""The faces of a solid body that make up its contact, by the numbers of the contact nodes."""

import numpy as np
from numpy.typing import NDArray

from shakedown.fem.body import ElasticBody, IntArray
from shakedown.joint.faces import faces_among, split_face


def contact_faces(body: ElasticBody, boundary: str, nodes: IntArray) -> NDArray[np.intp] | None:
    """Faces of a boundary that have all their corners among some nodes, (k, 4): −1 as the last of a triangle.

    None of a plane body. Faces with nodes on their sides are split.
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


def _around(body: ElasticBody, corners: IntArray) -> IntArray:
    """Corners of a face in order around it."""
    arms = body.positions(corners) - body.positions(corners).mean(axis=0)
    first, second = np.linalg.svd(arms)[2][:2]
    return corners[np.argsort(np.arctan2(arms @ second, arms @ first))]
