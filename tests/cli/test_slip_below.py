"""`--slip-below` beside the strict answers of verify: a load factor, the sentence, the exit code, every node."""

import json

import numpy as np
import pandas
import pytest
from command import document, run

import shakedown
from shakedown.assessment.transient_limit import slip_limit
from shakedown.studies.design_point import with_parameter


@pytest.mark.slow
def test_verify_says_up_to_where_slips_stay_below_a_length(tmp_path, undrawn):
    page = tmp_path / "page.html"
    arguments = ("verify", "press-fit", "--random", "0", "--load-factor", "1")
    strict = document(*arguments)
    _, out, _ = run(*arguments, "--slip-below", "1e-3", "-o", str(page))
    found = json.loads(page.with_suffix(".json").read_text())
    criterion, _ = found.pop("slip_criterion"), found.pop("report")
    assert criterion["below"] == 1e-3
    assert criterion["load_factor"] == pytest.approx(1.3214, abs=1e-3)
    assert 0.999e-3 < criterion["largest"] < 1e-3
    for one in (strict, found):
        for each in one["runs"]:
            del each["seconds"]
    assert found == strict
    assert "slips below 0.001 mm" in page.read_text()
    assert "Largest slip range of a node" in page.read_text()
    assert "slips below 0.001 mm up to λ = 1.321" in " ".join(out.split())


def test_a_map_says_from_how_many_states_it_holds(tmp_path):
    arguments = ("map", "two-node", "--load-factor", "0.7", "--states", "64")
    strict = document(*arguments)
    path = tmp_path / "map.npz"
    found = document(*arguments, "--slip-below", "0.1", "-o", str(path))
    criterion = found.pop("slip_criterion")
    assert found == strict
    joint = shakedown.example("two-node")
    with np.load(path) as file:
        starts, ranges = file["initial_slip"], file["slip_range"]
    expected = [shakedown.simulate(joint, 0.7, start, slip_below=0.1).slip_criterion for start in starts]
    assert ranges.tolist() == [one.largest for one in expected]
    assert criterion == {
        "below": 0.1, "met": False, "largest": ranges.max(), "met_fraction": np.mean([one.met for one in expected[2:]]),
    }  # fmt: skip
    assert 0 < criterion["met_fraction"] < 1
    again = document(
        *arguments, "--slip-below", "1", "-o", str(path), "--resume"
    )  # another length, the same map
    assert again["slip_criterion"]["met"] is True
    code, out, _ = run(*arguments, "--slip-below", "0.1")
    assert code == 0
    assert f"slips below 0.1 from {100 * criterion['met_fraction']:.1f} % of the states" in " ".join(
        out.split()
    )


def test_a_sweep_says_at_every_point_up_to_where(tmp_path):
    path = tmp_path / "sweep.csv"
    arguments = ("sweep", "press-fit", "--vary", "f=0.15,0.2", "--bounds", "upper")
    strict = document(*arguments)
    found = document(*arguments, "--slip-below", "1e-3", "-o", str(path))
    joint = shakedown.example("press-fit")
    expected = [slip_limit(with_parameter(joint, "f", f), 1e-3) for f in (0.15, 0.2)]
    criteria = [point.pop("slip_criterion") for point in found["points"]]
    assert found == strict
    assert criteria == [{"below": 1e-3, "load_factor": x.load_factor, "largest": x.largest} for x in expected]
    table = pandas.read_csv(path)
    assert table["lambda_slip [1]"].tolist() == [x.load_factor for x in expected]
    assert table["largest_slip_range"].tolist() == [x.largest for x in expected]
    code, out, _ = run(*arguments, "--slip-below", "1e-3")
    assert code == 0
    assert "slips below 0.001 mm up to" in " ".join(out.split())
    assert max(map(len, out.splitlines())) <= 80
    again = document(*arguments, "--slip-below", "1e-3", "-o", str(path), "--resume")
    assert [point["slip_criterion"] for point in again["points"]] == criteria
