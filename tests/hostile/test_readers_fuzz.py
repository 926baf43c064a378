"""Damaged input files: every reader ends in an answer or in one short line.

Mutations are seeded. ``SHAKEDOWN_FUZZ_SECONDS=60`` goes on with further seeds
for so long per file (and ``SHAKEDOWN_FUZZ_SEED=n`` starts elsewhere).
"""

import os
import random
import threading
import time
import tracemalloc
from contextlib import contextmanager, nullcontext, redirect_stderr, redirect_stdout
from functools import partial
from shutil import copytree

import meshlane
import numpy as np
import pytest
import writers
from command import run
from model_files import BLOCK
from scipy import sparse

from shakedown import ProblemError, import_model
from shakedown.models.readers.abaqus import read_nodal_loads, read_substructure_load
from shakedown.models.readers.formats import formats, read_any_mesh, read_stiffness
from shakedown.models.readers.mapped_matrices import read_row_map
from shakedown.models.readers.nastran import pyyeti_module, read_analysis_set, read_op4_entries
from shakedown.models.readers.parsing import read_table
from shakedown.models.readers.toml_table import read_toml

SECONDS = float(os.environ.get("SHAKEDOWN_FUZZ_SECONDS", "0"))
SEED = int(os.environ.get("SHAKEDOWN_FUZZ_SEED", "1"))
ROUNDS = 15  # mutations of each file where no time is given
LONGEST_MESSAGE = 600
NASTY = (
    b"nan", b"inf", b"-1", b"0", b"1e999", b"1e-320", b"9" * 400, b"99999999", b"-99999999", b"4294967296", b"1_0",
    b"\xc2\xa0", b"\xff\xfe", b"\0", b"'", b"*", b"**", b",", b",,,,", b"=", b"THRU", b"\n", b"\r", b"(0I0)", b"1P,0E0.0",
    b"\x1b[31m", b"[[[[[[[[", b"%%MatrixMarket", b"*NODE\n", b"DMIG", "１２".encode(),
)  # fmt: skip

DOFS = [(11, 1), (11, 2), (12, 1), (12, 2), (21, 1), (21, 2)]
K = writers.symmetric_matrix(len(DOFS))
DECK = """*HEADING
*NODE, NSET=ALL
1, 0., 0.
2, 1., 0.
3, 1., 1.
4, 0., 1.
*ELEMENT, TYPE=CPE4, ELSET=E
1, 1, 2, 3, 4
*NSET, NSET=BOTTOM, GENERATE
1, 2, 1
*SURFACE, NAME=S, TYPE=ELEMENT
E, S1
*EQUATION
3
1, 1, 1., 2, 1, -1., 3, 1, -1.
*TRANSFORM, NSET=BOTTOM
1., 0., 0., 0., 1., 0.
"""
PUNCH = """$ comment
CORD2R*               10               0 0.000000000E+00 0.000000000E+00
*        0.000000000E+00 0.100000000E+01 0.000000000E+00 0.000000000E+00
*        0.000000000E+00 0.100000000E+01 0.000000000E+00
EXTRN         11      12      12      12      21      12
GRID*                 11               0 0.600000000E+03 0.000000000E+00
*        0.300000000E+03              10               0               0
GRID          12              1.      2.      3.
GRID,21,,1.,2.,4.
ASET1         12      11    THRU      12
SPOINT   1995001
"""
SLOAD = (
    writers.abaqus_substructure(K, DOFS)
    + """** SUBSTRUCTURE LOAD CASE VECTOR. SLOAD CASE: LC1
** *CLOAD
**     1,     2, 0.1000000E+02
**     3,     1,-0.5000000E+01
"""
)
HARWELL = writers.harwell_boeing(K)
ARCHIVE = writers.ansys_archive(
    {1: (0.0, 0.5, 0.0), 2: (1.0, 0.0, 0.0), 3: (1.0, 1.0, 0.0), 4: (0.0, 1.0, 0.0)},
    {7: (1, [1, 2, 3, 4])},
    {"FOOT": ("NODE", [1, -2]), "BODY": ("ELEM", [7])},
)
TOML = (BLOCK / "import.toml").read_text()


