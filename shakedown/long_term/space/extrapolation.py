"""Where a sequence of states goes that a smooth map makes one after the other."""

from dataclasses import dataclass

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import ROUND_OFF

INDEPENDENT = 10 * ROUND_OFF  # of the largest: smaller singular values of the changes are round-off


@dataclass(frozen=True)
class Recurrence:
    """A sequence x_0, …, x_k that goes on as Δ_{j+1} = Σ c_i Δ_{j−r+i}, Δ_j = x_{j+1} − x_j.

    Attributes
    ----------
    last : (N,)
        x_k.
    changes : (r, N)
        The last changes, the newest last.
    weights : (r,)
        c.
    """

    last: FloatArray
    changes: FloatArray
    weights: FloatArray

    def ahead(self, count: int) -> tuple[FloatArray, FloatArray]:
        """The state so many steps ahead, and the change that follows it."""
        r = len(self.weights)
        # One step: the shares that the last changes have in those to come, and in the sum of these.
        one = np.zeros((r + 1, r + 1))
        one[: r - 1, 1:r] = np.eye(r - 1)
        one[r - 1 :, :r] = self.weights
        one[r, r] = 1.0
        many = np.linalg.matrix_power(one, count)[:, :r]
        return self.last + many[r] @ self.changes, (self.weights @ many[:r]) @ self.changes


def recurrence_of(states: FloatArray, root: FloatArray) -> Recurrence:
    """The course of states x_0, …, x_k, (k + 1, N), whose last change is the best sum of those before it.

    Where the map is affine on the span of the changes, and the sequence has gone through all of it, it goes
    on exactly so. What the map leaves alone (linear functions of the state that no cycle changes) is kept.

    Parameters
    ----------
    states
        x_0, …, x_k.
    root : (M, N)
        A change Δ counts for ‖root Δ‖.

    Examples
    --------
    >>> states = np.array([[1.0, 0.0], [0.5, 1.0], [0.25, 1.5], [0.125, 1.75]])
    >>> state, change = recurrence_of(states, np.eye(2)).ahead(1)
    >>> state.round(9), change.round(9)
    (array([0.0625, 1.875 ]), array([-0.03125,  0.0625 ]))
    """
    changes = np.diff(states, axis=0)
    seen = changes @ root.T
    seen = seen / (float(np.abs(seen).max()) or 1.0)
    weights = np.linalg.lstsq(seen[:-1].T, seen[-1], rcond=INDEPENDENT)[0]
    return Recurrence(states[-1], changes[1:], weights)
