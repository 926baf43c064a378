"""Many small cones in one vector: their products, scalings and reaches are those of the cones one by one."""

import numpy as np
import pytest

from shakedown.ground.status import Status
from shakedown.programs.cones import Cones
from shakedown.programs.disc_program import DiscProgram
from shakedown.programs.self_dual import inner_point, solve_self_dual


def inside(rng: np.random.Generator) -> np.ndarray:
    """A point inside four triples, two numbers and a cone of five."""
    triples, large = rng.normal(size=(4, 3)), rng.normal(size=5)
    triples[:, 0] = np.hypot(triples[:, 1], triples[:, 2]) + rng.uniform(1e-3, 2.0, 4)
    large[0] = np.linalg.norm(large[1:]) + rng.uniform(1e-3, 2.0)
    return np.concatenate([triples.ravel(), rng.uniform(0.1, 2.0, 2), large])


@pytest.mark.parametrize("seed", range(5))
def test_as_cones_one_by_one(seed):
    rng = np.random.default_rng(seed)
    cones, one, large = Cones(4, 2, 5), Cones(1, 0), Cones(0, 0, 5)
    s, z, step = inside(rng), inside(rng), rng.normal(size=19)
    np.testing.assert_allclose(cones.product(s, cones.quotient(s, z)), z, rtol=1e-9)
    scaling = cones.scaling(s, z)
    np.testing.assert_allclose(scaling.times(z), scaling.point, rtol=1e-10)
    np.testing.assert_allclose(scaling.divided(s), scaling.point, rtol=1e-10)
    np.testing.assert_allclose(scaling.divided(scaling.times(step)), step, rtol=1e-9, atol=1e-12)
    parts, head, last = [slice(3 * j, 3 * j + 3) for j in range(4)], slice(12, 14), slice(14, 19)
    for square, part in zip(scaling.inverse_squares(), parts, strict=True):
        np.testing.assert_allclose(
            square @ step[part], scaling.divided(scaling.divided(step))[part], rtol=1e-9
        )
    np.testing.assert_allclose(
        scaling.inverse_of_large() @ step[last], scaling.divided(step)[last], rtol=1e-9
    )
    ratios = -s[head] / step[head]
    reaches = [*ratios[step[head] < 0], *(one.reach(s[part], step[part]) for part in parts)]
    assert cones.reach(s, step) == pytest.approx(min(*reaches, large.reach(s[last], step[last])), rel=1e-9)
    margins = [*s[head], *(one.margin(s[part]) for part in parts), large.margin(s[last])]
    assert cones.margin(s) == pytest.approx(min(margins), rel=1e-12)
    assert cones.degree == 7 == pytest.approx(cones.unit @ cones.unit)


@pytest.mark.parametrize("cones", [Cones(1, 0), Cones(0, 0, 3)])
def test_a_step_straight_back_reaches_the_apex(cones):
    """The two ends of its line in the cone are one there: round-off may not let them vanish."""
    for seed in range(200):
        rng = np.random.default_rng(seed)
        point, back = inside(rng)[:3], rng.uniform(0.1, 10.0)
        assert cones.reach(point, -back * point) == pytest.approx(1.0 / back, rel=1e-7)


def disc(limit: float, least: float) -> DiscProgram:
    """Minimise −w with |(w, y)| ≤ limit, and w ≥ least."""
    return DiscProgram(
        blocks=np.array([[[0.0], [0.0], [-1.0]]]),
        node=np.array([0]),
        extra=np.array([[[0.0], [-1.0], [0.0]]]),
        right=np.array([[limit, 0.0, 0.0]]),
        rows=np.zeros((1, 1)),
        rows_extra=np.array([[-1.0]]),
        rows_right=np.array([-least]),
        cost=np.array([-1.0]),
    )


def test_every_end_has_its_proof():
    good, bad = disc(2.0, 0.5), disc(1.0, 1.5)
    end = solve_self_dual(good)
    assert end.status == Status.OPTIMAL
    np.testing.assert_allclose(end.x, [0.0, 2.0], atol=1e-9)
    inner = inner_point(good, end)
    assert good.cones.margin(inner.s) > 0 < good.cones.margin(inner.y)
    np.testing.assert_allclose(good.transposed(inner.y), -good.costs, atol=1e-12)
    none = solve_self_dual(bad)
    assert none.status == Status.INFEASIBLE
    assert bad.limits @ none.multipliers == pytest.approx(-1.0)
    np.testing.assert_allclose(bad.transposed(none.multipliers), 0.0, atol=1e-8)
    assert bad.cones.margin(none.multipliers) > -1e-12
