"""Sweeps and their parameters: every point is what the library says of that joint alone, in the plane and in space."""

import pickle
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import shakedown
from benchmarks.problems import joint, random_problem
from shakedown import Problem, Status, sweep
from shakedown.ground.errors import BudgetExceeded, ProblemError, UsageError
from shakedown.ground.tolerances import DEFAULT
from shakedown.joint.constraints import loading
from shakedown.models.importing.templates import write_import_example
from shakedown.studies.design_point import cycles_below, out_of_order, with_parameter
from shakedown.studies.sweep import Region

TWO = shakedown.example("two-node")
TRANSIENT = replace(joint(3), q_transient=np.full((2, 4), 0.1), p_transient=np.full((2, 4), 3.0))


def limits(problem):
    return (
        shakedown.lower_bound(problem, certify=False).load_factor,
        shakedown.universal_bound(problem).load_factor,
        shakedown.energy_bound(problem, certify=False).load_factor,
        shakedown.upper_bound(problem, certify=False).load_factor,
    )


@pytest.mark.parametrize("problem", [TWO, joint(1), random_problem(5, 2)], ids=["two", "joint", "random"])
def test_every_load_factor_is_inverse_to_the_amplitude_and_homogeneous_in_the_mean(problem):
    as_given = np.array(limits(problem))
    assert limits(with_parameter(problem, "amplitude", 2.0)) == pytest.approx(as_given / 2, rel=1e-7)
    assert limits(with_parameter(problem, "mean", 3.0)) == pytest.approx(as_given * 3, rel=1e-7)


def test_a_phase_there_and_back_changes_no_limit_and_whole_periods_nothing():
    there_and_back = with_parameter(with_parameter(TWO, "phase", 0.3), "phase", -0.3)
    assert limits(there_and_back) == pytest.approx(limits(TWO), rel=1e-9)
    for phase in (0.0, 1.0, -2.0):
        assert np.array_equal(loading(with_parameter(TWO, "phase", phase)).q1, loading(TWO).q1)


def test_without_coupling_both_bounds_are_melans():
    lower, universal, _, upper = limits(replace(TWO, B=0.0 * TWO.B))
    assert lower == universal == pytest.approx(upper, rel=1e-9)


@pytest.mark.parametrize(
    "problem", [TWO, joint(2), shakedown.example("two-node-3d")], ids=["two", "joint", "space"]
)
def test_more_friction_never_lowers_the_largest_load_factor(problem):
    found = [
        shakedown.upper_bound(with_parameter(problem, "friction", factor), certify=False).load_factor
        for factor in (0.3, 0.6, 0.9, 1.0)
    ]
    assert found == sorted(found)
    assert found[0] < found[-1]


def test_friction_factor_and_friction_coefficient_agree():
    assert np.array_equal(with_parameter(TWO, "f", 0.7).f, with_parameter(TWO, "friction", 2.0).f)
    with pytest.raises(UsageError, match=r"same friction coefficient at every node, found .* 'friction'"):
        with_parameter(joint(1), "f", 0.3)


def test_the_mean_takes_transient_load_steps_along_and_the_amplitude_does_not():
    assert np.array_equal(with_parameter(TRANSIENT, "mean", 2.0).p_transient, 2.0 * TRANSIENT.p_transient)
    assert np.array_equal(with_parameter(TRANSIENT, "amplitude", 2.0).p_transient, TRANSIENT.p_transient)


@pytest.mark.parametrize("name", ["mean", "amplitude"])
def test_the_units_of_a_load_are_scaled_with_it(name):
    joint = {"A": [[2.0]], "B": [[0.0]], "f": 0.5, "q_w": [[1.0], [0.0]], "p_w": [[3.0], [3.0]]}
    load = {"load_reactions": [[1.0, 0.0]], "load_history": [[1.0], [0.0]]}
    changed = with_parameter(Problem(**joint, **load), name, 3.0)
    assert np.array_equal(changed.load_history, changed.q_w)