def op4_bytes(folder, **layout):
    """OUTPUT4 as pyYeti writes it."""
    path = folder / "written.op4"
    op4 = pyyeti_module("op4", "the test").OP4()
    matrix = sparse.coo_matrix(K) if layout.get("sparse", "dense") != "dense" else K
    op4.write(path.as_posix(), {"kaa": matrix, "px": np.ones((6, 2))}, **layout)
    return path.read_bytes()


def stiffness(path):
    return read_stiffness(path, dof_map=np.array(DOFS))


TRIANGLE = {
    "points": np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
    "cells": [("triangle", [[0, 1, 2]]), ("line", [[0, 1]])],
    "cell_sets": {"FOOT": [[], [0]]},
}
UNV = writers.universal(TRIANGLE["points"], (1, 2, 3), [(41, [1, 2, 3]), (11, [1, 2])], [("FOOT", 8, [2])])
GMSH = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
1
1 1 "FOOT"
$EndPhysicalNames
$Nodes
3
1 0 0 0
2 1 0 0
3 0 1 0
$EndNodes
$Elements
2
1 1 2 1 1 1 2
2 2 2 2 1 1 2 3
$EndElements
"""


def mesh_bytes(folder, suffix):
    """A mesh with a group as meshlane writes it."""
    path = folder / f"written.{suffix}"
    with redirect_stdout(None), redirect_stderr(None):
        meshlane.Mesh(**TRIANGLE).write(path)
    return path.read_bytes()


STEPS = [([1, 2], np.ones((2, 3)))]
FILES = {  # of every format, by its name: texts, bytes or what writes some
    "abaqus-matrix": [writers.abaqus_matrix(K, DOFS)],
    "substructure": [SLOAD],
    "dmig": [writers.nastran_dmig(K, DOFS), writers.nastran_dmig(K, DOFS, style="free")],
    "matrix-market": [
        writers.matrix_market(K),
        writers.matrix_market(K, layout="array"),
        "%%MatrixMarket matrix array integer general\n3 1\n11\n12\n21\n",
    ],
    "numbered": [writers.calculix_storage(K, DOFS)[0]],
    "op4": [
        *(writers.nastran_op4(K, **style) for style in ({}, {"style": "sparse"}, {"style": "bigmat"})),
        *(
            partial(op4_bytes, binary=True, **layout)
            for layout in ({"endian": "<"}, {"endian": ">"}, {"sparse": "bigmat"}, {"sparse": "nonbigmat"})
        ),
    ],
    "harwell-boeing": [HARWELL],
    "rows": [writers.dof_map(DOFS)],
    "bulk": [PUNCH],
    "deck": [DECK],
    "archive": [ARCHIVE],
    "unv": [UNV],
    "gmsh": [GMSH],
    "med": [partial(mesh_bytes, suffix="med")],
    "vtu": [partial(mesh_bytes, suffix="vtu")],
    "coordinates": ["Node\tX\tY\tZ\n1\t0,5\t1,e-001\t0\n2\t1\t2\t3\n"],
    "reactions": [writers.calculix_reactions(STEPS), "step,node,fx,fy\n1,1,2.0,3.0\n2,1,4.0,5.0\n"],
    "displacements": [writers.calculix_displacements(STEPS)],
    "vectors": ["1,1,2.0,3.0\n2,1,4.0,5.0\n"],
    "frd": [writers.calculix_frd(STEPS)],
}
ARGUMENTS = {  # by what a file holds
    "stiffness": {"rows": np.array(DOFS), "matrix": None},
    "mesh": {},
    "rows": {"size": 6},
    "vectors": {"what": "displacements"},
}
TEXTS = {
    "substructure load": (SLOAD, read_substructure_load),
    "analysis set": (PUNCH, read_analysis_set),
    "deck as map": (DECK, lambda path: read_row_map(path, 8)),
    "table": ("time;factor\n0,0;1\n0,5;2\n", read_table),
    "nodal loads": ("*CLOAD\n1,2,3.0\n2,2,1.0\n", read_nodal_loads),
    "configuration": (TOML, read_toml),
}


def mutated(content, rng):
    """One to three small injuries."""
    data = bytearray(content)
    for _ in range(rng.choice((1, 1, 2, 3))):
        place = rng.randrange(len(data) + 1)
        match rng.randrange(7):
            case 0:
                data[place : place + 1] = bytes([rng.randrange(256)])
            case 1:
                data[place:] = b""
            case 2:
                data[place:place] = rng.choice(NASTY)
            case 3:
                data[place : place + rng.randrange(1, 9)] = rng.choice(NASTY)
            case 4:
                other = rng.randrange(len(data) + 1)
                data[place:place] = data[other : other + rng.randrange(1, 80)]
            case 5:
                del data[place : place + rng.randrange(1, 80)]
            case 6:
                data[place : place + 4] = rng.choice((0, 1, 24, 48, 2**31 - 1, 2**32 - 1)).to_bytes(
                    4, "little"
                )
    return bytes(data)


def survive(path, content, reader, origin):
    """A reader's answer, or one short line; anything else is a failure that says how to see it again."""
    path.write_bytes(content)
    start = time.process_time()
    try:
        reader(path)
    except ProblemError as error:
        message = str(error).replace(str(path.parent), "")
        assert len(message) < LONGEST_MESSAGE, (origin, len(message))
        assert "\n" not in message.rstrip(), (origin, message)
        assert message.isprintable(), (origin, message)
    except Exception as error:
        pytest.fail(f"{origin}: {type(error).__name__}: {error}")
    assert time.process_time() - start < 20, origin


