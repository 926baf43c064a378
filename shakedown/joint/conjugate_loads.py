"""The unit loads of a joint: how many units of each act, at a load factor and in time."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from shakedown.ground.argument_kinds import checked
from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.joint.arguments import require_problem
from shakedown.joint.derived import once_per_problem
from shakedown.joint.loading import loading
from shakedown.joint.problem import NamedLoad, Problem
from shakedown.joint.units import FORCES, LENGTHS, Units, units_of

NO_LOADS: dict[str, Any] = dict.fromkeys(
    ("load_reactions", "load_history", "load_compliance", "load_frequency")
)


class LoadUnit(NamedTuple):
    """What one unit of ``load_history`` is of a load, and the units of that and of its displacement.

    Attributes
    ----------
    size
        How much of the load it is: times it histories are loads, over it their displacements are conjugate to
        these. 1 where the problem does not say, and of a load that has the shape of a mode.
    load, displacement, stiffness
        The units of load, displacement, and load over displacement; of a force those of force, length and
        force per length of the problem. Empty where they are not known.
    """

    size: float = 1.0
    load: str = ""
    displacement: str = ""
    stiffness: str = ""

    def moved(self, problem: Problem) -> str:
        """The unit of the displacement, or that it is work per unit of the load, whatever that is."""
        return self.displacement or f"{units_of(problem).work or 'work'} per unit of load"


@checked
def without_loads(problem: Problem) -> Problem:
    """The joint without the unit reactions of its loads, so that its welded reactions may be anything.

    Examples
    --------
    >>> joint = Problem(A=[[2.0]], B=[[0.0]], f=0.5, q_w=[[1.0], [-1.0]], p_w=[[3.0], [3.0]],
    ...                 load_reactions=[[1.0, 0.0]], load_history=[[1.0], [-1.0]])
    >>> without_loads(joint).load_history is None
    True
    """
    require_problem(problem)
    return replace(problem, **NO_LOADS)


def require_loads(problem: Problem, *, compliance: bool = False) -> tuple[FloatArray, FloatArray]:
    """``load_reactions`` and ``load_history``; ``ProblemError`` where there are none, or no compliance."""
    require_problem(problem)
    if problem.load_reactions is None or problem.load_history is None:
        raise ProblemError(
            "key 'load_reactions': needed for what a load does, found none (fem, condense, import write it)"
        )
    if compliance and problem.load_compliance is None:
        raise ProblemError(
            "key 'load_compliance': needed for the displacement of a load, found none (a load that was run "
            "elsewhere comes without it)"
        )
    return problem.load_reactions, problem.load_history


@once_per_problem
def constant_units(problem: Problem) -> FloatArray:
    """Units of each load in the constant part r⁰ of the loading, (L,): those that a load factor leaves alone.

    The mean of the histories where that is what r⁰ says; else the least change of it that does. What no
    loads explain (an initial gap) is constant, and moves displacements by a constant alone.

    Examples
    --------
    >>> joint = Problem(A=[[2.0]], B=[[0.0]], f=0.5, q_w=[[1.0], [0.0]], p_w=[[3.0], [3.0]],
    ...                 load_reactions=[[1.0, 0.0]], load_history=[[1.0], [0.0]])
    >>> constant_units(joint)
    array([0.5])
    """
    unit, history = require_loads(problem)
    loop, mean = loading(problem), history.mean(axis=0)
    first = np.concatenate([problem.q_w[0], problem.p_w[0]]) - history[0] @ unit
    missing = np.concatenate([loop.q0, loop.p0]) - first - mean @ unit
    noise = NEGLIGIBLE * max(np.abs(problem.q_w).max(), np.abs(problem.p_w).max())
    if np.abs(missing).max() <= noise:
        return np.asarray(mean)
    lengths = np.linalg.norm(unit, axis=1)
    lengths[lengths == 0] = 1.0
    change, *_ = np.linalg.lstsq((unit / lengths[:, None]).T, missing, rcond=None)
    return np.asarray(mean + change / lengths)


def units_at(problem: Problem, load_factor: float) -> FloatArray:
    """Units of each load at the load steps at a load factor, (m, L)."""
    constant, history = constant_units(problem), require_loads(problem)[1]
    return constant + load_factor * (history - constant)


def scaled_units(problem: Problem, *, mean: float = 1.0, amplitude: float = 1.0) -> dict[str, Any]:
    """The histories of a joint whose constant or periodic loading is scaled; empty where it has none."""
    if problem.load_history is None:
        return {}
    constant = constant_units(problem)
    return {"load_history": mean * constant + amplitude * (problem.load_history - constant)}


def units_in_time(problem: Problem, load_factor: float, cycle: FloatArray) -> FloatArray:
    """Units of each load at times in cycles, (s, L); NaN before the first load step of the first period.

    Load step k of m is at the time k/m of every cycle.
    """
    steps = units_at(problem, load_factor)
    closed, corners = np.vstack([steps, steps[:1]]), np.arange(problem.m + 1) / problem.m
    found = np.stack([np.interp(cycle % 1.0, corners, column) for column in closed.T], axis=1)
    return np.where((cycle < -NEGLIGIBLE)[:, None], np.nan, found)


def load_units(problem: Problem) -> tuple[LoadUnit, ...]:
    """The units of each load, by ``load_units``, ``load_amplitude`` and ``load_mean``.

    Examples
    --------
    >>> joint = Problem(A=[[2.0]], B=[[0.0]], f=0.5, q_w=[[1.0], [-1.0]], p_w=[[3.0], [3.0]], units="N, mm",
    ...                 load_reactions=[[1.0, 0.0]], load_history=[[1.0], [-1.0]],
    ...                 load_names=["push"], load_mean=[0.0], load_amplitude=[3.0], load_units=["kN"])
    >>> load_units(joint)
    (LoadUnit(size=3000.0, load='N', displacement='mm', stiffness='N/mm'),)
    """
    history, units = require_loads(problem)[1], units_of(problem)
    count, constant, modes = history.shape[1], constant_units(problem), problem.load_frequency
    if len(problem.loads) != count or not units.work:
        return (LoadUnit(),) * count
    varying = np.abs(history - constant).max(axis=0)
    return tuple(
        LoadUnit() if modes is not None and np.isfinite(modes[j]) else _unit(load, units, *pair)
        for j, (load, *pair) in enumerate(
            zip(problem.loads, constant.tolist(), varying.tolist(), strict=True)
        )
    )


def _unit(load: NamedLoad, units: Units, constant: float, varying: float) -> LoadUnit:
    """The unit of a load, so many of which are constant and vary."""
    size = load.mean / constant if constant and load.mean else load.amplitude / varying if varying else 0.0
    if not (load.unit and size):
        return LoadUnit()
    for known, own, other in ((FORCES, units.force, units.length), (LENGTHS, units.length, units.force)):
        if load.unit in known:
            return LoadUnit(size * known[load.unit] / known[own], own, other, f"{own}/{other}")
    moved = f"{units.work}/({load.unit})"
    return LoadUnit(size, load.unit, moved, f"{load.unit}/({moved})")
