"""Proofs of shakedown from every initial state, for one and two tangential directions.

Reading order: ``least_pressures`` (the joint in units of its own; lower bounds of pressures, by duality; what
slip in any direction asks of a reaction; the reactions about which loads swing with least friction);
``bound_of_floating`` (no jumps in space; motions of a body that friction alone holds go on without a jump);
``universal_bound`` (how far least pressures prove shakedown, and the largest load factor that any argument
proves). The theorems and their proofs stand in ``docs/universal.md`` and
``docs/guarantee.md``.
"""
