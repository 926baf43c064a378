"""CalculiX itself, where Debian's calculix-ccx is installed; its shipped output elsewhere (test_fem, test_importing)."""

import re
import shutil

import numpy as np
import pytest
from calculix import ccx, needs_ccx
from model_files import BLOCK

import shakedown
from shakedown.fem import ElasticBody, Material, Support, block_mesh, contact_condensation
from shakedown.models.condensation.condense import condensed_stiffness
from shakedown.models.importing.import_model import import_problem
from shakedown.models.readers.formats import read_stiffness

MATRIX_STORAGE = """*INCLUDE,INPUT=dense.inc
*INCLUDE,INPUT=tie.inc
*BOUNDARY
NTOP,1,2
*STEP
*FREQUENCY,SOLVER=MATRIXSTORAGE
*END STEP
"""


@pytest.fixture
def deck(tmp_path):
    for file in BLOCK.glob("*.in[cp]"):
        shutil.copy(file, tmp_path)
    shutil.copy(BLOCK / "import.toml", tmp_path)
    return tmp_path


def same_block():
    """The mesh of the deck in scikit-fem: bilinear, plane strain, 0.25 deep."""
    body = ElasticBody(
        block_mesh(2.0, 1.0, 8, 6), Material(200e3, 0.3), thickness=0.25, supports=[Support("top")]
    )
    return contact_condensation(body, "bottom")


@needs_ccx
def test_calculix_and_scikit_fem_agree_on_a_b_c(deck):
    (deck / "dense.inc").write_text(
        (deck / "mesh.inc").read_text().replace("*SOLID SECTION", "*DENSITY\n1.\n*SOLID SECTION")
    )
    (deck / "storage.inp").write_text(MATRIX_STORAGE)
    ccx(deck, "storage")
    stored = read_stiffness(deck / "storage.sti")
    found = condensed_stiffness(stored.K, stored.dofs, range(1, 10), [0, 1])
    expected = same_block()
    scale = np.abs(expected.stiffness).max()
    np.testing.assert_allclose(found.stiffness, expected.stiffness, rtol=0, atol=1e-6 * scale)
    printed = shakedown.load_problem(BLOCK / "block.npz").kappa
    np.testing.assert_allclose(found.stiffness, printed, rtol=0, atol=1e-6 * np.abs(printed).max())


def test_forces_on_tied_nodes_are_added(tmp_path):
    """Both layers are printed: with the tied nodes the stiffness is that of the full depth, without, of half."""
    shutil.copytree(BLOCK, tmp_path, dirs_exist_ok=True)
    expected = same_block().stiffness
    scale = np.abs(expected).max()
    np.testing.assert_allclose(
        import_problem(tmp_path / "import.toml").kappa, expected, rtol=0, atol=1e-6 * scale
    )
    config = (tmp_path / "import.toml").read_text()
    (tmp_path / "import.toml").write_text(re.sub("\ntied = .*", "", config.split("[check]")[0]))
    np.testing.assert_allclose(
        import_problem(tmp_path / "import.toml").kappa, expected / 2, rtol=0, atol=1e-6 * scale
    )


def test_a_substructure_is_taken_where_that_is_accepted(tmp_path):
    load, words = "[[load]]\nreactions = [[0, 1]]\nhistory = [1, 0.5]\n", "it looks like a sub-block"
    about = f'friction = 0.3\n[stiffness]\nfile = "{BLOCK / "substructure.mtx"}"\n[contact]\n'
    contact = (
        f"nodes = {list(range(1, 10))}\nnormal = [0, 1]\n{load.replace('[0, 1]', ', '.join(['[0, 1]'] * 9))}"
    )
    config = tmp_path / "import.toml"
    config.write_text(about + contact)
    (said,) = shakedown.import_model(config).warnings
    assert words in said
    assert "found 56 of 81 node pairs" in said
    config.write_text(f'accept = ["{words}"]\n{about}{contact}')
    assert shakedown.import_model(config).warnings == ()
