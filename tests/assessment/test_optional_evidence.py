"""A certificate never changes and never kills an answer: every optional step fails in turn."""

import json

import pytest
from command import document, run

import shakedown
from shakedown.bounds import certificate
from shakedown.ground.errors import SolverError

WHY = "made to fail"
CERTIFICATES = [
    "bounds.certificate.certified_upper",
    "bounds.certificate.certified_lower",
    "bounds.energy.energy_bound._certificate",
]
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
    found = _verified()
    for bound in ("lower", "upper", "energy"):
        here, there = (getattr(each.limits, bound).load_factor for each in (found, verified))
        assert here == pytest.approx(there, rel=LOOSE)
    plain = {(run.simulation.load_factor, run.initial): run.simulation.outcome for run in verified.runs}
    here = {(run.simulation.load_factor, run.initial): run.simulation.outcome for run in found.runs}
    assert plain.items() >= {k: v for k, v in here.items() if k in plain}.items()
    assert found.agrees


@pytest.fixture(scope="module")
def verified():
    return _verified()


def _verified():
    return shakedown.verify(shakedown.example("two-node"), random_states=0, load_factors=[0.7], budget=0)


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
