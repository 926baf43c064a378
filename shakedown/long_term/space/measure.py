"""The size of a change of the state: the energy that it stores."""

from dataclasses import dataclass
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import BLOCK, EPS, NEGLIGIBLE, THREE_DIGITS, FloatArray
from shakedown.joint.arguments import once_per_problem
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import free_stiffness, rigid_slips

STATE_ROUND_OFF = 64.0 * EPS  # relative to a state: smaller changes are none


@dataclass(frozen=True)
class Measure:
    """The energy norm of changes of a state, in which rigid slips do not count.

    Attributes
    ----------
    root : (M, N)
        By columns: RᵀR = κ in units of a power of two: a change d has the size ‖R d‖ [√(force × length)].
    rigid : (N, r)
        Slips that change no reaction, orthonormal: cycles are the same wherever these stand.
    slips : (n,)
        √ of the largest stiffness of each node, whose slip counts for what it would store.
    largest
        ‖R‖, of all entries.
    """

    root: FloatArray
    rigid: FloatArray
    slips: FloatArray
    largest: float

    def size(self, change: FloatArray) -> float:
        """The size of a change of the state."""
        seen = self.seen(change)
        return sqrt(seen.dot(seen))  # as np.linalg.norm

    def seen(self, changes: FloatArray) -> FloatArray:
        """R d of changes (…, N), (…, k)."""
        return product(self.root, changes)

    def at_most(self, change: FloatArray) -> float:
        """An upper bound of ``terms``, without the product."""
        return 2.0 * self.largest * float(np.linalg.norm(change))

    def terms(self, change: FloatArray) -> float:
        """‖|R| |d|‖, to which the round-off of a size is relative."""
        return float(np.linalg.norm(np.abs(self.root) @ np.abs(change)))

    def is_rigid(self, change: FloatArray) -> bool:
        """Whether what a change of one slip does to the reactions is undone by what others do."""
        return self.size(change) <= THREE_DIGITS * self.terms(change)

    def without_rigid(self, changes: FloatArray) -> FloatArray:
        """Changes (…, N) without their rigid slip."""
        return np.asarray(changes - changes @ self.rigid @ self.rigid.T)

    def deviation(self, change: FloatArray, expected: FloatArray, size: float) -> float:
        """The deviation of a change from another one of this size, relative to it; rigid slips included."""
        off = self.size(change - expected) / size
        if not self.rigid.shape[1]:
            return off
        return max(off, float(np.linalg.norm(change - expected) / np.linalg.norm(expected)))


def product(root: FloatArray, changes: FloatArray) -> FloatArray:
    """R d of changes (…, N), (…, k): with a large R from the places that change, mostly few."""
    places: NDArray[np.intp] | slice = slice(None)
    if root.size > BLOCK and changes.any():
        moved = np.flatnonzero(changes.reshape(-1, changes.shape[-1]).any(axis=0))
        few = 4 * len(moved) < changes.shape[-1]
        places = moved if few else slice(moved[0], moved[-1] + 1)  # gaps, the last places, mostly rest
    return np.asarray(changes[..., places] @ root.T[places])


@once_per_problem
def measure_of(problem: Problem) -> Measure:
    """The measure for changes of the states of a joint."""
    stiffness, layout = free_stiffness(problem), problem.layout
    # In a unit of its own, as roots of odd powers of two are rounded.
    stiffness = np.ldexp(stiffness, -np.frexp(np.diag(stiffness).max())[1])
    if problem.C is None:  # gaps stay zero
        stiffness[layout.gaps] = stiffness[:, layout.gaps] = 0.0
    diagonal = np.diag(stiffness)
    own = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    values, vectors = np.linalg.eigh(0.5 * (stiffness + stiffness.T) / own / own[:, None])
    kept = values > NEGLIGIBLE * values[-1]
    motions = rigid_slips(problem).motions
    rigid = np.zeros((layout.size, motions.shape[1]))
    rigid[layout.slips] = np.linalg.qr(motions)[0] if motions.shape[1] else motions
    stiffest = diagonal[layout.slips].reshape(problem.n, -1).max(axis=1)
    root = np.asfortranarray(np.sqrt(values[kept])[:, None] * vectors[:, kept].T * own)
    return Measure(root, rigid, np.sqrt(stiffest), float(np.linalg.norm(root)))
