"""From an elastic model with many degrees of freedom to the contact stiffness κ.

Reading order: ``contact_frame`` (the contact nodes with normals and tangents, and what they face),
``load_case``, ``stiffness_checks`` (of matrices from other programs; motions that nothing resists),
``factorised_interior`` (the interior is eliminated, of large solids front by front), ``condense`` (the public
functions).

Two surfaces whose meshes do not match are coupled by the dual mortar method, a linear map in front of the
condensation: ``surface_mesh`` (nodes and facets, shape functions; P for nodes, pairs and surfaces, corrected
so that rigid motions are exact), ``dual_basis`` (which facets meet, cut exactly, with Gauss points; the
matrices D and P), ``surface_coupling`` (the public function).
"""
