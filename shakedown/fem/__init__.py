"""Elastic bodies in contact from finite-element meshes, plane or solid (extra ``fem``).

A few lines from a mesh to a problem: an :class:`ElasticBody` with supports and
loads on named boundaries, then :func:`contact_problem`.

How fine a mesh? Three things happen to the bounds as it is refined
(``python -m benchmarks.refinement`` measures them):

- λ_max, the largest load factor for which a safe initial slip exists, converges
  where friction exceeds the shear ratio of the welded ends of the contact
  (:func:`welded_corner`). Below that ratio the ends slip at any load in the
  limit, and λ_max falls by a power of the element size: it is then a statement
  about slip on that scale.
- λ_1, up to which *every* initial slip is safe, falls to zero wherever slip and
  pressure are coupled (B ≠ 0): a finer mesh admits rougher locked-in slips, and
  one that is rough enough lifts a node off under the mean load alone. The number
  is right, but the question asks too much. Ask which initial slips are possible:
  λ_1(R) of :func:`shakedown.guarantee_curve` with R in proportion to the element
  size (a bounded slope of slip along the contact) keeps its share of λ_max, unless
  an end of the contact carries hardly any pressure.
- For elastically similar bodies B = 0, and λ_1 = λ_max on every mesh.
"""

import shakedown.fem.extra  # noqa: F401  says what to install where it is missing
from shakedown.fem.blocks import cantilevered_block, receding_block, shipped_blocks
from shakedown.fem.body import ElasticBody, Material, Support
from shakedown.fem.bolt import Bolt
from shakedown.fem.classical import Hertz, cylinder_on_flat, hertz, press_fit, press_fit_pressure
from shakedown.fem.contact import contact_condensation, contact_problem
from shakedown.fem.corner import WeldedCorner, welded_corner
from shakedown.fem.dovetail import dovetail
from shakedown.fem.half_space import half_space_compliance, mean_half_space_compliance
from shakedown.fem.loads import BodyForce, Displacement, Force, Load, Pressure, Traction
from shakedown.fem.mesh import block_mesh, brick_mesh, read_mesh
from shakedown.fem.solids.blade_root import blade_root
from shakedown.fem.solids.bolted_flange import bolted_flange
from shakedown.fem.solids.lap_joint import lap_joint
from shakedown.fem.sphere import (
    SphereContact,
    disc_patches,
    rolling_limit,
    rolling_sphere,
    sphere_contact,
    sphere_on_flat,
)

__all__ = [
    "BodyForce",
    "Bolt",
    "Displacement",
    "ElasticBody",
    "Force",
    "Hertz",
    "Load",
    "Material",
    "Pressure",
    "SphereContact",
    "Support",
    "Traction",
    "WeldedCorner",
    "blade_root",
    "block_mesh",
    "bolted_flange",
    "brick_mesh",
    "cantilevered_block",
    "contact_condensation",
    "contact_problem",
    "cylinder_on_flat",
    "disc_patches",
    "dovetail",
    "half_space_compliance",
    "hertz",
    "lap_joint",
    "mean_half_space_compliance",
    "press_fit",
    "press_fit_pressure",
    "read_mesh",
    "receding_block",
    "rolling_limit",
    "rolling_sphere",
    "shipped_blocks",
    "sphere_contact",
    "sphere_on_flat",
    "welded_corner",
]
