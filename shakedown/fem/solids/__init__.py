"""Joints of solid bodies, meshed here.

Reading order: ``extrusion`` (a plan of quadrilaterals drawn out to hexahedra), ``lap_joint`` (two half beams
under three bolts), ``bolted_flange`` (one sector of a pair of ring flanges), ``blade_root`` (a dovetail
on two inclined flanks).
"""
