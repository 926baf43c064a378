"""The long-term state of a motion known only cycle by cycle, from the map of one cycle to the next.

Reading order: ``followed_cycles`` (of a search: the size of a change, what is left of the way as the change
falls on it, whether rigid slip goes on for ever); ``leaps`` along slow approaches (as a linear recurrence
goes on; along the map of a period, by its slopes), ``extrapolation`` (which one is tried, and what they leave
uncertain); ``steady_search`` (is it at rest, does it repeat, does it approach a cycle).
"""
