"""Sweeps: every point is what the functions of the library say of that joint alone."""

import pickle
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown import Status
from shakedown.ground.errors import BudgetExceeded, UsageError
from shakedown.ground.tolerances import DEFAULT
from shakedown.models.importing.templates import write_import_example
from shakedown.studies.design_point import cycles_below, out_of_order, with_parameter
from shakedown.studies.sweep import Region

TWO = shakedown.example("two-node")
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


def test_a_proof_that_cannot_be_right_is_a_contradiction():
    history = shakedown.transient_limit(TWO, largest=1.0, steps=16)
    wrong, right = {"accumulated": 0.75, "upper": 0.74}, {"accumulated": 0.73159, "upper": 0.74}
    assert list(out_of_order(wrong, DEFAULT, closed=True)) == ["λ_S = 0.75 exceeds λ_max = 0.74"]
    assert not list(out_of_order(wrong, DEFAULT, closed=False))
    (cycling,) = cycles_below({"accumulated": wrong["accumulated"]}, history, DEFAULT)
    assert cycling.endswith("below λ_S = 0.75")
    assert not list(out_of_order(right, DEFAULT, closed=True))
    assert not list(cycles_below({"accumulated": right["accumulated"]}, history, DEFAULT))


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


@pytest.mark.parametrize(
    ("joint", "vary", "options", "message"),
    [
        (TWO, {}, {}, "expected one or two parameters by name"),
        (TWO, "f", {}, "vary: expected a dictionary, found 'f'"),
        (TWO, {"friktion": [0.1]}, {}, "expected one of f, friction, .* found 'friktion'"),
        (TWO, {"f": []}, {}, "vary f: expected rising values, at least one, found"),
        (TWO, {"f": [0.1, np.nan]}, {}, "vary f: expected finite numbers, found nan"),
        (TWO, {"f": [0.3, 0.2]}, {}, r"vary f: expected rising values, at least one, found \[0.3, 0.2\]"),
        (TWO, {"f": 0.3}, {"bounds": ["lover"]}, "bounds: expected some of lower, .* found lover"),
        (TWO, {"f": 0.3}, {"bounds": ["upper", "upper"]}, "each once"),
        (
            TWO,
            {"f": 0.3},
            {"open_nodes": "all"},
            "open nodes: expected several whole numbers or 'auto', found 'all'",
        ),
        (TWO, {"f": 0.3}, {"open_nodes": [2]}, "open nodes: expected node numbers from 0 to 1, found 2"),
        (TWO, {"f": 0.3}, {"output": "table.txt"}, "ends in .csv or .parquet"),
        ("two-node", {"f": 0.3}, {}, "expected a Problem or an Import or a function, found 'two-node'"),
    ],
)
def test_bad_arguments_are_one_line(joint, vary, options, message):
    with pytest.raises(UsageError, match=message):
        shakedown.sweep(joint, vary, **options)


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
