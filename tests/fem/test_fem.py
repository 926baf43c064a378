"""Elastic bodies: patch test, rigid motions, laws of elasticity, meshes from files, what problems tell of their origin."""

import hashlib
import json
import subprocess
import sys
from dataclasses import replace

import meshlane
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import shakedown
from benchmarks.bodies.blocks import shipped_blocks
from benchmarks.bodies.classical import press_fit
from benchmarks.refinement import brick
from shakedown import ProblemError
from shakedown.fem import (
    BodyForce,
    Displacement,
    ElasticBody,
    Material,
    Pressure,
    Support,
    Traction,
    block_mesh,
    contact_condensation,
    contact_problem,
    read_mesh,
)

STEEL = Material(200e3, 0.3)


def distorted(nx=4, ny=3, seed=0):
    """A block whose inner nodes have been moved."""
    mesh = block_mesh(2.0, 1.0, nx, ny)
    p = mesh.p.copy()
    inner = mesh.interior_nodes()
    p[:, inner] += 0.08 * np.random.default_rng(seed).uniform(-1, 1, (2, len(inner)))
    return replace(mesh, doflocs=np.ascontiguousarray(p))


def triangles(mesh):
    return mesh.to_meshtri().with_boundaries(
        {"bottom": lambda x: x[1] < 1e-9, "top": lambda x: x[1] > 1 - 1e-9, "left": lambda x: x[0] < 1e-9}
    )


MESHES = {"quads": distorted(), "triangles": triangles(distorted())}


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("kind", MESHES)
def test_rigid_motions_cost_nothing(kind, order):
    body = ElasticBody(MESHES[kind], STEEL, order=order)
    x, y = body.basis.doflocs
    direction = body.dofs[:, 1]
    for motion in (direction == 1, direction == 2, np.where(direction == 1, -y, x)):
        force = body.stiffness @ motion.astype(float)
        assert np.abs(force).max() < 1e-12 * np.abs(body.stiffness.data).max()


@pytest.mark.parametrize("plane", ["strain", "stress"])
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("kind", MESHES)
def test_patch_test(kind, order, plane):
    """A linear displacement field on the boundary is a linear field inside, to 1e-12."""
    body = ElasticBody(MESHES[kind], STEEL, plane=plane, order=order)
    x, y = body.basis.doflocs
    u = np.where(body.dofs[:, 1] == 1, 0.3 * x - 0.2 * y, 0.5 * x + 0.1 * y)
    boundary = body.basis.get_dofs().flatten()
    inner = np.setdiff1d(np.arange(body.basis.N), boundary)
    K = body.stiffness.tocsr()
    found = np.linalg.solve(K[inner][:, inner].toarray(), -(K[inner][:, boundary] @ u[boundary]))
    np.testing.assert_allclose(found, u[inner], rtol=0, atol=1e-12)


@pytest.mark.parametrize(("plane", "modulus"), [("strain", 200e3 / (1 - 0.3**2)), ("stress", 200e3)])
def test_uniform_pressure_on_a_column(plane, modulus):
    """A free column under pressure: reactions carry the load, the stiffness is that of plane theory."""
    mesh = block_mesh(2.0, 1.0, 4, 3)
    load = Pressure(boundary="top", value=5.0, history=1.0)
    body = ElasticBody(mesh, STEEL, loads=[load], plane=plane, thickness=0.5)
    problem = contact_problem(body, "bottom", 0.3)
    assert problem.p_w.sum() == pytest.approx(5.0 * 2.0 * 0.5, rel=1e-12)
    assert problem.q_w.sum() == pytest.approx(0.0, abs=1e-12)
    K = body.stiffness.toarray()
    held = np.concatenate([body.rows_on("bottom", 2), body.rows_on("left", 1)])
    free = np.setdiff1d(np.arange(len(K)), held)
    force, _ = load.nodal(body)
    u = np.linalg.solve(K[np.ix_(free, free)], force[free])
    top = np.isin(free, body.rows_on("top", 2))
    np.testing.assert_allclose(u[top], -5.0 / modulus, rtol=1e-10)


def test_loads_carry_their_resultants():
    body = ElasticBody(block_mesh(2.0, 1.0, 4, 3), STEEL, thickness=0.5)
    cases = {
        Pressure(boundary="right", value=3.0, history=1.0): (-1.5, 0.0),
        Traction(boundary="top", value=(2.0, lambda x: x[0]), history=1.0): (2.0, 1.0),
        BodyForce(value=(0.0, -7.0), history=1.0): (0.0, -7.0),
    }
    for load, (fx, fy) in cases.items():
        force, _ = load.nodal(body)
        assert force[body.dofs[:, 1] == 1].sum() == pytest.approx(fx, abs=1e-12)
        assert force[body.dofs[:, 1] == 2].sum() == pytest.approx(fy, abs=1e-12)


