"""Press fit, lines, spheres and half-spaces against Lamé, Hertz, Cattaneo, Mindlin, Deresiewicz, Wetter, Popov and Love."""

import numpy as np
import pytest

import shakedown
from benchmarks.bodies.classical import hertz
from benchmarks.bodies.patch_compliance import half_space_compliance, mean_half_space_compliance
from benchmarks.bodies.sphere import disc_patches, half_spaces, sphere_contact, sphere_on_flat
from benchmarks.classical_contacts import line_contact_errors, permanent_stick, press_fit_errors
from shakedown.motion.evolution import evolve


def test_the_press_fit_converges_to_lames_pressure_with_order_two():
    errors = [press_fit_errors(k)["pressure"] for k in (1, 2, 4)]
    assert errors[0] < 2e-3
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx([2, 2], abs=0.25)


@pytest.mark.slow
def test_the_line_contact_converges_to_hertz_and_to_cattaneo_and_mindlin():
    coarse, fine = line_contact_errors(1), line_contact_errors(4)
    assert 0.3 < fine["utilisation"] < 0.9
    assert fine["peak"] < 3e-3  # the bodies are 100 half-widths wide, not infinite
    for key, order in (("pressure", 1.3), ("shear", 1.0)):
        assert np.log2(coarse[key] / fine[key]) / 2 > order
    assert fine["contact_edge"] < 1.0
    assert fine["stick_edge"] < 1.0


def test_hertz_shear_has_the_force_it_is_given_and_no_slip_without_it():
    sheared = hertz(0.02, 0.003, 0.3)
    x = np.linspace(-1.5, 1.5, 200_001)
    assert np.trapezoid(sheared.shear(x, 0.3), x) == pytest.approx(0.003, rel=1e-5)
    assert hertz(0.02).stick == hertz(0.02).half_width


@pytest.mark.parametrize("phase", [0.25, 0.0])
def test_what_never_slips_is_the_contact_under_the_force_where_the_tangents_of_the_loop_meet(phase):
    found = permanent_stick(2, phase)
    assert 0.5 < found["half_width"] < 0.8
    assert found["apart"] < 1.0


F = 0.5


def area(polygon):
    x, y = polygon.T
    return 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))


def test_the_patches_are_those_of_the_disc():
    patches, edges = disc_patches(3)
    assert len(patches) == 37
    areas = np.array([area(patch) for patch in patches])
    counts = np.array([1, 6, 12, 18])
    assert areas == pytest.approx(np.repeat(np.pi * np.diff(edges**2) / counts, counts), rel=1e-12)


def test_the_classical_solution_is_one():
    contact, force = sphere_contact(F, poisson=0.3), 0.8 * F
    edges = np.linspace(0, 1, 2001)
    assert contact.held_back(edges, force).sum() == pytest.approx(force)
    middle = (edges[1:] + edges[:-1]) / 2
    assert (contact.pressure(middle) * np.diff(np.pi * edges**2)).sum() == pytest.approx(1, rel=1e-5)
    forces = np.linspace(0, force, 4001)
    pushed = np.array([contact.displacement(each) for each in forces])
    lens = (
        8 * np.trapezoid(forces, pushed) - 4 * force * pushed[-1]
    )  # Masing: the loop is the first push, doubled
    assert contact.dissipation(force) == pytest.approx(lens, rel=1e-5)


def test_cycles_are_mindlins_in_every_direction():
    contact, works = sphere_contact(F), []
    for direction in (0.0, 0.4):
        run = evolve(sphere_on_flat(4, shear=0.6, direction=direction, f=F), 1.0, cycles=2)
        works.append(run.cycles[1].friction_dissipation)
    assert works[1:] == pytest.approx(works[:1], rel=1e-10)
    most = contact.dissipation(F)  # errors are a share of that times the square of a ring's width
    assert works[0] == pytest.approx(contact.dissipation(0.6 * F), abs=most / 4.5**2)
    crest = int(np.argmin(np.abs(run.history.cycle - 0.25)))
    held = np.hypot(*run.history.q[crest].reshape(-1, 2).T)
    _, edges = disc_patches(4)
    rings = np.add.reduceat(held, np.cumsum([0, 1, 6, 12, 18]))
    assert np.abs(rings - contact.held_back(edges, 0.6 * F)).sum() < 0.05 * 0.6 * F


