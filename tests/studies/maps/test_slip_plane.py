"""The plane of two slips: outlines obey the laws that they stand for."""

import numpy as np
import pytest

import shakedown
from shakedown.joint.constraints import constraints
from shakedown.joint.loading import loading
from shakedown.motion.checked_law import admissible, reactions
from shakedown.studies.samplers import sampling
from shakedown.studies.slip_plane import first_limits, slip_plane

JOINT = shakedown.example("two-node")


@pytest.mark.parametrize(("load_factor", "kind"), [(0.6, "i"), (0.7, "ii"), (0.8, "iii")])
def test_the_type_of_the_regions_changes_at_both_bounds(load_factor, kind):
    plane = slip_plane(sampling(JOINT, load_factor))
    assert plane.region_type == kind
    assert plane.region


def test_the_complementary_region_and_the_safe_region_meet_at_the_apex():
    plane, rows = slip_plane(sampling(JOINT, 0.7)), constraints(JOINT)
    beyond, apex = plane.complementary[1], plane.apexes[1]
    assert len(plane.safe) == len(beyond) == 3
    assert not len(plane.complementary[0])
    for region in (plane.safe, beyond):
        assert np.abs(region - apex).max(axis=1).min() <= 1e-9
    middle = rows.excess(beyond.mean(axis=0), 0.7)
    np.testing.assert_array_equal(middle > 0, [False, False, True, True])
    assert (rows.excess(plane.safe.mean(axis=0), 0.7) < 0).all()


@pytest.mark.parametrize(
    ("name", "pair"), [("two-node", (1, 0)), ("block-9", (2, 6)), ("three-node", (0, 2))]
)
def test_the_outline_of_the_ball_lies_on_its_surface(name, pair):
    joint = shakedown.example(name)
    load_factor = 0.6 * shakedown.upper_bound(joint).load_factor
    chosen = sampling(joint, load_factor, coordinates=pair)
    outline = slip_plane(chosen).ball
    slips = np.tile(chosen.centre, (len(outline), 1))
    slips[:, list(pair)] = outline
    np.testing.assert_allclose(chosen.ball.distance(slips), chosen.ball.radius, rtol=1e-9)


def test_admissible_slips_stay_where_they_are_under_the_first_load():
    generator = np.random.default_rng(0)
    slips = generator.uniform(-3, 3, (200, 2))
    inside = admissible(JOINT, 0.7, slips)
    polygon = slip_plane(sampling(JOINT, 0.7)).admissible
    loop = loading(JOINT).at(0.7)
    q, p = reactions(JOINT, loop[0][0], loop[1][0], slips, np.zeros_like(slips))
    np.testing.assert_array_equal(inside, (np.abs(q) <= JOINT.f * p).all(axis=1))
    middle = polygon.mean(axis=0)
    assert admissible(JOINT, 0.7, middle + 0.999 * (polygon - middle)).all()
    assert not admissible(JOINT, 0.7, middle + 1.001 * (polygon - middle)).any()
    assert first_limits(JOINT, 0.7).shape == (4,)
