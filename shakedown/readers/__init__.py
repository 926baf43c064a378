"""Stiffness matrices and reactions as finite-element codes write them.

The content of a file decides what it is, never its name.
"""

from shakedown.readers.abaqus_matrix import read_abaqus_matrix, read_nodal_loads
from shakedown.readers.abaqus_substructure import read_abaqus_substructure
from shakedown.readers.calculix_reactions import (
    Reactions,
    read_calculix_reactions,
    unit_displacement_stiffness,
)
from shakedown.readers.calculix_storage import read_calculix_storage
from shakedown.readers.dof_map import read_dof_map
from shakedown.readers.matrix_market import read_matrix_market
from shakedown.readers.nastran_dmig import read_nastran_dmig
from shakedown.readers.nastran_op4 import read_nastran_op4
from shakedown.readers.sniff import read_stiffness, stiffness_format
from shakedown.readers.stiffness import Stiffness

__all__ = [
    "Reactions",
    "Stiffness",
    "read_abaqus_matrix",
    "read_abaqus_substructure",
    "read_calculix_reactions",
    "read_calculix_storage",
    "read_dof_map",
    "read_matrix_market",
    "read_nastran_dmig",
    "read_nastran_op4",
    "read_nodal_loads",
    "read_stiffness",
    "stiffness_format",
    "unit_displacement_stiffness",
]
