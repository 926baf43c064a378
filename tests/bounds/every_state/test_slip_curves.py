"""How far the curve of directions of slip reaches, against samples of it."""

import numpy as np
import pytest

from shakedown.bounds.every_state.least_pressures import SlipCurves

ANGLES = 2 * np.pi * np.arange(20_000) / 20_000


def curves(rng: np.random.Generator, count: int) -> tuple[SlipCurves, np.ndarray]:
    """Curves of every size beside their lean, and vectors, many of them nearly opposed to the lean."""
    long, angle = rng.uniform(0.0, 1.0, count), rng.uniform(0.0, 7.0, count)
    long[: count // 8] = 0.0
    lean = long[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    towards = angle + np.where(
        rng.random(count) < 0.5, np.pi + rng.choice([0.0, 1e-15, 1e-8, 1e-3], count), rng.uniform(0, 7, count)
    )
    size = np.maximum(1.0 - long, 2e-3)
    y = rng.uniform(0.5, 2.0, count)[:, None] * np.stack([np.cos(towards), np.sin(towards)], axis=1)
    return SlipCurves(size, lean, np.zeros(count)), y


def test_the_reach_is_that_of_samples_and_the_farthest_point_is_on_the_curve():
    found, y = curves(np.random.default_rng(0), 400)
    u = np.stack([np.cos(ANGLES), np.sin(ANGLES)])
    sampled = ((found.size[:, None] + found.lean @ u) * (y @ u)).max(axis=1)
    reach, point = found.reach(y), found.farthest(y)
    assert np.all(reach >= sampled - 1e-14)
    np.testing.assert_allclose(reach, sampled, atol=1e-6)
    np.testing.assert_allclose(np.sum(point * y, axis=1), reach, atol=1e-12)


@pytest.mark.parametrize("d", [1, 2])
def test_the_origin_lies_between_the_points_around_it(d):
    if d == 2:
        found, _ = curves(np.random.default_rng(1), 400)
    else:
        lean = np.random.default_rng(2).uniform(-0.4, 0.4, (50, 1))
        found = SlipCurves(1.0 - np.abs(lean[:, 0]), lean, np.zeros(50))
    points = np.moveaxis(found.around(), 0, 1)
    rows = np.concatenate([points, np.ones((*points.shape[:2], 1))], axis=2).swapaxes(1, 2)
    weights = np.linalg.solve(rows, np.append(np.zeros(d), 1.0)[:, None] * np.ones((len(rows), 1, 1)))
    assert weights.min() > 0
