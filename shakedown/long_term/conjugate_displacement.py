"""How far each load moves: the displacement conjugate to it along a path, and the loops of the loads."""

import os
from typing import Any, NamedTuple

import numpy as np

from shakedown.files.atomic_write import check_table, write_csv
from shakedown.ground.constants import FloatArray
from shakedown.joint.arguments import checked
from shakedown.joint.constraints import loading
from shakedown.joint.problem import Problem
from shakedown.joint.units import LoadUnit, load_units, require_loads, units_in_time
from shakedown.motion.event_history import CurvedHistory, EventHistory, recorded_path

BOOLE = np.array([7, 32, 12, 32, 7]) / 90  # exact for curves of the fourth degree
CHORDS = np.array([1, 2, 2, 2, 1]) / 8


class LoadLoops(NamedTuple):
    """The loads along one period of a path, and the displacements conjugate to them.

    Attributes
    ----------
    cycle : (s,)
        Time [cycles]; the last row closes the period.
    load, displacement : (s, L)
        Each load and its displacement, in their units.
    areas : (L,)
        ∮ c dx of each load [force × length]: their sum is the dissipation in the period.
    units
        The units of each load (:class:`~shakedown.joint.units.LoadUnit`): forces and lengths where
        ``load_units`` says so, else units of ``load_history``, and work per unit.
    """

    cycle: FloatArray
    load: FloatArray
    displacement: FloatArray
    areas: FloatArray
    units: tuple[LoadUnit, ...]

    def save(self, path: str | os.PathLike[str], problem: Problem) -> None:
        """Write a table (.csv): time, load and displacement, of several loads one after the other, numbered.

        Raises
        ------
        UsageError
            If the file cannot be written or its name ends otherwise.
        """
        check_table(path)
        count = self.load.shape[1]
        names = problem.load_names or ()
        titles = names if len(names) == count else [str(k) for k in range(count)]
        columns: dict[str, list[Any]] = {
            "load_name": [title for title in titles for _ in self.cycle],
            "load_number": [k for k in range(count) for _ in self.cycle],
            "cycle": count * self.cycle.tolist(),
            "load": self.load.T.ravel().tolist(),
            "displacement": self.displacement.T.ravel().tolist(),
            "load_unit": [unit.load for unit in self.units for _ in self.cycle],
            "displacement_unit": [unit.moved(problem) for unit in self.units for _ in self.cycle],
        }
        write_csv(path, columns)


@checked
def conjugate_displacement(problem: Problem, history: Any) -> FloatArray:
    """The displacement conjugate to each load along a path, from the slips and the data of the welded joint.

    With R_j the welded reactions of a unit of load j, c_j(t) units of it acting, S_ij the displacement
    conjugate to load i under a unit of load j with all nodes welded, and u = (v, w) the state of the
    contact (Betti's theorem):

        x_i(t) = Σ_j S_ij c_j(t) − R_i · u(t),        ∮ Σ_i c_i dx_i = −∮ q · dv,

    so that the loops of all loads have together the area that friction dissipates (docs/damping.md). For a
    force it is the displacement that the force works along, for a prescribed displacement minus the holding
    force. An initial gap, and a part of the constant loading that no load explains, moves it by a constant.

    Parameters
    ----------
    problem
        The joint, with ``load_reactions``, ``load_history`` and ``load_compliance``.
    history
        The events of a path, or a result that holds some.

    Returns
    -------
    (points, L)
        One row per row of the path [work per unit of ``load_history``: where that is not 1 N, no length];
        NaN on the way to the first load step, where the loads are not known.

    Raises
    ------
    ProblemError
        If the problem does not know its loads, or their compliance.
    UsageError
        If nothing was recorded.

    Examples
    --------
    A node on a spring of stiffness 2, pushed past its friction limit 1 by a force of 3:

    >>> import shakedown
    >>> joint = Problem(
    ...     A=[[2.0]], B=[[0.0]], f=0.5, q_w=[[-3.0], [3.0]], p_w=[[2.0], [2.0]],
    ...     load_reactions=[[-1.0, 0.0]], load_history=[[3.0], [-3.0]], load_compliance=[[0.0]],
    ... )
    >>> state = shakedown.long_term_state(joint, 1.0)
    >>> conjugate_displacement(joint, state).ravel().round(6).tolist()
    [-1.0, -1.0, 1.0, 1.0, -1.0]
    """
    return _along(problem, recorded_path(history, "history"))[1]


def load_loops(problem: Problem, history: Any) -> LoadLoops:
    """The loops of the loads over the path of one period, in so many points that straight lines follow them.

    With fixed load steps that is the polygon of these. Raises as :func:`conjugate_displacement`.
    """
    path = recorded_path(history, "history")
    fine = path.refined()
    load, displacement = _along(problem, fine)
    known = np.flatnonzero(np.isfinite(displacement).all(axis=1))
    known = np.append(known, known[:1])  # the period closes even so
    load, displacement = load[known], displacement[known]
    areas = -(0.5 * (displacement[1:] + displacement[:-1]) * np.diff(load, axis=0)).sum(axis=0)
    if isinstance(path, CurvedHistory):
        areas -= _beside_straight_lines(problem, path)
    units = load_units(problem)
    size = np.array([unit.size for unit in units])
    return LoadLoops(fine.cycle[known], load * size, displacement / size, areas, units)


def _beside_straight_lines(problem: Problem, path: CurvedHistory) -> FloatArray:
    """∫ x dc over the steps of curves minus that along their chords: x is a polynomial, c linear in time."""
    row = np.flatnonzero(path.duration > 0)
    parts = [_along(problem, path.within(row, np.full(len(row), share))) for share in np.linspace(0, 1, 5)]
    change = parts[-1][0] - parts[0][0]
    x = [displacement for _, displacement in parts]
    exact = sum(weight * part for weight, part in zip(BOOLE, x, strict=True))
    straight = sum(weight * part for weight, part in zip(CHORDS, x, strict=True))
    return np.nansum(change * (exact - straight), axis=0)


def _along(problem: Problem, path: EventHistory) -> tuple[FloatArray, FloatArray]:
    unit, _ = require_loads(problem, compliance=True)
    assert problem.load_compliance is not None
    load = units_in_time(problem, _load_factor(problem, path), path.cycle)
    moved = problem.layout.joined(path.v, path.w)
    return load, load @ problem.load_compliance - moved @ unit.T


def _load_factor(problem: Problem, path: EventHistory) -> float:
    """The load factor of a path, from its welded reactions and those of the loop."""
    loop, later = loading(problem), path.cycle >= 0
    change = np.hstack([path.q_w - loop.q0, path.p_w - loop.p0])[later]
    corners = np.arange(problem.m + 1) / problem.m
    periodic = np.hstack([loop.q1, loop.p1])
    closed = np.vstack([periodic, periodic[:1]])
    at = np.stack([np.interp(path.cycle[later] % 1.0, corners, column) for column in closed.T], axis=1)
    size = float((at * at).sum())
    return float((at * change).sum()) / size if size else 1.0
