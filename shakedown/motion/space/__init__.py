"""Motion with two tangential directions: the state determines the directions of slip, equations the speeds.

Between events (a node reaches its cone, comes to rest, opens or closes; a load step begins) the
slips obey a smooth differential equation, which compiled loops integrate to a given accuracy; the method
and what its error estimate means stand in docs/space.md.

Reading order: ``moving_state`` (the joint, its state and its record as compiled code takes them),
``step_state`` (the data of rates and steps), ``space_run`` (all of these
together), ``exchange`` (open nodes eliminated),
``speeds`` (rates of the nodes that slip), ``explicit_step`` (Dormand and Prince's pair), ``turning_step``
(Radau's method near the apex), ``rate_choice`` (which nodes move after an event), ``event_search`` (the
first event within a step), ``curved_loop`` (one load step, from event to event); ``curved_history`` (the
path), ``directed_jump`` (across instants without rates),
``space_events`` (all of it, as an evolution follows it). Nothing of it is compiled before a joint with
two directions moves.

One load step at once, at fixed steps and where there are no rates: ``swept_stiffness`` (κ with its open nodes
eliminated, and the state in it), ``sweeps`` (the law at one node, its neighbours held; Gauss–Seidel over the
nodes), ``dense_solver`` (linear equations), ``newton_rounds`` (Newton on the slipping nodes), ``load_steps``
(both together, the law re-checked, step after step), ``implicit_step`` (what Python calls).
"""
