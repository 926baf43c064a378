"""Damping and stiffness versus amplitude: closed forms, limits, what does not close."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown import Outcome, Problem, UsageError, damping
from shakedown.fem import ElasticBody, Force, Material, Pressure, block_mesh, contact_problem
from shakedown.long_term.conjugate_displacement import load_loops
from shakedown.plot import damping_curve, loop

TURN = np.pi * np.arange(8) / 4

K, S, LIMIT = 2.0, 0.1, 1.0  # of a Jenkins element: its spring, the spring beside it (compliance), f p


def jenkins(**changes):
    """A force on a spring that ends in a friction node."""
    return Problem(
        **{
            "A": [[K]], "B": [[0.0]], "f": 0.5, "q_w": [[-1.0], [1.0]], "p_w": [[2.0], [2.0]],
            "load_reactions": [[-1.0, 0.0]], "load_history": [[1.0], [-1.0]], "load_compliance": [[S]],
            "load_names": ["push"],
        } | changes
    )  # fmt: skip


def words(axes):
    """What the legend of a picture says."""
    return [text.get_text() for text in axes.get_legend().get_texts()]


def test_a_jenkins_element_has_its_parallelogram():
    """Displacement s F + (F − f p)/k and dissipation 4 f p (F − f p)/k above the limit, by its own numbers."""
    F = np.array([0.3, 0.99, 1.2, 3.0, 50.0])
    curve = damping(jenkins(), F)
    beyond = np.maximum(F - LIMIT, 0)
    np.testing.assert_allclose(curve.dissipation, 4 * LIMIT * beyond / K, rtol=1e-12)
    np.testing.assert_allclose(curve.displacement, S * F + beyond / K, rtol=1e-12)
    np.testing.assert_allclose(curve.secant_stiffness, F / curve.displacement, rtol=1e-15)
    factor = curve.dissipation / (np.pi * F * curve.displacement)
    np.testing.assert_allclose(curve.loss_factor, factor, rtol=1e-12)
    assert curve.outcome == (Outcome.SHAKEDOWN,) * 2 + (Outcome.CYCLIC_SLIP,) * 3
    assert curve.proved.tolist() == [True, True, False, False, False]
    assert curve.dissipation[:2].tolist() == [0.0, 0.0]
    assert (curve.proved_limit, curve.simulated_limit) == (pytest.approx(1.0), pytest.approx(1.0, rel=2e-3))
    assert np.isnan(curve.frequency).all()
    modal = damping(jenkins(load_frequency=[5.0]), F)
    np.testing.assert_allclose(modal.frequency, np.sqrt(F / modal.displacement))
    np.testing.assert_allclose(modal.damping_ratio, 0.5 * factor, atol=0)


def stated(factor, unit, amplitude, **changes):
    """A force of ±3 N on the same element, with a history of ±3/factor, stated as an amplitude in some unit."""
    history, reaction = np.array([[3.0], [-3.0]]) / factor, -factor
    return jenkins(
        q_w=reaction * history, load_reactions=[[reaction, 0.0]], load_history=history,
        load_compliance=[[S * factor**2]], load_mean=[0.0], load_amplitude=[amplitude], load_units=[unit],
        units="N, mm", **changes,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("factor", "unit", "amplitude"),
    [(1.0, "N", 3.0), (3.0, "N", 3.0), (1e3, "kN", 3e-3), (0.25, "mN", 3e3), (7.0, "lbf", 3 / 4.4482216152605)],
)  # fmt: skip
def test_displacements_of_a_force_are_lengths(factor, unit, amplitude):
    """Whatever unit the load is stated in, and whatever force the numbers of its history stand for."""
    joint = stated(factor, unit, amplitude)
    curve, F = damping(joint, [0.5, 2.0]), np.array([1.5, 6.0])
    X = S * F + np.maximum(F - LIMIT, 0) / K
    np.testing.assert_allclose(curve.force, F, rtol=1e-12)
    np.testing.assert_allclose(curve.displacement, X, rtol=1e-12)
    np.testing.assert_allclose(curve.secant_stiffness, F / X, rtol=1e-12)
    np.testing.assert_allclose(curve.loss_factor, curve.dissipation / (np.pi * F * X), rtol=1e-12)
    units = {"force": "N", "displacement": "mm", "dissipation": "N mm", "secant_stiffness": "N/mm"}
    assert curve.to_dict()["units"] == units
    state = shakedown.long_term_state(joint, 2.0)
    loops = load_loops(joint, state)
    assert 0.5 * np.ptp(loops.load) == pytest.approx(6.0)
    assert 0.5 * np.ptp(loops.displacement) == pytest.approx(X[1])
    assert loops.areas == pytest.approx(state.dissipation_per_cycle)
    axes = loop(state)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("conjugate displacement [mm]", "load [N]")
    assert damping_curve(curve).figure.axes[1].get_ylabel() == "secant stiffness [N/mm]"


def test_a_force_that_never_rests_is_measured_from_zero():
    """A force between 0 and 40 kN, stated as 20 ± 20: its history of 0 to 2 has 20 kN a unit."""
    joint = jenkins(
        q_w=[[0.0], [-2.0]], load_history=[[0.0], [2.0]], units="kN, mm",
        load_mean=[20.0], load_amplitude=[20.0], load_units=["kN"],
    )  # fmt: skip
    assert damping(joint, [0.1, 0.4]).force == pytest.approx([2.0, 8.0])


@pytest.mark.parametrize(
    ("unit", "amplitude", "displacement", "stiffness"),
    [
        ("N m", 3.0, "N mm/(N m)", "N m/(N mm/(N m))"),
        ("mm", 3.0, "N", "mm/N"),
        ("cm", 0.3, "N", "mm/N"),
        ("", 3.0, "N mm per unit of load", ""),
    ],
)
def test_what_is_no_force_moves_by_work_per_unit(unit, amplitude, displacement, stiffness):
    curve = damping(stated(1.0, unit, amplitude), [1.0])
    assert (curve.units["displacement"], curve.units["secant_stiffness"]) == (displacement, stiffness)
    assert curve.displacement == pytest.approx(S * 3.0 + (3.0 - LIMIT) / K)


def test_a_row_of_elements_is_iwans():
    """Jenkins elements side by side, each on the same displacement X of a stiff bar on a spring that a force moves.

    Element i slips where k_i X exceeds its limit: forces and 4 limit (X − limit / k) add up.
    """
    k, limits, ground = np.linspace(1.0, 2.0, 8), np.linspace(0.2, 3.0, 8), 0.7
    total = k.sum() + ground
    kappa, unit = np.diag(k) - np.outer(k, k) / total, -k / total  # the bar is condensed
    joint = jenkins(
        A=kappa, B=np.zeros((8, 8)), f=1.0, q_w=np.outer([1.0, -1.0], unit), p_w=np.tile(limits, (2, 1)),
        load_reactions=[np.append(unit, np.zeros(8))], load_compliance=[[1 / total]],
    )  # fmt: skip
    X = np.array([0.05, 0.5, 1.0, 5.0])
    F = ground * X + np.minimum(k * X[:, None], limits).sum(axis=1)
    curve = damping(joint, F)
    np.testing.assert_allclose(curve.displacement, X, rtol=1e-10)
    expected = (4 * limits * np.maximum(X[:, None] - limits / k, 0)).sum(axis=1)
    np.testing.assert_allclose(curve.dissipation, expected, rtol=1e-10)
    np.testing.assert_allclose(curve.slipping_share, (k * X[:, None] > limits).mean(axis=1))


def test_another_load_that_varies_stays_as_it_is():
    """Then an amplitude is no load factor, and there is no limit on it; the joint is made anew for each."""
    unit = np.array([[-1.0, 0.0], [0.5, 0.2]])

    def joint(amplitude):
        history = np.column_stack([amplitude * np.sin(TURN), 0.3 * np.cos(TURN)])
        q, p = (history @ unit).T[:, :, None]
        loads = {"load_reactions": unit, "load_history": history, "load_compliance": S * np.eye(2)}
        return jenkins(q_w=q, p_w=p + 2.0, load_names=None, **loads)

    curve = damping(joint(1.0), [1.0, 2.0])
    assert np.isnan([curve.proved_limit, curve.simulated_limit]).all()
    alone = [shakedown.long_term_state(joint(x), 1.0).dissipation_per_cycle for x in curve.amplitude]
    assert curve.dissipation == pytest.approx(alone, abs=1e-12)


def test_where_the_joint_ratchets_nothing_is_said_but_that():
    """Two nodes that hold each other alone, pressed in turn, walk under a constant shear from 0.6 on."""
    rocking = np.array([0.0, 1.0, 0.0, -1.0])
    joint = Problem(
        A=[[1, -1], [-1, 1]], B=np.zeros((2, 2)), f=0.5, q_w=np.full((4, 2), 0.2), p_w=1 + np.outer(rocking, [1, -1]),
        load_reactions=[[0, 0, 1, -1]], load_history=rocking[:, None], load_compliance=[[0.1]],
    )  # fmt: skip
    curve = damping(joint, [0.1, 0.5, 0.8, 0.9])
    assert curve.outcome == (Outcome.SHAKEDOWN,) * 2 + (Outcome.RATCHETTING,) * 2
    assert np.isnan(curve.dissipation).tolist() == [False, False, True, True]
    assert np.isnan(curve.displacement).tolist() == [False, False, True, True]
    assert curve.proved_limit == pytest.approx(0.6)
    assert "ratchetting" in words(damping_curve(curve))


def test_gross_slip_that_nothing_holds_is_said():
    """A block without a spring: at rest below f p, away above."""
    curve = damping(jenkins(A=[[0.0]]), [0.5, 0.9, 2.0])
    assert curve.slides_away.tolist() == [False, False, True]
    assert np.isnan(curve.dissipation).tolist() == [False, False, True]
    assert curve.displacement[:2] == pytest.approx(S * curve.amplitude[:2])
    assert "slides away" in words(damping_curve(curve))


def test_the_start_decides_where_slip_and_pressure_are_coupled():
    """A block on a floor: driven up it ends in other cycles than from no slip, a little above its limit only."""
    loads = [Pressure("top", 1.0, history=1.0), Force("top", (1.0, 0.0), history=np.sin(TURN))]
    body = ElasticBody(block_mesh(4.0, 1.0, 24, 8), Material(100.0, 0.3), loads=loads)
    joint = contact_problem(body, "bottom", 0.4)
    curve = damping(joint, [1.2, 1.3, 1.4, 1.5], load="force", states=np.zeros((1, joint.n)))
    from_zero = curve.of_states[1, 0]
    same = np.isclose(from_zero, curve.dissipation, rtol=1e-6, atol=0.0)
    assert (same | curve.unique).tolist() == [True, True, False, True]
    assert from_zero[2] < 0.99 * curve.dissipation[2]


def test_by_default_the_first_load_that_varies_is_followed():
    """A clamping load comes first, in a small unit, and is constant but for round-off."""
    clamp = 1e12, 1e12 + 2.0**-10
    loads = {"load_reactions": [[0.0, 2e-12], [-1.0, 0.0]], "load_history": np.stack([clamp, [1.0, -1.0]], 1)}
    joint = jenkins(**loads, load_compliance=np.diag([1.0, S]), load_names=["clamp", "push"])
    curve = damping(joint, [0.5, 2.0])
    assert (curve.load, curve.load_name) == (1, "push")
    alone = damping(jenkins(), [0.5, 2.0])
    assert curve.dissipation == pytest.approx(alone.dissipation, rel=1e-12)
    assert curve.proved_limit == pytest.approx(alone.proved_limit)
    assert damping(joint, [1.0], load="clamp").force.max() < 1e-15 * clamp[0]


def test_without_compliance_the_dissipation_is_known():
    curve = damping(jenkins(load_compliance=None), [0.0, 2.0])
    assert curve.dissipation.tolist() == [0.0, 2.0]
    assert np.isnan(curve.displacement).all()


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"amplitudes": [1.0, 1.0]}, "amplitudes: expected numbers >= 0 that rise"),
        ({"amplitudes": [-1.0]}, "amplitudes: expected numbers >= 0"),
        ({"amplitudes": []}, "amplitudes: expected"),
        ({"load": "pull"}, "load: expected one of 0 to 0, 'push', found 'pull'"),
        ({"load": 1}, "load: expected one of 0 to 0"),
        ({"open_nodes": "all"}, "open.nodes: expected"),
        ({"states": [1.0, 2.0]}, "states: expected a number or slips"),
    ],
)
def test_wrong_arguments_are_named(change, line):
    with pytest.raises(UsageError, match=line):
        damping(jenkins(), **({"amplitudes": [1.0]} | change))
    with pytest.raises(UsageError, match="load: expected one of 0 to 2, 'bolt', found 'force'"):
        damping(shakedown.example("bolted-flange"), [1.0], load="force")  # of two loads


def test_a_load_by_its_name_and_its_pictures():
    """Limits, marks and titles are on the pictures; the loop closes."""
    curve = damping(jenkins(load_frequency=[5.0]), [0.5, 2.0, 20.0], load="push")
    axes = damping_curve(curve)
    assert words(axes)[0] == "damping ratio ζ"
    assert any("λ_E = 1" in label for label in words(axes))
    assert axes.get_xscale() == "log"
    (line,) = loop(shakedown.long_term_state(jenkins(), 2.0)).lines
    x, y = line.get_data()
    assert (x[0], y[0]) == (x[-1], y[-1])
    for record in (True, False):  # of a simulation the period that it found, recorded or not
        run = shakedown.simulate(jenkins(), 2.0, record=record)
        assert loop(run).get_title() == "load 0 (push)\narea 2 in one period"
    with pytest.raises(UsageError, match="load: expected a number from 0 to 0"):
        loop(shakedown.long_term_state(jenkins(), 2.0), load=1)


def coupled_pair(B):
    """The two-node system under one load that varies, beside a constant one."""
    joint, history = shakedown.example("two-node"), np.column_stack([np.cos(TURN), np.ones(8)])
    unit = np.array([[200.0, -500.0, 90.0, -120.0], [15.8, -300.0, 588.5, 1300.0]])
    return Problem(
        A=joint.A, B=B, C=joint.C, f=0.35, q_w=(history @ unit)[:, :2], p_w=(history @ unit)[:, 2:],
        load_reactions=unit, load_history=history, load_compliance=np.diag([2000.0, 1.0]),
    )  # fmt: skip


@pytest.mark.parametrize("coupled", [True, False])
def test_a_band_holds_every_run_and_is_a_line_where_the_cycle_is_unique(coupled):
    """Below λ_U and without coupling all drawn states end alike; at 1.0 it is between rest and 204 per cycle."""
    joint = shakedown.example("two-node")
    problem, amplitudes = coupled_pair(joint.B if coupled else 0 * joint.B), np.array([0.6, 1.0, 1.5])
    band = damping(problem, amplitudes, states=24)
    assert band.unique.tolist() == [True, not coupled, not coupled]
    drawn = np.random.default_rng(3).uniform(-3, 3, (1000, 2))
    for k, amplitude in enumerate(amplitudes):
        ends = shakedown.long_term_states(problem, amplitude, drawn).dissipation
        slack = 1e-6 * band.largest["dissipation"][k] + 1e-9
        assert band.least["dissipation"][k] - slack <= ends.min()
        assert ends.max() <= band.largest["dissipation"][k] + slack
        if band.unique[k]:
            assert np.ptp(ends) <= slack
    if coupled:
        at_rest = damping(replace(problem, f=1.0), [0.0], states=2)
        assert not at_rest.unique.any()  # λ_U = 0 proves nothing, at no load either
        low, high = band.least["dissipation"], band.largest["dissipation"]
        assert (low[1], high[1]) == (0, pytest.approx(203.94, abs=0.01))
        which = band.of_states[1, :, 1].argmax()
        again = damping(problem, [1.0], initial_slip=band.states[which])
        assert again.dissipation[0] == pytest.approx(high[1], rel=1e-9)
    assert "from 26 initial slips" in words(damping_curve(band))


@pytest.mark.parametrize(("amplitude", "slips"), [(0.99, False), (1.1, True)])
def test_drawn_states_are_those_that_loads_of_this_amplitude_leave(amplitude, slips):
    assert damping(jenkins(), [amplitude], states=10).states.any() == slips


def test_states_may_be_given_and_followed_by_an_executor(tmp_path):
    problem = coupled_pair(shakedown.example("two-node").B)
    states = [[0.0, 0.0], [2.0, -1.0], [-1.0, 2.0]]
    with ThreadPoolExecutor(2) as threads:
        found = damping(problem, [1.0, 1.5], states=states, executor=threads)
    alone = damping(problem, [1.0, 1.5], states=states)
    assert found == alone
    found.save(tmp_path / "band.csv")
    heading = (tmp_path / "band.csv").read_text().splitlines()[0]
    assert "least_loss_factor" in heading
    assert "largest_secant_stiffness" in heading
    assert found.to_dict()["states"] == 3
