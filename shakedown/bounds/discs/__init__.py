"""λ_max and safe slips with two tangential directions: a cone program over the discs of all nodes.

Reading order: ``disc_rows`` (the limits, node by node), ``scaled_discs`` (the program in numbers near 1),
``polished_solution`` (its end: interior points, Newton's method on the active discs; what it proves),
``frictionless`` (nodes without a limit), ``safest_slip`` (the slip with most slack, the mean load),
``safe_proof`` (what proofs are computed with; safe slips, proved), ``enclosure`` (two load factors with
λ_max between them, proved), ``disc_limits`` (the largest load factor, its status).
"""
