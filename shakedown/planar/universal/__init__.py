"""Proofs of shakedown from every initial state.

Reading order: ``admissible_states`` (the states a closed joint can be in, and extremes over
them), ``limit_multipliers`` (bounds on A v by one limit per node), ``swing_lines`` (what follows
for every load factor), ``swing_bound`` (where they meet first), ``rigid_swing`` (the same for a
floating body), ``exact_swing`` (in exact arithmetic), ``universal_bound`` (the largest load
factor that any argument proves), ``guarantee_curve`` (from every state in a box). The theorems and their
proofs stand in ``docs/universal.md`` and ``docs/guarantee.md``.
"""
