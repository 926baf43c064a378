"""Solid bodies, meshes that do not match, bolts, rigid boundaries, symmetry; modes with the contact stuck, modal loads."""

import json

import numpy as np
import pytest
import solids
import writers
from calculix import ccx, needs_ccx
from scipy.linalg import eigh

import shakedown
from benchmarks.bodies.lap_joint import lap_joint
from shakedown import ProblemError, ShakedownError, damping, import_model
from shakedown.fem import (
    Bolt,
    ElasticBody,
    Force,
    Material,
    Pressure,
    Support,
    Traction,
    block_mesh,
    brick_mesh,
    contact_condensation,
    contact_problem,
    modal_load,
)
from shakedown.fem.loads import mass_of
from shakedown.joint.places import faces_among
from shakedown.models.condensation.condense import condensed_stiffness

STEEL = Material(210e3, 0.3)
LOADS = (
    Force("top", (0.0, 0.0, -120.0), history=1.0),
    Force("top", (24.0, 12.0, 0.0), history=[1.0, 0.0, -1.0, 0.0]),
)


def block(lower=False, *, order=1, tetrahedra=False, counts=solids.COUNTS, **more):
    place = (0.0, 0.0, 0.0 if lower else solids.SIZE[2])
    mesh = brick_mesh(solids.SIZE, counts, origin=place, tetrahedra=tetrahedra)
    more = ({"supports": [Support("bottom")]} if lower else {"loads": LOADS}) | more
    return ElasticBody(mesh, STEEL, order=order, **more)


@pytest.mark.parametrize(
    ("mesh", "more"),
    [
        (block_mesh(4.0, 1.0, 4, 2), {"order": 1}),
        (block_mesh(4.0, 1.0, 4, 2), {"order": 2, "thickness": 2.5}),
        (brick_mesh((2.0, 1.0, 1.0), (3, 2, 2)), {}),
        (brick_mesh((2.0, 1.0, 1.0), (3, 2, 2), tetrahedra=True), {}),
        (brick_mesh((2.0, 1.5, 1.0), (2, 2, 1), tetrahedra=True), {"order": 2}),
    ],
)
def test_a_pressure_arrives_as_nodal_forces_over_the_areas(mesh, more):
    """Without Poisson's ratio the stress of a pressed block on a rigid plane is the same everywhere."""
    body = ElasticBody(mesh, Material(1.0, 0.0), loads=[Pressure("top", 3.0, history=1.0)], **more)
    joint = contact_problem(body, "bottom", 0.4)
    d = mesh.p.shape[0] - 1
    assert (joint.directions, joint.warnings) == (d, ())
    assert joint.node_area.min() > 0
    assert joint.node_area.sum() == pytest.approx(np.ptp(mesh.p[:d], axis=1).prod() * body.thickness)
    np.testing.assert_allclose(joint.p_w[0], 3.0 * joint.node_area, rtol=1e-12)
    np.testing.assert_allclose(joint.q_w, 0.0, atol=1e-12)
    np.testing.assert_allclose(joint.x.reshape(-1, d), joint.coordinates[:, :d], atol=1e-15)
    assert contact_condensation(body, "bottom").zero_modes == 3 * d
    tight = contact_problem(body, "bottom", 0.4, gap=lambda x: -0.1 - 0.05 * x[0])
    pushed = joint.C @ (0.1 + 0.05 * joint.coordinates[:, 0])
    np.testing.assert_allclose(tight.p_w[0] - joint.p_w[0], pushed, atol=1e-12)


@pytest.mark.parametrize("tetrahedra", [False, True])
@pytest.mark.parametrize("order", [1, 2])
def test_the_faces_of_a_contact_cover_it_once(tetrahedra, order):
    body = block(order=order, tetrahedra=tetrahedra)
    nodes, _ = body.normals_on("bottom")
    faces, place = (
        faces_among(np.array(body.surface("bottom").split()), nodes.tolist()),
        body.positions(nodes),
    )
    corners = place[np.where(faces < 0, faces[:, :1], faces)]  # of a triangle the first one twice
    across = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    assert 0.5 * np.linalg.norm(across, axis=1).sum() == pytest.approx(body.extent_of("bottom"))
    np.testing.assert_array_equal(np.unique(faces[faces >= 0]), np.arange(len(nodes)))
    assert (
        len(faces_among(np.array(body.surface("bottom").split()), nodes[1:].tolist()))
        == len(faces) - (faces == 0).any(axis=1).sum()
    )
    assert (faces[:, 3] < 0).all() == tetrahedra