@pytest.mark.parametrize("phase", [0.25, 1.137])
def test_a_phase_moves_the_tangential_part_along_the_period_and_nothing_else(phase):
    changed = with_parameter(TWO, "phase", phase)
    before, after = loading(TWO), loading(changed)
    assert np.array_equal(after.q0, before.q0)
    assert np.array_equal(after.p0, before.p0)
    for periodic in ("q1", "p1"):
        old, new = getattr(before, periodic), getattr(after, periodic)
        assert new.max(axis=0) == pytest.approx(old.max(axis=0), rel=1e-12)  # no corner is cut off
        assert new.min(axis=0) == pytest.approx(old.min(axis=0), rel=1e-12)
    # the same path as that of a loop refined so far that the phase is a whole number of its steps
    fine = 1000 if phase > 1 else 20
    t = np.arange(TWO.m * fine) / (TWO.m * fine)

    def at(samples, times):
        closed = np.vstack([samples, samples[:1]])
        return np.stack([np.interp(times % 1, np.arange(TWO.m + 1) / TWO.m, c) for c in closed.T], axis=1)

    refined = replace(
        TWO,
        q_w=before.q0 + at(before.q1, t - phase),
        p_w=before.p0 + at(before.p1, t),
        q_mean=before.q0,
        p_mean=before.p0,
    )
    assert limits(changed) == pytest.approx(limits(refined), rel=1e-9)


@pytest.mark.parametrize(
    ("name", "value", "error", "message"),
    [
        ("friktion", 1.0, UsageError, "expected one of f, friction, amplitude, .* found 'friktion'"),
        ("f", np.nan, UsageError, "parameter f: expected a finite number, found nan"),
        ("amplitude", -1.0, UsageError, "parameter amplitude: expected a number >= 0"),
        ("f", -0.1, ProblemError, "expected friction coefficients >= 0"),
        ("mean", 1e200, ProblemError, "between 1e-100 and 1e"),
        ("amplitude", 1e308, ProblemError, "expected finite numbers, found"),
    ],
)
def test_what_makes_no_joint_is_said_in_one_line(name, value, error, message):
    with pytest.raises(error, match=message) as caught:
        with_parameter(TWO, name, value)
    assert "\n" not in str(caught.value)


def test_the_corners_of_a_load_domain_have_no_phase():
    domain = replace(shakedown.example("two-node"), load_path="domain")
    with pytest.raises(UsageError, match="phase: expected load steps in their order"):
        with_parameter(domain, "phase", 0.25)
    assert with_parameter(domain, "amplitude", 2.0).is_domain


FRICTIONS = [0.1, 0.35, 0.6]


def of_mean(mean):
    """A joint that can be imported by worker processes."""
    return with_parameter(TWO, "mean", mean)


class Sent(ThreadPoolExecutor):
    """What it is given to do comes as to another process."""

    def submit(self, *call):
        return super().submit(*pickle.loads(pickle.dumps(call)))


@pytest.fixture(scope="module")
def found():
    return shakedown.sweep(TWO, {"f": FRICTIONS})


def test_every_point_is_that_joints_own_answer(found):
    for k, f in enumerate(FRICTIONS):
        problem = replace(TWO, f=np.full(2, f))
        lower = shakedown.lower_bound(problem, certify=False)
        assert found.lower[k] == lower.load_factor
        assert found.guarantee[k] == lower.guarantee
        assert found.universal[k] == shakedown.universal_bound(problem).load_factor
        assert found.energy[k] == shakedown.energy_bound(problem, certify=False).load_factor
        assert found.accumulated[k] == shakedown.accumulated_bound(problem).load_factor
        assert found.upper[k] == shakedown.upper_bound(problem, certify=False).load_factor
        limit = shakedown.transient_limit(problem, accuracy=1e-6)
        assert found.transient[k] == pytest.approx(limit.load_factor, rel=3e-6)
        scanned = found.points[k]["transient"]
        assert scanned["low"] <= found.transient[k] < scanned["high"]
    assert found.contradictions == ()


def test_regions_follow_from_the_limits(found):
    every, this, never = found.boundaries
    for load_factor in (0.0, 0.15, 0.5, 0.8, 2.0):
        for k, name in enumerate(found.regions(load_factor)):
            expected = (
                Region.EVERY_STATE
                if load_factor < every[k]
                else Region.THIS_STATE
                if load_factor < this[k]
                else Region.NEVER
                if load_factor > never[k]
                else Region.DEPENDS
            )
            assert name == expected
    for load_factor in (0.2, 0.7):
        for f, name in zip(FRICTIONS, found.regions(load_factor), strict=True):
            end = shakedown.long_term_state(replace(TWO, f=np.full(2, f)), load_factor)
            if name != Region.DEPENDS:
                assert (end.outcome == "shakedown") == (name != Region.NEVER)


