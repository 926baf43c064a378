"""The energy ball of joints with two tangential directions, where every load step of a node is a cone.

Reading order: ``ball_limits`` (every limit with the room that a ball needs, and what of a pressure is
tied to the node's own reaction), ``own_share`` (the best such share), ``about_slip`` (the limits about a
slip, without dimension, and the programs over them), ``sharp_end`` (their end, by Newton's method),
``rounds`` (centre and shares by turns), ``best_ball`` and ``best_bound`` (what they make up, and what
confirms it), ``closed_ball`` (no
node opens in it), ``exact_discs`` (the conditions without round-off). The proofs are in ``docs/energy.md``.
"""
