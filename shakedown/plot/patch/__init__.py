"""Pictures of a patch: joints with two tangential directions, whose contact is an area.

Reading order: ``patch_places`` (where nodes are drawn, and which way their tangents lead),
``colour_field`` (one number per node), ``arrows`` (reactions, loads, slips), ``contact_zones`` (stick, slip
and open at an instant), ``orbits`` (ways of a slip, of a reaction within its limit).
"""
