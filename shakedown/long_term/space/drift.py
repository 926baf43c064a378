"""Whether a drift goes on for ever: rigid slip in every period, which meets no resistance."""

import numpy as np

from shakedown.ground.constants import NEGLIGIBLE, SIX_DIGITS, THREE_DIGITS, FloatArray
from shakedown.joint.law import Layout
from shakedown.joint.rigid_slips import free_stiffness
from shakedown.long_term.space.followed_cycles import FollowedCycles
from shakedown.long_term.space.measure import STATE_ROUND_OFF


def drift_goes_on(
    cycles: FollowedCycles, p: int, left: FloatArray, none: FloatArray, error: float
) -> tuple[bool, bool]:
    """Whether the rigid slip of a node goes on, and whether all that changes does so and is a rigid slip.

    Of a node: by a share of its own slip that counts, as a slow change of others, in which no rigid slip is,
    may hide it. Of all: by more than the error, no less than before. Either is expected to stay for the most
    part.

    Parameters
    ----------
    cycles, p
        What was followed; the period is the last p cycles.
    left : (r,)
        Of the drift, where the change falls to nothing [length].
    none : (n,)
        Slip of each node that counts as none [length].
    error
        Of the slips in a cycle [length].
    """
    layout, measure, now = cycles.layout, cycles.measure, cycles.last(p)
    before = cycles.states[-1 - p].u - cycles.states[-1 - 2 * p].u
    known = p * error + STATE_ROUND_OFF * float(np.abs(now.state).max())
    last = float(np.abs(now.change).max())
    same = np.abs(now.change - before).max() <= SIX_DIGITS * last + known
    stays = 2.0 * np.linalg.norm(left) >= np.linalg.norm(now.drift)
    of_all = bool(stays and last > known and same and measure.is_rigid(now.change))
    kappa, rigid, ways = free_stiffness(cycles.motion.problem), measure.rigid, layout.ways
    drift = rigid @ now.drift
    size = ways(drift)
    counts = size > np.maximum(np.maximum(SIX_DIGITS * now.slip, none), known)
    same_of_nodes = ways(drift - rigid @ (rigid.T @ before)) <= SIX_DIGITS * size + known
    free = ways(kappa @ now.change) <= THREE_DIGITS * ways(np.abs(kappa) @ np.abs(now.change))
    stay = 2.0 * ways(rigid @ left) >= size
    return bool((counts & stay & same_of_nodes & free).any()), of_all


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
