"""Where a motion begins: chosen slips with all nodes closed, or with some of them open."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from shakedown.ground.contact_status import BACKWARD_SLIP, OPEN
from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked_initial_slip
from shakedown.joint.contact_zone import contact_zone
from shakedown.joint.loading import first_load, ramp_start
from shakedown.joint.problem import Problem
from shakedown.motion.contact_law import scales
from shakedown.motion.cycle_record import State


class Beginning(NamedTuple):
    """The state at the very beginning, and the welded reactions there.

    Attributes
    ----------
    state
        Slips, gaps and contact states.
    load : (2n,)
        Welded reactions (q_w, p_w) from which the load rises to its first step [force].
    """

    state: State
    load: FloatArray


def beginning(
    problem: Problem,
    load_factor: float,
    initial_slip: ArrayLike | None = None,
    open_nodes: Iterable[int] = (),
    tolerances: Tolerances = DEFAULT,
) -> Beginning:
    """The state in which a motion begins, in equilibrium with the first load step where nodes are open.

    Parameters
    ----------
    problem, load_factor
        The joint and λ.
    initial_slip : (n,), optional
        Slip [length]; zero by default. Entries of open nodes are ignored: their
        displacements follow from equilibrium, q = p = 0.
    open_nodes
        The nodes that are open; all others are closed.
    tolerances
        ``feasibility`` says how far an open node may overlap by round-off.

    Raises
    ------
    UsageError
        If an argument is out of range, or an open node would overlap.
    ProblemError
        If nodes are open and the problem has no C.

    Examples
    --------
    >>> import shakedown
    >>> block = shakedown.example("receding-block")
    >>> upper = shakedown.upper_bound(block, open_nodes="auto")
    >>> start = beginning(block, 0.5 * upper.load_factor, upper.slip, upper.open_nodes)
    >>> bool((start.state.u[33:] >= 0).all()), bool(start.state.u[33] > 0)
    (True, True)
    """
    slip, layout = checked_initial_slip(problem, initial_slip), problem.layout
    zone = contact_zone(problem, open_nodes, tolerances=tolerances)
    first = first_load(problem, load_factor)
    contact = np.where(problem.f == 0.0, BACKWARD_SLIP, 0)
    nodes = np.array(zone.open_nodes, dtype=np.intp)
    if not nodes.size:
        state = State(layout.joined(slip, np.zeros(problem.n)), contact)
        return Beginning(state, ramp_start(problem, first, state.u))
    u = zone.displacements(slip[layout.slips_of(zone.closed_nodes)], *layout.split(first[None]))[0]
    gaps = u[layout.gaps_of(nodes)]
    if gaps.min() < -tolerances.feasibility * max(scales(problem, load_factor).length, np.abs(u).max()):
        raise UsageError(
            "open nodes: expected gaps >= 0 under the first load, found that "
            f"node {nodes[gaps.argmin()]} would overlap by {-gaps.min():.6g}"
        )
    u[layout.gaps_of(nodes)] = np.maximum(gaps, 0.0)
    contact[nodes] = OPEN
    load = ramp_start(problem, first, u)
    load[layout.of_nodes(nodes)] = first[layout.of_nodes(nodes)]  # in equilibrium all the way
    return Beginning(State(u, contact), load)
