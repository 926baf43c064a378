"""The states of the nodes at instants of a period, as a series of files for ParaView."""

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from shakedown.files.vtk_points import write_points_series
from shakedown.ground.argument_kinds import check_count
from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.visible_text import with_unit
from shakedown.joint.arguments import checked
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.long_term.node_results import settled_of
from shakedown.long_term.node_table import (
    axes_of,
    coordinates_of,
    faces_of,
    fixed_numbers,
    labels_of,
    normals_of,
    points_of,
)
from shakedown.long_term.state import LongTermState
from shakedown.motion.event_history import EventHistory

MOST_INSTANTS = 500


@checked
def save_node_instants(
    simulation_or_state: object, path: str | os.PathLike[str], instants: int = 24
) -> tuple[Path, ...]:
    """Write the nodes at instants of a period: NAME_000.vtp, …, and NAME.pvd, which ParaView opens as one.

    Time is the phase, from 0 to 1 over the recorded period. At every point: ``cycle``, when that is, in
    cycles of the loading; names, ``normal`` and faces as :meth:`NodeResults.save` has them; ``status`` 0
    stick, 1 slip, 2 open; slip ``v`` and tangential reaction ``q``, vectors of three components along the
    axes of the model where the joint knows its tangents, else in x and y of the node; gap ``w`` and normal
    reaction ``p``. Units stand in brackets after the names.

    Parameters
    ----------
    simulation_or_state
        A long-term state, a simulation, or a run of a verification, from event to event.
    path
        NAME.vtp or NAME.vtu.
    instants
        How many, evenly over the recorded period, both ends among them (500 at most).

    Returns
    -------
    paths
        The files, that of all times first; all of them are written, or none.

    Raises
    ------
    UsageError
        If there is no such state or no steady period, the name has another ending, or a file cannot be
        written.

    Examples
    --------
    >>> import shakedown
    >>> state = shakedown.long_term_state(shakedown.example("four-node-3d"), 1.4)
    >>> [path.name for path in save_node_instants(state, "nodes.vtp", 2)]  # doctest: +SKIP
    ['nodes.pvd', 'nodes_000.vtp', 'nodes_001.vtp']
    """
    settled = settled_of(simulation_or_state, "save_node_instants")
    check_count("instants", instants, MOST_INSTANTS)
    history, problem = settled.history, settled.problem
    if not isinstance(settled, LongTermState) or not settled.period or len(history) < 2:
        raise UsageError("save_node_instants: expected a steady period from event to event, found none")
    times = np.linspace(max(float(history.cycle[0]), 0.0), float(history.cycle[-1]), instants)
    at = history.at(times)
    fixed = fixed_numbers(labels_of(problem), normals_of(problem))
    numbers = [fixed | _numbers(problem, at, row) for row in range(instants)]
    points, phase = points_of(coordinates_of(problem)), np.linspace(0.0, 1.0, instants)
    return write_points_series(path, points, phase.tolist(), numbers, faces_of(problem))


def _numbers(problem: Problem, at: EventHistory, row: int) -> dict[str, NDArray[np.generic]]:
    """The data written for one instant."""
    force, length = units_of(problem)
    return {
        "cycle": np.full(problem.n, at.cycle[row]),
        "status": np.abs(at.state[row]),
        with_unit("v", length): _in_space(problem, at.v[row]),
        with_unit("w", length): at.w[row],
        with_unit("q", force): _in_space(problem, at.q[row]),
        with_unit("p", force): at.p[row],
    }


def _in_space(problem: Problem, parts: FloatArray) -> FloatArray:
    """Slips or tangential reactions of the nodes, flat, as vectors (n, 3) of the model."""
    axes = axes_of(problem)
    if axes is None:
        axes = np.tile(np.eye(3)[: problem.directions], (problem.n, 1, 1))
    return np.asarray(np.einsum("nd,ndk->nk", problem.layout.by_node(parts), axes))
