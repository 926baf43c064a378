"""Dissipation from cycle to cycle: the thesis's conjecture that it never rises (3.3.2) is false."""

import numpy as np
import pytest

import shakedown


def test_dissipation_per_cycle_can_rise():
    """The thesis's own two-node system, from an initial slip in the gap between the bounds' limits."""
    problem, load_factor = shakedown.example("two-node"), 1.16549
    run = shakedown.simulate(problem, load_factor, [1.986, 1.706], record=True)
    _, second, third, *_ = by_cycle = run.cycles.dissipation
    assert (second, third) == pytest.approx((2578.501, 2579.560), abs=1e-3)
    assert by_cycle[1:4] == pytest.approx(dissipated_by_energy(problem, run.history, 4)[1:], rel=1e-9)
    assert run.outcome == "cyclic-slip"
    assert run.dissipation_per_cycle == pytest.approx(third)  # the state stays there


def dissipated_by_energy(problem, path, cycles):
    """Work of the loading less what is stored, per cycle: a second method for −∫ q dv."""
    u, load = np.hstack([path.v, path.w]), np.hstack([path.q_w, path.p_w])
    fed = np.append(0.0, np.cumsum((0.5 * (u[1:] + u[:-1]) * np.diff(load, axis=0)).sum(axis=1)))
    stored = 0.5 * np.einsum("ri,ij,rj->r", u, problem.kappa, u) + (u * load).sum(axis=1)
    ends = np.arange(cycles + 1) - 1 / problem.m  # a cycle begins and ends with the last load step
    rows = np.searchsorted(path.cycle, ends + 1e-9, side="right") - 1
    return np.diff((fed - stored)[rows])
