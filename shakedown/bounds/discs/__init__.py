"""λ_max and safe slips with two tangential directions: a cone program over the discs of all nodes.

Reading order: ``disc_rows`` (orthonormal columns for slips; the limits, node by node), ``scaled_solution``
(the program in numbers near 1, solved: interior points, Newton's method on the active discs; the slip with
most slack, the mean load), ``enclosure`` (safe slips, and two load factors with λ_max between them, proved).

λ_max in space, call by call:

1. ``bounds.upper.upper_bound`` (public) has ``largest_load_factor.chosen_zone`` say which nodes stay open;
   ``disc_rows.zone_rows`` writes the limits, one disc a node and load step, and
   ``bounds.largest_load_factor`` answers.
2. There ``_solved`` states the program in numbers near 1 and has it solved by
   ``scaled_solution.solve_scaled``.
3. ``solve_scaled`` calls ``programs.self_dual.solve_discs``, and that ``solve_self_dual``: here λ_max is
   computed, by interior points. Back in ``solve_scaled`` Newton's method brings it to round-off.
4. Back in ``largest_load_factor``, ``_proved`` proves two load factors around it (``enclosure``).
"""
