"""Uniqueness of the evolution: which nodes may slip, in which directions, without losing it.

Reading order: ``coupling`` (κ in units of its own; the friction at which the determinant of some moving
nodes vanishes; the ratio ρ* of a joint; friction up to which none can vanish; the answer for the given
friction; what is known where ρ* is not below 1), ``friction_thresholds`` (at which uniqueness ends, and a
joint wedges).
"""