def test_hexahedra_are_those_of_calculix():
    """Against the C3D8 of the tests: two blocks by hand, and the same two from meshes."""
    K, dofs = solids.stiffness(solids.places())
    sets = solids.node_sets()
    pairs = np.column_stack([sets["UPPER_FOOT"], sets["LOWER_TOP"]])
    expected = condensed_stiffness(K, dofs, pairs, [0, 0, 1]).stiffness
    joint = contact_problem(block(), "bottom", 0.4, against=(block(lower=True), "top"))
    place = solids.places()[sets["UPPER_FOOT"] - 1]
    order = [int(np.argmin(np.linalg.norm(joint.coordinates - p, axis=1))) for p in place]
    rows = joint.layout.of_nodes(order)
    size = np.abs(expected).max()
    np.testing.assert_allclose(joint.kappa[np.ix_(rows, rows)], expected, rtol=0, atol=1e-12 * size)
    np.testing.assert_allclose(joint.q_w[0].reshape(-1, 2).sum(axis=0), [-24.0, -12.0])
    assert joint.p_w[0].sum() == pytest.approx(120.0)


def deck(lower, upper):
    """Both bodies for CalculiX: C3D4 or C3D10, labels from 1, those of the upper body after the lower one's."""
    nodes, elements, sets, shift = [], [], {}, 1
    for name, body, foot, top in (("L", lower, "bottom", "top"), ("U", upper, "bottom", "top")):
        count = body.dofs[:, 0].max() + 1
        nodes += body.positions(np.arange(count)).tolist()
        corners = body.mesh.t.copy()
        turned = np.linalg.det(np.diff(body.mesh.p[:, corners], axis=1).T) < 0
        corners[:2, turned] = corners[1::-1, turned]
        parts = [corners]
        if body.order == 2:  # between the corners 1-2, 2-3, 3-1, 1-4, 2-4, 3-4
            number = {tuple(sorted(e)): k for k, e in enumerate(body.mesh.edges.T.tolist())}
            for a, b in ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)):
                pairs = np.sort(corners[[a, b]].T, axis=1).tolist()
                parts.append(np.array([[body.mesh.nvertices + number[tuple(pair)] for pair in pairs]]))
        elements += (np.vstack(parts).T + shift).tolist()
        for end, boundary in (("FOOT", foot), ("TOP", top)):
            sets[f"{name}_{end}"] = body.normals_on(boundary)[0] + shift
        shift += count
    kind = f"C3D{4 if lower.order == 1 else 10}"
    return writers.calculix_deck(nodes, elements, sets, kind, more=["*BOUNDARY", "L_FOOT, 1, 3"]), sets


@needs_ccx
@pytest.mark.parametrize(
    ("order", "digits"), [(1, 1e-12), (2, 1e-8)]
)  # C3D10 of ccx has nine-digit constants
def test_tetrahedra_of_calculix_condense_to_the_same_joint(tmp_path, order, digits):
    lower, upper = (block(k, order=order, tetrahedra=True, counts=(2, 1, 1)) for k in (True, False))
    text, sets = deck(lower, upper)
    (tmp_path / "job.inp").write_text(text)
    ccx(tmp_path, "job")
    config = 'friction = 0.4\n[model]\nfile = "job.inp"\n[stiffness]\nfile = "job.sti"\n[contact]\npairs = ["U_FOOT", "L_TOP"]\n'
    (tmp_path / "c.toml").write_text(
        f"{config}[[load]]\nforces = [[{sets['U_TOP'][0]}, 3, -1.0]]\nhistory = 1.0\n"
    )
    found = import_model(tmp_path / "c.toml")
    expected = contact_condensation(upper, "bottom", against=(lower, "top"))
    size = np.abs(expected.stiffness).max()
    np.testing.assert_allclose(found.condensation.stiffness, expected.stiffness, rtol=0, atol=digits * size)
    assert found.condensation.zero_modes == expected.zero_modes == 6


