"""Local coordinate systems of decks: their axes, and one thing wrong at a time."""

import numpy as np
import pytest

from shakedown import ProblemError
from shakedown.models.readers.deck import read_deck

NODES = "*NODE\n1, 2., 0., 1.\n2, 0., 3., 7.\n3, 0., 0., 5.\n"


def deck(folder, system):
    (folder / "job.inp").write_text(f"{NODES}*ORIENTATION, NAME=Own{system}\n")
    return read_deck(folder / "job.inp")


@pytest.mark.parametrize(
    ("system", "axes"),
    [
        ("\n0., 2., 0., -3., 5., 0.", [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]),
        (
            ", SYSTEM=RECTANGULAR\n1., 3., 0., -2., 6., 0., 1., 1., 0.\n3, 0.",
            [[0, 1, 0], [-1, 0, 0], [0, 0, 1]],
        ),
        (", SYSTEM=CYLINDRICAL\n0., 0., 0., 0., 0., 9.", [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]),
        (", SYSTEM=CYLINDRICAL\n0., 0., 9., 0., 0., 0.", [[0, 1, 0], [1, 0, 0], [0, 0, -1]]),
    ],
)
def test_axes_at_a_node(tmp_path, system, axes):
    mesh = deck(tmp_path, system)
    np.testing.assert_allclose(mesh.system("own").axes_at(mesh.at([2])), [axes], atol=1e-15)


@pytest.mark.parametrize(
    ("system", "message"),
    [
        (", SYSTEM=CYLINDRICAL\n1., 2., 0., 1., 2., 0.", "expected two points on the axis"),
        (", SYSTEM=CYLINDRICAL\n0., 0., 0., 0., 0., 1.", "expected nodes beside its axis"),
        (
            "\n0., 2., 0., -3., 5., 0.\n3, 30.",
            "job.inp: line 7: expected no further turn of .*, found '3, 30.'",
        ),
    ],
)
def test_one_thing_wrong_is_named(tmp_path, system, message):
    mesh = deck(tmp_path, system)
    with pytest.raises(ProblemError, match=message):
        mesh.system("own").axes_at(mesh.at([1, 3]))
