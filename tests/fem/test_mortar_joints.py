"""Bodies whose meshes do not match: patch test, rigid motions, matching meshes, quadratic elements, a press fit."""

import numpy as np
import pytest
from skfem import MeshQuad

from shakedown import ProblemError, UsageError
from shakedown.fem import (
    ElasticBody,
    Force,
    Material,
    Pressure,
    Support,
    block_mesh,
    brick_mesh,
    contact_condensation,
    contact_problem,
)

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


@pytest.mark.parametrize("name", BODIES)
def test_a_constant_pressure_arrives_and_nothing_resists_rigid_motions(name):
    upper, lower = BODIES[name]
    joint = contact_problem(upper, "bottom", 0.4, against=(lower, "top"), coupling="mortar")
    np.testing.assert_allclose(joint.p_w[0], 3.0 * joint.node_area, rtol=1e-12)
    np.testing.assert_allclose(joint.q_w, 0.0, atol=1e-12)
    found = contact_condensation(upper, "bottom", against=(lower, "top"), coupling="mortar")
    assert found.zero_modes == (3 if upper.dimension == 2 else 6)
    assert found.asymmetry < 1e-13
    values = np.linalg.eigvalsh(found.stiffness)
    assert values[0] > -1e-12 * values[-1]


@pytest.mark.parametrize(
    ("upper", "lower"),
    [
        (plane(4, upper=True, poisson=0.3), plane(4, upper=False, poisson=0.3)),
        (solid((2, 2, 1), upper=True, poisson=0.3), solid((2, 2, 1), upper=False, poisson=0.3)),
        tuple(solid((1, 1, 1), upper=up, tetrahedra=True, order=2, poisson=0.3) for up in (True, False)),
    ],
)
def test_matching_meshes_are_pairs(upper, lower):
    one, other = (
        contact_problem(upper, "bottom", 0.4, against=(lower, "top"), coupling=how)
        for how in ("mortar", "nodes")
    )
    np.testing.assert_allclose(one.kappa, other.kappa, rtol=0, atol=1e-13 * np.abs(other.kappa).max())
    np.testing.assert_allclose(one.p_w, other.p_w, rtol=0, atol=1e-12)
    np.testing.assert_allclose(one.node_area, other.node_area, rtol=1e-12)


def ring(inner, outer, count, layers, *, upper):
    """A whole ring of quadrilaterals, plane strain."""
    radius, angle = np.linspace(inner, outer, layers + 1), np.linspace(0, 2 * np.pi, count + 1)[:-1]
    places = np.array([[r * np.cos(a), r * np.sin(a)] for r in radius for a in angle]).T
    k = np.arange(layers * count).reshape(layers, count)
    after = np.roll(k, -1, axis=1)
    cells = np.stack([k, k + count, after + count, after]).reshape(4, -1)
    mesh = MeshQuad(places, cells)
    size = (outer - inner) / layers
    mesh = mesh.with_boundaries(
        {
            "bore": lambda x: np.hypot(*x) < inner + 0.4 * size,
            "seat": lambda x: np.hypot(*x) > outer - 0.4 * size,
        }
    )
    turn = [Force("seat", (1.0, 0.0), history=[1.0, 0.0])] if upper else []
    more = {"loads": turn} if upper else {"supports": [Support("bore")]}
    return ElasticBody(mesh, Material(210e3, 0.3), **more)


