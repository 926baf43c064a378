"""Import: the CalculiX reference to round-off, every route to one problem, and one thing wrong at a time."""

from dataclasses import fields
from pathlib import Path
from shutil import copytree

import numpy as np
import pytest
import writers
from model_files import BLOCK, refused_with

import shakedown
from shakedown import LoadCase, ProblemError, condense, import_model
from shakedown.models.importing.import_model import import_problem
from shakedown.models.importing.load_section import time_function
from shakedown.models.readers.parsing import InputFiles
from shakedown.models.readers.toml_table import TomlTable


def test_the_calculix_reference_comes_back_to_round_off():
    made, reference = import_model(BLOCK / "import.toml"), shakedown.load_problem(BLOCK / "block.npz")
    assert made.format == "reactions to unit displacements"
    assert 1e-9 < made.static_run < 2e-6  # another run, printed with seven digits
    assert (made.condensation.zero_modes, made.notes) == (0, ())
    for field in fields(reference):
        found, expected = getattr(made.problem, field.name), getattr(reference, field.name)
        if isinstance(expected, np.ndarray):
            scale = np.abs(expected).max()
            np.testing.assert_allclose(found, expected, rtol=0, atol=4 * np.finfo(float).eps * scale)
        elif expected:  # the reference says nothing of where it comes from
            assert found == expected


# One small model, written in every format: two contact nodes, two interior nodes, one held node.
DOFS = [(node, d) for node in (11, 12, 21, 22, 31) for d in (1, 2)]
K = writers.symmetric_matrix(10, seed=3)
FORCE = [[21, 1, 3.0], [22, 2, -7.0]]
HEAD = "friction = 0.4\nsteps = 4\n"
TAIL = """
[contact]
nodes = [11, 12]
normal = [0.0, 1.0]
[supports]
fixed = [[31, 1], [31, 2]]
[[load]]
forces = [[21, 1, 3.0], [22, 2, -7.0]]
history = { constant = 1.0, harmonics = [{ order = 1, cos = 0.5 }, { order = 2, sin = 0.25 }] }
"""


def expected_problem():
    force = np.zeros(10)
    for node, direction, value in FORCE:
        force[DOFS.index((node, direction))] = value
    t = np.arange(4) / 4
    history = 1.0 + 0.5 * np.cos(2 * np.pi * t) + 0.25 * np.sin(4 * np.pi * t)
    return condense(K, DOFS, [11, 12], [0, 1], [LoadCase(history=history, force=force)], 0.4, fixed=[8, 9])


def write(folder, **files):
    for name, text in files.items():
        (folder / name.replace("__", ".")).write_text(text)
    return folder / "c.toml"


def configured(folder, stiffness, tail=TAIL, **files):
    return write(folder, c__toml=f"{HEAD}[stiffness]\n{stiffness}\n{tail}", **files)


STORED, ROWS = writers.calculix_storage(K, DOFS), writers.dof_map(DOFS)
ROUTES = {
    "abaqus": ('file = "k"', {"k": writers.abaqus_matrix(K, DOFS)}, 1e-14),
    "substructure": ('file = "k"', {"k": writers.abaqus_substructure(K, DOFS)}, 1e-12),
    "sti": ('file = "k.sti"', {"k__sti": STORED[0], "k__dof": STORED[1]}, 1e-12),
    "matrix market": ('file = "k"\nmap = "rows"', {"k": writers.matrix_market(K), "rows": ROWS}, 1e-15),
    "dmig": ('file = "k"\nmatrix = "KAAX"', {"k": writers.nastran_dmig(K, DOFS)}, 1e-8),
    "op4": ('file = "k"\nmap = "rows"', {"k": writers.nastran_op4(K), "rows": ROWS}, 1e-15),
    "scaled": ('file = "k"\nscale = 0.5', {"k": writers.abaqus_matrix(2 * K, DOFS)}, 1e-14),
}


@pytest.mark.parametrize("route", ROUTES)
def test_every_route_leads_to_the_same_problem(tmp_path, route):
    stiffness, files, digits = ROUTES[route]
    found, expected = import_problem(configured(tmp_path, stiffness, **files)), expected_problem()
    for key in ("A", "B", "C", "q_w", "p_w", "f"):
        scale = np.abs(getattr(expected, key)).max()
        np.testing.assert_allclose(
            getattr(found, key), getattr(expected, key), rtol=0, atol=20 * digits * scale
        )


def clamped_reactions():
    """What a static run with the contact clamped prints under the forces."""
    rows = [i for i, (node, _) in enumerate(DOFS) if node in (21, 22)]
    u = np.linalg.solve(K[np.ix_(rows, rows)], [3.0, 0.0, 0.0, -7.0])
    return (K[:4][:, rows] @ u).reshape(2, 2).tolist()


SAME_LOADS = {
    "clamped reactions": (f"forces = {FORCE}", f"reactions = {clamped_reactions()}"),
    "an Abaqus load file": (f"forces = {FORCE}", 'forces = { file = "load" }'),
    "zero displacements": (
        "[supports]\nfixed = [[31, 1], [31, 2]]\n[[load]]",
        "[[load]]\ndisplacements = [[31, 1, 0.0], [31, 2, 0.0]]",
    ),
}


