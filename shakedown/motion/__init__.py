"""The path of a joint under its loading, cycle by cycle: exactly from event to event, or at fixed steps.

Reading order: ``checked_law`` (Coulomb's law and its violation, the judge of every path),
``event_history``, ``cycle_record`` (what is kept), ``violation`` (the law along a path), ``viscous_jump``
(chapter VI), ``method`` (where a motion begins, what every way to follow it has in common), ``fixed_steps``
(load steps, by Gauss–Seidel or each solved at once), ``evolution`` (from event to event, jumps included),
``plane_events`` (how it is followed in the plane), ``evolve`` (the public function). Below them ``plane/``,
the compiled loops of the plane, and ``space/``, those of two tangential directions: from event to event, and
load steps solved at once.
"""
