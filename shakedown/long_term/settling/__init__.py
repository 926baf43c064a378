"""Long-term states of many initial slips, decided in compiled code; the rooms know arrays, no ``Problem``.

The steps are those of :class:`shakedown.long_term.limit_search.LimitSearch`, in the same order and
with the same tolerances, one cycle at a time:

    WALK     cycles one by one from the start, until the state is that of some cycles ago (then
             CONFIRM) or the signatures of the cycles of a period repeat (then MAP);
    MAP      one more period with its derivative: the affine map of the period, and its limit;
    LEAP     the states 2, 4, 8, … periods ahead: a period from each must run through that sequence;
    CONFIRM  one period from the limit or from the state that has returned, recorded: it must come
             back there, and obey the friction law at every event.

What cannot be decided so is handed over: instants without rates, motions that stop, states that
break the friction law. Where the map drifts, its limit is asked for. Every search begins from
nothing that another one has left, so that no answer depends on the others.

Reading order: ``path_check`` (the friction law along a recorded path), ``period_map`` (a period as
an affine map), ``limit_of_powers``, ``search`` (where a search has got to), ``repeats`` (until the
contact states repeat), ``leaps`` (to the limit, and its confirmation), ``settle`` (state after state).
"""
