"""Stiffness matrices, loads, reactions and meshes as finite-element codes write them.

The content of a file decides what it is, never its name. A matrix becomes a
:class:`Stiffness`: entries, and the (node, direction) of every row. Some formats label
their rows; for the others ``mapped_matrices`` takes the labels from files that the codes write
beside the matrix. A deck, bulk data or a list of nodes becomes a :class:`Mesh`:
coordinates, sets and normals.

Reading order:

- ``parsing``: files and their lines, and columns of numbers;
- ``stiffness``, by formats with labels: ``abaqus``, ``nastran``; by formats that need a map of their rows:
  ``mapped_matrices`` (Matrix Market, Harwell-Boeing, CalculiX ``.sti``, Abaqus COORDINATE);
- ``nodal_vectors`` (reactions and displacements);
- ``mesh``, by ``deck``, ``nastran`` or ``mesh_files`` (Gmsh, MED, VTU, UNV, archives of Ansys, lists);
- ``formats``, which recognises a file and reads a stiffness or a mesh of any format: a new format is an entry
  in the ``FORMATS`` at the end of the module that reads it;
- ``toml_table``: a configuration.
"""
