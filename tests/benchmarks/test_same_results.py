"""Checkouts that say the same are told from such that do not, be it by one bit; their times are held against each other."""

import json
import sys
from math import inf, nextafter

import pytest

from benchmarks import before_and_after, same_results
from benchmarks.answers import differences

CHOSEN = ["--joints", "2", "--on", "one-node,random-1,space-0,ansys", "--only", "solve,import"]


@pytest.mark.slow
def test_a_checkout_is_the_same_as_itself_and_not_as_one_a_bit_away(tmp_path, capsys):
    kept = tmp_path / "answers.json"
    assert same_results.main(["--reference", sys.executable, "--save", str(kept), *CHOSEN]) == 0
    assert "No difference." in capsys.readouterr().out

    answers = json.loads(kept.read_text())
    upper = answers["answers"]["solve random-1.npz --json -q"]["out"]["upper"]
    there = upper["load_factor"]
    upper["load_factor"] = nextafter(there, inf)
    kept.write_text(json.dumps(answers))
    assert same_results.main(["--reference", str(kept), *CHOSEN]) == 1
    said = capsys.readouterr().out
    assert f"out.upper.load_factor\n    reference {nextafter(there, inf)}\n    new       {there}\n" in said
    rows = {line.split()[0]: line.split()[1:3] for line in said.splitlines() if line.strip()}
    assert rows["solve"] == ["3", "1"]
    assert rows["import"] == ["1", "0"]
    assert same_results.main(["--reference", str(kept), "--minutes", "0", *CHOSEN]) == 1
    assert capsys.readouterr().out.rstrip().endswith("minutes; 11 runs were not compared")


def one_leaf(was, found):
    return [(leaf.path, leaf.reference, leaf.new) for leaf in differences({"out": was}, {"out": found})]


def test_every_kind_of_difference_is_seen():
    assert one_leaf({"a": [0.1, None]}, {"a": [0.1, None]}) == []
    assert one_leaf([0.1], [nextafter(0.1, 1)]) == [("out[0]", "0.1", "0.10000000000000002")]
    assert one_leaf(0.0, -0.0) == [("out", "0.0", "-0.0")]
    assert one_leaf(1, 1.0) == [("out", "1", "1.0")]
    assert one_leaf([], [1]) == [("out", "[]", "(absent)"), ("out[0]", "(absent)", "1")]
    assert one_leaf([1, 2], [2, 1]) == [("out[0]", "1", "2"), ("out[1]", "2", "1")]
    assert one_leaf({"a": 1}, {"b": 1}) == [("out.a", "1", "(absent)"), ("out.b", "(absent)", "1")]


def near(was, found):
    return not differences({"out": was}, {"out": found}, within=1e-9)


def test_near_numbers_are_told_from_others_and_from_words():
    assert near([1.0, 1e-12], [1.0 + 1e-12, 2e-12])  # of one array, whose size counts
    assert not near({"a": 1.0, "b": 1e-12}, {"a": 1.0, "b": 2e-12})
    assert not near([1.0, 0.0], [1.0 + 1e-8, 0.0])
    assert near(0.0, -0.0)
    assert not near(["shakedown", 1.0], ["ratchetting", 1.0])
    assert near("λ_max = 0.6574, of 3 nodes", "λ_max = 0.6575, of 3 nodes")  # rounded to the next digit
    assert not near("λ_max = 0.6574", "λ_max = 0.6576")
    assert not near("λ_max = 0.6574", "λ_E = 0.6574")
    assert near("x=123456.123456789", "x=123456.123470000")


def test_only_what_is_listed_may_differ():
    message = "{} subsets are more than the budget; they would take about {} on one core of this machine"
    was = {"err": message.format(9, "2 s"), "out": {"runs": [{"seconds": 0.1}], "seconds": 1}, "seconds": 1}
    same = {"err": message.format(9, "3 s"), "out": {"runs": [{"seconds": 0.2}], "seconds": 1}, "seconds": 2}
    assert differences(was, same) == []
    assert [leaf.path for leaf in differences(was, same | {"err": message.format(8, "3 s")})] == ["err"]
    assert [leaf.path for leaf in differences(was, {"err": was["err"]})] == [
        "out.runs[0].seconds",
        "out.seconds",
        "seconds",
    ]


@pytest.mark.slow
def test_every_call_is_timed_by_the_worker():
    """A checkout beside itself; the names that have moved are found."""
    found = dict(before_and_after.measured((sys.executable, sys.executable), "lower_bound chain", 2))
    assert list(found) == ["lower_bound chain-10", "conic_lower_bound chain-5"]
    assert all(seconds > 0 for turns in found.values() for turn in turns for seconds in turn)
