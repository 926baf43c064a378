"""What an engineer asks of a joint, each limit computed once; prediction held against simulation.

Reading order: ``assess`` (the three numbers, and the nominal load), ``every_limit`` (every limit, when it
is first read), ``three_numbers`` (what is made of many limits: three numbers, what has no answer),
``mesh_check`` (whether an edge of the mesh decides them), ``shakedown_bounds`` (lower and upper bound
together), ``transient_limit`` (λ_T, up to which the joint shakes down from its own start),
``slip_limit`` (up to which it slips little enough). What a limit owes to friction, constant load and
amplitude of each node: ``row_rates`` (how the slack in every row changes with a parameter), ``one_sided``
(what that makes of the load factor, on either side), ``sensitivities``. Between the limit and gross slip:
``damping`` (long-term states over the amplitude of a load), ``loaded_joint`` (the joint under that load),
``amplitude_curve`` (what they make of stiffness and damping).

Beside simulations: ``load_regions`` (where a load factor lies), ``plan`` (which load factors and initial
states, what is predicted there), ``runs`` (the simulations), ``independent_bounds`` (the bounds by another
method), ``recorded_work`` (its pieces, and what is asked beside), ``verify``, ``random_paths`` (other paths
through the same loads).
"""
