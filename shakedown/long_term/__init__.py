"""What becomes of a joint: shakedown, cyclic slip, ratchetting, separation, or undecided.

Reading order: ``plane/`` (the search in the plane, compiled), ``cycle_map`` (the limit of one cycle as
an affine map, where it drifts), ``limit_search`` (the search as Python drives it, and what is left to
Python), ``passage`` (where a motion began, and what the transient leaves of its start, the slip that random
loads leave), ``known_bounds`` (limits that no verdict contradicts), ``energy_proof`` (verdicts with proof),
``state`` (the answer), ``space/`` (the search for motions that are known cycle by cycle only; verdicts of
both held against what is proved), ``find_state`` (for one initial state), ``part_by_part`` (of a
joint in uncoupled parts), ``many_states`` (for many); ``recorded_verdict`` (what the last
cycles at fixed steps show), ``simulation`` (from event to event or at fixed load steps, and the path as a
file).

Where a verdict is said, "for ever" included: in the plane by ``plane.period_verdict.judge_period``, of one
period that has come back to where it began; whether a drift lasts is decided before it, by
``limit_search.LimitSearch._give_limit`` and ``plane.leaps.begin_leaps``. In space by ``ReturnSearch`` in
``space.return_search``: ``_verdict_at_rest``, ``_verdict_for_ever``, ``_verdict_of_period``, ``_drifts_on``.
At fixed steps by ``recorded_verdict``. Whatever a search from event to event has found,
``space.proved_verdict`` has the last word, in the plane, too: proofs of rest, and of slip in every cycle.

What a period does to each node: ``node_points`` (where it is, for ParaView), ``node_table`` (the answer, and
its files), ``node_results`` (how it follows from the path), ``diameters`` (of paths in a plane),
``node_instants`` (the state at instants, as files),
``slip_criterion`` (whether its slip stays small). What it does to each load: ``conjugate_displacement``.
"""
