"""Numbers rounded to the safe side, texts as wide as a terminal, notes that are sentences; what is said follows from numbers.

Each statement about limits and runs at numbers on both sides of its condition.
"""

import re
from dataclasses import replace
from math import inf, nan
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from stated_limits import stated

import shakedown
from shakedown.assessment.assess import Assessment
from shakedown.assessment.creep_limit import Creep
from shakedown.assessment.transient_limit import SlipLimit
from shakedown.bounds.friction_thresholds import Threshold
from shakedown.bounds.onset import Onset
from shakedown.ground.shown_values import down, up
from shakedown.ground.status import Status
from shakedown.report import data_facts, facts, limit_facts, run_facts
from shakedown.report.facts import Fact, Section, Sheet, Table, limits_as_text, margin, notes, sheet_as_text

TWO = shakedown.example("two-node")
OPEN = {"open_nodes": (1,)}


def is_safe(text, value, rounding):
    """Whether a number as it is shown lies on the side of the exact one that keeps the statement true."""
    return float(text) <= value if rounding == "down" else float(text) >= value


@pytest.mark.parametrize("value", [1.3276878539, 0.65, 1.9, 1e-7, 123456.7891])
def test_a_rounded_limit_is_never_on_the_wrong_side(value):
    assert float(down(value)) <= value <= float(up(value))
    assert float(up(value)) - float(down(value)) <= 1.0001e-6 * value
    assert limits_as_text([(4321.7, "down")], 4) == ["4321"]
    for digits in (2, 4, 7, 12):
        low, high = limits_as_text([(value, "down"), (value, "up")], digits)
        assert float(low) <= value <= float(high)


@pytest.mark.parametrize(
    ("value", "rounding"), [(1.00004, "down"), (0.99996, "up"), (1.0, "down"), (1e-9, "up")]
)
def test_a_rounded_load_factor_stays_on_its_side_of_one(value, rounding):
    (text,) = limits_as_text([(value, rounding)])
    assert np.sign(float(text) - 1) == np.sign(value - 1)
    assert is_safe(text, value, rounding)


def test_limits_that_differ_look_different():
    rng = np.random.default_rng(0)
    for _ in range(100):
        first = rng.uniform(0.1, 20.0)
        limits = [(first, "down"), (first * (1 + 10 ** rng.uniform(-5.5, -1)), "down"), (2 * first, "up")]
        texts = limits_as_text(limits)
        assert len(set(texts)) == 3
        assert all(is_safe(text, *limit) for text, limit in zip(texts, limits, strict=True))


def test_a_margin_is_rounded_to_the_safe_side():
    for value in np.random.default_rng(1).uniform(0.0, 12.0, 200):
        for rounding in ("down", "up"):
            shown = float(margin(value, rounding).removesuffix(" %").replace("−", "-"))
            exact, slack = 100 * (value - 1), 1e-9
            assert is_safe(shown, exact + (slack if rounding == "down" else -slack), rounding)
            assert shown == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize("width", [40, 60, 80, 120])
def test_no_line_is_wider_than_the_terminal_and_no_cell_is_lost(width):
    rows = [
        [f"name {k}", *(f"{k}{j}.125" for j in range(9)), "some words that say what it is"] for k in range(5)
    ]
    head = ["row", *(f"column {j}" for j in range(9)), "remark"]
    told = [Fact("a label", 1.23456, "mm", note="a note of several words " * 5), Fact("b", "word " * 30)]
    sections = [Section("Title", (), [Table(head, rows, (0, 10))])]
    text = sheet_as_text(Sheet(["headline"], ["The answer."], None, told, sections), width)
    assert max(map(len, text.splitlines())) <= width
    for cell in (cell for row in rows for cell in row[1:10]):
        assert cell in text
    assert text.count("some") == 5


def test_a_long_table_shows_its_first_and_last_rows_and_leaves_out_no_single_one():
    rows = [[f"row{k}"] for k in range(49)]
    assert facts.table_as_text(Table(["x"], rows)).count("row") == 49
    cut = facts.table_as_text(Table(["x"], [*rows, ["row49"]]))
    assert "row0\n" in cut
    assert "row49" in cut
    assert "10 more rows" in cut


def test_characters_that_a_terminal_obeys_are_shown():
    text = sheet_as_text(Sheet(["a\x1b[2J"], ["b\u202e"], None, [Fact("c", "d\x07", note="e\x1b")]))
    assert not re.search("[\x00-\x09\x0b-\x1f\u202e]", text)


def test_every_note_is_a_sentence_that_some_sheet_has():
    sources = "".join(path.read_text() for path in Path(facts.__file__).parent.glob("*.py"))
    assert set(re.findall(r"(?<![\w./])notes\.(\w+)", sources)) == set(vars(notes))
    assert all(text[-1] in ".?)" and len(text.split()) <= 60 for text in vars(notes).values())


