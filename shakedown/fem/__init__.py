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
- λ_1, the first collapse (a proof from every initial slip only where its ``guarantee``
  says so), falls to zero wherever slip and
  pressure are coupled (B ≠ 0): a finer mesh admits rougher locked-in slips, and
  one that is rough enough lifts a node off under the mean load alone. The number
  is right, but the question asks too much. Ask which initial slips are possible:
  λ_1(R) of :func:`shakedown.guarantee_curve` with R in proportion to the element
  size (a bounded slope of slip along the contact) keeps its share of λ_max, unless
  an end of the contact carries hardly any pressure.
- For elastically similar bodies B = 0, and λ_1 = λ_max on every mesh.
"""

import shakedown.fem.extra  # noqa: F401  says what to install where it is missing
from shakedown.fem.body import ElasticBody, Material, Support
from shakedown.fem.bolt import Bolt
from shakedown.fem.contact import contact_condensation, contact_problem, modal_load
from shakedown.fem.corner import WeldedCorner, welded_corner
from shakedown.fem.half_space import half_space_compliance, mean_half_space_compliance
from shakedown.fem.loads import BodyForce, Displacement, Force, Load, Pressure, Traction
from shakedown.fem.mesh import block_mesh, brick_mesh, read_mesh
from shakedown.fem.modes import ModalLoad

__all__ = [
    "BodyForce",
    "Bolt",
    "Displacement",
    "ElasticBody",
    "Force",
    "Load",
    "Material",
    "ModalLoad",
    "Pressure",
    "Support",
    "Traction",
    "WeldedCorner",
    "block_mesh",
    "brick_mesh",
    "contact_condensation",
    "contact_problem",
    "half_space_compliance",
    "mean_half_space_compliance",
    "modal_load",
    "read_mesh",
    "welded_corner",
]
