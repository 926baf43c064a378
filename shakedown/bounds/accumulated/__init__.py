"""Proofs from a given state by bounds on the total slip of nodes, for any order of the loads.

Reading order: ``arc_search`` (the directions in which nodes may slip, and how far in all; how far a node is
from slipping in a direction, what slip in an arc of directions takes from that, and arcs that are wide
enough, at one load factor), ``accumulated_bound`` (the largest load factor, λ_S; in the plane the conditions
of the theorem once more, without round-off). The theorem and its proof are
in ``docs/accumulated.md``.
"""
