"""Problems made from meshes know their nodes: labels, places, directions, areas."""

import numpy as np
import pytest
from dovetail import dovetail

from benchmarks.bodies.blocks import receding_block
from shakedown.fem import ElasticBody, Material, Pressure, Support, block_mesh, contact_problem


def pressed(order: int, angle: float = 0.0, thickness: float = 1.0):
    """A block without Poisson's effect, under a uniform pressure 2 on its top."""
    press = Pressure(boundary="top", value=2.0, history=1.0)
    mesh = block_mesh(4.0, 1.0, 4, 2, angle=angle)
    body = ElasticBody(mesh, Material(1.0, 0.0), supports=[Support("left", x=True, y=False)] if not angle else [],
                       loads=[press], order=order, thickness=thickness)  # fmt: skip
    return contact_problem(body, "bottom", 0.3)


@pytest.mark.parametrize("thickness", [1.0, 2.5])
def test_second_order_elements_load_their_middle_with_four_sixths(thickness):
    problem = pressed(2, thickness=thickness)
    assert problem.node_area == pytest.approx(thickness * np.array([1, 4, 2, 4, 2, 4, 2, 4, 1]) / 6)


def test_places_and_directions_are_those_of_the_mesh():
    angle = 0.3
    problem = pressed(1, angle)
    assert problem.normal[:, :2] == pytest.approx(np.tile([-np.sin(angle), np.cos(angle)], (5, 1)))
    assert np.cross(problem.tangent, problem.normal) == pytest.approx(np.tile([0.0, 0.0, 1.0], (5, 1)))
    assert np.hypot(*np.diff(problem.coordinates[:, :2], axis=0).T) == pytest.approx(1.0)
    along = (problem.coordinates - problem.coordinates[0]) @ problem.tangent[0]
    assert along == pytest.approx(problem.x)


def test_labels_are_the_nodes_of_both_meshes():
    joint = dovetail()
    assert joint.n == len(set(joint.label)) == 26
    assert all(len(name.split("/")) == 2 for name in joint.label)
    assert joint.load_names == ("traction", "traction")
    assert receding_block(1).label[:2] == ("0", "5")  # the first row of each column of the block