def batter(folder, content, reader):
    path, end = folder / "damaged", time.monotonic() + SECONDS
    survive(path, content, reader, "whole")
    k = SEED
    while k < SEED + ROUNDS or time.monotonic() < end:
        survive(path, mutated(content, random.Random(k)), reader, f"seed {k}")
        k += 1


@pytest.mark.parametrize("kind", TEXTS)
def test_damaged_text_ends_in_an_answer_or_one_line(tmp_path, kind):
    text, reader = TEXTS[kind]
    batter(tmp_path, text.encode(), reader)


@pytest.mark.parametrize("format", formats(), ids=lambda format: f"{format.name}: {format.title}"[:30])
def test_every_registered_reader_ends_in_an_answer_or_one_line(tmp_path, format):
    for holds, reader in format.reads.items():
        given = ARGUMENTS[holds]
        own = given if holds in ("rows", "vectors") else {key: given[key] for key in format.takes}
        for file in FILES[format.name]:
            content = file(tmp_path) if callable(file) else file.encode() if isinstance(file, str) else file
            batter(tmp_path, content, partial(reader, **own))


def test_damaged_configurations_end_in_an_answer_or_one_line(tmp_path):
    batter(copytree(BLOCK, tmp_path / "block"), TOML.encode(), import_model)


LIES = {
    "matrix market": "%%MatrixMarket matrix coordinate real general\n1000000 1000000 999999999999\n1 1 1.0\n",
    "matrix market array": "%%MatrixMarket matrix array real general\n40000 40000\n1.0\n",
    "harwell-boeing": HARWELL.replace(
        f"{6:14d}{6:14d}{21:14d}", f"{40000000:14d}{40000000:14d}{999999999:14d}"
    ),
    "op4 text": writers.nastran_op4(K).replace("       6       6", "   40000   40000", 1),
    "op4 text string": "      40      40       2       2KAA     1P,3E23.16\n       1       0 9999999\n99999999999999999\n",
    "substructure": SLOAD.replace("NODES= 3", "NODES= 99999999999999999999"),
    "set": DECK.replace("1, 2, 1\n", "1, 999999999999999999, 1\n"),
    "thru": PUNCH.replace("EXTRN", "$XTRN").replace("    THRU      12", "    THRU99999999"),
}


@contextmanager
def little_memory():
    tracemalloc.start()
    try:
        yield
        assert tracemalloc.get_traced_memory()[1] < 50e6
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("kind", LIES)
def test_headers_that_claim_much_cost_little(tmp_path, kind):
    readers = {"set": read_any_mesh, "thru": read_analysis_set, "substructure": read_stiffness}
    reader = readers.get(kind, stiffness)
    (tmp_path / "lie").write_text(LIES[kind])
    refused = nullcontext() if kind == "set" else pytest.raises(ProblemError)
    with little_memory(), refused:  # of a set the members that there are, and no others
        reader(tmp_path / "lie")


