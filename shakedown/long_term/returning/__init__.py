"""The long-term state of a motion that is known only cycle by cycle: the map from one cycle to the next.

Reading order: ``extrapolation`` (the limit of a sequence of states), ``approach`` (how a sequence of states
closes in on a period), ``return_search`` (cycle after cycle, and leaps to the limit, until it is clear),
``returned_state`` (the answer).
"""
