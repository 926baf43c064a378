"""Elastic bodies: patch test, rigid motions, laws of elasticity, meshes from files, origins told; rings and rolling elements in them."""

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
from skfem import MeshQuad

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
    RollingLoad,
    Support,
    Traction,
    block_mesh,
    contact_condensation,
    contact_problem,
    read_mesh,
    ring_mesh,
)
from shakedown.joint.contact_surface import surface_of
from shakedown.joint.places import strips

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


COUNT, RADIUS, BORE = 24, 40.0, 32.0


def sector(turn=360.0, *, start=0.0):
    """A ring, or a part of it, from quadrilaterals; its outer boundary is called bottom."""
    closed = turn == 360.0
    angle = np.radians(start + turn * np.arange(COUNT + (not closed)) / COUNT)
    radius = np.array([BORE, (BORE + RADIUS) / 2, RADIUS])
    around = np.stack([np.cos(angle), np.sin(angle)])
    places = (radius[:, None, None] * around.T).reshape(-1, 2).T
    k = np.arange(len(radius) * len(angle)).reshape(len(radius), -1)
    after = np.roll(k, -1, axis=1)
    parts = [part[:, : None if closed else -1] for part in (k[:-1], k[1:], after[1:], after[:-1])]
    mesh = MeshQuad(places, np.stack(parts).reshape(4, -1))
    outer, inner = (lambda x: np.hypot(*x) > 0.97 * RADIUS), (lambda x: np.hypot(*x) < 1.03 * BORE)
    return mesh.with_boundaries({"bottom": outer, "top": inner})


def joint(mesh, **more):
    body = ElasticBody(mesh, STEEL, loads=[Pressure("top", 1.0, history=np.array([0.0, 1.0]))], **more)
    return contact_problem(body, "bottom", 0.3, gap=-0.01)


def angles(problem):
    return np.degrees(np.arctan2(problem.coordinates[:, 1], problem.coordinates[:, 0]))


@pytest.mark.parametrize("turn", [90.0, 200.0, 345.0, 360.0])
@pytest.mark.parametrize("order", [1, 2])
def test_positions_are_lengths_along_the_contact(turn, order):
    problem = joint(sector(turn, start=15.0), order=order)
    pieces = COUNT * order
    step = 2 * RADIUS * np.sin(np.radians(turn / COUNT / 2)) / order  # edges are straight
    np.testing.assert_allclose(problem.x, step * np.arange(pieces + (turn < 360.0)), rtol=1e-12)
    assert np.all(np.abs(np.diff(np.unwrap(angles(problem), period=360.0))) < 1.5 * turn / pieces)


@pytest.mark.parametrize("turn", [200.0, 345.0, 360.0])
def test_the_ends_are_those_of_the_mesh(turn):
    """Also where the ends of an open ring are nearer to each other than two nodes elsewhere."""
    surface = surface_of(joint(sector(turn)))
    assert np.flatnonzero(surface.edge).tolist() == ([] if turn == 360.0 else [0, COUNT])


@pytest.mark.parametrize("turn", [90.0, 200.0, 360.0])
def test_without_edges_a_node_is_followed_by_the_nearest_ahead(turn):
    """Nodes in any order, of two strips that face each other."""
    problem = joint(sector(turn))
    count, order = problem.n, np.random.default_rng(0).permutation(2 * problem.n)
    places = np.vstack([problem.coordinates, 0.97 * problem.coordinates])[order]
    found = strips(places, np.vstack([problem.tangent, -problem.tangent])[order])
    assert len(found) == 2
    for strip in found:
        nodes = order[strip] % count
        way = 1 if order[strip[0]] < count else -1
        first = nodes[0] if turn == 360.0 else (count - 1 if way < 0 else 0)
        np.testing.assert_array_equal(nodes, (first + way * np.arange(count)) % count)


@pytest.mark.parametrize("order", [1, 2])
def test_a_narrow_slit_is_no_element(order):
    problem = joint(sector(345.0 + 7.5), order=order)
    assert surface_of(problem).edge.sum() == 2
    assert not surface_of(replace(problem, node_area=None)).edge.any()  # places alone do not tell


@pytest.mark.parametrize("turn", [90.0, 200.0, 360.0])
def test_it_is_the_same_joint_wherever_it_begins(turn):
    """By steps of half an element and less, for which sums of normals round differently."""
    expected = joint(sector(turn))
    for start in (3.0, 7.5, 90.0, 123.0):
        found = joint(sector(turn, start=start))
        np.testing.assert_allclose(found.x, expected.x, rtol=1e-12)
        size = np.abs(expected.kappa).max()
        np.testing.assert_allclose(found.kappa, expected.kappa, rtol=0, atol=1e-9 * size)


