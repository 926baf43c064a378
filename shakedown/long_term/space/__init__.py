"""The long-term state of a motion that is known only cycle by cycle: the map from one cycle to the next.

Reading order: ``extrapolation`` (where a sequence of states goes), ``leap_methods`` (to what comes many
cycles later), ``return_search`` (cycle after cycle, and leaps, until it is clear), ``proved_rest``
(verdicts, also those in the plane, held against what is proved), ``returned_state`` (the answer).
"""