def rolled_sphere(shear, direction, *, size=0.4, amplitude=0.3, poisson=0.3, steps=8):
    """A sphere rolled to and fro under a constant tangential force, f times ``shear`` of the normal one.

    Square patches are laid over all that the contact reaches, askew, so that no line of them meets its edge
    at once; which of them touch follows from the gaps. Transient load steps put the tangential force on before.
    """
    skew, reach = (
        np.array([[np.cos(0.4), np.sin(0.4)], [-np.sin(0.4), np.cos(0.4)]]),
        int((1 + amplitude) / size) + 3,
    )
    line = size * np.arange(-reach, reach + 1)
    centres = np.array([(x, y) for y in line for x in line]) @ skew
    beside = np.maximum(np.abs(centres[:, 0]) - amplitude, 0.0)
    centres = centres[np.hypot(beside, centres[:, 1]) < 1 + size]
    square = size / 2 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) @ skew
    along, across = half_spaces([centre + square for centre in centres], poisson)
    curvature = 1.5 * (1 - poisson**2)  # 1/R = 3 N/4 E* a³, E* = E/2(1 − ν²)
    places = amplitude * np.sin(2 * np.pi * np.arange(steps) / steps)
    gaps = [
        ((centres - [at, 0.0]) ** 2).sum(axis=1) * curvature / 2 + size**2 * curvature / 12 for at in places
    ]
    pressed = across.reactions[:, 0] - np.array(gaps) @ across.stiffness  # symmetric
    sheared = -along.reactions @ (shear * F * np.array([np.cos(direction), np.sin(direction)]))
    n, first = len(centres), np.linspace(0.0, 1.0, 5)
    return shakedown.Problem(
        A=along.stiffness, B=np.zeros((n, 2 * n)), C=across.stiffness, f=F, x=centres,
        q_w=np.tile(sheared, (steps, 1)), p_w=pressed,
        q_transient=np.outer(first, sheared), p_transient=np.tile(pressed[0], (len(first), 1)),
    )  # fmt: skip


def test_the_rolled_sphere_is_held_below_the_limit_and_creeps_above_it():
    """The limit, over f N of a sphere rolled by ±w: the integral of the least pressure at each place (Wetter, Popov)."""
    w = 0.3
    limit = 1.0 - 1.5 * w + 0.5 * w**3
    below, above = (
        shakedown.simulate(rolled_sphere(share * limit, 0.4, amplitude=w), 1.0, cycles=60)
        for share in (0.9, 1.2)
    )
    assert below.outcome == "separation"  # squares open and close; none slips
    assert above.outcome == "ratchetting"
    crept = above.drift.reshape(-1, 2)
    assert crept == pytest.approx(np.tile(crept[0], (len(crept), 1)), abs=1e-6)  # as one body
    assert np.arctan2(*crept[0][::-1]) == pytest.approx(0.4, abs=0.05)


TRIANGLE = np.array([[0.2, 0.1], [1.3, 0.4], [0.6, 1.5]])
HOOK = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 0.5], [0.0, 1.0]])
POISSON = 0.27


def point_force(apart):
    """Displacements by a unit force, E = 1 (Johnson, 3.2 and 3.6), z into the half-space."""
    (x, y), nu = apart, POISSON
    r = np.hypot(x, y)
    across = (1 - 2 * nu) / 2
    found = [
        [(1 - nu) / r + nu * x * x / r**3, nu * x * y / r**3, -across * x / r**2],
        [nu * x * y / r**3, (1 - nu) / r + nu * y * y / r**3, -across * y / r**2],
        [across * x / r**2, across * y / r**2, (1 - nu) / r],
    ]
    return np.array(found) * (1 + nu) / np.pi


def integrated(point, polygon):
    """Gauss' rule along the edges of point forces over the triangles from the point to each edge."""
    places, weights = np.polynomial.legendre.leggauss(80)
    total, area = np.zeros((3, 3)), 0.0
    for a, b in zip(polygon - point, np.roll(polygon, -1, axis=0) - point, strict=True):
        twice = a[0] * b[1] - a[1] * b[0]
        area += twice / 2
        if abs(twice) > 1e-12:
            ways = a + (b - a) * (places[:, None] + 1) / 2
            total += twice * sum(
                weight / 2 * point_force(-way) for way, weight in zip(ways, weights, strict=True)
            )
    return total / area


@pytest.mark.parametrize("point", [(2.0, -1.0), (0.7, 0.6), (0.75, 0.25), (0.2, 0.1), (-3.0, 0.4)])
@pytest.mark.parametrize("polygon", [TRIANGLE, HOOK], ids=["triangle", "hook"])
def test_a_polygon_has_the_integral_of_its_point_forces(point, polygon):
    found = half_space_compliance([point], [polygon], poisson=POISSON)
    assert found == pytest.approx(integrated(np.array(point), polygon), abs=1e-7)
    assert half_space_compliance([point], [polygon[::-1]], poisson=POISSON) == pytest.approx(found, abs=1e-15)


def test_the_mean_of_a_square_is_known():
    square = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    diagonal = np.sqrt(2)
    exact = 4 * (np.log(1 + diagonal) + (1 - diagonal) / 3) * (1 - POISSON**2) / np.pi
    assert mean_half_space_compliance([square], poisson=POISSON)[2, 2] == pytest.approx(exact, rel=7e-3)
    quarters = [0.5 * (square + shift) for shift in square]
    parts = mean_half_space_compliance(quarters, poisson=POISSON)[2::3, 2::3]
    assert parts.mean() == pytest.approx(exact, rel=3e-3)  # errors at the edges between patches cancel
