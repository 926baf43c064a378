"""The core works on any rows: what another kind of condition adds."""

from dataclasses import replace

import numpy as np
import pytest
from bounds.energy.joints import strong_joint

from shakedown.bounds.energy.cone_rows import cone_rows
from shakedown.bounds.energy.energy_rows import EnergyRows, energy_rows
from shakedown.bounds.energy.row_ball import largest_ball
from shakedown.bounds.energy.row_bound import farthest_load_factor
from shakedown.ground.tolerances import DEFAULT


def with_condition(rows: EnergyRows, slope: np.ndarray, slack: float) -> EnergyRows:
    """One more row: slope · v ≤ slack throughout the ball."""
    spread = rows.metric.relative_dual_norms(slope[None], np.zeros(1), DEFAULT)
    return replace(
        rows,
        G=np.vstack([rows.G, slope]),
        d=np.append(rows.d, 0.0),
        g=np.append(rows.g, slack),
        spread=np.append(rows.spread, spread),
        node=np.append(rows.node, 0),
        side=np.append(rows.side, 0),
    )


@pytest.mark.parametrize("seed", range(3))
def test_a_further_row_keeps_its_distance_from_the_ball(seed):
    rows = energy_rows(strong_joint(seed, 4))
    plain = largest_ball(rows, 0.5)
    slope = np.random.default_rng(seed).normal(size=4)
    metric, slack = rows.metric, float(slope @ plain.slip)  # cuts through the centre
    ball = largest_ball(with_condition(rows, slope, slack), 0.5)
    assert 0 < ball.radius < plain.radius
    assert (0, 0) in ball.active
    touching = ball.slip + ball.radius / metric.unit * metric.inverse @ _unit(slope @ metric.inverse)
    assert slope @ touching == pytest.approx(slack, rel=1e-9, abs=1e-9)


def test_a_further_row_lowers_the_load_factor():
    rows = energy_rows(strong_joint(1, 4))
    start = largest_ball(rows, 0.5).slip
    plain = farthest_load_factor(rows, start, 0.05)
    slope = plain.slip - start
    cut = with_condition(rows, slope, float(slope @ start) + 0.5 * float(slope @ slope))
    bound = farthest_load_factor(cut, start, 0.05)
    assert bound.load_factor < plain.load_factor
    assert abs(bound.gap) <= 1e-9
    assert bound.residual <= 1e-12


def test_multipliers_of_rows_without_load_prove_no_load_factor():
    """As Newton's method finds them where the load hardly matters: none at all."""
    about = cone_rows(energy_rows(strong_joint(0, 4)), np.zeros(4), 0.05)
    assert about.proved(np.zeros(len(about.d))) == np.inf
    unloaded = replace(about, d=np.append(np.zeros(len(about.d) - 1), -1.0))
    assert unloaded.proved(np.append(np.ones(len(about.d) - 1), 0.0)) == np.inf


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector)
