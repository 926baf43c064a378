"""A new kind of bound needs its function and one entry; a certificate never changes and never kills an answer.

With its entry a kind is in assessments, documents, pages and sweeps. Every optional step fails in turn.
"""

import json
import re
import sys
from dataclasses import dataclass
from types import ModuleType
from typing import ClassVar

import numpy as np
import pytest
from command import document, run

import shakedown
from shakedown.bounds import certificate
from shakedown.bounds.bound_result import Evidence
from shakedown.bounds.registry import BOUNDS, BoundKind, Claim, kinds_of
from shakedown.ground.errors import SolverError
from shakedown.ground.status import Status


@dataclass(frozen=True, eq=False, repr=False)
class OfTwo(Evidence):
    """Evidence of a bound that is a share of another."""

    DOCUMENT: ClassVar[str] = "load_factor status share"

    share: float


@pytest.fixture
def half(monkeypatch):
    """A bound for the state asked about, between what is proved of it and λ_max."""
    module = ModuleType("half_way")

    def of_joint(limits):
        load_factor = 0.5 * (limits.accumulated.load_factor + limits.upper.load_factor)
        return shakedown.Bound("half", Status.OPTIMAL, load_factor, OfTwo(0.5))

    module.of_joint = of_joint
    monkeypatch.setitem(sys.modules, "half_way", module)
    kind = BoundKind("half", "λ_H", "half way", Claim.THIS_STATE, "half_way:of_joint")
    monkeypatch.setitem(BOUNDS, "half", kind)
    return kind


def test_a_new_kind_takes_part_in_what_is_proved(half):
    found = shakedown.assess(shakedown.example("two-node"))
    bound = found.details.half
    assert (bound.symbol, bound.share, half in kinds_of(Claim.THIS_STATE)) == ("λ_H", 0.5, True)
    assert found.proved_from_this_state == bound.load_factor > found.details.accumulated.load_factor
    assert found.details.from_state.kind == "half"


def test_a_new_kind_stands_in_documents_tables_sweeps_and_pictures(half):
    code, text, _ = run("solve", "two-node", "--json")
    said = json.loads(text)
    assert code == 0
    assert set(said["half"]) == {"load_factor", "status", "share"}
    assert said["assessment"]["proved_from_this_state"] == said["half"]["load_factor"]
    assert re.search(r"λ_H +half way +0\.7353", run("solve", "two-node", "--details")[1])
    found = shakedown.sweep(shakedown.example("two-node"), {"f": [0.3, 0.35]}, bounds=("half", "upper"))
    assert found.load_factors("half")[1] == pytest.approx(said["half"]["load_factor"], rel=1e-12)
    assert "lambda_H [1]" in found.columns()
    labels = [line.get_label() for line in shakedown.plot.regions(found).get_lines()]
    assert "λ_H, half way" in labels


def test_what_refutes_a_new_kind_withdraws_it(half, monkeypatch):
    far = lambda limits: shakedown.Bound("half", Status.OPTIMAL, 2.0, OfTwo(2.0))  # noqa: E731
    monkeypatch.setattr(sys.modules["half_way"], "of_joint", far)
    limits = shakedown.assess(shakedown.example("two-node")).details
    assert limits.half.undecided
    assert np.isnan(limits.half.load_factor)
    assert limits.from_state.kind == "accumulated"


def test_a_bound_has_its_evidence_and_says_what_it_has_not():
    bound = shakedown.energy_bound(shakedown.example("two-node"))
    assert bound.radius == bound.evidence.radius > 0
    assert bound.but(radius=1.0, load_factor=0.5).evidence.radius == 1.0
    with pytest.raises(AttributeError, match="kind 'energy' has no 'collapse_limits'"):
        _ = bound.collapse_limits


@pytest.mark.parametrize("name", ["two-node", "one-node-3d"])
def test_every_kind_is_computed_or_says_why_not(name):
    limits = shakedown.assess(shakedown.example(name)).details
    for kind in BOUNDS.values():
        found = getattr(limits, kind.name)
        if kind.exists_for(limits.problem):
            assert (found.kind, found.symbol) == (kind.name, kind.symbol)
        else:
            assert found.reason == kind.absent