def test_a_held_node_opens_a_ring():
    mesh = sector()
    held = lambda x: (np.hypot(*x) > 0.97 * RADIUS) & (np.abs(np.arctan2(x[1], x[0])) < 2 * np.pi / COUNT)  # noqa: E731
    problem = joint(mesh.with_boundaries({"held": held}), supports=[Support("held")])
    assert problem.n == COUNT - 3
    assert np.flatnonzero(surface_of(problem).edge).tolist() == [0, problem.n - 1]
    assert np.all(np.diff(problem.x) > 0)


def ring(around, order=1, **more):
    return ElasticBody(ring_mesh(35.0, 40.0, around, 2), STEEL, plane="stress", order=order, **more)


def test_a_ring_in_a_rigid_housing_bears_the_pressure_of_lame():
    body = ring(96, 2, loads=[Pressure("inside", 0.0, history=1.0)])
    joint = contact_problem(body, "outside", 0.2, gap=-1e-3, steps=1)
    stiffness = STEEL.young / 40.0 / ((40.0**2 + 35.0**2) / (40.0**2 - 35.0**2) - 0.3)
    assert joint.p_w.sum() / joint.node_area.sum() == pytest.approx(1e-3 * stiffness, rel=2e-3)
    assert np.abs(joint.q_w).max() < 1e-9 * joint.p_w.max()


@pytest.mark.parametrize(("around", "order"), [(20, 1), (20, 2), (33, 1)])
@pytest.mark.parametrize("half_width", [0.02, 6.0])
def test_rolling_elements_press_with_their_force_on_any_mesh(around, order, half_width):
    body, load = ring(around, order), RollingLoad("inside", 3e3, elements=7, half_width=half_width)
    for t in (0.0, 0.37):
        nodal = load.nodal(body, t)
        at = 2 * np.pi * (np.arange(7) + t) / 7
        # the resultant of a half ellipse over an arc: 2 J₁(b/R) R/b of a force at its middle
        force = 3e3 * np.clip(np.cos(at), 0, None) ** 1.5 * (1 - (half_width / 35.0) ** 2 / 8)
        expected = [(force * np.cos(at - np.pi / 2)).sum(), (force * np.sin(at - np.pi / 2)).sum()]
        assert nodal.reshape(-1, 2).sum(axis=0) == pytest.approx(expected, abs=1e-4 * force.max())
        assert load.nodal(body, t + 1.0) == pytest.approx(nodal, abs=1e-9 * force.max())
        mirrored = replace(load, backwards=True).nodal(body, t).reshape(-1, 2).sum(axis=0)
        there = nodal.reshape(-1, 2).sum(axis=0)
        assert mirrored == pytest.approx([-there[0], there[1]], abs=1e-9 * force.max())


def test_the_work_of_rolling_elements_converges_with_the_mesh():
    load, work = RollingLoad("inside", 3e3, elements=7, half_width=0.3), []
    for around in (24, 48, 96, 192):
        body = ring(around)
        x, y = body.basis.doflocs[:, ::2]
        along = np.column_stack([x * y, y**2 - x]).ravel() / 35.0
        work.append(load.nodal(body, 0.3) @ along)
    steps = np.abs(np.diff(work))
    assert steps[0] / steps[2] > 10  # of order 2 on average: 16; it depends on where the facets end


def test_an_inner_ring_is_pressed_inwards_and_what_is_no_raceway_is_refused():
    body = ring(24)
    above = RollingLoad("outside", 1e3, elements=5, half_width=0.3)  # the middle element, at −90°
    assert above.nodal(body, 0.0).reshape(-1, 2).sum(axis=0)[1] > 0
    with pytest.raises(ProblemError, match="expected a circle about"):
        replace(above, centre=(1.0, 0.0)).nodal(body, 0.0)
    with pytest.raises(ProblemError, match="half_width: expected less than"):
        replace(above, half_width=30.0).nodal(body, 0.0)
    with pytest.raises(ProblemError, match="steps: needed"):
        contact_problem(replace(body, loads=[above]), "inside", 0.1)
    with pytest.raises(ProblemError, match="radii 0 < inside < outside"):
        ring_mesh(40.0, 35.0, 24, 2)


@pytest.mark.parametrize("around", [3, 8])
def test_a_coarse_ring_has_both_boundaries(around):
    boundaries = ring_mesh(35.0, 40.0, around, 2).boundaries
    assert {name: len(facets) for name, facets in boundaries.items()} == {"inside": around, "outside": around}