@pytest.mark.parametrize("size", [40_000, 2**31 - 1])
def test_a_binary_header_that_claims_much_costs_little(tmp_path, size):
    """10 GB and more, with closing records that fit the lie: a matrix of zeros, held sparse."""
    word = (24).to_bytes(4, "little")
    head = b"".join(int(v).to_bytes(4, "little") for v in (size - 1, size - 1, 2, 2)) + b"KAA     "
    last = b"".join(int(v).to_bytes(4, "little") for v in (size, 1, 2)) + np.float64(1.0).tobytes()
    mark = len(last).to_bytes(4, "little")
    (tmp_path / "k.op4").write_bytes(word + head + word + mark + last + mark)
    with little_memory():
        with pytest.raises(ProblemError, match=r"expected a map of \d+ lines, one per row, found 6"):
            stiffness(tmp_path / "k.op4")
        assert read_op4_entries(tmp_path / "k.op4", "KAA").shape == (size - 1, size - 1)


@pytest.mark.parametrize("what", ["pipe", "/dev/zero", "folder", "nul", "loop"])
def test_only_regular_files_are_read(tmp_path, what):
    path = tmp_path / "x"
    if what == "pipe":
        os.mkfifo(path)
    elif what == "folder":
        path.mkdir()
    elif what == "loop":
        path.symlink_to(path)
    name = {"nul": "a\\u0000b"}.get(what, what if what.startswith("/") else "x")
    (tmp_path / "c.toml").write_text(TOML.replace('file = "stiffness.dat"', f'file = "{name}"'))
    done = threading.Event()

    def read():
        with pytest.raises(ProblemError, match=r"cannot be read|expected a regular file, found a"):
            import_model(tmp_path / "c.toml")
        done.set()

    thread = threading.Thread(target=read, daemon=True)
    thread.start()
    thread.join(20)
    assert done.is_set()


DAMAGED_TOML = {
    "deep arrays": "friction = " + "[" * 100_000,
    "deep tables": "a = " + "{a = " * 20_000,
    "long integer": "friction = " + "9" * 5_000,
    "integer of 400 digits": "friction = " + "9" * 400,
    "steps of 400 digits": "friction = 0.3\nsteps = " + "9" * 400,
    "blank": " \n\t\n",
    "no-break spaces": "\u00a0\u00a0\n",
    "long key": "k" * 60_000 + " = 1\nfriction = 0.3",
    "control characters": 'friction = "\\u001b[31m\\u009b"',
    "surrogates": 'friction = "\\ud800"',
    "nul": "friction = 0.3\0",
}


@pytest.mark.parametrize("case", DAMAGED_TOML)
def test_a_damaged_configuration_is_one_line(tmp_path, case):
    (tmp_path / "c.toml").write_text(DAMAGED_TOML[case])
    code, out, err = run("import", "c.toml", "-o", "b.npz", cwd=tmp_path)
    assert (code, out, err.count("\n")) == (2, "", 1), err
    assert len(err) < LONGEST_MESSAGE
    assert err.strip().isprintable()


def test_what_lies_outside_the_folder_is_never_shown(tmp_path):
    """Any file may be named, but a configuration must not be a way to read it."""
    (tmp_path / "secret").write_text("root:hunter2:0\nuser:swordfish:1\n")
    inside = copytree(BLOCK, tmp_path / "case")
    (inside / "k").write_text(writers.matrix_market(K))
    mapped = (
        'friction = 0.3\n[stiffness]\nfile = "k"\nmap = "map"\n[contact]\nnodes = [11]\nnormal = [0, 1]\n'
        "[[load]]\nreactions = [[0, 1]]\nhistory = 1\n"
    )
    for text, key in ((TOML, '"stiffness.dat"'), (TOML, '"unit_loads.dat"'), (mapped, '"map"')):
        (inside / "c.toml").write_text(text.replace(key, '"../secret"', 1))
        with pytest.raises(ProblemError, match="lies outside the folder") as caught:
            import_model(inside / "c.toml")
        said = str(caught.value).replace("/root/", "/").replace("pytest-of-root", "")
        assert not {"hunter2", "root"} & set(said.replace(":", " ").split())
        assert "hunter2" not in said
