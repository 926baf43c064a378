"""Every study measures, prints and draws; exact paths and built-in problems are what they are said to be."""

import importlib
import json
from dataclasses import fields
from fractions import Fraction

import numpy as np
import pytest

import shakedown
from benchmarks import STUDIES, calculix_peer, timing
from benchmarks.bodies.small_problems import small_problems
from benchmarks.problems import random_problem
from benchmarks.rational_path import one_step_holds, rational_path
from benchmarks.stability_scenes import coarse, one_node
from shakedown.motion.course import EventKind
from shakedown.motion.evolution import evolve

BUILT_IN = small_problems()
PEERS = {"calculix_contact": calculix_peer}  # without which no case is left

# The fewest cases from which a study can print and draw; the first case alone where nothing is said here.
FEWEST = {
    "bounds": [{"n": 10}],
    "creep": [{"kind": "uncoupled"}, {"kind": "steps"}],
    "damping": [{"part": "row"}],
    "enumeration": [{"n": 6}],
    "evolution": [{"scene": "two-node", "method": "gauss-seidel", "parts": 1}],
    "hard_cases": [{"problem": "load factor 0"}],
    "long_term": [{"scene": "random 2", "exponent": 1, "start": 0}],
    "space_peers": [{"part": "paths", "scene": "25, closed, few slip", "method": "implicit", "parts": 1}],
    "stability": [{"scene": "from the limit"}, {"scene": "condition 1e14", "method": "event"}],  # one stops
    "verify_times": [{"what": "λ_max"}],
}


def test_a_slip_is_the_overshoot_over_the_resistance() -> None:
    """One node with A = 1, B = 1/2, f = 1/2: backward slip of (q − f p) / (A − f B), then the other way."""
    problem = one_node(0.5, [0.0, 2.0, -2.0], [2.0, 2.0, 2.0])
    u = rational_path(problem, 1.0, np.zeros(1), 1).u
    backward = -Fraction(1) / Fraction(3, 4)  # A − f B
    trial = -2 + backward + Fraction(1, 2) * (2 + backward / 2)  # q + f p before it slips forward
    assert [state[0] for state in u] == [0, backward, backward - trial / Fraction(5, 4)]


@pytest.mark.parametrize(("n", "seed"), [(1, 0), (2, 1), (3, 2), (4, 3)])
def test_rational_and_event_driven_paths_agree(n: int, seed: int) -> None:
    problem = random_problem(n, seed, m=8)
    load_factor = 1.4 * shakedown.upper_bound(problem).load_factor
    exact = rational_path(problem, load_factor, np.zeros(n), 2).slips(2)
    history = evolve(problem, load_factor, cycles=2).history
    steps = history.rows(history.kind == EventKind.LOAD_STEP)
    assert np.abs(steps.v[1:] - exact).max() <= 1e-13 * np.ptp(exact)


def test_long_load_steps_are_told_from_short_ones() -> None:
    hard, easy = coarse(), random_problem(3, seed=1, m=8)
    assert not one_step_holds(hard.problem, rational_path(hard.problem, 1.0, hard.start, 2))
    assert one_step_holds(easy, rational_path(easy, 1.0, np.zeros(3), 2))


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.needs(PEERS[name])) if name in PEERS else name for name in STUDIES],
)
def test_a_study_measures_prints_and_draws(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(timing, "LEAST", 0.0)  # times mean nothing here
    study = importlib.import_module(f"benchmarks.{name}")
    cases = list(study.cases(True))
    fewest = FEWEST.get(name, [cases[0]])
    chosen = [case for case in cases if any(few.items() <= case.items() for few in fewest)]
    rows = [case | study.measure(case) for case in chosen]
    assert rows
    assert json.loads(json.dumps(rows, allow_nan=False)) == rows
    assert study.tables(rows).strip()
    if hasattr(study, "figures"):
        for figure in study.figures(rows).values():
            figure.canvas.draw()


@pytest.mark.parametrize("name", BUILT_IN)
def test_a_built_in_problem_is_as_it_is_defined(name):
    """To the round-off of the processor that wrote the file."""
    stored, defined = shakedown.example(name), BUILT_IN[name]
    for field in fields(defined):
        one, other = getattr(stored, field.name), getattr(defined, field.name)
        if isinstance(other, np.ndarray) and other.dtype == float:
            np.testing.assert_allclose(one, other, rtol=1e-13, atol=1e-13 * np.abs(other).max(initial=0.0))
        else:
            assert np.all(one == other)
