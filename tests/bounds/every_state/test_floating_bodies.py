"""Unique rates of slip against a search for minors that are not positive; bodies that friction alone holds."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from difficult_joints import floating_joint

import shakedown
from shakedown import Problem, universal_bound
from shakedown.bounds.every_state.bound_of_floating import energy_margin, rigid_rates, unique_rates
from shakedown.bounds.every_state.least_pressures import ScaledJoint, pressures_of_floating, scaled_joint
from shakedown.bounds.every_state.universal_bound import least_pressure_bound
from shakedown.joint.constraints import loading

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
    strong = scaled_joint(scaled(problem, 30.0))
    assert least_minor(strong, rng) < 0
    assert not unique_rates(strong)


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
    A, loads = np.ones((4, 4)) + 1e-6 * np.eye(4), {"q_w": np.zeros((1, 4)), "p_w": np.ones((1, 2))}
    near_singular = Problem(A=A, B=1e-15 * np.eye(2, 4), f=f, stiffness_accuracy=1e-15, **loads)
    assert energy_margin(scaled_joint(near_singular)) <= 1 - 16 * 4 * np.finfo(float).eps * np.linalg.cond(A)


def drawn(seed: int, kind: str, loads: str = "smooth") -> Problem:
    return floating_joint(np.random.default_rng([seed, 7]), 4, kind, loads)


def proved(kind: str, loads: str = "smooth") -> Problem:
    """The first of them of which something is proved by least pressures."""
    for seed in range(20):
        problem = drawn(seed, kind, loads)
        if least_pressure_bound(problem).load_factor > 0:
            return problem
    raise AssertionError("nothing is proved of any")


def test_two_like_halves_are_proved_to_their_end():
    flange = shakedown.example("bolted-flange")
    found = universal_bound(flange)
    assert found.load_factor / shakedown.upper_bound(flange).load_factor == pytest.approx(1.0, abs=1e-5)
    assert (found.argument, found.limited_by) == ("least pressures, rigid motions apart", "swing")
    assert shakedown.assess(flange).proved_from_every_state == found.load_factor


@pytest.mark.parametrize("kind", ["translations", "plane"])
def test_what_falls_at_the_bound_falls_at_every_smaller_load_factor(kind: str):
    problem = proved(kind, "off centre")
    known, joint, d = least_pressure_bound(problem), scaled_joint(problem), problem.directions
    least, rigid, lengths = pressures_of_floating(joint), joint.motions, np.repeat(joint.lengths, d)
    angle = 2 * np.pi * np.arange(720) / 720
    u = np.stack([np.cos(angle), np.sin(angle)], axis=1) if d == 2 else np.array([[1.0], [-1.0]])
    for share in (0.0, 0.3, 0.7, 0.999):
        z = known.mean_reactions + share * (known.reactions - known.mean_reactions)
        assert np.abs(rigid.T @ (lengths * z)).max() < 1e-12 * np.abs(z).max()  # of some slip
        load_factor = share * known.load_factor
        q, _ = loading(problem).at(load_factor)
        w = (q + z).reshape(len(q), problem.n, -1)
        pressures = least.at(joint, joint.q0 + load_factor * joint.q1, joint.p0 + load_factor * joint.p1)
        Y = problem.f[:, None] * least.multipliers.reshape(problem.n, problem.n, d)[range(4), range(4)]
        g = (1.0 - np.linalg.norm(Y, axis=1))[:, None] + Y @ u.T  # what π is divided by in slip along u
        asked = (-g * np.einsum("mna,ua->mnu", w, u)).max(axis=2)
        assert np.all(asked < problem.f * pressures / joint.lengths)
    scaled = 0.5 * (known.reactions - loading(problem).q0)  # what does where something holds the body
    assert np.abs(rigid.T @ (lengths * scaled)).max() > 1e-3 * np.abs(scaled).max()
    still = replace(problem, q_w=problem.q_w[:1] * 0, p_w=problem.p_w[:1], q_mean=None, p_mean=None)
    assert universal_bound(still).status == "unbounded"


@pytest.mark.parametrize("kind", ["translations", "rotation"])
def test_rest_is_bounded_for_all_rigid_motions(kind: str):
    """Against 20,000 of them, at pressures between the least and the largest: no smaller margin passes."""
    joint = scaled_joint(drawn(3, kind))
    rates, rng = rigid_rates(joint), np.random.default_rng(0)
    shape = (3, joint.n)
    firm, long, low = rng.uniform(0.5, 1.0, shape), rng.uniform(0.2, 0.5, shape), rng.uniform(0.3, 2.0, shape)
    long[:, 0] = low[:, 0] + 0.1
    high, sure = 1.5 * low, (low >= long).all(axis=0)
    c = rng.normal(size=(20_000, rates.motions.shape[2]))
    sizes = np.linalg.norm(np.tensordot(c, rates.motions, axes=(1, 2)), axis=2)
    fed, seen = np.linalg.norm(sizes @ rates.feeds, axis=1), 0.0
    for share in rng.choice([0.0, 0.0, 0.3, 1.0, 1.0], (200, joint.n)):
        limit = low + share * (high - low)
        held = np.where(sure, limit - long, firm)
        pull = np.where(sure, 2.0 * limit, high + long + firm)
        reach = np.sqrt(np.sum(pull**2 / rates.weights, axis=1) * rates.stretch)
        seen = max(seen, float((reach * fed[:, None] / (sizes @ held.T)).max()))
    assert not replace(rates, margin=0.999 * seen).proved(firm, long, low, high)
    assert replace(rates, margin=1.2 * seen + 1e-6).proved(firm, long, low, high)


@pytest.mark.parametrize("seed", range(3))
def test_a_floating_body_in_the_plane_is_proved_no_further_than_its_first_collapse(seed: int):
    problem = drawn(seed, "plane")
    assert least_pressure_bound(problem).load_factor <= shakedown.lower_bound(problem).load_factor


def test_in_the_plane_it_counts_where_no_gauge_closes():
    found = universal_bound(floating_joint(np.random.default_rng(110), 4, "plane", "smooth"))
    assert found.argument == "least pressures, rigid motions apart"
    assert 0.5 * found.first_collapse < found.load_factor <= found.first_collapse
