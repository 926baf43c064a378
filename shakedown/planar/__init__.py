"""What lives in the plane: theorems that need the two signs of a slip.

``uniqueness/`` (may the evolution branch; the coupling ratio ρ*), ``collapse/`` (first collapse λ_1 and
how far it is a guarantee), ``universal/`` (proofs from every initial state), ``enumeration/`` (all
critical load factors), ``friction_thresholds`` (friction at which uniqueness ends), ``wedging`` (at which
a joint wedges).
"""