@settings(max_examples=8)
@given(st.floats(-1.5, 1.5))
def test_an_inclined_plane_gives_the_same_problem(angle):
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    flat, inclined = (
        contact_problem(
            ElasticBody(
                block_mesh(2.0, 1.0, 4, 2, angle=a, origin=(3.0, -1.0)),
                STEEL,
                loads=[Traction(boundary="top", value=tuple(t), history=[1.0, 0.5])],
            ),
            "bottom",
            0.4,
        )
        for a, t in ((0.0, [1.0, -3.0]), (angle, turn @ [1.0, -3.0]))
    )
    np.testing.assert_allclose(inclined.kappa, flat.kappa, atol=1e-9 * np.abs(flat.kappa).max())
    np.testing.assert_allclose(inclined.q_w, flat.q_w, atol=1e-11)
    np.testing.assert_allclose(inclined.x, flat.x, atol=1e-12)


def pair(n, lower_rows):
    """Two blocks on each other, the upper one pressed and sheared through its top."""
    loads = [
        Displacement(boundary="top", x=0.0, y=-1e-3, history=1.0),
        Displacement(boundary="top", x=2e-4, y=0.0, history=lambda t: np.sin(2 * np.pi * t)),
    ]
    above = ElasticBody(block_mesh(2.0, 1.0, 2 * n, n), STEEL, loads=loads)
    mesh = block_mesh(2.0, 1.0, 2 * n, lower_rows, origin=(0.0, -1.0))
    below = ElasticBody(mesh, STEEL, supports=[Support("bottom")])
    return contact_problem(above, "bottom", 0.3, against=(below, "top"), steps=12)


def test_elastically_similar_bodies_are_uncoupled():
    """B = 0 exactly on mirrored meshes, and to discretization error on different ones (thesis §1.2.1)."""
    mirrored = pair(4, lower_rows=4)
    assert np.abs(mirrored.B).max() < 1e-12 * np.abs(mirrored.A).max()
    error = []
    for n in (4, 8, 16):
        unlike = pair(n, lower_rows=2 * n)
        slip = np.sin(np.pi * unlike.x / 2) ** 2
        inner = slice(n // 2, -(n // 2))  # at the ends a corner of each body keeps an error of its own
        error.append(np.abs(unlike.B @ slip)[inner].max() / np.abs(unlike.A @ slip).max())
    rates = np.log2(np.array(error[:-1]) / error[1:])
    assert (rates > 1.7).all()  # second order
    assert error[-1] < 2e-3
    bounds = shakedown.shakedown_bounds(mirrored)
    assert bounds.lower.load_factor == pytest.approx(bounds.upper.load_factor, rel=1e-6)


def test_materials_per_subdomain():
    mesh = block_mesh(2.0, 1.0, 4, 2).with_subdomains(
        {"soft": lambda x: x[0] < 1, "hard": lambda x: x[0] > 1}
    )
    same = ElasticBody(mesh, {"soft": STEEL, "hard": STEEL})
    np.testing.assert_allclose(
        same.stiffness.toarray(), ElasticBody(mesh, STEEL).stiffness.toarray(), atol=1e-9
    )
    mixed = ElasticBody(mesh, {"soft": Material(1.0, 0.3), "hard": STEEL}, supports=[Support("top")])
    kappa = contact_condensation(mixed, "bottom")
    assert kappa.A[0, 0] < 1e-3 * kappa.A[-1, -1]
    weight = BodyForce(value=(0.0, -1.0), subdomain="soft", history=1.0).nodal(same)[0]
    assert weight.sum() == pytest.approx(-1.0)


def pressed_on(mesh, boundary, history=1.0, **more):
    mesh = mesh.with_boundaries({"worn": lambda x: x[1] > 5.0})
    return contact_problem(
        ElasticBody(mesh, STEEL, loads=[Pressure("top", 1.0, history=history)], **more), boundary, 0.3
    )


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda m: Material(-1.0, 0.3), "Young's modulus > 0"),
        (lambda m: Material(1.0, 0.5), "Poisson's ratio < 0.5"),
        (lambda m: ElasticBody(m, STEEL, plane="shell"), "'strain' or 'stress'"),
        (lambda m: ElasticBody(m, STEEL, thickness=0.0), "thickness: expected a finite one > 0"),
        (lambda m: ElasticBody(m, {"x": STEEL}), "no such subdomain"),
        (lambda m: ElasticBody(m, STEEL, supports=[Support("front")]), "boundary 'front': not in the mesh"),
        (lambda m: pressed_on(m, "worn"), "boundary 'worn': expected at least one facet, found none"),
        (lambda m: contact_problem(ElasticBody(m, STEEL), "bottom", 0.3), "at least one load"),
        (lambda m: pressed_on(m, "bottom", history=np.cos), "needed to sample"),
        (lambda m: pressed_on(m, "bottom", supports=[Support("bottom")]), "all of them held"),
    ],
)
def test_misuse_is_named(make, message):
    with pytest.raises(ProblemError, match=message):
        make(block_mesh(2.0, 1.0, 4, 2))


def pressed_and_pulled(pull, steps=None, press=1.0):
    loads = [Pressure("top", 10.0, history=press), Traction("top", (1.0, 0.0), history=pull)]
    return contact_problem(
        ElasticBody(block_mesh(2.0, 1.0, 4, 2), STEEL, loads=loads), "bottom", 0.5, steps=steps
    )