@pytest.mark.parametrize("name", ["two-node", "block-9"])
@pytest.mark.parametrize("asked", ["energy", "accumulated"])
def test_proved_from_this_state_is_what_an_assessment_proves_whichever_bound_is_asked_for(name, asked):
    joint = shakedown.example(name)
    start = 0.1 * shakedown.upper_bound(joint, certify=False).slip
    found = shakedown.sweep(joint, {"amplitude": [1.0]}, bounds=[asked], initial_slip=start)
    proved = shakedown.assess(joint, start, certify=False).proved_from_this_state
    assert found.from_this_state[0] == pytest.approx(proved, rel=1e-12)
    assert found.columns()["proved_from_this_state [1]"] == [found.from_this_state[0]]
    at = np.array([0.999, 1.001]) * proved
    assert [found.regions(x)[0] == Region.THIS_STATE for x in at] == [True, False]


def test_a_proof_that_cannot_be_right_is_a_contradiction(monkeypatch):
    history = shakedown.transient_limit(TWO, largest=1.0, steps=16)
    wrong, right = {"accumulated": 0.75, "upper": 0.74}, {"accumulated": 0.73159, "upper": 0.74}
    assert list(out_of_order(wrong, DEFAULT, closed=True)) == ["λ_S = 0.75 exceeds λ_max = 0.74"]
    assert not list(out_of_order(wrong, DEFAULT, closed=False))
    (cycling,) = cycles_below({"accumulated": wrong["accumulated"]}, history, DEFAULT)
    assert cycling.endswith("below λ_S = 0.75")
    assert not list(out_of_order(right, DEFAULT, closed=True))
    assert not list(cycles_below({"accumulated": right["accumulated"]}, history, DEFAULT))
    early, B, q = history.but(scanned=1e-3 * history.scanned), [[0, 0.2], [0.6, 0]], [1, 0.02]
    monkeypatch.setattr("shakedown.assessment.transient_limit.of_joint", lambda limits: early)
    lifts = Problem(A=np.eye(2), B=B, f=0.3, q_w=np.outer([1, -1], q), p_w=[[6, 1.2]] * 2)
    for problem, proved in ((TWO, 1), (lifts, 0)):  # below λ_1 the other is not proved to shake down
        told = sweep(problem, {"mean": [1.0]}, bounds=("lower", "transient")).contradictions
        assert sum("below λ_1 = " in each for each in told) == proved


def test_processes_and_a_resumed_run_give_the_same(tmp_path):
    plain = shakedown.sweep(of_mean, {"mean": [1.0, 2.0, 3.0]}, quick=True)
    output, options = tmp_path / "sweep.csv", {"quick": True, "output": tmp_path / "sweep.csv"}
    partial = tmp_path / "sweep.csv.parts"
    stopped = KeyboardInterrupt

    def stop(done, of):
        if done == 2:
            raise stopped

    with pytest.raises(stopped):
        shakedown.sweep(of_mean, {"mean": [1.0, 2.0, 3.0]}, **options, progress=stop)
    assert partial.exists()
    assert not output.exists()
    with pytest.raises(UsageError, match="an unfinished run is kept there"):
        shakedown.sweep(of_mean, {"mean": [1.0, 2.0, 3.0]}, **options)
    calls = []
    resumed = shakedown.sweep(
        of_mean, {"mean": [1.0, 2.0, 3.0]}, **options, resume=True, workers=2,
        progress=lambda done, of: calls.append(done),
    )  # fmt: skip
    assert calls == [2, 3]
    assert not partial.exists()
    assert resumed == plain
    plain.save(tmp_path / "plain.csv")
    assert output.read_bytes() == (tmp_path / "plain.csv").read_bytes()


def test_a_parameter_that_makes_no_joint_is_a_point_with_its_reason():
    found = shakedown.sweep(TWO, {"f": [-0.1, 0.0, 0.35], "mean": [-1.0, 1.0]})
    assert (found.regions(0.5)[0] == Region.NO_JOINT).all()
    assert found.regions(0.5)[2].tolist() == [Region.DEPENDS, Region.EVERY_STATE]
    assert "expected friction coefficients >= 0" in found.points[0]["reason"]
    assert (found.status("upper")[0] == Region.NO_JOINT).all()
    assert np.isnan(found.upper[0]).all()
    assert found.status("lower")[2].tolist() == [Status.INFEASIBLE, Status.OPTIMAL]
    assert len(found.points[4]["open_nodes"]) == 1  # pulled apart: λ_max is that of a zone, if of anything
    assert np.isnan(found.of_joint("upper")).tolist() == (np.isnan(found.upper) | found.in_zone).tolist()
    assert found.contradictions == ()


