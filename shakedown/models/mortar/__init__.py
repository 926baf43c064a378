"""Two surfaces whose meshes do not match: the dual mortar method, a linear map in front of the condensation.

Reading order: ``surface_mesh`` (nodes and facets), ``facet_shapes``, ``overlaps`` (which may meet, exact
segments, Gauss points), ``dual_basis`` (D, P), ``node_coupling`` (what nodes follow, also of
pairs, the least correction of P), ``surface_coupling`` (the public function).
"""
