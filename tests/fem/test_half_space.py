"""Half-space compliance of polygons against an independent integration, Love, rotation and reciprocity."""

import numpy as np
import pytest

from benchmarks.bodies.patch_compliance import half_space_compliance, mean_half_space_compliance

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
