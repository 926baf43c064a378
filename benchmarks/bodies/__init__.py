"""Joints that studies and built-in examples are made of, meshed here with :mod:`shakedown.fem`.

``blocks`` (thesis, chapters III and V, and what is built in), ``classical`` (a press fit, a cylinder on a
flat), ``sphere`` (pushed on a flat, of ``patch_compliance``: half-spaces under polygons), ``bearing_ring``
(under balls that run round); of solids ``lap_joint`` (two half beams under three bolts), ``bolted_flange`` (a
sector of a pair of ring flanges), ``blade_root`` (a dovetail on two inclined flanks), drawn out of plans by
``extrusion``.
"""
