"""Displacements and reactions of static steps: .dat, .frd and tables say the same; steps are added."""

import numpy as np
import pytest
import writers
from model_files import HEAT

from shakedown import ProblemError
from shakedown.models.readers.nodal_vectors import combined, read_nodal_vectors

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


def test_a_result_file_has_reactions_apart_from_displacements(tmp_path):
    first = writers.calculix_frd(STEPS[:1], ("DISP",))
    (one,) = read_nodal_vectors(write(tmp_path, first), "displacements")
    with pytest.raises(
        ProblemError, match=r"job: expected reactions \(\*NODE FILE, RF\), found no block FORC"
    ):
        read_nodal_vectors(tmp_path / "job")
    (other,) = read_nodal_vectors(write(tmp_path, writers.calculix_frd(STEPS[:1], ("FORC",))))
    np.testing.assert_array_equal(one.vectors, other.vectors)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("-1.42857E-01", "", "line 10: expected a node with three numbers"),
        ("-1.42857E-01", "-1.4x857E-01", "line 10: expected a number, found '-1.4x857E-01'"),
        (" 1\n -4", " 7\n -4", "expected a block in text form that ends with -3, found the format '7'"),
        (f"{1042:10d}", f"{7:10d}", "expected every node once at time 1, found node 7 twice"),
    ],
)
def test_a_damaged_result_file_is_refused(tmp_path, old, new, message):
    text = writers.calculix_frd(STEPS[:1])
    assert old in text
    with pytest.raises(ProblemError, match=message):
        read_nodal_vectors(write(tmp_path, text.replace(old, new)))


def test_steps_are_added_by_node_and_not_by_place(tmp_path):
    turned = [STEPS[0], (NODES[::-1], STEPS[1][1][::-1])]
    runs = read_nodal_vectors(write(tmp_path, writers.calculix_displacements(turned)), "displacements")
    total = combined(runs, [2.0, -0.5])
    np.testing.assert_allclose(total.vectors, 2 * STEPS[0][1] - 0.5 * STEPS[1][1], rtol=2e-6)
    fewer = [STEPS[0], (NODES[:2], STEPS[1][1][:2])]
    runs = read_nodal_vectors(write(tmp_path, writers.calculix_displacements(fewer)), "displacements")
    with pytest.raises(
        ProblemError, match="displacements at time 2: expected node 12345678, found it not printed"
    ):
        combined(runs, [1.0, 1.0])


BINARY = (HEAT / "open_binary.frd").read_bytes()


def test_a_binary_result_file_has_the_displacements_of_the_printed_ones():
    """CalculiX wrote all three in one run, or of one deck; the binary one is the most accurate."""
    single, printed, text = (
        read_nodal_vectors(HEAT / file, "displacements")
        for file in ("open_binary.frd", "open.dat", "open.frd")
    )
    assert [step.time for step in single] == [step.time for step in text] == [1.0, 2.0, 3.0]
    for one, two, three in zip(single, text, printed, strict=True):
        assert one.nodes.tolist() == two.nodes.tolist()
        np.testing.assert_allclose(one.vectors, two.vectors, rtol=5.1e-6)
        rows = np.searchsorted(one.nodes, three.nodes)
        np.testing.assert_allclose(one.vectors[rows], three.vectors, rtol=6e-7)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (b"          12  ", b"          1x  ", "expected a whole number, found '1x'"),
        (b" -5  D3 ", b" -4  D3 ", "found 2 components"),
        (b"1ALL\n\1\0\0\0", b"1ALL\n\0\0\0\0", "expected nodes from 1 with finite numbers, found node 0"),
    ],
)  # fmt: skip
def test_a_damaged_binary_file_is_refused(tmp_path, old, new, message):
    assert old in BINARY
    (tmp_path / "job").write_bytes(BINARY.replace(old, new))
    with pytest.raises(ProblemError, match=message):
        read_nodal_vectors(tmp_path / "job", "displacements")
