"""From an elastic model with many degrees of freedom to the contact stiffness κ.

Reading order: ``tangent_pairs``, ``contact_frame`` (contact nodes, normals, tangents), ``shanks``,
``coupled_frame`` (what they follow where that is no node), ``load_case``, ``stiffness_checks``,
``loose_motion``, ``dissection``, ``fronts`` (large solids, and what they take), ``factorised_interior``,
``condense`` (the public functions).

Two surfaces whose meshes do not match, by the dual mortar method, a linear map in front of the condensation:
``surface_mesh`` (nodes and facets), ``facet_shapes``, ``overlaps`` (which may meet, exact segments, Gauss
points), ``dual_basis`` (D, P), ``node_coupling`` (what nodes follow, also of pairs, the least correction of
P), ``surface_coupling`` (the public function).
"""
