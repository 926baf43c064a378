"""What is proved of a joint from a given state on: the energy ball, with no condition on friction or size.

Reading order: ``ball_limits`` (the norm of a difference of slips; every limit with the slack that a ball
needs, γ, also with open nodes: discs with two tangential directions, two rows a node with one),
``about_slip`` (the same about a given slip, without dimension, and the programs over them), ``ball_search``
(their solution, and what it proves; the best centre and the best shares by turns), ``energy_ball``
(the largest ball at one load factor, and the one that holds a given state best) and ``energy_bound`` (the
largest load factor for a given state, λ_E, and its conditions without round-off). The theorem and its
proof are in ``docs/energy.md``.
"""