@pytest.mark.parametrize(("old", "new"), SAME_LOADS.values(), ids=SAME_LOADS)
def test_every_way_to_say_a_load_is_the_same_load(tmp_path, old, new):
    assert old in TAIL
    load = "** Assembled nodal loads\n*CLOAD, REAL\n21,1, 3.0\n22,2, -7.0\n"
    path = configured(
        tmp_path, 'file = "k"', TAIL.replace(old, new), k=writers.abaqus_matrix(K, DOFS), load=load
    )
    found = import_model(path)
    assert found.condensation.held == 2
    for key in ("q_w", "p_w"):
        expected = getattr(expected_problem(), key)
        np.testing.assert_allclose(getattr(found.problem, key), expected, atol=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("friction = 0.4", "friction = -0.4", "key 'friction': expected coefficients >= 0, found -0.4"),
        ("steps = 4", "steps = 99999999999999", "expected 'steps' from 1"),
        ("normal = [0.0, 1.0]", "", "one of 'normal' and 'normals'"),
        ("normal = [0.0, 1.0]", "normal = [0.0, 1.0]\naxes = [1, 1]", "two of 1, 2, 3"),
        ("normal = [0.0, 1.0]", "normals = [[0.0, 1.0], [0.0, 1.0, 0.0]]", "a list of n x 2 numbers"),
        ("normal = [0.0, 1.0]", "normal = [0, 1]\nsurface = 'S'", "found 'normal' and 'surface'"),
        ("[[31, 1], [31, 2]]", "[[31, 7]]", "key 'fixed': expected a row for direction 7 of node 31"),
        ("[21, 1, 3.0]", "[99, 1, 3.0]", "key 'forces': expected a row for direction 1 of node 99"),
        ("[21, 1, 3.0]", "[21, 1, 1e308]", r"load \d: force: expected numbers below 1e\+150, found 1e"),
        ('file = "k"', 'file = "k"\nscale = -1', "'scale': expected a number > 0, found -1"),
        ("[stiffness]", "[stifness]", "expected the key 'stiffness' .*, found the unknown key 'stifness'"),
        ("[[load]]", "[load]", "key 'load': expected a list of tables"),
        ("history =", "histories =", "expected the key 'history'"),
        ("steps = 4", "steps = ", "expected a TOML file"),
    ],
)
def test_one_thing_wrong_in_the_configuration_is_named(tmp_path, old, new, message):
    path = configured(tmp_path, 'file = "k"', k=writers.abaqus_matrix(K, DOFS))
    refused_with(path, old, new, message)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("step = 2 }", "step = 3 }", "key 'step': expected 1 to 2, found 3"),
        ("[5, 2, ", "[4, 2, ", r"expected every \(node, direction\) once, found \(4, 2\) twice"),
        ('"check.dat"', '"stiffness.dat"', "a run of its own, found the file that the stiffness was"),
        ('"check.dat" }', '"check.dat", scale = -1.0 }', r"factor -1 \(wrong sign\)"),
        ("[5, 2, 0", "[50, 2, 0", "found node 50, direction 2"),
    ],
)
def test_one_thing_wrong_in_the_reference_is_named(tmp_path, old, new, message):
    refused_with(copytree(BLOCK, tmp_path / "block") / "import.toml", old, new, message)


def history_of(value, folder=Path(), steps=4):
    table = TomlTable({"history": value}, "load 1")
    return time_function(table, steps, InputFiles(folder))[0]


def test_time_functions(tmp_path):
    (tmp_path / "h.txt").write_text("# t, factor\n0, 1.0\n0.5, -2.0D0\n")
    assert history_of(2).tolist() == 2.0
    assert history_of([1, 2.5]).tolist() == [1.0, 2.5]
    assert history_of({"points": [[0, 0], [0.5, 1], [1, 0]]}).tolist() == [0.0, 0.5, 1.0, 0.5]
    assert history_of({"points": [[0.25, 1], [0.75, 3]]}).tolist() == [2.0, 1.0, 2.0, 3.0]
    assert history_of({"points": [[0, 0], [1, 2]]}).tolist() == [0.0, 0.5, 1.0, 1.5]  # falls back at the end
    assert history_of({"file": "h.txt", "column": 2}, tmp_path).tolist() == [1.0, -2.0]
    for wrong, message in (
        ({"points": [[0.5, 1], [0.2, 0]]}, "in ascending order"),
        ({"points": [[0.5, 1, 2]]}, "n x 2 numbers"),
        ({"harmonics": [], "points": []}, "found 2"),
        ({"harmonics": [{"order": 1, "tan": 1}]}, "unknown key 'tan'"),
        ({"harmonics": [{"cos": True}]}, "expected a finite number, found True"),
        ("wave", "expected a finite number, found 'wave'"),
    ):
        with pytest.raises(ProblemError, match=message):
            history_of(wrong)
    with pytest.raises(ProblemError, match="expected a column from 1 to 2, found 3"):
        history_of({"file": "h.txt", "column": 3}, tmp_path)
