"""The state that a joint settles into under periodic loading, exactly (long-term state)."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import MANY, check_arguments, check_count, checked, require_plane
from shakedown.joint.problem import Problem
from shakedown.long_term.limit_search import LONGEST_PERIOD, LimitSearch
from shakedown.long_term.state import LongTermState
from shakedown.motion.evolve import expanded_history, require_closed
from shakedown.motion.reduced_scene import Scene, reduced_scene


@checked
def long_term_state(
    problem: Problem,
    load_factor: float,
    initial_slip: ArrayLike | None = None,
    *,
    open_nodes: Iterable[int] = (),
    max_cycles: int = 1000,
    longest_period: int = LONGEST_PERIOD,
    reduce: bool = False,
    tolerances: Tolerances = DEFAULT,
) -> LongTermState:
    """What becomes of a joint under its loading loop, decided exactly and not by waiting.

    As soon as the cycles of a period (1, 2, … ``longest_period`` cycles) pass
    through the same sequence of contact states as those before them, the map
    from the start of a period to the next is affine there, v ↦ J v + c. Its
    limit follows from the geometric series. It is accepted when the states
    2, 4, 8, … periods ahead still pass through that sequence, and when one more
    exact period from the limit returns to it.

    Parameters
    ----------
    problem
        The joint and its loading.
    load_factor
        λ ≥ 0, multiplies the periodic part of the loading.
    initial_slip : (n,), optional
        Slip at the start [length]; zero by default. Transient load steps, where the
        problem has them, come before the first period.
    open_nodes
        Nodes that are open at the start, as for :func:`evolve`.
    max_cycles
        Give up after so many cycles, with the outcome "undecided".
    longest_period
        Longest period looked for, in cycles.
    reduce
        Follow only the nodes that can move (:func:`reduced_scene`).
    tolerances
        What counts as zero, as reached and as periodic (:class:`Tolerances`).

    Raises
    ------
    UsageError
        If an argument is out of range.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("three-node")
    >>> state = long_term_state(joint, 2.6, joint.initial_slip[0])
    >>> state.outcome.value, state.slip_per_cycle.round(6)
    ('cyclic-slip', array([3.854489, 0.      , 0.      ]))
    """
    require_plane("long-term state", problem)
    check_arguments(load_factor, max_cycles, problem)
    check_count("longest_period", longest_period, MANY)
    opened = tuple(open_nodes)
    if reduce:
        require_closed(opened)
        scene = reduced_scene(problem, load_factor, initial_slip)
        moving = scene.initial_slip[scene.moving]
        search = LimitSearch(scene.problem, load_factor, moving, tolerances, longest_period)
        small = search.run(max_cycles)
        if small.period and not small.jumps_per_cycle:
            return _expanded(problem, small, scene)
    search = LimitSearch(problem, load_factor, initial_slip, tolerances, longest_period, open_nodes=opened)
    return search.run(max_cycles)


def _expanded(problem: Problem, small: LongTermState, scene: Scene) -> LongTermState:
    """The long-term state of a reduced problem in terms of all nodes."""
    passage = None if small.passage is None else replace(small.passage, scene=scene)
    return replace(
        small,
        problem=problem,
        initial_slip=scene.initial_slip,
        final_slip=scene.spread(small.final_slip, scene.initial_slip),
        drift=scene.spread(small.drift, 0.0),
        slip_per_cycle=scene.spread(small.slip_per_cycle, 0.0),
        work_per_cycle=scene.spread(small.work_per_cycle, 0.0),
        open_nodes=tuple(int(j) for j in np.flatnonzero(scene.moving)[list(small.open_nodes)]),
        opened=scene.spread(small.opened, False),
        history=expanded_history(problem, small.load_factor, scene, small.history),
        scene=scene,
        passage=passage,
    )