def at(load_factor, **more):
    return {"load_factor": load_factor, "certified": None, **more}


@pytest.mark.parametrize(
    ("bounds", "told"),
    [
        ({}, ["0.5 (λ_U)", "0.6 (λ_E)", "0.8 (λ_max)"]),
        ({"universal": at(0.0)}, ["not proved", "0.6 (λ_E)", "0.8 (λ_max)"]),
        ({"universal": at(0.0), "energy": at(0.0)}, ["not proved", "not proved", "0.8 (λ_max)"]),
        ({"universal": at(nan, status="undecided")}, ["unknown", "0.6 (λ_E)", "0.8 (λ_max)"]),
        ({"universal": at(0.7)}, ["0.7 (λ_U)", "0.7 (λ_U)", "0.8 (λ_max)"]),
        ({"universal": at(inf), "energy": at(inf), "upper": at(inf, status="unbounded")},
         ["any load factor", "any load factor", "no load factor"]),
        ({"universal": at(0.0), "energy": at(0.0), "upper": at(0.0)}, ["not proved", "not proved", "0"]),
        ({"upper": at(nan, status="infeasible"), "universal": at(0.0), "energy": at(0.0)}, ["not proved", "not proved", "0"]),
        ({"energy": at(0.6) | OPEN, "upper": at(0.8) | OPEN, "universal": at(0.0)},
         ["unknown (1 node open)", "0.6 (λ_E)", "unknown (1 node open)"]),
        ({"energy": at(inf) | OPEN, "upper": at(inf) | OPEN, "universal": at(0.0)},
         ["unknown (1 node open)", "any load factor", "unknown (1 node open)"]),
    ],
)  # fmt: skip
def test_a_claim_is_its_number_with_its_limit_or_says_why_there_is_none(bounds, told):
    usual = {"universal": at(0.5), "energy": at(0.6), "accumulated": at(0.0), "upper": at(0.8)}
    known = limit_facts.claims(Assessment(stated(**usual | bounds)))
    assert [f"{each.value} ({each.unit})" if each.unit else each.value for each in known] == told


@pytest.mark.parametrize(
    ("low", "high", "state", "ends"),
    [
        (0.4, 0.4, "yes", "for f below 0.4"),
        (0.35, 0.5, "not decided", "for f below 0.35, lost from f = 0.5 on"),
        (0.3, 0.35, "no", "for f below 0.3, lost from f = 0.35 on"),
        (0.2, 0.2001, "no", "for f below 0.2"),
        (0.0, 0.5, "not decided", "lost from f = 0.5 on"),
        (inf, inf, "yes", "with any friction"),
    ],
)
def test_friction_is_below_a_threshold_above_it_or_between_what_encloses_it(low, high, state, ends):
    """Of a joint with f = 0.35."""
    limits, closed, opened = stated(), Threshold(low, high), Threshold(0.2, 0.2001)
    vars(limits)["friction"] = replace(limits.friction, uniqueness_in_contact=closed, uniqueness=opened)
    told = {each.label: each for each in limit_facts.friction_facts(limits)}
    assert ("unique motion, nodes open" in told) == ((low, high) != (opened.low, opened.high))
    one = told["unique motion, closed"]
    assert (one.shown, one.note.partition(";")[0]) == (state, ends)
    assert one.note.endswith("here 0.35." if state == "yes" else notes.not_unique)


EXACT = (0.5, 0.5), (0.0, 0.0), (inf, inf)


@pytest.mark.parametrize(
    ("certified", "told"),
    [(None, "in floating point"), ((0.5, 0.5 + 1e-12), "to 2e-12"), *((each, "exactly") for each in EXACT)],
)
def test_how_a_limit_is_computed_is_how_wide_its_enclosure_is(certified, told):
    limits = stated(upper={"certified": certified, "least_load_factor": 1 / 3} | OPEN)
    rows = {row[0]: row for row in limit_facts.limits_table(limits, simulated=False).rows}
    assert (rows["λ_max"][-1], rows["λ_lo"][1:3]) == (told, ["safe slips from", "0.3334"])
    zone = {each.label: each.shown for each in limit_facts.decided_by(Assessment(limits))}
    assert (zone["open nodes"], zone["safe from"]) == ("node 1", "0.3334")


@pytest.mark.parametrize(("proved", "told"), [(0.7, []), (0.8, []), (0.9, ["λ = 0.8 to 0.9"]), (inf, [])])
def test_it_slips_without_creep_from_where_it_does_not_rest_to_where_creep_is_excluded(proved, told):
    limits = stated(upper=at(0.8))
    vars(limits)["creep"] = shakedown.Bound("creep", Status.UNDECIDED, inf, Creep(proved, "every state"))
    assert [fact.shown for fact in limit_facts.without_creep(limits)] == told


