"""Shakedown from every initial state with two tangential directions: by least pressures.

Reading order: ``scaled_joint`` (the joint in units of its own), ``unique_rates`` (no jumps),
``sectors`` (of directions in which a node slips),
``least_pressures`` (what a node is pressed with at least, by duality), ``leaning_discs`` and
``sector_rows`` (what slip in any direction, or in a sector, asks of a reaction), ``disc_centres`` (the
smallest disc that holds a loop), ``bound_from_every_state``.
"""
