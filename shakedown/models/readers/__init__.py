"""Stiffness matrices, loads, reactions and meshes as finite-element codes write them.

The content of a file decides what it is, never its name. A matrix becomes a
:class:`Stiffness`: entries, and the (node, direction) of every row. Some formats label
their rows; for the others ``row_map`` takes the labels from files that the codes write
beside the matrix. A deck, bulk data or a list of nodes becomes a :class:`Mesh`:
coordinates, sets and normals.

Reading order:

- ``text`` and ``table``: files and their lines, and columns of numbers;
- ``stiffness``, by formats with labels: ``abaqus_matrix``, ``abaqus_substructure``, ``nastran_dmig``;
  by formats that need a ``row_map``: ``calculix_storage`` (also Abaqus COORDINATE), ``matrix_market``,
  ``harwell_boeing``, ``nastran_op4``; ``circumference`` (of axisymmetric models);
- ``nodal_vectors`` (reactions and displacements), by ``calculix_reactions``, ``calculix_frd`` or
  ``reactions_table``;
- ``mesh``, by ``deck`` (its local systems: ``coordinate_system``), ``nastran_bulk``, ``ansys_archive``,
  ``mesh_files`` (Gmsh, MED, VTU, UNV) or ``coordinates``;
- ``formats``, which recognises a file: a new format is a module that ends in its ``FORMATS``; ``sniff``,
  which reads a stiffness or a mesh of any format;
- ``toml_table``: a configuration.
"""
