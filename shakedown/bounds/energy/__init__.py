"""What is proved of a joint from a given state on: the energy ball, with no condition on friction or size.

Reading order: ``energy_metric`` (the norm of a difference of slips, and γ of every limit), ``energy_rows``
(every limit with the slack that a ball needs, also with open nodes), ``cone_rows`` (the same about a given
slip), ``row_solution`` (the cone program over them), ``energy_ball`` (the largest ball at one load factor,
and the one that holds a given state best) and ``energy_bound`` (the largest load factor for a given state,
λ_E): what they find (``energy_results``) comes from ``row_ball`` and ``row_bound``; ``exact_check`` (the
conditions without round-off).

With two tangential directions every load step of a node is a cone: ``ball_limits`` (every limit with the
slack that a ball needs, and what of a pressure is tied to the node's own reaction), ``own_share`` (the best
such share), ``about_slip`` (the limits about a slip, without dimension, and the programs over them),
``centre_and_shares`` (both by turns), ``disc_ball`` (no node opens in it) and ``disc_bound`` (what they
make up, and what confirms it), ``exact_discs`` (the conditions without round-off). The theorem and its
proof are in ``docs/energy.md``.
"""
