"""The path of a joint under its loading, cycle by cycle: exactly from event to event, or at fixed steps.

Reading order: ``contact_law`` (Coulomb's law and its violation, the judge of every path),
``event_history``, ``cycle_record`` (what is kept), ``violation`` (the law along a path),
``initial_state`` (where a motion begins), ``method`` (what every way to follow it has in common),
``fixed_steps`` (Gauss–Seidel), ``implicit_path`` (steps in space), ``viscous_jump`` (chapter VI),
``integrator`` (the exact path, jumps included), ``reduced_scene`` (only the nodes that matter), ``evolve``
(the public function). Below them ``kernels/``, the compiled loops, and ``implicit/``, load steps solved
at once; beside them ``directed/``, which follows joints in space from event to event.
"""