WHY = "made to fail"
IN_THE_PLANE = ["bounds.certificate.certified_upper", "bounds.certificate.certified_lower"]
CERTIFICATES = [*IN_THE_PLANE, "bounds.energy.energy_bound._certificate"]
OF_SOLVE = [*CERTIFICATES, "bounds.friction_thresholds.wedging_threshold"]
OF_VERIFY = ["assessment.transient_limit.scanned_limit", "long_term.state.energy_ball"]
ANSWERS = [("lower", "load_factor"), ("upper", "load_factor"), ("energy", "load_factor"), ("lower", "slip"),
           ("upper", "slip"), ("upper", "least_load_factor"), ("universal", "node")]  # fmt: skip
LOOSE = 1e-8  # an exact number is rounded once, a float is what the solver leaves


def fails(*given, **named):
    raise SolverError(WHY)


def details(name):
    return " ".join(run("solve", name, "--details")[1].split())


@pytest.fixture(scope="module")
def expected():
    return {name: document("solve", name) for name in ("two-node", "three-node")}


@pytest.mark.parametrize("step", OF_SOLVE)
def test_solve_keeps_every_answer_and_says_what_is_missing(monkeypatch, expected, step):
    monkeypatch.setattr(f"shakedown.{step}", fails)
    found = document("solve", "two-node")
    for part, word in ANSWERS:
        assert found[part][word] == pytest.approx(expected["two-node"][part][word], rel=LOOSE)
    assert found["friction"]["single_node"] == expected["two-node"]["friction"]["single_node"]
    if step not in CERTIFICATES:
        known = shakedown.friction_thresholds(shakedown.example("two-node"))
        assert known.wedging.low == pytest.approx(known.uniqueness_in_contact.low)
    else:
        assert WHY in json.dumps(found)
        assert WHY in details("two-node")


@pytest.mark.parametrize("step", OF_VERIFY)
def test_verify_keeps_every_answer(monkeypatch, verified, step):
    monkeypatch.setattr(f"shakedown.{step}", fails)
    found = verify_two_node()
    for bound in ("lower", "upper", "energy"):
        here, there = (getattr(each.limits, bound).load_factor for each in (found, verified))
        assert here == pytest.approx(there, rel=LOOSE)
    plain = {(run.simulation.load_factor, run.initial): run.simulation.outcome for run in verified.runs}
    here = {(run.simulation.load_factor, run.initial): run.simulation.outcome for run in found.runs}
    assert plain.items() >= {k: v for k, v in here.items() if k in plain}.items()
    assert found.agrees


def verify_two_node():
    return shakedown.verify(shakedown.example("two-node"), random_states=0, load_factors=[0.7], budget=0)


@pytest.fixture(scope="module")
def verified():
    return verify_two_node()


@pytest.mark.parametrize(
    ("step", "name", "bound"),
    [
        ("bounds.proof_status.lift_off_bound", "two-node", "universal"),
        ("bounds.every_state.universal_bound.least_pressure_bound", "three-node", "universal"),
        ("bounds.energy.energy_bound.largest_load_factor", "two-node", "energy"),
    ],
)
def test_a_bound_whose_programs_fail_is_open_and_no_number(monkeypatch, expected, step, name, bound):
    monkeypatch.setattr(f"shakedown.{step}", fails)
    found = document("solve", name, code=1)
    assert (found[bound]["load_factor"], found[bound]["status"]) == (None, "undecided")
    for other in ("lower", "upper"):
        assert found[other]["load_factor"] == expected[name][other]["load_factor"]
    assert WHY in details(name)


def test_exact_numbers_that_floats_contradict_replace_nothing(monkeypatch):
    """A certificate that is off by far more than the data: the floats stand, and the exit code is 1."""
    made = certificate._certificate

    def off(*given):
        found = made(*given)
        return certificate.replace(found, load_factor=1.01 * found.load_factor)

    joint = shakedown.example("two-node")
    plain = shakedown.shakedown_bounds(joint, certify=False)
    monkeypatch.setattr(certificate, "_certificate", off)
    bounds = shakedown.shakedown_bounds(joint)
    for found, right in ((bounds.upper, plain.upper), (bounds.lower, plain.lower)):
        assert found.load_factor == pytest.approx(right.load_factor, rel=1e-12)
        assert (found.certified, found.disputed) == (None, True)
        assert "on all its digits" in found.uncertified
    found = document("solve", "two-node", code=1)
    assert found["upper"]["certified"] is None
    assert found["upper"]["uncertified"]
