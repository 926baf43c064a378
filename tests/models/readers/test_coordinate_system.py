"""Local coordinate systems of decks: their axes, and one thing wrong at a time."""

import numpy as np
import pytest

from shakedown import ProblemError
from shakedown.models.readers.deck import read_deck

NODES = "*NODE\n1, 2., 0., 1.\n2, 0., 3., 7.\n3, 0., 0., 5.\n"


def deck(folder, system):
    (folder / "job.inp").write_text(f"{NODES}*NSET, NSET=ALL, GENERATE\n1, 3\n*TRANSFORM, NSET=ALL{system}\n")
    return read_deck(folder / "job.inp")


@pytest.mark.parametrize(
    ("system", "axes"),
    [
        ("\n0., 2., 0., -3., 5., 0.", [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]),
        (", TYPE=C\n0., 0., 0., 0., 0., 9.", [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]),
        (", TYPE=C\n0., 0., 9., 0., 0., 0.", [[0, 1, 0], [1, 0, 0], [0, 0, -1]]),
    ],
)
def test_axes_at_a_node(tmp_path, system, axes):
    np.testing.assert_allclose(deck(tmp_path, system).directions_of([2]), [axes], atol=1e-15)


@pytest.mark.parametrize(
    ("system", "message"),
    [
        (", TYPE=C\n1., 2., 0., 1., 2., 0.", "expected two points on the axis"),
        (", TYPE=C\n0., 0., 0., 0., 0., 1.", "expected nodes beside its axis"),
        (", TYPE=S\n0., 0., 0., 0., 0., 1.", "found 'S, 0., 0.,"),
    ],
)
def test_one_thing_wrong_is_named(tmp_path, system, message):
    mesh = deck(tmp_path, system)
    with pytest.raises(ProblemError, match=message):
        mesh.directions_of([1, 3])
