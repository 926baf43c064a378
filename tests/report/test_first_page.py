"""The first page of a joint: the answer, the claims in the user's loads, what decides, the next step."""

import json
import re
from copy import copy
from dataclasses import replace

import numpy as np
import pytest
from partly_open import SOME, partly_open

import shakedown
from shakedown import Problem
from shakedown.assessment.assess import Assessment
from shakedown.assessment.verify import Verification
from shakedown.ground.shown_values import FEW_DIGITS, down, few, up
from shakedown.joint.units import without_loads
from shakedown.report import facts, limit_facts, run_facts
from shakedown.report.facts import Sheet, notes, sheet_as_text
from shakedown.report.html import write_report
from shakedown.report.limit_facts import solve_sheet
from shakedown.report.run_facts import run_sheet, state_facts, verify_sheet
from tests.report.test_page import CLAIMS

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
    names = "one-node-separation three-node receding-block jump uncoupled four-node-3d bolted-flange"
    built_in = {name: shakedown.example(name) for name in names.split()}
    return built_in | {f"open {seed}": partly_open(seed) for seed in SOME[:2]} | {"loaded": loaded(1.0)}


@pytest.mark.parametrize("name", joints())
def test_the_first_screen_of_every_joint(name):
    """At most 14 lines of 80 characters, no long sentence; three claims, each named once; one next step."""
    found = shakedown.assess(joints()[name])
    sheet = solve_sheet(found, name)
    lines = sheet_as_text(sheet).splitlines()
    assert len(lines) <= 14 + bool(found.problem.loads) + (name == "loaded")
    assert max(map(len, lines)) <= 80
    told = [*sheet.answer, *(f"{each.shown} {each.note}" for each in sheet.facts)]
    for sentence in re.split(r"(?<=[.:]) ", " ".join(told)):
        assert len(COMMAND.sub("", sentence).split()) <= 25, sentence
    assert [row[0] for row in sheet.claims.rows] == CLAIMS
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
    shown = verify_sheet(v).headline[1]
    assert shown.startswith("loads at λ = 1: axial load 20 ± 20 kN; bolt preload")
    claimed = {row[0]: row[1:] for row in verify_sheet(v).claims.rows}
    for claim, rounding in (("proved from this state", "down"), ("impossible above", "up")):
        exact, (_, load, margin, *_) = v.assessment.to_dict()[claim.replace(" ", "_")], claimed[claim]
        amplitude = {"down": down, "up": up}[rounding](20 * exact, FEW_DIGITS)
        assert (load, margin) == (f"20 ± {amplitude} kN", facts.margin(exact, rounding))
    assert claimed["proved from every state"][:2] == ["not proved", ""]


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


def test_a_state_that_is_none_of_those_that_every_state_means_says_why():
    joint = shakedown.example("two-node")
    inside, outside = (shakedown.assess(joint, slip) for slip in ([0.5, 0.0], [0.0, -1.5]))
    assert outside.proved_from_this_state < outside.proved_from_every_state
    assert fact(solve_sheet(outside), "this state") == f"moves at once {notes.moves_at_once}"
    assert fact(solve_sheet(inside), "this state") == ""


@pytest.mark.parametrize(
    ("load_factor", "told"), [(0.9, "axial load 20 ± 18 kN; bolt preload 12 kN, unchanged"), (1.0, "")]
)
def test_a_run_tells_its_loads_where_they_are_not_the_nominal_ones(load_factor, told):
    joint = loaded(1.0)
    assert fact(run_sheet(joint, shakedown.simulate(joint, load_factor), "zero"), "loads") == told


@pytest.mark.parametrize(("known", "told"), [(0.5, True), (0.9999, False)])
def test_what_is_proved_by_following_is_told_where_it_is_noticeably_more(slips, known, told):
    """Beside a proof from this state of that share of it."""
    limits, proof = copy(slips.limits), {"load_factor": known * slips.transient.proved}
    changed = {name: getattr(limits, name).but(**proof) for name in ("energy", "accumulated", "universal")}
    vars(limits).update(changed)
    assert bool(fact(verify_sheet(replace(slips, assessment=Assessment(limits))), "followed")) == told


@pytest.mark.parametrize(
    ("cycles", "when"), [(0, "from the start on"), (1, "after 1 cycle"), (2, "after 2 cycles")]
)
def test_it_is_told_how_long_a_motion_is_followed_until_it_is_proved(slips, cycles, when):
    limits, state = copy(slips.limits), copy(slips.transient.at_proved)
    vars(state)["proof_found"] = replace(state.proof_found, cycles=cycles)
    vars(limits)["transient"] = slips.transient.but(at_proved=state)
    assert limit_facts.followed(limits).note == f"proved for this λ only, {when}"


def test_one_run_is_not_all_runs():
    """Without loads zero slip alone has a predicted outcome."""
    joint = shakedown.example("two-node")
    idle = replace(joint, q_w=0.0 * joint.q_w, p_w=0.0 * joint.p_w, q_mean=None, p_mean=None)
    said = run_facts.verdict(shakedown.verify(without_loads(idle)))
    assert said.startswith("Simulation agrees with the limits in 1 run with a predicted outcome")
