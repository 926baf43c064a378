"""Proofs from a given state by bounds on the total slip of nodes, for any order of the loads.

Reading order: ``slip_arcs`` (the directions in which nodes may slip, and how far in all), ``arc_search``
(how far a node is from slipping in a direction, what slip in an arc of directions takes from that, and arcs
that are wide enough, at one load factor), ``lid_check`` (in the plane the conditions of the theorem once
more, without round-off), ``accumulated_bound`` (the largest load factor, λ_S). The theorem and its proof are
in ``docs/accumulated.md``.
"""
