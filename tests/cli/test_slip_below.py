"""`--slip-below` beside the strict answers of verify: a load factor, the sentence, the exit code, every node."""

import pandas
import pytest
from command import document, run

import shakedown


def test_verify_says_up_to_where_slips_stay_below_a_length(tmp_path, undrawn):
    table, page = tmp_path / "nodes.csv", tmp_path / "page.html"
    arguments = ("verify", "press-fit", "--random", "0")
    strict = document(*arguments)
    found = document(*arguments, "--slip-below", "1e-3", "--nodes", str(table), "-o", str(page))
    criterion = found.pop("slip_criterion")
    assert criterion["below"] == 1e-3
    assert criterion["load_factor"] == pytest.approx(1.3214, abs=1e-3)
    assert 0.999e-3 < criterion["largest"] < 1e-3
    for one in (strict, found):
        for each in one["runs"]:
            del each["seconds"]
    assert found == strict
    nodes = shakedown.node_results(shakedown.simulate(shakedown.example("press-fit"), 1.0))
    assert pandas.read_csv(table)["slip_range [mm]"].tolist() == nodes.slip_range.tolist()
    sentence = "every slip range stays below 0.001 mm up to λ = 1.321457"
    assert sentence in page.read_text()
    _, out, _ = run(*arguments, "--slip-below", "1e-3")
    assert sentence in " ".join(out.split())


def test_the_state_asked_about_is_the_given_one():
    joint = shakedown.example("three-node")
    found = shakedown.verify(joint, random_states=0, load_factors=[1.0], slip_below=0.5)
    assert (found.slip_limit.initial_slip == joint.initial_slip[0]).all()
    with pytest.raises(shakedown.UsageError, match="slip_below: expected a positive length"):
        shakedown.verify(joint, slip_below=-1.0)
