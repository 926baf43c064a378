"""Motion with two tangential directions: the state determines the directions of slip, equations the speeds.

Between events (a node reaches its cone, comes to rest, opens or closes; a load step begins) the
slips obey a smooth differential equation, which compiled loops integrate to a given accuracy; the method
and what its error estimate means stand in docs/space.md.

Reading order: ``space_run`` (the joint, its state, its record, the data of rates and steps, as compiled code
takes them), ``speeds`` (open nodes eliminated; rates of the nodes that slip, with LAPACK),
``smooth_step`` (Dormand and Prince's pair; Radau's method near the apex), ``rate_choice`` (which nodes move
after an event), ``event_search`` (the first event within a step), ``curved_loop`` (one load step, from event
to event); ``space_events`` (all of it, as an evolution follows it; across instants without rates). Nothing of
it is compiled before a joint with two directions moves.
"""
