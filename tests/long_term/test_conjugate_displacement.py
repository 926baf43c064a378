"""What loads move, from the welded joint's data alone: held against the whole model, and against friction's work."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown import LoadCase, condense
from shakedown.long_term.conjugate_displacement import conjugate_displacement, load_loops
from shakedown.models.condensation.condense import condensed_stiffness
from shakedown.studies.design_point import with_parameter

STEPS = 12


def model(rng, n, d, loads=2, press=3.0):
    """A random elastic body on n contact nodes, loads out of phase on inner and contact rows, one a displacement."""
    inner = 4
    size = (d + 1) * n + inner + 1
    root = rng.normal(size=(size, size))
    K = root @ root.T / size + np.eye(size)
    dofs = [(i + 1, k + 1) for i in range(n) for k in range(d + 1)] + [(100 + i, 1) for i in range(inner + 1)]
    normals = np.eye(d + 1)[d]
    t = np.arange(STEPS) / STEPS
    forces = rng.normal(size=(loads, size))
    forces[:, -1] = 0.0
    held = np.zeros(size)
    held[-1] = 1.0
    waves = [np.sin(2 * np.pi * (t - rng.random())) * rng.uniform(1, 3) for _ in range(loads + 1)]
    cases = [LoadCase(history=w, force=F) for w, F in zip(waves, forces, strict=False)]
    cases.append(LoadCase(history=0.5 * waves[-1], displacement=held))
    down = np.zeros(size)
    down[d : (d + 1) * n : d + 1] = -press
    cases.append(LoadCase(history=1.0, force=down))
    joint = condense(K, dofs, list(range(1, n + 1)), normals, cases, 0.3, fixed=[size - 1], allow_sparse=True)
    return joint, K, [case.force for case in cases], held


def settled(rng, n, d, press):
    """A joint that cycles, and its long-term state."""
    while True:
        joint, *rest = model(rng, n, d, press=press)
        state = shakedown.long_term_state(joint, 1.0)
        if state.outcome == "cyclic-slip" or (
            press < 1.5 and state.period and state.dissipation_per_cycle > 0
        ):
            return joint, state, rest


@pytest.mark.parametrize(("n", "d", "press"), [(3, 1, 3.0), (4, 1, 0.7), (2, 2, 3.0), (3, 2, 0.7)])
def test_the_loops_have_the_area_that_friction_dissipates(n, d, press):
    """With loads out of phase, a prescribed displacement among them, in the plane and in space, where nodes open too."""
    joint, state, _ = settled(np.random.default_rng(5), n, d, press)
    assert state.opened.any() or press > 1
    area = load_loops(joint, state).areas.sum() / state.period
    assert area == pytest.approx(state.dissipation_per_cycle, rel=1e-8)


@pytest.mark.parametrize("d", [1, 2])
def test_a_load_moves_as_in_the_whole_model(d):
    """Contact displacements prescribed in the model that was condensed: forces on all rows do the work of x."""
    joint, state, (K, forces, held) = settled(np.random.default_rng(2), 2, d, 3.0)
    size, contact = len(K), (d + 1) * 2
    t = np.array([state.history.cycle[-1] - 0.21])
    at = state.history.at(t)
    times, period = np.arange(STEPS + 1) / STEPS, np.vstack([joint.load_history, joint.load_history[:1]])
    c = np.array([np.interp(t % 1.0, times, history)[0] for history in period.T])
    dofs = [(i, k) for i in (1, 2) for k in range(1, d + 2)]
    frame = condensed_stiffness(
        K[:contact, :contact], dofs, [1, 2], np.eye(d + 1)[d], allow_sparse=True
    ).frame
    tangents = np.asarray(frame.tangents).reshape(2, d, d + 1)
    slips = np.einsum("id,idk->ik", at.v.reshape(2, d), tangents)
    u = np.zeros(size)
    u[:contact] = (slips + np.outer(at.w[0], np.eye(d + 1)[d])).ravel()
    u[-1] = c[2]
    total = c[0] * forces[0] + c[1] * forces[1] + c[3] * forces[3]
    free = np.arange(contact, size - 1)
    given = np.setdiff1d(np.arange(size), free)
    u[free] = np.linalg.solve(K[np.ix_(free, free)], total[free] - K[np.ix_(free, given)] @ u[given])
    expected = [forces[0] @ u, forces[1] @ u, -held @ (K @ u - total), forces[3] @ u]
    np.testing.assert_allclose(conjugate_displacement(joint, at)[0], expected, rtol=1e-9, atol=1e-12)


def test_below_load_factor_one_and_under_a_mean_load_only_a_constant_is_added():
    """λ multiplies what varies of every load: areas are those of the joint whose loads are smaller by as much."""
    joint, *_ = settled(np.random.default_rng(5), 3, 1, 3.0)
    lower = shakedown.long_term_state(joint, 0.9)
    smaller = with_parameter(joint, "amplitude", 0.9)
    own = shakedown.long_term_state(smaller, 1.0)
    np.testing.assert_allclose(load_loops(joint, lower).areas, load_loops(smaller, own).areas, rtol=1e-9)


LIES = {
    "other reactions": ({"q_w": 1}, "keys 'q_w', 'p_w': expected a constant and load_history @ load_reactions"),
    "no history": ({"load_history": None}, "key 'load_history': required because 'load_reactions' is given"),
    "one load too many": ({"load_compliance": np.eye(5)}, r"key 'load_compliance': expected shape \(4, 4\), found \(5, 5\)"),
    "a compliance that is none": ({"load_compliance": np.tri(4)}, "key 'load_compliance': expected a symmetric matrix"),
    "forces that store less than no energy": (
        {"load_compliance": np.eye(4) + 2.0 * (np.tri(4, 4, 1) * np.tri(4, 4, 1).T - np.eye(4))},
        r"key 'load_compliance': expected stored energy >= 0, found less for some sums of loads \[0 1 2 3\]",
    ),
    "a frequency of zero": ({"load_frequency": [0.0, np.nan, 1.0, np.nan]}, "key 'load_frequency': expected frequencies > 0"),
}  # fmt: skip


@pytest.mark.parametrize(("change", "line"), LIES.values(), ids=LIES)
def test_loads_that_do_not_fit_are_named(change, line):
    joint, *_ = model(np.random.default_rng(5), 3, 1)
    if isinstance(change.get("q_w"), int):
        change = {"q_w": joint.q_w + np.eye(STEPS, 3)}
    with pytest.raises(shakedown.ProblemError, match=line):
        replace(joint, **change)


def test_without_compliance_there_is_no_displacement():
    joint, state, _ = settled(np.random.default_rng(5), 3, 1, 3.0)
    with pytest.raises(shakedown.ProblemError, match="key 'load_compliance': needed"):
        conjugate_displacement(replace(joint, load_compliance=None), state)
    with pytest.raises(shakedown.ProblemError, match="key 'load_reactions': needed"):
        conjugate_displacement(shakedown.example("two-node"), state)
