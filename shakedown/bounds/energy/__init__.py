"""What is proved of a joint from a given state on: the energy ball, with no condition on friction or size.

Reading order: ``energy_metric`` (the norm of a difference of slips, and γ of every limit),
``energy_rows`` (every limit with the room that a ball needs), ``zone_rows`` (the same with open
nodes), ``cone_rows`` (the same about a given slip), ``farthest`` (the cone program over them),
``energy_ball`` (the largest ball at one load factor, and the one that holds a given state best),
``energy_bound`` (the largest load factor for a given state, λ_E), ``exact_check`` (the conditions
without round-off), ``reasons`` (why there is no ball, in words), ``ball_watch`` (whether the
states of a motion are in one); below them ``discs/``, the same with two
tangential directions. The theorem and its proof are in ``docs/energy.md``.
"""
