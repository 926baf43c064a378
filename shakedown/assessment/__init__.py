"""What an engineer asks about a joint, each limit computed once; predictions compared with simulations.

Reading order: ``assess`` (the three numbers, and the nominal load; the bounds by another method),
``every_limit`` (every limit, computed when first read; what they come to; whether an edge of
the mesh decides it), ``transient_limit`` (λ_T, up to which the joint shakes
down from its own start, and up to which slips stay small),
``creep_limit`` (λ_c, from which on it creeps). How a limit depends on friction, constant load
and amplitude of each node: ``sensitivities`` (how the slack in every row changes with a parameter, and so
the load factor). Between the limit and gross slip: ``damping`` (long-term states, stiffness and damping over
the amplitude of a load).

Beside simulations: ``plan`` (where a load factor lies, which load factors, initial states and other paths
through the same loads, what is predicted there), ``verify`` (the simulations, and the comparison).
"""
