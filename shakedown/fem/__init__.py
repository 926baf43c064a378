"""Elastic bodies in contact from finite-element meshes, plane or solid (extra ``fem``).

A few lines from a mesh to a problem: an :class:`ElasticBody` with supports and
loads on named boundaries, then :func:`contact_problem`.

How fine a mesh? What converges, and what does not, is in docs/mesh.md; :func:`shakedown.refine` tells it
of a joint:

- λ_max converges where friction exceeds the shear ratio of the welded tractions at every corner of the
  contact. Below it, and at edges without a corner (Hertz), it falls by a power of the element size: it is
  then a statement about slip on that scale. The same with slips averaged over a length
  (:func:`shakedown.averaged`) converges.
- What is proved from every state, and λ_1, fall with the logarithm of the element size at sharp corners where
  slip and pressure are coupled (B ≠ 0): a finer mesh admits rougher locked-in slips, and a rough one lifts a
  node off under the mean load alone. Without a sharp edge (a press fit) they converge with order 2, for
  similar bodies (B = 0) they are λ_max on every mesh.
- Friction work and slips at a fixed load converge; the largest pressure, work and wear of a node at a
  corner do not.
"""

import lazy_loader

from shakedown.ground.errors import not_installed as _not_installed

try:  # what the extra brings
    import skfem as skfem
except ImportError as error:
    raise ImportError(_not_installed("shakedown.fem", "scikit-fem", "fem")) from error

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
