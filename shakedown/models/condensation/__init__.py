"""From an elastic model with many degrees of freedom to the contact stiffness κ.

Reading order: ``tangent_pairs``, ``contact_frame`` (contact nodes,
normals, tangents), ``shanks``, ``coupled_frame`` (what they follow where that is no node), ``load_case``,
``stiffness_checks``, ``loose_motion``, ``dissection``, ``fronts`` (large solids, and what they take),
``factorised_interior``, ``condense`` (the public functions).
"""
