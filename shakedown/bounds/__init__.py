"""Bounds of the load factor, and what they guarantee.

Reading order: ``upper`` (λ_max and the safe slip), ``collapse_programs`` and ``lower`` (λ_1, first
collapse), ``safe_slip`` (most room at one load factor), ``shakedown_bounds`` (both), ``certificate``
(exact enclosures), then how far λ_1 is a guarantee: ``single_node_cycle``, ``lift_off``, ``proof_status``;
``least_box`` (the box of slips that a state cannot leave) and ``box_bound`` (what it proves from that
state); ``interior_point`` is the second road to both bounds.
"""
