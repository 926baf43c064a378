"""The steps of the proof in space, number by number; zones, transients, means of their own, load domains."""

from dataclasses import replace

import numpy as np
import pytest
from bounds.energy.joints import space_joint

from shakedown import energy_ball, energy_bound
from shakedown.joint.constraints import loading
from shakedown.joint.contact_zone import contact_zone


def test_open_nodes_keep_their_gap():
    """Every state of the ball of a zone leaves the open node open: the gap row, checked in the whole joint."""
    problem = space_joint(7, 4)
    opened = replace(problem, p_w=problem.p_w - 9.0 * (np.arange(4) == 2))
    zone = contact_zone(opened, [2])
    ball = energy_ball(opened, 0.3, open_nodes=[2])
    assert ball.open_nodes == (2,)
    assert ball.status == "optimal"
    rng = np.random.default_rng(0)
    loads = loading(opened).at(0.3)
    for _ in range(200):
        state = ball.at(rng.normal(size=6), 1 - 1e-9)
        u = zone.displacements(state[opened.layout.slips_of(zone.closed_nodes)], *loads)
        assert np.all(u[:, opened.layout.gaps][:, 2] > 0)
    bound = energy_bound(opened, ball.slip, open_nodes=[2])
    assert bound.load_factor > 0.3
    assert bound.residual <= 1e-13
    assert np.all(np.isin([node for node, _ in bound.active], range(4)))
    assert energy_bound(opened, ball.slip).status == "infeasible"


def test_transient_steps_are_further_ones_without_load_factor():
    problem = space_joint(2, 3)
    middle = energy_ball(problem, 0.0).slip
    plain = energy_bound(problem, middle, split=False, certify=False)
    loop = loading(problem)
    harmless = replace(problem, q_transient=loop.q0[None], p_transient=loop.p0[None])
    assert energy_bound(harmless, middle, split=False, certify=False).load_factor == pytest.approx(
        plain.load_factor, rel=1e-9
    )
    late = 0.9 * plain.load_factor
    q, p = loop.at(late)
    hard = replace(problem, q_transient=q, p_transient=p)
    assert energy_bound(hard, middle, split=False, certify=False).load_factor == pytest.approx(
        plain.load_factor, rel=1e-9
    )
    q, p = loop.at(1.1 * plain.load_factor)
    harder = energy_bound(replace(problem, q_transient=q, p_transient=p), middle, split=False, certify=False)
    assert harder.status == "infeasible" or harder.load_factor < plain.load_factor
    ball = energy_ball(replace(problem, q_transient=q, p_transient=p), 0.1, transient=False, split=False)
    assert ball.radius == pytest.approx(energy_ball(problem, 0.1, split=False).radius, rel=1e-9)
