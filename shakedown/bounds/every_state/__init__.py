"""Proofs of shakedown from every initial state.

Reading order in the plane: ``admissible_states`` (the states a closed joint can be in, and extremes over
them), ``swing_lines`` (bounds on A v by one limit per node, valid for every load factor), ``swing_bound``
(where they meet first), ``rigid_swing`` (the same for a floating body), ``exact_swing`` (in exact
arithmetic), ``universal_bound`` (the largest load factor that any argument proves). With two tangential
directions, by least pressures: ``scaled_joint`` (the joint in units of its own), ``unique_rates`` (no jumps),
``sectors`` (of directions in which a node slips), ``sector_rows`` (conditions of slip there on a reaction),
``least_pressures`` (lower bounds of pressures, by duality), ``disc_centres`` (conditions of slip in any
direction on a reaction; the smallest disc that holds a loop), ``bound_from_every_state``; of a body that
friction alone holds ``rigid_rates`` (motions go on without a jump), ``bound_of_floating``. The theorems and
their proofs stand in ``docs/universal.md`` and ``docs/guarantee.md``.
"""
