"""First collapse λ_1, how far it is a guarantee, and the box that holds a state.

Reading order: ``collapse_programs`` (the load factor at which each node can collapse), ``lower`` (λ_1),
``single_node_cycle``, ``lift_off`` and ``proof_status`` (how far λ_1 is a guarantee);
``least_box`` (the box of slips that a state cannot leave), ``box_bound`` (the bound that it gives).
"""
