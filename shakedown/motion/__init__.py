"""The path of a joint under its loading, cycle by cycle: exactly from event to event, or at fixed steps.

Reading order: ``contact_law`` (Coulomb's law and its violation, the judge of every path),
``event_history``, ``cycle_record`` (what is kept), ``violation`` (the law along a path), ``viscous_jump``
(chapter VI), ``method`` (the start of a motion, and what all methods share), ``fixed_steps``
(load steps, by Gauss–Seidel or each solved at once), ``integrator`` (from event to event, jumps included),
``plane_events`` (how it is followed in the plane), ``evolve`` (the public function). Below them ``plane/``,
the compiled loops of the plane, and ``implicit/``, load steps solved at once; beside them ``space/``, the
loops that follow joints in space from event to event.
"""
