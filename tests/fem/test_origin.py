"""Problems made from meshes tell what they were made of."""

import hashlib
import json

import meshlane
import numpy as np
import pytest

from benchmarks.bodies.classical import press_fit
from shakedown.fem import (
    ElasticBody,
    Material,
    Pressure,
    Traction,
    block_mesh,
    contact_problem,
    read_mesh,
)


def clamped(clamp=60.0, shear=12.0, **changes):
    loads = [
        Pressure("top", clamp, history=1.0),
        Traction("top", (shear, 0.0), history=lambda t: np.sin(2 * np.pi * t)),
    ]
    body = ElasticBody(
        block_mesh(23.0, 8.0, 23, 8), Material(210e3, 0.3), loads=loads, thickness=10.0, **changes
    )
    return contact_problem(body, "bottom", 0.5, steps=24)


def told(problem):
    return json.loads(problem.source)


def test_material_mesh_loads_and_contact_are_told():
    source = told(clamped())
    assert source["toolkit"].startswith("shakedown-bounds ")
    assert (source["made_by"], source["friction"], source["steps"], source["gap"]) == (
        "shakedown.fem.contact_problem", 0.5, 24, "none",
    )  # fmt: skip
    (body,) = source["bodies"]
    assert (body["contact"], body["plane"], body["thickness"]) == ("bottom", "strain", 10.0)
    assert body["materials"] == {"whole body": {"young": 210e3, "poisson": 0.3}}
    assert body["mesh"] == {
        "elements": 184, "nodes": 216, "type": "ElementQuad1", "x": [0.0, 23.0], "y": [0.0, 8.0],
    }  # fmt: skip
    assert body["loads"] == [
        {"kind": "Pressure", "history": 1.0, "boundary": "top", "value": 60.0},
        {"kind": "Traction", "history": "a function", "boundary": "top",
         "value": [12.0, 0.0]},
    ]  # fmt: skip


def test_the_same_joint_has_the_same_source_and_another_magnitude_another():
    assert clamped().source == clamped().source
    assert clamped().source != clamped(shear=12.5).source
    assert told(clamped(order=2))["bodies"][0]["mesh"]["type"] == "ElementQuad2"


def test_the_file_of_a_mesh_is_told_with_its_digest(tmp_path):
    mesh, path = block_mesh(2.0, 1.0, 4, 2), tmp_path / "block.med"
    sets = {name: np.unique(mesh.facets[:, facets]) for name, facets in mesh.boundaries.items()}
    points = np.column_stack([mesh.p.T, np.zeros(mesh.nvertices)])
    meshlane.write(path, meshlane.Mesh(points, [("quad", mesh.t.T)], point_sets=sets))
    keys = {key.lower(): key for key in read_mesh(path).boundaries}
    press = Pressure(keys["top"], 2.0, history=1.0)
    made = contact_problem(
        ElasticBody(read_mesh(path), Material(1.0, 0.3), loads=[press]), keys["bottom"], 0.5
    )
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    assert told(made)["files"] == [{"name": "block.med", "sha256": digest}]


@pytest.mark.parametrize("make", [clamped, press_fit])
def test_no_address_of_a_function_is_told(make):
    assert " at 0x" not in make().source