@pytest.mark.parametrize(("hub", "shaft"), [(24, 36), (36, 24)])
def test_a_press_fit_has_the_pressure_of_a_thick_ring(hub, shaft):
    """Interference 0.02 at R = 20: Lamé's pressure, the same everywhere, whatever the meshes."""
    outer, inner = ring(20, 40, hub, 6, upper=True), ring(10, 20, shaft, 4, upper=False)
    joint = contact_problem(
        outer, "bore", 0.3, against=(inner, "seat"), coupling="mortar", reach=1.0, gap=-0.02
    )
    pressure = joint.p_w[1] / joint.node_area
    np.testing.assert_allclose(pressure, pressure.mean(), rtol=0.01)
    found = contact_condensation(outer, "bore", against=(inner, "seat"), coupling="mortar", reach=1.0)
    assert found.zero_modes == 3
    # Lamé, plane strain: the hub is free outside, the shaft held at its bore
    young, poisson, a, b, c = 210e3, 0.3, 10.0, 20.0, 40.0
    hub_gives = b * (1 + poisson) / young * ((1 - 2 * poisson) * b**2 + c**2) / (c**2 - b**2)
    shaft_gives = (
        b * (1 + poisson) / young * (1 - 2 * poisson) * (b**2 - a**2) / (b**2 + (1 - 2 * poisson) * a**2)
    )
    assert pressure.mean() == pytest.approx(0.02 / (hub_gives + shaft_gives), rel=0.02)


@pytest.mark.parametrize("coupled", [False, True])
def test_half_of_a_joint_on_a_plane_of_symmetry_is_half_of_the_whole(coupled):
    """Pressed and sheared along x in the plane y = 0: nodes there have half the reactions of the whole."""
    loads = [Force("top", (3.0, 0.0, -20.0), history=1.0)]
    joints = []
    for width, low in ((2.0, -1.0), (1.0, 0.0)):
        upper, lower = (
            brick_mesh((2.0, width, 1.0), (nx, round(ny * width), 1), origin=(0, low, z))
            for nx, ny, z in ((2, 1, 1.0), (3, 2, 0.0))
        )
        guide = [] if low else [Support("front", x=False, z=False)]
        own = loads if low else [Force("top", (1.5, 0.0, -10.0), history=1.0)]
        above = ElasticBody(upper, Material(1.0, 0.3), supports=guide, loads=own)
        below = ElasticBody(lower, Material(1.0, 0.3), supports=[Support("bottom"), *guide])
        how = {"against": (below, "top"), "coupling": "mortar"} if coupled else {}
        joints.append(contact_problem(above, "bottom", 0.4, **how))
    whole, half = joints
    held = contact_condensation(above, "bottom", **how).notes[0]
    assert "3 contact node(s) are held along a tangent" in held
    for k, place in enumerate(half.coordinates):
        j = int(np.argmin(np.linalg.norm(whole.coordinates - place, axis=1)))
        share = 0.5 if place[1] == 0 else 1.0
        assert half.p_w[0, k] == pytest.approx(share * whole.p_w[0, j], rel=1e-9)
        assert half.q_w[0, 2 * k] == pytest.approx(share * whole.q_w[0, 2 * j], rel=1e-8, abs=1e-9)


def test_what_cannot_be_coupled_is_refused():
    upper, lower = BODIES["2:3"]
    with pytest.raises(ProblemError, match="expected matching nodes on both bodies, found 5 and 7 nodes"):
        contact_problem(upper, "bottom", 0.4, against=(lower, "top"))
    with pytest.raises(ProblemError, match="expected a second body beside 'mortar'"):
        contact_problem(upper, "bottom", 0.4, coupling="mortar")
    with pytest.raises(ProblemError, match="coupling, reach: expected a second body"):
        contact_problem(upper, "bottom", 0.4, against=(lower, "top"), reach=1.0)
    with pytest.raises(ProblemError, match="expected two plane bodies or two solid ones"):
        contact_problem(upper, "bottom", 0.4, against=(BODIES["hexahedra"][1], "top"), coupling="mortar")
    with pytest.raises(UsageError, match="gap: expected real numbers, found 'coordinates'"):
        contact_problem(upper, "bottom", 0.4, against=(lower, "top"), coupling="mortar", gap="coordinates")
    with pytest.raises(UsageError, match="f: expected finite numbers, found nan"):
        contact_problem(upper, "bottom", np.nan)