def test_a_bolt_presses_by_its_preload_and_its_shank_holds():
    lower, upper = block(lower=True), block()
    bolt = Bolt(head="top", preload=500.0)
    joint = contact_problem(upper, "bottom", 0.4, bolts=[bolt])
    assert joint.p_w[0].sum() == pytest.approx(500.0 + 120.0)
    assert joint.load_names == ("force", "force", "bolt")
    both = contact_problem(
        upper, "bottom", 0.4, against=(lower, "top"), bolts=[Bolt(head="top", nut="bottom", preload=500.0)]
    )
    assert both.p_w[0].sum() == pytest.approx(620.0)
    assert json.loads(both.source)["bolts"][0]["preload"] == 500.0
    alone = contact_condensation(upper, "bottom")
    held = contact_condensation(upper, "bottom", bolts=[Bolt(head="top", stiffness=1e4)])
    assert (alone.zero_modes, held.zero_modes) == (6, 5)  # stretches by u_z of the head only, on average
    added = held.stiffness - alone.stiffness
    values = np.linalg.eigvalsh(0.5 * (added + added.T))
    assert values[-1] > 0
    np.testing.assert_allclose(values[:-1], 0.0, atol=1e-9 * values[-1])  # one spring
    with pytest.raises(ProblemError, match="bolt 'top': expected no nut on a rigid obstacle, found 'bottom'"):
        contact_problem(upper, "bottom", 0.4, bolts=[Bolt(head="top", nut="bottom")])


def test_a_rigid_boundary_knows_resultants_only():
    """Two tractions of one force and one moment: the same reactions, unless the boundary is elastic."""
    centre = 1.0
    even = Traction("top", (0.0, 0.0, lambda x: -1.0 - (x[0] - centre)), history=1.0)
    uneven = Traction("top", (0.0, 0.0, lambda x: -1.0 - (x[0] - centre) ** 3 / 0.6), history=1.0)
    fine = {"counts": (4, 1, 1)}
    for rigid, same in (((), False), (("top",), True)):
        one, other = (
            contact_problem(block(loads=[load], rigid=rigid, **fine), "bottom", 0.4)
            for load in (even, uneven)
        )
        size = np.abs(one.p_w).max()
        assert (np.abs(one.p_w - other.p_w).max() < 1e-3 * size) == same
        np.testing.assert_allclose(one.p_w.sum(), 3.0)
    found = contact_condensation(block(rigid=("top",), **fine), "bottom")
    assert (found.zero_modes, found.interior) == (6, 6)
    plane = ElasticBody(
        block_mesh(2.0, 1.0, 4, 2), STEEL, loads=[Force("top", (0.0, -5.0), history=1.0)], rigid=["top"]
    )
    pressed = contact_problem(plane, "bottom", 0.4)
    assert pressed.p_w.sum() == pytest.approx(5.0)
    assert contact_condensation(plane, "bottom").zero_modes == 3


def test_the_lap_joint_carries_its_load_and_is_pressed_alike_on_both_sides():
    """Sideways the contact alone carries the load at the tip, 360 mm from the middle of the lap."""
    joint = lap_joint((12, 2, 1), steps=4)
    assert (joint.n, joint.p_w.min() > 0) == (27, True)
    pressed = joint.p_w.mean(axis=0)
    q = joint.layout.by_node(joint.q_w[0] - joint.q_w.mean(axis=0))
    on_left = np.einsum("nk,nkj->nj", q, joint.tangents) + (joint.p_w[0] - pressed)[:, None] * joint.normal
    np.testing.assert_allclose(on_left.sum(axis=0), [0.0, 10.0, 0.0], atol=1e-8)
    moment = np.cross(joint.coordinates - [360.0, 12.7, 12.7], on_left).sum(axis=0)
    np.testing.assert_allclose(moment, [0.0, 0.0, 3600.0], atol=1e-5)
    across = [
        int(np.argmin(np.linalg.norm(joint.coordinates - [x, 25.4 - y, z], axis=1)))
        for x, y, z in joint.coordinates
    ]
    np.testing.assert_allclose(pressed[across], pressed, rtol=1e-7)


PRESS = [Pressure("top", 3.0, history=1.0)]


def plane(count, *, upper, order=1, poisson=0.0, loads=PRESS):
    mesh = block_mesh(2.0, 1.0, count, 2, origin=(0.0, 0.0 if upper else -1.0))
    more = {"loads": loads} if upper else {"supports": [Support("bottom")]}
    return ElasticBody(mesh, Material(1.0, poisson), order=order, **more)


def solid(counts, *, upper, order=1, tetrahedra=False, poisson=0.0, loads=PRESS):
    mesh = brick_mesh((2.0, 1.5, 1.0), counts, origin=(0, 0, 1.0 if upper else 0.0), tetrahedra=tetrahedra)
    more = {"loads": loads} if upper else {"supports": [Support("bottom")]}
    return ElasticBody(mesh, Material(1.0, poisson), order=order, **more)


