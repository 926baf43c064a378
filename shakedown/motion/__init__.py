"""The path of a joint under its loading, cycle by cycle: exactly from event to event, or at fixed steps.

Reading order: ``checked_law`` (Coulomb's law and its violation, the judge of every path), ``course`` (the
load path that compiled loops follow, and how these end), ``event_history`` (the path, and the law along it),
``viscous_jump`` (chapter VI, how long the implicit steps of a jump are, rigid motions that nothing ends),
``method`` (where a motion begins, what is kept of a cycle, what every way to follow
one has in common), ``fixed_steps`` (load steps by sweeps over the nodes), ``evolution`` (from event to
event, jumps included; the public function). Below them ``plane/`` and ``space/``, the compiled loops of one
and of two tangential directions.

Between two events, call by call:

1. ``evolution.Evolution`` calls ``follow`` of its method, again after every full record and every jump:
   ``plane.plane_events.PlaneEvents`` or ``space.space_events.SpaceEvents``, with the same functions.
2. In the plane ``plane.event_loop.follow_straight``: rates by ``solve_rates`` at the event, then straight to
   the next one (``next_event``, ``advance``); load steps without one by ``event_loop.quiet_steps``.
3. In space ``space.curved_loop.follow_curve``: which nodes move by ``rate_choice``, then steps along the
   curve (``smooth_step.explicit_step``; ``turning_step`` near an apex), each cut at its first event by
   ``event_search``.

At fixed steps there are no events: ``fixed_steps.FixedSteps`` calls ``load_steps``, which solves
one load step after the other, with one tangential direction or two.
"""