def test_frame_and_parquet(tmp_path, found):
    pandas = pytest.importorskip("pandas")
    table = found.to_frame()
    assert table["lambda_max"].tolist() == found.upper.tolist()
    assert not [name for name in table if "[" in name]
    headings = [
        f"{name} [{table.attrs['units'][name]}]" if name in table.attrs["units"] else name for name in table
    ]
    assert headings == list(found.columns())
    try:
        import pyarrow  # noqa: F401
    except ImportError:
        with pytest.raises(UsageError, match="expected the packages pandas and pyarrow, found no pyarrow"):
            found.save(tmp_path / "f.parquet")
        assert not list(tmp_path.iterdir())
    else:
        found.save(tmp_path / "f.parquet")
        assert (pandas.read_parquet(tmp_path / "f.parquet").to_numpy() == table.to_numpy()).all()


def test_too_many_points_are_refused_before_the_work():
    with pytest.raises(BudgetExceeded, match="nothing was computed"):
        shakedown.sweep(TWO, {"f": np.linspace(0.1, 1, 2000), "mean": np.linspace(1, 2, 2000)})


def test_an_imported_joint_is_swept_over_numbers_of_its_configuration(tmp_path):
    write_import_example(tmp_path / "punch")
    made = shakedown.import_model(tmp_path / "punch" / "import.toml")
    force, harmonic = "load.2.forces.1.3", "load.3.history.harmonics.1.cos"
    found = shakedown.sweep(made, {force: [5.0, 10.0], harmonic: [0.5]}, bounds=["upper"])
    as_given = shakedown.upper_bound(made.problem, certify=False).load_factor
    afresh = shakedown.import_model(made.path, changes={force: 5.0, harmonic: 0.5})
    assert found.upper[0, 0] == shakedown.upper_bound(afresh.problem, certify=False).load_factor
    with Sent(1) as executor:
        both = shakedown.sweep(made, {"f": [0.3, 0.4], harmonic: [1.0]}, bounds=["upper"], executor=executor)
    assert both.upper[0, 0] == pytest.approx(as_given, rel=1e-12)
    wrong = shakedown.sweep(made, {"load.1.name": [1.0]})
    assert "load.1.name: expected the key of a number, found 'pressed down'" in wrong.points[0]["reason"]


JOINT = shakedown.example("one-node-3d")


@pytest.mark.slow
def test_every_point_is_the_joint_by_itself():
    found = sweep(JOINT, {"friction": [0.5]}, quick=True)
    assert found.bounds == ("universal", "energy", "accumulated", "transient", "upper")
    assert (found.energy <= found.transient).all()
    assert (found.transient <= found.upper).all()
    one = shakedown.assess(with_parameter(JOINT, "friction", 0.5), certify=False)
    assert found.upper[0] == one.impossible_above
    assert found.universal[0] == one.proved_from_every_state
    assert found.energy[0] == one.details.energy.load_factor
    assert found.contradictions == ()
    assert np.isnan(found.lower).all()


def of_friction(f: float) -> Problem:
    return replace(JOINT, f=np.array([f]))


def test_of_a_function_that_makes_joints_what_there_is_not_is_undecided_with_the_reason():
    found = sweep(of_friction, {"f": [0.4]}, bounds=["lower", "universal", "upper"])
    assert found.status("lower").tolist() == ["undecided"]
    assert "λ_1: first collapse: expected one tangential direction" in found.columns()["remark"][0]
    assert 0 < found.universal[0] < found.upper[0]
    with pytest.raises(UsageError, match="bounds with two directions: expected some of universal, energy"):
        sweep(JOINT, {"f": [0.4, 0.5]}, bounds=["lower"])


def test_up_to_where_the_slips_of_every_point_are_small():
    found = sweep(JOINT, {"friction": [1.0]}, bounds=["upper"], slip_below=0.05)
    (point,), upper = found.points, found.upper[0]
    assert 0.9 * upper < point["slip_criterion"]["load_factor"] < 2.0 * upper
    assert 0 <= point["slip_criterion"]["largest"] < 0.05
