"""Whether a drift goes on for ever: rigid slip in every period, which meets no resistance."""

from typing import NamedTuple

import numpy as np

from shakedown.ground.constants import NEGLIGIBLE, SIX_DIGITS, THREE_DIGITS, FloatArray
from shakedown.joint.law import Layout
from shakedown.long_term.space.decay import Period
from shakedown.long_term.space.measure import Measure


class Drift(NamedTuple):
    """What is known of the drift of the last period.

    Attributes
    ----------
    layout, stiffness, measure
        Of the joint: where slips stand, κ (N, N) of closed nodes, and what counts of a change.
    none : (n,)
        Slip of each node that counts as none [length].
    now
        What the period did.
    left : (r,)
        Of its drift, where the change falls to nothing [length].
    before : (N,)
        Change of the state in the period before [length].
    known
        Up to how much these are not known [length].
    """

    layout: Layout
    stiffness: FloatArray
    measure: Measure
    none: FloatArray
    now: Period
    left: FloatArray
    before: FloatArray
    known: float

    def of_all(self) -> bool:
        """Whether all that changes is a rigid slip, by more than the error, no less than before.

        And most of its drift is expected to stay.
        """
        last = self.now.change
        size = float(np.abs(last).max())
        same = np.abs(last - self.before).max() <= SIX_DIGITS * size + self.known
        stays = 2.0 * np.linalg.norm(self.left) >= np.linalg.norm(self.now.drift)
        return bool(stays and size > self.known and same and self.measure.is_rigid(last))

    def of_a_node(self) -> bool:
        """Whether the rigid slip of a node goes on, by a share of its own slip that counts.

        Node by node, as a slow change of others, in which no rigid slip is, may hide it.
        """
        kappa, rigid, ways = self.stiffness, self.measure.rigid, self.layout.ways
        drift = rigid @ self.now.drift
        size = ways(drift)
        counts = size > np.maximum(np.maximum(SIX_DIGITS * self.now.slip, self.none), self.known)
        stays = 2.0 * ways(rigid @ self.left) >= size
        same = ways(drift - rigid @ (rigid.T @ self.before)) <= SIX_DIGITS * size + self.known
        terms = ways(np.abs(kappa) @ np.abs(self.now.change))
        free = ways(kappa @ self.now.change) <= THREE_DIGITS * terms
        return bool((counts & stays & same & free).any())


def is_held(layout: Layout, rigid: FloatArray, slip: FloatArray, none: FloatArray) -> bool:
    """Whether the nodes that stick, or all but stick, leave no room for a rigid slip.

    Parameters
    ----------
    layout
        Of the state.
    rigid : (N, r)
        Orthonormal rigid slips, at least one.
    slip, none : (n,)
        How far each node slips in a period, and what counts as none [length].
    """
    least = SIX_DIGITS * float(slip.max())
    stuck = np.flatnonzero(slip <= np.minimum(least, none))
    room = np.linalg.svd(rigid[layout.slips_of(stuck)], compute_uv=False)
    held = len(room) == rigid.shape[1] and room[-1] > NEGLIGIBLE
    return bool(held and slip[stuck].max() <= least * room[-1])