BODIES = {
    "2:3": (plane(4, upper=True), plane(6, upper=False)),
    "3:2": (plane(6, upper=True), plane(4, upper=False)),
    "1:2.7": (plane(3, upper=True), plane(8, upper=False)),
    "quadratic": (plane(3, upper=True, order=2), plane(4, upper=False, order=2)),
    "hexahedra": (solid((2, 2, 1), upper=True), solid((3, 2, 1), upper=False)),
    "tetrahedra": (
        solid((2, 2, 1), upper=True, tetrahedra=True),
        solid((3, 2, 1), upper=False, tetrahedra=True),
    ),
    "tetrahedra on hexahedra": (solid((2, 2, 1), upper=True, tetrahedra=True), solid((3, 2, 1), upper=False)),
    "C3D10": (
        solid((2, 1, 1), upper=True, tetrahedra=True, order=2),
        solid((1, 2, 1), upper=False, tetrahedra=True, order=2),
    ),
}


def mortar(name, **more):
    upper, lower = BODIES[name]
    return contact_problem(upper, "bottom", 0.4, **{"against": (lower, "top"), "coupling": "mortar"} | more)


@pytest.mark.parametrize("name", BODIES)
def test_a_constant_pressure_arrives_and_nothing_resists_rigid_motions(name):
    upper, lower = BODIES[name]
    joint = mortar(name)
    np.testing.assert_allclose(joint.p_w[0], 3.0 * joint.node_area, rtol=1e-12)
    np.testing.assert_allclose(joint.q_w, 0.0, atol=1e-12)
    found = contact_condensation(upper, "bottom", against=(lower, "top"), coupling="mortar")
    assert found.zero_modes == (3 if upper.dimension == 2 else 6)
    assert found.asymmetry < 1e-13
    values = np.linalg.eigvalsh(found.stiffness)
    assert values[0] > -1e-12 * values[-1]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: block(thickness=2.0), "expected of a plane body only, found a solid one"),
        (lambda: block(rigid=["lid"]), "boundary 'lid': not in the mesh"),
        (lambda: contact_problem(block(rigid=["bottom"]), "bottom", 0.4), "'bottom': expected free nodes, found node 0 in contact"),
        (lambda: contact_problem(block(rigid=["right"]), "bottom", 0.4), r"'right': expected free nodes, found node \d+ in contact"),
        (lambda: contact_problem(block(loads=[Force("top", (1.0, 2.0), history=1.0)]), "bottom", 0.4), "Force: expected one component for each of 3 directions, found 2"),
        (lambda: Bolt(head="top", stiffness=-1.0), "Bolt: expected a finite preload and a stiffness >= 0"),
        (lambda: brick_mesh((1.0, 1.0, 0.0), (1, 1, 1)), "block: expected finite sides > 0"),
        (lambda: contact_problem(block(), "bottom", 0.4, against=(ElasticBody(block_mesh(2.0, 1.0, 3, 2), STEEL), "top")), "expected two plane bodies or two solid ones"),
        (lambda: mortar("2:3", coupling="nodes"), "expected matching nodes on both bodies, found 5 and 7 nodes"),
        (lambda: contact_problem(BODIES["2:3"][0], "bottom", 0.4, coupling="mortar"), "expected a second body beside 'mortar'"),
        (lambda: mortar("2:3", coupling="nodes", reach=1.0), "coupling, reach: expected a second body"),
        (lambda: mortar("2:3", against=(BODIES["hexahedra"][1], "top")), "expected two plane bodies or two solid ones"),
        (lambda: mortar("2:3", gap="coordinates"), "gap: expected real numbers, found 'coordinates'"),
        (lambda: contact_problem(BODIES["2:3"][0], "bottom", np.nan), "f: expected finite numbers, found nan"),
    ],
)  # fmt: skip
def test_one_thing_wrong_is_named(make, message):
    with pytest.raises(ShakedownError, match=message):
        make()


DENSE = Material(100.0, 0.3, density=2.0)
LENGTHS, COUNTS = (4.0, 1.0), (8, 2)


