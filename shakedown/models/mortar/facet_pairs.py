"""Which facets of two surfaces may lie on each other."""

import numpy as np
from scipy.spatial import KDTree

from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.models.mortar.surface_mesh import ContactSurface, IntArray

OPPOSED = -0.5  # cosine between the normals of facets that look at each other


def facet_pairs(slave: ContactSurface, master: ContactSurface, reach: float) -> tuple[IntArray, IntArray]:
    """(facet of the slave, facet of the master) whose circles come nearer than the reach."""
    tree = KDTree(master.middles)
    near = tree.query_ball_point(
        slave.middles, (1.0 + NEGLIGIBLE) * (slave.radii + master.radii.max() + reach)
    )
    count = np.array([len(found) for found in near])
    one = np.repeat(np.arange(len(near)), count)
    other = np.concatenate([np.array(found, dtype=np.intp) for found in near])
    apart = np.linalg.norm(slave.middles[one] - master.middles[other], axis=1)
    kept = apart <= (1.0 + NEGLIGIBLE) * (slave.radii[one] + master.radii[other] + reach)
    kept &= (slave.normals[one] * master.normals[other]).sum(axis=1) < OPPOSED
    return one[kept], other[kept]
