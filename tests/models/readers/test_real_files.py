"""Files that Abaqus, Ansys and Nastran wrote, where a folder of them is at hand.

    SHAKEDOWN_REAL_FILES=FOLDER python -m pytest tests/models/readers/test_real_files.py

The folder has the sub-folders ``abaqus``, ``ansys`` and ``nastran``; the files
are those of EXUDYN's and pyYeti's test data.
"""

import os
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from shakedown import ProblemError, import_model
from shakedown.models.readers.deck import read_deck
from shakedown.models.readers.formats import stiffness_format
from shakedown.models.readers.mesh_files import read_coordinates
from shakedown.models.readers.nastran import read_grids

NAMED = os.environ.get("SHAKEDOWN_REAL_FILES", "")
FOLDER = Path(NAMED) if NAMED else Path("no-such-folder")
FILES = sorted(path for path in FOLDER.glob("*/*") if path.is_file())
pytestmark = pytest.mark.skipif(not FILES, reason="SHAKEDOWN_REAL_FILES names no folder of files")

MATRICES = {  # the others are decks, lists, maps, licences: refused as a stiffness
    "_STIF1.mtx": "numbered",
    "TestSTIF1.mtx": "numbered",
    "Sparse.txt": "matrix-market",
    "Vector.txt": "matrix-market",
    ".op4": "op4",
    "dmig.pch": "dmig",
}
ROTOR = (
    ("abaqus/rotorDiscTestSTIF1.mtx", "abaqus/rotorDiscTest.inp", "abaqus/rotorDiscTest.inp", 1.0),
    (
        "ansys/rotorAnsysStiffnessMatrixSparse.txt",
        "ansys/rotorAnsysMatrixDofMappingVector.txt",
        "ansys/rotorAnsysNodalCoordinates.txt",
        100.0,  # the unit of force of that model
    ),
)
SUPERELEMENTS = [("inboard", ".pch"), ("inboard", ".asm"), ("outboard", ".pch"), ("outboard", ".asm")]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_every_file_is_known_or_refused_for_a_true_reason(path):
    expected = next((kind for end, kind in MATRICES.items() if path.name.endswith(end)), None)
    if expected is not None:
        assert stiffness_format(path) == expected
        return
    reasons = {
        ".inp": "an input deck",
        ".asm": "Nastran bulk data",
        ".pch": "Nastran bulk data",
        ".hdf5": "found a mesh, MED",
    }
    with pytest.raises(ProblemError, match=reasons.get(path.suffix, "expected a stiffness matrix")):
        stiffness_format(path)


def test_the_rotor_of_abaqus_and_of_ansys_has_one_condensed_stiffness(tmp_path):
    """Rows, nodes and coordinates from the codes' own files; the nodes match by where they are."""
    meshes = [read_deck(FOLDER / ROTOR[0][2]), read_coordinates(FOLDER / ROTOR[1][2])]
    first, second = (mesh.coordinates for mesh in meshes)
    distance, partner = cKDTree(second).query(first)
    assert distance.max() < 1e-7
    z = first[:, 2]
    contact = np.flatnonzero((np.abs(z - 0.1) < 1e-6) & (np.abs(first[:, 1]) < 1e-6))
    held = np.flatnonzero(np.abs(z - z.max()) < 1e-6)
    assert (len(contact), len(held)) == (5, 9)
    found = []
    for (matrix, rows, _, scale), mesh, index in zip(
        ROTOR, meshes, (np.arange(len(z)), partner), strict=True
    ):
        labels = mesh.labels[index]
        (tmp_path / "c.toml").write_text(f"""friction = 0.3
[stiffness]
file = "{FOLDER.absolute() / matrix}"
map = "{FOLDER.absolute() / rows}"
scale = {scale}
[contact]
nodes = {labels[contact].tolist()}
normal = [0, 1]
axes = [1, 3]
free_out_of_plane = true
[supports]
fixed = {[[int(node), d] for node in labels[held] for d in (1, 2, 3)]}
[[load]]
forces = [[{labels[contact[0]]}, 3, -1.0]]
history = 1
""")
        made = import_model(tmp_path / "c.toml")
        assert made.condensation.held == 27
        assert made.condensation.zero_modes == 0
        found.append(made.problem.kappa)
    difference = np.abs(found[0] - found[1]).max() / np.abs(found[0]).max()
    assert difference < 1e-6


@pytest.mark.parametrize(("stem", "suffix"), SUPERELEMENTS)
def test_superelements_have_their_rigid_motions(tmp_path, stem, suffix):
    """Six of the body in space; three in the plane of the contact, held across it.

    One of the four points has directions of its own, which the import turns.
    """
    (tmp_path / f"{stem}.op4").write_bytes((FOLDER / "nastran" / f"{stem}.op4").read_bytes())
    (tmp_path / f"{stem}{suffix}").write_bytes((FOLDER / "nastran" / f"{stem}{suffix}").read_bytes())
    (tmp_path / "c.toml").write_text(f"""friction = 0.3
[model]
file = "{stem}{suffix}"
[stiffness]
file = "{stem}.op4"
matrix = "KXX"
[contact]
nodes = [3, 11, 19, 27]
normal = [0, 1]
axes = [2, 3]
[supports]
fixed = [[3, 1], [11, 1], [19, 1], [27, 1]]
[[load]]
forces = [[3, 3, 1.0]]
history = 1
""")
    made = import_model(tmp_path / "c.toml")
    assert made.condensation.zero_modes == 3
    assert made.stiffness.format == "Nastran OUTPUT4"
    dofs, mesh = made.stiffness.dofs, read_grids(tmp_path / f"{stem}{suffix}")
    assert list(mesh.frames) == [11]
    motions = np.zeros((len(dofs), 6))
    for k, (node, direction) in enumerate(dofs.tolist()):
        if direction > 3:
            motions[k, direction - 1] = 1.0
        elif direction > 0:  # u = c + omega x r
            motions[k, direction - 1] = 1.0
            motions[k, 3:] = np.cross(mesh.at([node])[0], np.eye(3)[direction - 1])
    K = made.stiffness.K.toarray()
    assert np.abs(K @ motions).max() < 1e-9 * np.abs(K).max() * np.abs(motions).max()
    eigenvalues = np.linalg.eigvalsh(K)
    assert (np.abs(eigenvalues) < 1e-11 * eigenvalues[-1]).sum() == 6
