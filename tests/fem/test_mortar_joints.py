"""Bodies whose meshes do not match: patch test, rigid motions, matching meshes, quadratic elements, a press fit."""

import numpy as np
import pytest

from shakedown import ProblemError, UsageError
from shakedown.fem import (
    ElasticBody,
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
