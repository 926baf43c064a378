"""When the rates of slip in space are unique: what proves it against a search for minors that are not positive."""

from itertools import combinations

import numpy as np
import pytest

from shakedown import Problem
from shakedown.bounds.every_state.bound_of_floating import energy_margin, unique_rates
from shakedown.bounds.every_state.least_pressures import ScaledJoint, scaled_joint

SETS = [list(each) for size in (1, 2, 3) for each in combinations(range(3), size)]
LOOP = {"q_w": np.zeros((1, 6)), "p_w": np.ones((1, 3))}


def joint(rng: np.random.Generator, size: float) -> Problem:
    root = rng.normal(size=(6, 6))
    A = np.eye(6) + rng.uniform(0.05, 1.0) * root @ root.T
    B = size * rng.normal(size=(3, 6)) * rng.uniform(0.1, 1.0, (3, 1))
    return Problem(A=A, B=B, f=rng.uniform(0.2, 0.8, 3), **LOOP)


def least_minor(joint: ScaledJoint, rng: np.random.Generator) -> float:
    """The least principal minor of M(u) over its diagonal, over unit vectors u: a search."""
    angles = rng.uniform(0, 2 * np.pi, (2000, 3))
    values = minors(joint, angles)
    for width in (0.3, 0.1, 0.03, 0.01):
        best = angles[np.argsort(values)[:20]]
        near = (best[:, None] + width * rng.normal(size=(20, 60, 3))).reshape(-1, 3)
        angles = np.concatenate([best, near])
        values = minors(joint, angles)
    return float(values.min())


def minors(joint: ScaledJoint, angles: np.ndarray) -> np.ndarray:
    u = np.stack([np.cos(angles), np.sin(angles)], axis=2)
    A, fB = joint.A.reshape(3, 2, 3, 2), joint.fB.reshape(3, 3, 2)
    M = np.einsum("kia,iajb,kjb->kij", u, A, u) + np.einsum("ija,kja->kij", fB, u)
    own = np.einsum("iaib->iab", A).trace(axis1=1, axis2=2)
    return np.min([np.linalg.det(M[:, s][:, :, s]) / own[s].prod() for s in SETS], axis=0)


@pytest.mark.parametrize("seed", range(3))
def test_just_below_what_is_proved_all_minors_are_positive(seed):
    rng = np.random.default_rng(seed)
    problem = joint(rng, 1.0)
    by_energy = 1.0 - energy_margin(scaled_joint(problem))
    near = scaled_joint(scaled(problem, 0.999 / by_energy))
    assert unique_rates(near).argument == "every motion stores more energy than friction can feed it"
    assert least_minor(near, rng) > 0


def scaled(problem: Problem, factor: float) -> Problem:
    return Problem(A=problem.A, B=factor * problem.B, f=problem.f, **LOOP)


def test_for_one_node_the_energy_decides():
    """M = uᵀA u + f B · u vanishes for some u exactly where the energy says so."""
    A, B, f = np.array([[2.0, 0.3], [0.3, 1.0]]), np.array([[1.0, -0.6]]), 0.5
    angle = np.linspace(0, 2 * np.pi, 20001)
    u = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    threshold = 1.0 / np.max(-f * (u @ B[0]) / np.einsum("ka,ab,kb->k", u, A, u))
    for factor, unique in ((1 - 1e-3, True), (1 + 1e-3, False)):
        node = Problem(A=A, B=factor * threshold * B, f=f, q_w=np.zeros((1, 2)), p_w=np.ones((1, 1)))
        assert bool(unique_rates(scaled_joint(node))) is unique


def test_strong_coupling_loses_uniqueness():
    rng = np.random.default_rng(0)
    strong = scaled_joint(joint(rng, 30.0))
    assert least_minor(strong, rng) < 0
    assert not unique_rates(strong)