def pair(solid=False, *, supports=(), press=1.0, material=DENSE):
    """Two blocks one on the other, pressed together; and the same as one block."""
    if solid:
        counts, size = (3, 2, 1), (3.0, 1.0, 0.5)
        upper, lower = (brick_mesh(size, counts, origin=(0.0, 0.0, z)) for z in (0.5, 0.0))
        whole = brick_mesh((3.0, 1.0, 1.0), (3, 2, 2))
    else:
        upper, lower = (block_mesh(*LENGTHS, *COUNTS, origin=(0.0, y)) for y in (1.0, 0.0))
        whole = block_mesh(LENGTHS[0], 2 * LENGTHS[1], COUNTS[0], 2 * COUNTS[1])
    loads = [[Pressure(face, press, history=1.0)] for face in ("top", "bottom")]
    return (
        ElasticBody(upper, material, loads=loads[0], supports=supports),
        ElasticBody(lower, material, loads=loads[1], supports=supports),
        ElasticBody(whole, material, supports=supports),
    )


def frequencies(body):
    """All circular frequencies of a body, densely."""
    free = np.setdiff1d(np.arange(body.basis.N), body.held_rows())
    K, M = (matrix.toarray()[np.ix_(free, free)] for matrix in (body.stiffness, mass_of(body)))
    return np.sqrt(np.maximum(eigh(K, M, eigvals_only=True), 0))


@pytest.mark.parametrize(("solid", "held", "rigid"), [(False, False, 3), (False, True, 0), (True, False, 6)])
def test_with_its_contact_stuck_a_pair_vibrates_as_one_body(solid, held, rigid):
    """Rigid motions of a free one do not count; the mass is that of the bodies, the shape has mass one."""
    first, second, whole = pair(solid, supports=[Support("left")] if held else [])
    expected = frequencies(whole)[rigid : rigid + 3]
    found = [modal_load(first, "bottom", k, against=(second, "top")) for k in range(2)]
    np.testing.assert_allclose([load.frequency for load in found], expected[:2], rtol=1e-8)
    for load in found:
        assert load.free is not held
        assert load.shape @ load.force == pytest.approx(1.0, rel=1e-10)


def test_at_rest_a_mode_has_its_frequency_and_above_it_falls_and_damps():
    """Nothing supports the pair: what holds it while it is condensed bears nothing, and is told."""
    first, second, _ = pair()
    load = modal_load(first, "bottom", against=(second, "top"))
    joint = contact_problem(first, "bottom", 0.3, against=(second, "top"), modal=[load], steps=16)
    assert joint.load_names == ("pressure", "pressure", "mode 0")
    assert np.isnan(joint.load_frequency).tolist() == [True, True, False]
    origin = json.loads(joint.source)
    assert "for the condensation alone" in origin["free"]
    assert origin["modes"] == [{"mode": 0, "frequency": load.frequency}]
    curve = damping(joint, [0.1, 1.0, 4.0, 5.0], load="mode 0")
    np.testing.assert_allclose(curve.frequency[0], load.frequency, rtol=1e-8)
    assert curve.dissipation[0] == 0
    assert curve.proved[0]
    assert curve.frequency[-1] < 0.999 * load.frequency
    assert curve.damping_ratio[-1] > 1e-4


def test_nodes_that_the_preload_leaves_open_are_open_in_the_mode():
    first, second, _ = pair()
    stuck = modal_load(first, "bottom", against=(second, "top"))
    opened = modal_load(first, "bottom", against=(second, "top"), open_nodes=[0, 1])
    assert opened.frequency < stuck.frequency


WRONG = {
    "no density": ({"material": Material(100.0, 0.3)}, {}, "material: expected a density for a mode, found none"),
    "no such mode": ({}, {"mode": 10**6}, "mode: expected a number from 0 to"),
    "no such node": ({}, {"open_nodes": [99]}, "open nodes: expected node numbers from 0 to 8, found 99"),
}  # fmt: skip


@pytest.mark.parametrize(("bodies", "asked", "line"), WRONG.values(), ids=WRONG)
def test_what_is_no_mode_is_said(bodies, asked, line):
    first, second, _ = pair(**bodies)
    with pytest.raises(shakedown.ShakedownError, match=line):
        modal_load(first, "bottom", **({"against": (second, "top")} | asked))


def test_loads_out_of_balance_on_a_free_structure_are_named():
    first, second, _ = pair()
    pushed = ElasticBody(first.mesh, DENSE, loads=[Force(boundary="top", value=(1.0, 0.0), history=1.0)])
    message = "loads: expected loads in equilibrium, as nothing supports the bodies"
    with pytest.raises(ProblemError, match=message):
        contact_problem(pushed, "bottom", 0.3, against=(second, "top"))