@pytest.mark.parametrize(("load_factor", "told"), [(0.0, []), (0.3, ["0.3"]), (2.0, ["2"]), (inf, [])])
def test_the_first_slip_is_told_where_there_is_one(load_factor, told):
    limits = stated()
    vars(limits)["first_slip"] = Onset(load_factor, 1, 0, Status.OPTIMAL)
    about = limit_facts.decided_by(Assessment(limits))
    assert [each.shown for each in about if each.label == "first slip"] == told


@pytest.mark.parametrize(
    ("every", "here", "above", "told", "command"),
    [
        (0.5, 0.6, 0.8, "cannot shake down in full contact", "nodes F"),
        (0.5, 0.6, 1.2, "it is not decided whether", "simulate F"),
        (0.5, 1.1, 1.2, "shakes down from zero slip: proved", "verify F"),
        (1.1, 1.1, 1.2, "shakes down from every state: proved", "verify F"),
        (1.0, 1.0, 1.0, "it is not decided whether", "simulate F"),
    ],
)
def test_the_answer_and_the_next_step_are_those_of_the_limits_beside_one(every, here, above, told, command):
    bounds = {"universal": at(every), "energy": at(here), "accumulated": at(0.0), "upper": at(above)}
    found = Assessment(stated(**bounds))
    assert told in limit_facts.nominal_load_sentence(found)
    (step,) = limit_facts.next_step(found, "F")
    assert step.shown.startswith(f"shakedown-bounds {command}")


@pytest.mark.parametrize(
    ("found", "shown", "note"),
    [
        ({}, "up to λ = 0.7499", "largest 0.09877, node 1"),
        ({"monotone": False}, "up to λ = 0.7499", "largest 0.09877, node 1; above it there are load factors at which they are again"),
        ({"node": -1}, "up to λ = 0.7499", ""),
        ({"load_factor": nan}, "at no load factor", ""),
        ({"exceeded_at": inf}, "at every load factor simulated", ""),
    ],
)  # fmt: skip
def test_up_to_where_slips_stay_small(found, shown, note):
    none = np.zeros(0)
    limit = SlipLimit(0.1, 0.74999, 0.09877, 1, exceeded_at=0.75, monotone=True, initial_slip=none,
                      scanned=none, slip_range=none, outcomes=())  # fmt: skip
    (fact,) = run_facts.slip_limit_fact(replace(limit, **found), TWO)
    assert (fact.label, fact.shown, fact.note) == ("slips below 0.1", shown, note)


@pytest.mark.parametrize(
    ("found", "told"),
    [
        ({}, ["0.7499: up to here the joint shakes down in the simulation"]),
        ({"monotone": False}, ["0.7499: up to here the joint shakes down in the simulation; below there are load factors at which it does not"]),
        ({"high": inf}, ["every λ simulated: up to here the joint shakes down in the simulation"]),
        ({"load_factor": nan}, ["no λ: the joint shakes down at no load factor simulated"]),
        ({"proved": 0.74999}, []),
    ],
)  # fmt: skip
def test_the_simulated_limit_is_told_where_it_is_not_proved(found, told):
    usual = {"load_factor": 0.74999, "high": 0.75001, "proved": 0.7, "monotone": True}
    limit = SimpleNamespace(**usual | found, scanned=(), status=Status.OPTIMAL)
    none = SimpleNamespace(period=0, reason="none")
    about = SimpleNamespace(transient=limit, nodes=none, slip_limit=None, problem=TWO)
    assert [f"{each.shown}: {each.note}" for each in run_facts.state_facts(about)[1:]] == told


@pytest.mark.parametrize(
    ("period", "jumps", "opened", "told"),
    [(1, 0.0, (), []), (2, 0.5, (), ["period 2", "0.5 jumps per cycle"]), (1, 0.0, (1, 4), ["nodes 1, 4 open"])],
)  # fmt: skip
def test_what_is_remarkable_of_a_run_is_told(period, jumps, opened, told):
    assert run_facts.remarks(SimpleNamespace(period=period, jumps_per_cycle=jumps, open_nodes=opened)) == told


@pytest.mark.parametrize(
    ("given", "told"),
    [((), "no q_mean, p_mean"), (("q_mean",), "no p_mean"), (("q_mean", "p_mean"), "as given")],
)
def test_that_the_mean_load_is_assumed_is_said_of_what_is_not_given(given, told):
    means = {"q_mean": TWO.q_w.mean(axis=0), "p_mean": TWO.p_w.mean(axis=0)}
    (line,) = data_facts.constant_load(replace(TWO, **{word: means[word] for word in given}))
    assert (f"({told});" if given != tuple(means) else f": {told};") in line
