"""A ring, and rolling elements that run round in it: laws of mechanics, on meshes that do not fit them."""

from dataclasses import replace

import numpy as np
import pytest

from shakedown import ProblemError
from shakedown.fem import ElasticBody, Material, Pressure, RollingLoad, contact_problem, ring_mesh

STEEL = Material(206e3, 0.3)


def ring(around, order=1, **more):
    return ElasticBody(ring_mesh(35.0, 40.0, around, 2), STEEL, plane="stress", order=order, **more)


def test_a_ring_in_a_rigid_housing_bears_the_pressure_of_lame():
    body = ring(96, 2, loads=[Pressure("inside", 0.0, history=1.0)])
    joint = contact_problem(body, "outside", 0.2, gap=-1e-3, steps=1)
    stiffness = 206e3 / 40.0 / ((40.0**2 + 35.0**2) / (40.0**2 - 35.0**2) - 0.3)
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
