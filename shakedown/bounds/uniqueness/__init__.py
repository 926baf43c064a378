"""Uniqueness of the evolution: which nodes may slip, in which directions, without losing it.

Reading order: ``scaled_stiffness`` (κ in units of its own), ``moving_sets`` (the friction at which the
determinant of some moving nodes vanishes; the few that matter among many nodes), ``coupling`` (the ratio ρ*
of a joint; friction up to which none can vanish), ``difference_gauge`` (where that is not below 1),
``in_contact`` (the answer for the given friction), ``wedging`` (the friction at which a joint wedges),
``friction_thresholds`` (at which uniqueness ends).
"""
