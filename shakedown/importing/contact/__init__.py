"""``[contact]`` of a configuration: which nodes, with which normals and tangents, how far apart.

Reading order: ``contact_nodes``, ``contact_directions``, ``initial_gap``, ``contact_section`` (all of it),
``coefficients`` (of friction).
"""