def test_a_last_load_step_that_repeats_the_first_is_left_out_and_said():
    """The period closes by itself: the same joint as without it, unless the number of steps is stated."""
    pull = np.cos(2 * np.pi * np.arange(8) / 8) + 0.3
    open_end = pressed_and_pulled(pull)
    for press in (1.0, np.ones(9)):
        closed = pressed_and_pulled(np.append(pull, pull[0]), press=press)
        assert (closed.m, closed.q_w.tolist(), closed.p_w.tolist()) == (
            8,
            open_end.q_w.tolist(),
            open_end.p_w.tolist(),
        )
        (said,) = closed.warnings
        assert said.startswith("the last of 9 load steps repeats the first and is left out")
    limits = [shakedown.upper_bound(joint).load_factor for joint in (open_end, closed)]
    assert limits[0] == limits[1]
    stated = pressed_and_pulled(np.append(pull, pull[0]), steps=9)
    assert (stated.m, stated.warnings) == (9, ())
    halves = pressed_and_pulled(lambda t: np.cos(2 * np.pi * (t + 1 / 16)), steps=8)
    assert (halves.m, halves.warnings) == (8, ())  # the first sample and the last lie beside the same peak


ABAQUS = """*NODE
1, 0, 0
2, 1, 0
3, 2, 0
4, 0, 1
5, 1, 1
6, 2, 1
9, 7, 7
*ELEMENT, TYPE=CPE4, ELSET=steel
1, 1, 2, 5, 4
2, 2, 3, 6, 5
*NSET, NSET=foot
1, 2, 3
"""


def test_decks_are_read_as_an_import_reads_them(tmp_path):
    """Included files, ranges, sets of sets, surfaces of faces; of two parts no elements on the wrong nodes."""
    nodes, rest = ABAQUS.split("*ELEMENT", 1)
    (tmp_path / "nodes.inc").write_text(nodes)
    more = "*NSET, NSET=Both, GENERATE\n1, 2\n*NSET, NSET=All3\nBoth, 3\n*SURFACE, NAME=Sole\n1, S1\n"
    (tmp_path / "block.inp").write_text(f"*INCLUDE, INPUT=nodes.inc\n*ELEMENT{rest}{more}")
    mesh = read_mesh(tmp_path / "block.inp")
    assert {name: len(facets) for name, facets in mesh.boundaries.items()} == {
        "foot": 2, "Both": 1, "All3": 2, "Sole": 1,
    }  # fmt: skip
    parts = "".join(f"*PART, NAME={name}\n{ABAQUS}*END PART\n" for name in "AB")
    (tmp_path / "parts.inp").write_text(parts)
    with pytest.raises(ProblemError, match="expected one part instance, found several"):
        read_mesh(tmp_path / "parts.inp")


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("broken.msh", "$MeshFormat\n9.9 0 8\n", "cannot be read as a mesh"),
        (
            "bent.inp",
            "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,1,1,1\n*ELEMENT,TYPE=CPS3\n1,1,2,3\n2,2,3,4\n",
            "plane",
        ),
        ("unknown.inp", "*NODE\n1,0,0\n2,1,0\n*ELEMENT,TYPE=XYZ9\n1,1,2\n", "found no cells"),
    ],
)
def test_unusable_meshes_are_named(tmp_path, name, text, message):
    (tmp_path / name).write_text(text)
    with pytest.raises(ProblemError, match=message):
        read_mesh(tmp_path / name)


def test_shipped_blocks_are_made_again():
    """Every number, to round-off of stiffness and reactions: what vanishes by symmetry is nothing else."""
    for name, made in shipped_blocks().items():
        shipped = shakedown.example(name)
        assert (shipped.name, shipped.units) == (made.name, made.units)
        for keys in (("A", "B", "C"), ("q_w", "p_w", "q_transient", "p_transient"), ("f",), ("x",)):
            parts = [(getattr(shipped, key), getattr(made, key)) for key in keys]
            size = max(np.abs(expected).max() for _, expected in parts if expected is not None)
            for key, (found, expected) in zip(keys, parts, strict=True):
                assert (found is None) == (expected is None), (name, key)
                if expected is not None:
                    np.testing.assert_allclose(
                        found, expected, rtol=0, atol=1e-12 * size, err_msg=f"{name}: {key}"
                    )


def test_without_scikit_fem_the_import_says_what_to_install():
    code = "import sys; sys.modules['skfem'] = None; import shakedown.fem"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert "pip install '.[fem]'" in run.stderr


def test_a_body_of_one_layer_of_elements_is_no_sub_block():
    assert brick(3, 0.3).n == 16


def clamped(shear=12.0, **more):
    mesh, pushed = (
        block_mesh(23.0, 8.0, 23, 8),
        Traction("top", (shear, 0.0), history=lambda t: np.sin(2 * np.pi * t)),
    )
    loads = [Pressure("top", 60.0, history=1.0), pushed]
    body = ElasticBody(mesh, Material(210e3, 0.3), loads=loads, thickness=10.0, **more)
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
