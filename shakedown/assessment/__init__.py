"""What an engineer asks about a joint, each limit computed once; predictions compared with simulations.

Reading order: ``assess`` (the three numbers, and the nominal load), ``every_limit`` (every limit, computed
when first read), ``three_numbers`` (many limits reduced to three numbers, and open ends),
``mesh_check`` (whether an edge of the mesh decides them), ``shakedown_bounds`` (lower and upper bound
together), ``transient_limit`` (λ_T, up to which the joint shakes down from its own start),
``slip_limit`` (up to which slips stay small). How a limit depends on friction, constant load and
amplitude of each node: ``row_rates`` (how the slack in every row changes with a parameter),
``sensitivities`` (the resulting change of the load factor). Between the limit and gross slip:
``damping`` (long-term states over the amplitude of a load), ``loaded_joint`` (the joint under that load),
``amplitude_curve`` (the resulting stiffness and damping).

Beside simulations: ``load_regions`` (where a load factor lies), ``plan`` (which load factors and initial
states, what is predicted there), ``runs`` (the simulations), ``independent_bounds`` (the bounds by another
method), ``side_by_side`` (of a verification, beside each other), ``verify``, ``random_paths`` (other paths
through the same loads).
"""
