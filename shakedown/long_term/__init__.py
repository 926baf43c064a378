"""What becomes of a joint: shakedown, cyclic slip, ratchetting, separation, or undecided.

Reading order: ``plane/`` (the search in the plane, compiled), ``cycle_map`` (one cycle as an affine map,
and its limit where it drifts), ``limit_search`` (the search as Python drives it, and what is left to
Python), ``passage`` (where a motion began, and what the transient leaves of its start, the slip that random
loads leave), ``known_bounds`` (limits that no verdict contradicts), ``energy_proof`` (verdicts with proof),
``state`` (the answer), ``space/`` (the search for motions that are known cycle by cycle only; verdicts of
both held against what is proved), ``find_state`` (for one initial state), ``many_states`` (for many);
``recorded_walk`` (cycles of a run that can be resumed, and what the last ones show), ``simulation`` (from
event to event or at fixed load steps, and the path as a file).

What a period does to each node: ``node_points`` (where it is, for ParaView), ``node_table`` (the answer, and
its files), ``node_results`` (how it follows from the path), ``diameters`` (of paths in a plane),
``node_instants`` (the state at instants, as files),
``slip_criterion`` (whether its slip stays small). What it does to each load: ``conjugate_displacement``.
"""
