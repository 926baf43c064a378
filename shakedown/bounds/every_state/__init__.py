"""Proofs of shakedown from every initial state, for one and two tangential directions.

Reading order: ``scaled_joint`` (the joint in units of its own), ``least_pressures`` (lower bounds of
pressures, by duality), ``slip_curves`` (what slip in any direction asks of a reaction),
``reaction_centres`` (the reactions about which loads swing with least friction), ``bound_from_every_state``
(how far least pressures prove shakedown); in space ``unique_rates`` (no jumps); of a body that friction
alone holds ``rigid_rates`` (motions go on without a jump), ``bound_of_floating``; ``universal_bound`` (the
largest load factor that any argument proves). The theorems and their proofs stand in ``docs/universal.md``
and ``docs/guarantee.md``.
"""
