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
``mesh`` (with ``face_shares``) from ``deck``, ``nastran_bulk`` or ``coordinates``;
``circumference`` (axisymmetric models); ``sniff`` chooses. Configurations, and the files that they
name: ``toml_table``, ``input_files``.
"""

from shakedown.readers.abaqus_matrix import read_abaqus_matrix, read_nodal_loads
from shakedown.readers.abaqus_substructure import read_abaqus_substructure, read_substructure_load
from shakedown.readers.calculix_reactions import unit_displacement_stiffness
from shakedown.readers.calculix_storage import read_calculix_storage
from shakedown.readers.coordinates import read_coordinates
from shakedown.readers.deck import read_deck
from shakedown.readers.harwell_boeing import read_harwell_boeing
from shakedown.readers.matrix_market import read_matrix_market
from shakedown.readers.mesh import Mesh
from shakedown.readers.nastran_bulk import read_analysis_set, read_grids
from shakedown.readers.nastran_dmig import read_nastran_dmig
from shakedown.readers.nastran_op4 import read_nastran_op4, read_op4_columns
from shakedown.readers.nodal_vectors import NodalVectors
from shakedown.readers.reactions_table import read_nodal_vectors
from shakedown.readers.row_map import read_dof_map, read_row_map
from shakedown.readers.sniff import read_stiffness, stiffness_format
from shakedown.readers.stiffness import Stiffness
from shakedown.readers.table import NumberTable, read_table

__all__ = [
    "Mesh",
    "NodalVectors",
    "NumberTable",
    "Stiffness",
    "read_abaqus_matrix",
    "read_abaqus_substructure",
    "read_analysis_set",
    "read_calculix_storage",
    "read_coordinates",
    "read_deck",
    "read_dof_map",
    "read_grids",
    "read_harwell_boeing",
    "read_matrix_market",
    "read_nastran_dmig",
    "read_nastran_op4",
    "read_nodal_loads",
    "read_nodal_vectors",
    "read_op4_columns",
    "read_row_map",
    "read_stiffness",
    "read_substructure_load",
    "read_table",
    "stiffness_format",
    "unit_displacement_stiffness",
]
