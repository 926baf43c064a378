"""First collapse λ_1, and whether it is a guarantee.

Reading order: ``lower`` (the load factor at which each node can collapse, and λ_1),
``proof_status`` (whether λ_1 is a guarantee, and no node lifts off).
"""
