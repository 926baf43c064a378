"""First collapse λ_1, and whether it is a guarantee.

Reading order: ``collapse_programs`` (the load factor at which each node can collapse), ``lower`` (λ_1),
``proof_status`` (whether λ_1 is a guarantee, and no node lifts off).
"""
