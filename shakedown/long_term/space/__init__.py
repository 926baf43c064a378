"""The long-term state of a motion known only cycle by cycle, from the map of one cycle to the next.

Reading order: ``extrapolation`` (the continuation of a sequence of states), ``leap_methods`` (leaps over
many cycles), ``local_map`` (what a period changes next to a state), ``slope_leaps`` (leaps by the slopes
of that), ``mean_leaps`` (leaps along a kink, by what many periods do on average), ``fading`` (how the change
falls on the way, and what is left where it ends), ``drift`` (whether rigid slip goes on for ever),
``settled`` (what a search goes by, and comes to), ``return_search`` (cycles and leaps until the outcome is
clear), ``proved_verdict`` (verdicts, also those in the plane, compared with what is proved),
``returned_state`` (the answer).
"""
