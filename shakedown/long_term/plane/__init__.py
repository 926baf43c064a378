"""The search for long-term states, one after the other, in compiled code; it knows arrays, no ``Problem``.

It goes one cycle at a time:

    WALK     cycles one by one from the start, until the state is that of some cycles ago (then
             CONFIRM) or the signatures of the cycles of a period repeat (then MAP);
    MAP      one more period with its derivative: the affine map of the period, and its limit;
    LEAP     the states 2, 4, 8, … periods ahead: a period from each must run through that sequence;
    CONFIRM  one period from the limit or from the state that has returned, recorded: it must come
             back there, and obey the friction law at every event.

Where an instant has no rates, where the motion stops, and where the map drifts, so that its limit
must be split off, the search returns and is given what Python has found. Every search begins from
nothing that another one has left, so that no answer depends on the others.

Reading order: ``period_map`` (a period as an affine map, its powers and their limit), ``search`` (where a
search has got to; the friction law along a recorded path), ``phase_loop`` (from phase
to phase, state after state).
"""
