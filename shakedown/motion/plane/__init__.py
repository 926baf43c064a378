"""Compiled loops of the evolution in the plane, on arrays and small named states.

Reading order: ``active_set`` (systems of the moving nodes; rates at an event, by pivoting), ``moving_state``
(the state between events, and its record; the data of a run), ``event_loop`` (load steps in which nothing
happens; from event to event; rates by enumeration, from Python); ``plane_events`` (all of it, as an evolution
follows it, which alone knows a ``Problem``).

How a path is computed: a problem at one load factor gives a stiffness κ and a *course*, the welded
reactions at the ends of the load steps. A *run* binds the course to the *moving state* (slips and
gaps, contact states, the inverse of the equations of the moving nodes) and to a
*record*. ``event_loop.follow_straight`` carries the run along: load steps without an event are passed by one
solution and one comparison, the others from event to event, where ``active_set`` finds the rates.
It returns when the course has been passed as often as asked, when the record is full, after a
stated amount of work (so that an interrupt is seen), or where the motion stops; Python then empties
the record, searches for rates, carries the state across a jump, or says why it ended, and enters
again. What one cycle did (slip, dissipation, signature of the contact states) is counted in the
moving state and becomes a ``CycleRecord``; the rows of the record become an ``EventHistory``; the
long-term state is decided from both. No step of a cycle needs Python, so that many cycles, or many
states, can be followed in one call.
"""
