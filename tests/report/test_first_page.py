"""The first page of a joint: the answer, the claims in the user's loads, what decides, the next step."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from joints import free_pair
from partly_open import SOME, partly_open

import shakedown
from shakedown import Problem
from shakedown.assessment.verify import Verification
from shakedown.ground.shown_values import FEW_DIGITS, down, few, up
from shakedown.joint.units import without_loads
from shakedown.report import notes
from shakedown.report.facts import Sheet, sheet_as_text
from shakedown.report.html import render, write_report
from shakedown.report.limit_facts import decided_by, solve_sheet
from shakedown.report.run_facts import answer, state_facts, verify_sheet, worst_table
from tests.report.test_page import Page, nominal

LOADS = {
    "load_names": ["bolt preload", "axial load"],
    "load_mean": [12.0, 20.0],
    "load_amplitude": [0.0, 20.0],
    "load_units": ["kN", "kN"],
}
COMMAND = re.compile(r"shakedown-bounds .*")


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


def said(sheet: Sheet) -> str:
    return sheet_as_text(sheet)


def fact(sheet: Sheet, label: str) -> str:
    """What is said under one label, value and note; empty where there is none."""
    return " ".join(f"{each.shown} {each.note}".strip() for each in sheet.facts if each.label == label)


@pytest.fixture(scope="module")
def holds() -> Verification:
    return verified(loaded(1.0))


@pytest.fixture(scope="module")
def slips() -> Verification:
    return verified(loaded(5.2))


def joints() -> dict[str, Problem]:
    built_in = {name: shakedown.example(name) for name in shakedown.example_names()}
    return built_in | {f"open {seed}": partly_open(seed) for seed in SOME[:4]} | {"loaded": loaded(1.0)}


@pytest.mark.parametrize("name", joints())
def test_the_first_screen_of_every_joint(name):
    """At most 14 lines of 80 characters, no long sentence; three claims, each named once; one next step."""
    found = shakedown.assess(joints()[name])
    sheet = solve_sheet(found, name)
    lines = said(sheet).splitlines()
    assert len(lines) <= 14 + bool(found.problem.loads) + (name == "loaded")
    assert max(map(len, lines)) <= 80
    told = [*sheet.answer, *(f"{each.shown} {each.note}" for each in sheet.facts)]
    for sentence in re.split(r"(?<=[.:]) ", " ".join(told)):
        assert len(COMMAND.sub("", sentence).split()) <= 25, sentence
    assert [row[0] for row in sheet.claims.rows] == [
        "proved from every state",
        "proved from this state",
        "impossible above",
    ]
    assert [each.label for each in sheet.facts].count("next") == 1
    assert len(sheet.answer) == 1
    assert "(λ = 1)" in sheet.answer[0]
    opened = len(found.details.open_nodes)
    if opened:
        assert sheet.claims.rows[2][1] == f"unknown ({opened} node{'s' * (opened > 1)} open)"
        assert sheet.answer[0].endswith("it is not decided which nodes open.")


@pytest.mark.parametrize("which", ["holds", "slips"])
def test_claims_are_those_of_the_assessment_in_the_loads_of_the_user(which, request):
    v = request.getfixturevalue(which)
    assert (
        said(verify_sheet(v))
        .splitlines()[1]
        .startswith("loads at λ = 1: axial load 20 ± 20 kN; bolt preload")
    )
    claimed = {row[0]: row[1:] for row in verify_sheet(v).claims.rows}
    for claim, exact, rounded in (
        ("proved from this state", v.assessment.proved_from_this_state, down),
        ("impossible above", v.assessment.impossible_above, up),
    ):
        factor, load, margin, *_ = claimed[claim]
        assert float(factor) == pytest.approx(exact, rel=1e-3)
        assert (float(factor) <= exact) == (rounded is down)
        assert load == f"20 ± {rounded(20 * exact, FEW_DIGITS)} kN"
        percent = float(margin.removesuffix(" %").replace("−", "-"))
        assert percent == pytest.approx(100 * (exact - 1), rel=2e-3)
        assert (percent <= 100 * (exact - 1)) == (rounded is down)
    assert claimed["proved from every state"][:2] == ["not proved", ""]


def test_a_joint_that_slips_says_where_and_how_far(slips):
    assert answer(slips) == "At the nominal load (λ = 1) the joint slips in every cycle: simulated."
    nodes = shakedown.node_results(slips.as_given)
    most = int(nodes.slip_range.argmax())
    shown = {each.label: (each.shown, each.note) for each in state_facts(slips)}
    assert shown["largest slip range"] == (
        f"{few(nodes.slip_range[most])} mm",
        f"node {most} (FE {slips.problem.label[most]})",
    )


@pytest.mark.usefixtures("undrawn")
def test_the_largest_results_per_node_are_those_of_the_json(slips, tmp_path):
    write_report(tmp_path / "page.html", slips)
    nodes = json.loads((tmp_path / "page.json").read_text())["nodes"]
    shown = {each.label: (each.shown, each.note) for each in state_facts(slips)}
    for name, column, unit in (
        ("largest slip range", "slip_range", "mm"),
        ("largest slip distance", "accumulated_slip", "mm"),
        ("largest pressure", "pressure_max", "MPa"),
        ("largest friction work", "work", "N mm"),
    ):
        exact = max(nodes[column])
        node = nodes[column].index(exact)
        assert shown[name] == (f"{few(exact)} {unit}", f"node {node} (FE {nodes['label'][node]})")
    assert shown["friction work, all nodes"][0] == f"{few(sum(nodes['work']))} N mm"
    assert sum(int(part.split()[0]) for part in shown["nodes, simulated"][1].split(", ")) == 9


def test_the_worst_nodes_come_first(slips):
    nodes = shakedown.node_results(slips.as_given)
    shown = worst_table(slips.problem, nodes)
    assert shown.head[:4] == ["node", "FE", "status", "slip range [mm]"]
    slip = [float(row[3]) for row in shown.rows]
    assert slip == sorted(slip, reverse=True)
    for row in shown.rows:
        node = int(row[0])
        assert list(row[1:3]) == [slips.problem.label[node], nodes.status[node]]
        assert float(row[4]) == pytest.approx(nodes.accumulated_slip[node], rel=6e-3, abs=1e-12)


def test_where_nothing_slips_no_node_is_said_to(holds):
    shown = {each.label: (each.shown, each.note) for each in state_facts(holds)}
    assert shown["slip"] == ("none", "proved: no node ever slips")
    assert shown["nodes, simulated"] == ("9", "9 stick")
    assert "largest slip range" not in shown


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
    page = render(replace(slips, assessment=shakedown.assess(named)))
    body = re.sub(r'aria-label="[^"]*"', "", page[page.index("</style>") :])
    assert "<h1>Shakedown report: λ_E joint</h1>" in body
    assert "λ<sub>max</sub>" in body
    assert "load = p_w</pre>" in body
    assert "p_w.mtx" in body
    assert body.count("pairs lie apart") == 1


SAID = {
    "one-node-separation": "the joint opens and closes in every cycle: simulated.",
    "jump": "the joint shakes down with node 1 open: proved by following its cycles.",
    "receding-block": "the joint ",
    "uncoupled": "the joint slips in every cycle: simulated.",
    "block-9": "the joint shakes down from zero slip: proved.",
    "bolted-flange": "the joint shakes down from every state: proved.",
}


@pytest.mark.parametrize("name", SAID)
def test_the_answer_is_the_outcome(name):
    assert answer(nominal(name)).startswith(f"At the nominal load (λ = 1) {SAID[name]}")


def test_a_body_that_slides_away_does_not_hold():
    free = Problem(A=[[0.0]], B=[[0.0]], C=[[1.0]], f=0.5, q_w=[[0.9], [-0.1]], p_w=[[1.0], [1.0]])
    v = verified(free)
    assert answer(v) == f"At the nominal load (λ = 1) t{notes.SLIDES_AWAY[1:]}"
    assert fact(verify_sheet(v), "results per node").startswith("none")


@pytest.mark.usefixtures("undrawn")
def test_of_a_load_domain_what_is_simulated_is_said_to_be_one_path():
    v = verified(replace(shakedown.example("two-node"), load_path="domain"))
    page = Page(render(v)).text
    for told in (notes.LOAD_DOMAIN, notes.ONE_PATH):
        assert page.count(told) == 1


def test_a_state_that_is_none_of_those_that_every_state_means_says_why():
    joint = shakedown.example("two-node")
    inside, outside = (shakedown.assess(joint, slip) for slip in ([0.5, 0.0], [0.0, -1.5]))
    assert outside.proved_from_this_state < outside.proved_from_every_state
    why = "the first load step makes node 1 slip, so it is not one of all"
    assert fact(solve_sheet(outside), "this state") == why
    assert fact(solve_sheet(inside), "this state") == ""


def test_a_proof_of_another_zone_is_none_of_the_joint():
    v = nominal("receding-block")
    assert v.limits.open_nodes
    known = {row[0]: row[1] for row in verify_sheet(v).claims.rows}
    for claim in ("proved from every state", "proved from this state", "impossible above"):
        assert known[claim] == "unknown (10 nodes open)"


def test_a_floating_joint_says_what_slips_are_relative_to():
    free = shakedown.assess(free_pair([0.1, -0.1], C=np.eye(2)))
    text = said(solve_sheet(free, details=True))
    assert "slips relative to" in text
    assert text.count("Only friction keeps") == 1


def test_the_mesh_warning_has_its_numbers():
    found = shakedown.assess(shakedown.example("bolted-flange"))
    (warning,) = [each.shown for each in decided_by(found) if each.label == "mesh"]
    (by,) = {f"{100 * by:.0f} % higher" for by in found.details.mesh.coarser.values()}
    assert f"all three limits are {by}" in warning
    assert "17, 23" in warning
