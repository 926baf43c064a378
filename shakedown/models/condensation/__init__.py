"""From an elastic model with many degrees of freedom to the contact stiffness κ.

Reading order: ``tangent_pairs`` (two tangents at a node), ``contact_frame`` (the contact nodes with normals
and tangents, and what they face), ``load_case``, ``stiffness_checks`` (of matrices from other programs),
``loose_motion`` (motions that nothing resists), ``factorised_interior`` (the interior is eliminated; of large
solids by ``fronts``), ``condense`` (the public functions).

Two surfaces whose meshes do not match are coupled by the dual mortar method, a linear map in front of the
condensation: ``surface_mesh`` (nodes and facets), ``facet_shapes`` (shape functions), ``dual_basis`` (which
facets meet, cut exactly, with Gauss points; the matrices D and P), ``node_coupling`` (P for nodes, pairs and
surfaces, corrected so that rigid motions are exact), ``surface_coupling`` (the public function).
"""
