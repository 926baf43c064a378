"""Displacements and reactions of static steps: .dat, .frd and tables say the same; steps are added."""

import numpy as np
import pytest
import writers
from model_files import HEAT

from shakedown import ProblemError
from shakedown.models.readers.nodal_vectors import read_nodal_vectors

NODES = [7, 1042, 12345678]
STEPS = [(NODES, -np.arange(9.0).reshape(3, 3) / 7), (NODES, 1e-30 + np.arange(9.0).reshape(3, 3) * 1e5)]
TABLE = "step;node;U1;U2;U3\n" + "".join(
    f"{step};{node};{';'.join(map(repr, vector.tolist()))}\n"
    for step, (nodes, vectors) in enumerate(STEPS, 1)
    for node, vector in zip(nodes, vectors, strict=True)
)


def write(folder, text):
    (folder / "job").write_text(text)
    return folder / "job"


FILES = {
    "dat": (writers.calculix_displacements(STEPS), 5e-7),
    "frd": (writers.calculix_frd(STEPS, ("FORC", "DISP")), 5e-6),
    "table": (TABLE, 0.0),
    "table without a heading": (TABLE.partition("\n")[2], 0.0),
}


@pytest.mark.parametrize("kind", FILES)
def test_every_file_has_the_same_displacements(tmp_path, kind):
    text, digits = FILES[kind]
    found = read_nodal_vectors(write(tmp_path, text), "displacements")
    assert [step.time for step in found] == [1.0, 2.0]
    for step, (nodes, vectors) in zip(found, STEPS, strict=True):
        assert step.nodes.tolist() == nodes
        assert step.what == "displacements"
        assert (np.abs(step.vectors - vectors) <= digits * np.abs(step.vectors)).all()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("-1.42857E-01", "", "line 10: expected a node with three numbers"),
        ("-1.42857E-01", "-1.4x857E-01", "line 10: expected a number, found '-1.4x857E-01'"),
        (" 1\n -4", " 7\n -4", r"expected a block in text form \(\*NODE FILE\), found the format '7'"),
        (f"{1042:10d}", f"{7:10d}", "expected every node once at time 1, found node 7 twice"),
    ],
)
def test_a_damaged_result_file_is_refused(tmp_path, old, new, message):
    text = writers.calculix_frd(STEPS[:1])
    assert old in text
    with pytest.raises(ProblemError, match=message):
        read_nodal_vectors(write(tmp_path, text.replace(old, new)))


def test_a_binary_result_file_is_refused(tmp_path):
    path = tmp_path / "job.frd"
    path.write_bytes((HEAT / "open.frd").read_bytes()[:2000] + b"\0\0")
    with pytest.raises(ProblemError, match=r"found a binary one \(.*CalculiX: \*NODE FILE\)"):
        read_nodal_vectors(path, "displacements")
