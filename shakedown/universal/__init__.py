"""Proofs of shakedown from every initial state.

Reading order: ``admissible_states`` (the states a closed joint can be in, and extremes over
them), ``limit_multipliers`` (bounds on A v by one limit per node), ``swing_lines`` (what follows
for every load factor), ``swing_bound`` (where they meet first), ``rigid_swing`` (the same for a
floating body), ``exact_swing`` (in exact arithmetic), ``closing_box`` (one linear system, for
weak coupling), ``shrinking_box`` (where every motion ends up), ``best_metric`` (in which it
settles), ``sharpened_swing`` (both together), ``universal_bound`` (the largest load factor that
any argument proves). The theorems and their proofs stand in ``docs/universal.md``.
"""
