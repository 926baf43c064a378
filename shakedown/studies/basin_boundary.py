"""Boundaries between basins, by bisection between neighbours of a grid."""

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.argument_kinds import check_count
from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Outcome
from shakedown.joint.arguments import checked
from shakedown.long_term.many_states import long_term_states
from shakedown.studies.basin_map import InitialStateMap
from shakedown.studies.limit_cycles import STABLE, same_slip
from shakedown.studies.samplers import Sampler


@checked
def basin_boundary(found: InitialStateMap, *, halvings: int = 30) -> FloatArray:
    """Initial slips on the boundaries between basins, in the plane of a grid (thesis §7.2.1).

    Basins are told apart by outcome and period, and where a limit cycle is stable, by
    the limit cycle; with two tangential directions where several states end on it. Between
    any two neighbours of the grid that belong to different basins the way is halved again
    and again, all of them at once.

    Parameters
    ----------
    found
        A map made with the sampler ``"grid"``.
    halvings
        How often: each one halves the distance between neighbours.

    Returns
    -------
    (k, dn)
        One slip for each such pair of neighbours [length].

    Raises
    ------
    UsageError
        If the map is no grid.

    Examples
    --------
    >>> import shakedown
    >>> found = shakedown.initial_state_map(shakedown.example("two-node"), 0.7, states=16, sampler="grid")
    >>> shakedown.basin_boundary(found)[0].round(5).tolist()[0]
    0.65407
    """
    check_count("halvings", halvings)
    if found.sampling.sampler != Sampler.GRID:
        raise UsageError(f"basin boundary: expected a map on a grid, found sampler {found.sampling.sampler}")
    side, rest = found.sampling.side, found.sampled
    basins = _basins(found, found.outcome[rest], found.period[rest], found.final_slip[rest]).reshape(
        side, side
    )
    number = np.arange(side**2).reshape(side, side)
    here, there = [], []
    for one, other in (
        ((slice(None), slice(-1)), (slice(None), slice(1, None))),
        ((slice(-1),), (slice(1, None),)),
    ):
        differ = basins[one] != basins[other]
        here.append(number[one][differ])
        there.append(number[other][differ])
    start, end = np.concatenate(here), np.concatenate(there)
    low, high = (found.initial_slip[rest][which] for which in (start, end))
    kind = basins.ravel()[start]
    for _ in range(halvings if len(start) else 0):
        middle = 0.5 * (low + high)
        states = long_term_states(
            found.problem,
            found.load_factor,
            middle,
            max_cycles=found.search.max_cycles,
            longest_period=found.search.longest_period,
            tolerances=found.search.tolerances,
        )
        same = _basins(found, states.outcome, states.period, states.final_slip) == kind
        low, high = np.where(same[:, None], middle, low), np.where(same[:, None], high, middle)
    return np.asarray(0.5 * (low + high))


def _basins(
    found: InitialStateMap, outcome: NDArray[np.str_], period: NDArray[np.int64], final_slip: FloatArray
) -> NDArray[np.int64]:
    """A number for the basin of each state."""
    basins = period * len(Outcome) + np.array(
        [list(Outcome).index(Outcome(word)) for word in outcome], dtype=np.int64
    )
    near = same_slip(found.problem, found.load_factor, found.search.tolerances)
    for number, cycle in enumerate(found.limit_cycles, 1):
        gathers = not found.tells_stability and cycle.coincide and cycle.count > 1
        if cycle.stability != STABLE and not gathers:
            continue
        for place in cycle.final_slip:
            basins[np.abs(final_slip - place).max(axis=1) <= near] = -number
    return np.asarray(basins)
