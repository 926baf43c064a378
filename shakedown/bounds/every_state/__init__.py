"""Proofs of shakedown from every initial state, for one and two tangential directions.

Reading order: ``least_pressures`` (lower bounds of pressures, by duality; what slip in any direction asks of
a reaction; the reactions about which loads swing with least friction); ``rates`` (the joint in units of its
own; no jumps in space; motions of a body that friction alone holds go on without a jump),
``bound_of_floating``; ``universal_bound`` (how far least pressures prove shakedown, and the largest load
factor that any argument proves). The theorems and their proofs stand in ``docs/universal.md`` and
``docs/guarantee.md``.
"""
