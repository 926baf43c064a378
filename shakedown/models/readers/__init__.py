"""Stiffness matrices, loads, reactions and meshes as finite-element codes write them.

The content of a file decides what it is, never its name. A matrix becomes a
:class:`Stiffness`: entries, and the (node, direction) of every row. Formats with
labels bring the rows themselves; for the others ``row_map`` takes them from the
files that the codes write beside the matrix. A deck, bulk data or a list of nodes
becomes a :class:`Mesh`: coordinates, sets and normals.

Reading order: ``text`` and ``table`` (lines and columns of numbers), ``stiffness``;
with labels ``abaqus_matrix``, ``abaqus_substructure``, ``nastran_dmig`` (``nastran_cards``); with a
``row_map`` ``calculix_storage`` (also Abaqus COORDINATE), ``matrix_market``,
``harwell_boeing``, ``nastran_op4``; ``nodal_vectors`` (reactions, displacements) by
``calculix_reactions``, ``calculix_frd`` and ``reactions_table``;
``mesh`` from ``deck``, ``nastran_bulk`` or ``coordinates``;
``circumference`` (axisymmetric models); ``sniff`` chooses: a new format of stiffness files is a module
and an entry of its ``FORMATS``. Configurations, and the files that they name: ``toml_table``,
``input_files``.
"""
