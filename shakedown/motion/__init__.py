"""The exact path of a joint under its loading: from event to event, jumps included.

Reading order: ``contact_law`` (Coulomb's law and its violation, the judge of every path),
``event_history``, ``cycle_record`` (what is kept), ``initial_state`` (where it begins),
``viscous_jump`` (chapter VI), ``integrator`` (cycle by cycle), ``reduced_scene`` (only the nodes
that matter), ``evolve`` (the public function). Below them ``kernels/``, the compiled loops.
"""
