"""What becomes of a joint: shakedown, cyclic slip, ratchetting, separation, or undecided.

Reading order: ``plane/`` (the search in the plane, compiled), ``motion_start`` (where a motion began, what
the transient leaves of its start, the slip that random loads leave, limits that no verdict contradicts),
``state`` (the answer, and what proves it), ``limit_search`` (the search in the plane as Python drives it),
``space/`` (the search for motions that are known cycle by cycle only), ``proved_outcome`` (verdicts of both
compared with what is proved), ``find_state`` (for one initial state, for many, and part by part of an
uncoupled joint);
``simulation`` (from event to event or at fixed load steps, and the path as a file).

Where a verdict is reached, "for ever" included: in the plane by ``plane.phase_loop.judge_period``, of one
period that has come back to where it began; whether a drift lasts is decided before it, by
``plane.period_map.find_limit``, which finds the limit that it has, or where that finds none by
``limit_search.LimitSearch._give_limit``. In space by ``SteadySearch``
in ``space.steady_search``: ``_at_rest``, ``_repeats``, ``_approaches``, ``_slips_for_ever``. At fixed steps
by ``simulation.recorded_verdict``. Whatever a search from event to event has found, in the plane, too,
``proved_outcome.overruled_by_proofs`` has the last word: proofs of rest, and of slip in every cycle.

What a period does to each node: ``node_results`` (the answer and its files, how it follows from the path; the
state at instants, as files). Whether its slip stays small is asked by ``simulation``.
What it does to each load: ``conjugate_displacement``; to a body that creeps: ``rigid_drift``; where creep is
excluded: ``creep_proofs``.
"""
