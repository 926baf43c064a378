"""The first page: one sentence with the answer in the user's loads, three numbers, and the rest in one table."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown import Problem
from shakedown.assessment.assess import proved_limit
from shakedown.assessment.verify import Verification
from shakedown.ground.shown_values import FEW_DIGITS, down, few, up
from shakedown.joint.conjugate_loads import without_loads
from shakedown.report.answer_words import answer_in_words, margin_of_answer
from shakedown.report.assessment_words import beside_one
from shakedown.report.first_page import large_numbers, rest_table
from shakedown.report.html import render, write_report
from shakedown.report.next_words import margin_in_words
from shakedown.report.page_tables import WORST, worst_table
from tests.report.test_page import Page, nominal

LOADS = {
    "load_names": ["bolt preload", "axial load"],
    "load_mean": [12.0, 20.0],
    "load_amplitude": [0.0, 20.0],
    "load_units": ["kN", "kN"],
}
NUMBER = r"([\d.]+(?:e-?\d+)?)"


def verified(problem: Problem) -> Verification:
    return shakedown.verify(problem, random_states=0, load_factors=[1.0])


def loaded(factor: float) -> Problem:
    """A block with labels, areas and loads, its periodic part multiplied."""
    block = without_loads(shakedown.example("block-9"))
    mean_q, mean_p = block.q_w.mean(axis=0), block.p_w.mean(axis=0)
    return replace(
        block,
        q_w=mean_q + factor * (block.q_w - mean_q),
        p_w=mean_p + factor * (block.p_w - mean_p),
        label=[f"{4700 + k}" for k in range(9)],
        node_area=np.full(9, 0.25),
        **LOADS,
    )


@pytest.fixture(scope="module")
def holds() -> Verification:
    return verified(loaded(1.0))


@pytest.fixture(scope="module")
def slips() -> Verification:
    return verified(loaded(5.2))


def test_a_joint_that_shakes_down_has_its_limit_in_the_loads_of_the_user(holds):
    text = answer_in_words(holds)
    found = re.fullmatch(
        r"At axial load 20 ± 20 kN \(λ = 1\) the joint shakes down\. Starting without slip, it is proved to do so "
        rf"up to 20 ± {NUMBER} kN \(λ = {NUMBER}\); bolt preload 12 kN, unchanged\.",
        text,
    )
    load, factor = map(float, found.groups())
    exact = holds.assessment.proved_from_this_state
    assert factor == float(down(exact))
    assert 0.99 * 20 * exact < load <= 20 * exact
    percent, simulated = map(float, re.findall(rf"{NUMBER} %", margin_of_answer(holds)))
    assert 0.99 * (exact - 1) < percent / 100 <= exact - 1
    assert 0.99 * (holds.transient.load_factor - 1) < simulated / 100 <= holds.transient.load_factor - 1


def test_a_joint_that_slips_says_where_how_far_and_what_is_enough(slips):
    text = answer_in_words(slips)
    found = re.fullmatch(
        rf"At axial load 20 ± 20 kN \(λ = 1\) the joint slips in every cycle, with a slip range of up to {NUMBER} mm at "
        rf"node (\d+) \(FE (\d+)\), in the simulation. Starting without slip, it is proved to shake down up to 20 ± {NUMBER} kN \(λ = {NUMBER}\)"
        "; bolt preload 12 kN, unchanged.",
        text,
    )
    slip, node, label, load, factor = found.groups()
    nodes = shakedown.node_results(slips.as_given)
    assert int(node) == nodes.slip_range.argmax()
    assert label == slips.problem.label[int(node)]
    assert slip == few(nodes.slip_range.max())
    exact = slips.assessment.proved_from_this_state
    assert 0.99 * exact < float(factor) <= exact
    assert 0.99 * 20 * exact < float(load) <= 20 * exact
    (less, *_) = re.findall(rf"{NUMBER} % smaller it is proved", margin_of_answer(slips))
    assert 1 - exact <= float(less) / 100 < 1.01 * (1 - exact)


@pytest.mark.parametrize("which", ["holds", "slips"])
def test_the_three_large_numbers_are_those_of_the_assessment_rounded_to_the_safe_side(which, request):
    v = request.getfixturevalue(which)
    every, here, above = large_numbers(v)
    assert [every.name, here.name, above.name] == [
        "proved from every state",
        "proved from this state",
        "impossible above",
    ]
    exact = v.assessment.proved_from_this_state, v.assessment.impossible_above
    for shown, value, rounded in zip((here, above), exact, (down, up), strict=True):
        assert shown.value == f"20 ± {rounded(20 * value, FEW_DIGITS)} kN"
        symbol = "λ_max" if rounded is up else "λ"
        assert re.match(rf"{symbol} = {re.escape(rounded(value))}0*, ", shown.remark)
    assert every.value == "nothing proved"
    bare = replace(v.problem, load_mean=None, load_amplitude=None, load_units=None)
    assert re.fullmatch(rf"λ = {re.escape(down(exact[0]))}0*", large_numbers(verified(bare))[1].value)


@pytest.mark.usefixtures("undrawn")
def test_the_table_has_the_worst_of_the_results_per_node_of_the_json(slips, tmp_path):
    write_report(tmp_path / "page.html", slips)
    nodes = json.loads((tmp_path / "page.json").read_text())["nodes"]
    rows = {name: (value, where) for name, value, where in rest_table(slips).rows}
    for name, column, unit in (
        ("largest slip range", "slip_range", "mm"),
        ("largest slip per cycle", "accumulated_slip", "mm"),
        ("largest pressure", "pressure_max", "MPa"),
        ("largest friction work per cycle", "work", "N mm"),
    ):
        value, where = rows[name]
        exact = max(nodes[column])
        assert value == f"{few(exact)} {unit}"
        node = nodes[column].index(exact)
        assert where.startswith(f"node {node} (FE {nodes['label'][node]})")
    total = sum(nodes["work"])
    assert rows["friction work per cycle, all nodes"][0] == f"{few(total)} N mm"
    assert sum(int(part.split()[0]) for part in rows["nodes"][1].split(", ")) == 9


def test_the_worst_nodes_come_first_and_are_told_to_all_digits_shown(slips):
    nodes, shown = shakedown.node_results(slips.as_given), worst_table(slips)
    assert shown.head[:4] == ["node", "FE label", "status", "slip range [mm]"]
    slip = [float(row[3]) for row in shown.rows]
    assert slip == sorted(slip, reverse=True)
    for row in shown.rows:
        node = int(row[0])
        assert row[1:3] == [slips.problem.label[node], nodes.status[node]]
        assert float(row[4]) == pytest.approx(nodes.accumulated_slip[node], rel=1e-5, abs=1e-12)


def test_where_nothing_slips_zero_is_said_of_no_node(holds):
    rows = {name: (value, where) for name, value, where in rest_table(holds).rows}
    assert rows["slip and friction work per cycle"] == ("0", "no node ever slips, proved")
    assert rows["nodes"] == ("9", "all stick")


def test_numbers_of_the_table_are_written_without_an_exponent_where_that_takes_few_zeros():
    values = [value for _, value, _ in rest_table(nominal("two-node")).rows]
    assert not any("e+" in value for value in values)
    assert "1785" in values


@pytest.mark.usefixtures("undrawn")
def test_on_paper_long_tables_of_nodes_have_their_worst_rows_only():
    v = nominal("receding-block")
    text = render(v)
    page = Page(text)
    left_out = [row for row in page.all("tr") if row.get("class") == "more"]
    assert len(left_out) == 2 * (33 - WORST)
    assert page.text.count(f"On paper: the {WORST} worst nodes of 33") == 2
    assert ".more { display: none; }" in text.split("@media print")[1]


@pytest.mark.usefixtures("undrawn")
def test_symbols_have_subscripts_and_what_the_user_wrote_has_none(slips):
    kept = json.dumps(
        {
            "configuration": {"name": "q_w.toml", "text": "load = p_w"},
            "files": [{"name": "p_w.mtx"}],
            "warnings": ["pairs lie apart"],
        }
    )
    named = replace(slips.problem, name="λ_E joint", source=kept)
    found = replace(slips, assessment=shakedown.assess(named))
    page = render(found)
    body = re.sub(r'(data-name|aria-label)="[^"]*"', "", page[page.index("</style>") :])
    assert re.findall(r".*λ_.*", body) == ["<h1>Shakedown report: λ_E joint</h1>"]
    assert "λ<sub>max</sub>" in body
    assert "load = p_w</pre>" in body
    assert "p_w.mtx" in body
    assert "<p>Warning: pairs lie apart.</p>" in body[: body.index("<dl")]
    assert body.count("pairs lie apart") == 2  # and among the sources
    assert "p<sub>w</sub> mean" in body


SAID = {
    "one-node-separation": r"At the nominal load \(λ = 1\) the joint is in separation, in the simulation: .*\.",
    "jump": r"At the nominal load \(λ = 1\) the joint shakes down with node 1 open, proved by following its cycles\.",
    "receding-block": r"At the nominal load \(λ = 1\) the joint .*nodes? .*",
    "uncoupled": rf".*slips in every cycle, with a slip range of up to {NUMBER} at node \d, in the simulation\.",
}


@pytest.mark.parametrize("name", SAID)
def test_the_sentence_of_every_outcome_is_true(name):
    assert re.fullmatch(SAID[name], answer_in_words(nominal(name)))


def test_a_body_that_slides_away_does_not_hold():
    free = Problem(A=[[0.0]], B=[[0.0]], C=[[1.0]], f=0.5, q_w=[[0.9], [-0.1]], p_w=[[1.0], [1.0]])
    v = verified(free)
    assert answer_in_words(v).startswith("At the nominal load (λ = 1) the joint does not hold: ")
    assert "gross slip" in answer_in_words(v)
    assert rest_table(v).rows[0][1] == "–"


@pytest.mark.usefixtures("undrawn")
def test_of_a_load_domain_what_is_simulated_is_said_to_be_one_path():
    domain = replace(shakedown.example("two-node"), load_path="domain")
    v = verified(domain)
    assert ", with the corners of the load domain in their order" in answer_in_words(v)
    assert "one path of many" in Page(render(v)).text[:2500]


def test_a_state_that_is_none_of_those_that_every_state_means_says_why():
    joint = shakedown.example("two-node")
    inside, outside = (shakedown.assess(joint, slip) for slip in ([0.5, 0.0], [0.0, -1.5]))
    assert outside.proved_from_this_state < outside.proved_from_every_state
    said = "The first load step makes node 1 slip, so the given slip is not one of these states."
    assert said in margin_in_words(outside)
    assert "first load step" not in margin_in_words(inside)


def test_a_proof_of_another_zone_is_no_margin():
    v = nominal("receding-block")
    assert v.limits.open_nodes
    assert proved_limit(v.assessment).load_factor == 0
    assert "proved" not in margin_of_answer(v)


@pytest.mark.usefixtures("undrawn")
def test_a_floating_joint_says_what_slips_are_relative_to():
    A = np.array([[1.0, -1.0], [-1.0, 1.0]])
    free = Problem(
        A=A, B=np.zeros((2, 2)), C=np.eye(2), f=0.5, q_w=[[0.1, 0.1], [-0.1, -0.1]], p_w=np.ones((2, 2))
    )
    text = Page(render(verified(free))).text
    assert "Only friction keeps one body from sliding or turning on the other" in text


@pytest.mark.parametrize(("value", "rounded"), [(1.00004, down), (0.99996, up), (1.0, down), (1e-9, up)])
def test_a_rounded_load_factor_stays_on_its_side_of_one(value, rounded):
    shown = float(beside_one(value, rounded))
    assert np.sign(shown - 1) == np.sign(value - 1)
    assert shown <= value if rounded is down else shown >= value
