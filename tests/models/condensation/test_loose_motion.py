"""What can move is named: which nodes, and how."""

import numpy as np
import pytest
from scipy import sparse

from shakedown.fem import ElasticBody, Material, block_mesh
from shakedown.models.condensation.stiffness_checks import loose_motion


def block(columns=2, rows=2):
    """A free block: stiffness, (node, direction) of its rows, places of its nodes."""
    body = ElasticBody(block_mesh(2.0, 1.0, columns, rows), Material(200e3, 0.3))
    dofs = np.asarray(body.dofs)
    nodes = np.unique(dofs[:, 0])
    places = {int(n): (*xy, 0.0) for n, xy in zip(nodes, body.positions(nodes).tolist(), strict=True)}
    return body.stiffness.tocsc(), dofs, places


LEFT, RIGHT = (0.0, 0.0), (2.0, 0.0)  # lower corners


@pytest.mark.parametrize(
    ("held", "expected"),
    [
        ((), "along x and along y and turning about z"),
        (((LEFT, 1), (LEFT, 2)), "turning about z"),
        (((LEFT, 2),), "along x and turning about z"),
        (((LEFT, 2), (RIGHT, 2)), "along x"),
    ],
)
@pytest.mark.parametrize(("columns", "rows"), [(2, 2), (20, 15)])
def test_free_motions_of_a_block(columns, rows, held, expected):
    K, dofs, places = block(columns, rows)
    kept = [k for k, (node, d) in enumerate(dofs.tolist()) if (places[node][:2], d) not in held]
    said = loose_motion(K[kept][:, kept], dofs[kept], places)
    moving = len(set(dofs[kept, 0].tolist()))
    assert said.startswith("nodes ")
    assert said.endswith(f" ({moving} in all) {expected}")


@pytest.mark.parametrize("factor", [2.0**-40, 1.0, 2.0**40])
def test_parts_are_told_apart_and_units_do_not_matter(factor):
    pair = np.array([[1.0, -1.0], [-1.0, 1.0]])
    K = np.zeros((7, 7))
    K[:2, :2] = K[2:4, 2:4] = pair
    K[4:6, 4:6], K[6, 6] = 2 * pair, 1.0
    dofs = np.array([(1, 1), (2, 1), (5, 1), (6, 1), (5, 3), (6, 3), (9, 2)])
    said = loose_motion(sparse.csc_array(factor * K), dofs)
    assert said == "nodes 1, 2, 5, 6 along x; nodes 5, 6 along z"
