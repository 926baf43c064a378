"""The elastic energy of a difference of slips as a norm, and the dual norm of what slip changes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.rigid_slips import RigidSlips
from shakedown.programs.scaling import power_of_two

EIGENVALUE_ROUND_OFF = 8 * np.finfo(float).eps  # round-off of an eigenvalue per node, relative to the largest


@dataclass(frozen=True)
class EnergyMetric:
    """‖e‖_A = sqrt(eᵀ A e), the energy norm of a difference of slips; ½ ‖e‖²_A is its elastic energy.

    Directions of slip that cost no energy (rigid motions of a body that is held by the
    contact alone) have no length: the norm is that of the slips relative to the
    pinned nodes. A is divided by ``unit``² before anything is computed, so that a change of
    units by a power of two changes no other bit.

    Attributes
    ----------
    unit
        Square root of a power of two [√stiffness].
    root : (r, n)
        ‖e‖_A = unit · ‖root e‖, r the rank of A.
    inverse : (n, r)
        root · inverse = I: the slips of unit vectors, zero at pinned nodes [1].
    free : (n, n − r)
        Directions of slip without energy, the rigid slips first.
    stiffness : (n,)
        Diagonal of A [force/length].
    stiffest
        Largest energy, doubled, of a slip of one node alone by a unit length [force/length].
    sizes : (n,)
        Size of a row of A against a slip of unit energy, to which what should vanish is compared.
    pinned
        The nodes at which rigid slips are pinned.
    """

    unit: float
    root: FloatArray
    inverse: FloatArray
    free: FloatArray
    stiffness: FloatArray
    stiffest: float
    sizes: FloatArray
    pinned: tuple[int, ...] = ()

    def norm(self, difference: ArrayLike) -> FloatArray:
        """‖e‖_A of differences of slip (…, n) [√(force · length)]."""
        return np.asarray(self.unit * np.linalg.norm(np.asarray(difference) @ self.root.T, axis=-1))

    def relative_dual_norms(
        self, rows: FloatArray, sizes: FloatArray, tolerances: Tolerances, *, rigid: bool = True
    ) -> FloatArray:
        """Largest change of rows · e over all ‖root e‖ ≤ 1; inf where a free direction changes a row.

        Parameters
        ----------
        rows : (k, n)
            Linear functions of the slip [force/length].
        sizes : (k,)
            What the change along a free direction is compared to [force/length].
        rigid
            Whether rigid slips may change the rows: those of friction they do not, by their definition.
        """
        norms = np.linalg.norm(rows @ self.inverse, axis=1)
        free = self.free if rigid else self.free[:, len(self.pinned) :]
        leak = np.abs(rows @ free).max(axis=1, initial=0.0)
        return np.where(leak <= tolerances.zero_mode * np.maximum(sizes, norms), norms, np.inf)


def energy_metric(
    A: FloatArray, B: FloatArray, rigid: RigidSlips | None = None, *, tolerances: Tolerances = DEFAULT
) -> EnergyMetric:
    """The energy norm of a tangential stiffness A (n, n), with the coupling B (n, n) next to it.

    An eigenvalue of A that is zero to the tolerance counts as zero where slip in
    its direction changes no pressure either, as it must where κ ⪰ 0. Rigid slips, where they are
    known, are free by their definition, and the rest is the energy of the slips relative to the pinned nodes.

    Examples
    --------
    >>> metric = energy_metric(np.array([[4.0, 0.0], [0.0, 9.0]]), np.zeros((2, 2)))
    >>> metric.norm([[1.0, 0.0], [1.0, 1.0]]) ** 2
    array([ 4., 13.])
    """
    stiffness = np.diagonal(A).copy()
    scale = power_of_two(float(stiffness.max()))
    lengths = np.array([1.0 / power_of_two(float(np.sqrt(a))) for a in stiffness / scale])
    known = RigidSlips(np.zeros((len(A), 0)), ()) if rigid is None else rigid
    kept = np.setdiff1d(np.arange(len(A)), known.pinned)
    values, vectors = np.linalg.eigh((A / scale * lengths * lengths[:, None])[np.ix_(kept, kept)])
    directions = np.zeros((len(A), len(kept)))
    directions[kept] = lengths[kept, None] * vectors
    sizes = scale / lengths
    largest = float(values.max(initial=0.0))
    pressed = sizes.reshape(len(B), -1).max(axis=1)  # the largest of a node's directions
    leak = (np.abs(B @ directions) / pressed[:, None]).max(axis=0)
    soft = values <= tolerances.zero_mode * largest
    free = soft & ((leak <= tolerances.zero_mode) | (values <= len(A) * EIGENVALUE_ROUND_OFF * largest))
    lasting = np.sqrt(values[~free])
    root = np.zeros((len(lasting), len(A)))
    root[:, kept] = (vectors[:, ~free] * lasting).T / lengths[kept]
    root[:, list(known.pinned)] = -root @ known.motions
    return EnergyMetric(
        unit=float(np.sqrt(scale)),
        root=root,
        inverse=directions[:, ~free] / lasting,
        free=np.hstack([known.motions, directions[:, free]]),
        stiffness=stiffness,
        stiffest=_stiffest(A, len(A) // len(B)),
        sizes=sizes,
        pinned=known.pinned,
    )


def _stiffest(A: FloatArray, d: int) -> float:
    """The largest eigenvalue of the stiffness of one node alone, in d directions."""
    if d == 1:
        return float(np.diagonal(A).max())
    nodes = np.arange(len(A) // d)
    blocks = A.reshape(len(nodes), d, len(nodes), d)[nodes, :, nodes, :]
    return float(np.linalg.eigvalsh(blocks).max())
