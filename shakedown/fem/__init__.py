"""Elastic bodies in contact from finite-element meshes (extra ``fem``).

A few lines from a mesh to a problem: an :class:`ElasticBody` with supports and
loads on named boundaries, then :func:`contact_problem`.
"""

from shakedown.fem.blocks import cantilevered_block, receding_block
from shakedown.fem.body import ElasticBody, Material, Support
from shakedown.fem.contact import contact_condensation, contact_problem
from shakedown.fem.loads import BodyForce, Displacement, Load, Pressure, Traction
from shakedown.fem.mesh import block_mesh, read_mesh

__all__ = [
    "BodyForce",
    "Displacement",
    "ElasticBody",
    "Load",
    "Material",
    "Pressure",
    "Support",
    "Traction",
    "block_mesh",
    "cantilevered_block",
    "contact_condensation",
    "contact_problem",
    "read_mesh",
    "receding_block",
]
