"""Every study measures, prints and draws; exact paths and built-in problems are what they are said to be.

In the named collection of hard cases the default method is exact, or says what it is. CalculiX with contact and
friction of its own comes to what the toolkit says of the same joints.
"""

import importlib
import json
from dataclasses import fields
from fractions import Fraction
from functools import cache
from math import inf

import numpy as np
import pytest
from calculix import needs_ccx

import shakedown
from benchmarks import STUDIES, calculix_peer, timing
from benchmarks.bodies.small_problems import small_problems
from benchmarks.calculix_contact import COMPARED, measure, ranges, verdict
from benchmarks.hard_cases import HARD_CASES
from benchmarks.problems import random_problem
from benchmarks.rational_path import one_step_holds, rational_path
from benchmarks.rational_reference import fraction_rows, load_factor_range
from benchmarks.stability_scenes import coarse, one_node
from shakedown.motion.course import EventKind
from shakedown.motion.evolution import evolve

BUILT_IN = small_problems()
PEERS = {"calculix_contact": calculix_peer}  # without which no case is left
SENSITIVE = {"condition 1e8", "condition 1e12", "condition 1e14"}  # the rounded rows have another optimum
UNRESOLVED = {"condition 1e14"}  # whether the softest motion meets a spring or round-off, nobody can tell
DECIDED_EXACTLY = {"barely pulled off"}
SMALL = sorted(name for name, make in HARD_CASES.items() if make().n <= 6)
ROWS = {name: fraction_rows(HARD_CASES[name]()) for name in SMALL}

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


@cache
def safe_range(name: str) -> tuple[Fraction, Fraction | float] | None:
    """The range of safe load factors of a small case, in rational arithmetic."""
    return load_factor_range(*ROWS[name])


@pytest.mark.parametrize("name", sorted(UNRESOLVED))
def test_nothing_is_certified_where_round_off_may_be_a_spring(name: str) -> None:
    bounds = shakedown.shakedown_bounds(HARD_CASES[name](), certify=True)
    for bound in (bounds.upper, bounds.lower):
        assert bound.certified is None
        assert "hardly more than its error: give stiffness_accuracy" in bound.uncertified


@pytest.mark.parametrize("name", sorted(set(SMALL) - UNRESOLVED))
def test_upper_bound_is_the_exact_optimum(name: str) -> None:
    upper, safe = shakedown.upper_bound(HARD_CASES[name]()), safe_range(name)
    assert upper.exact
    assert (safe is None) == (upper.status == "infeasible")
    if safe is None:
        return
    assert (safe[1] == inf) == (upper.status == "unbounded")
    low, high = upper.certified
    assert low <= safe[1] <= high
    assert upper.load_factor == pytest.approx(float(safe[1]), rel=1e-15)


@pytest.mark.parametrize("name", sorted(set(HARD_CASES) - SENSITIVE - DECIDED_EXACTLY))
def test_floats_alone_are_right_to_1e_9(name: str) -> None:
    problem = HARD_CASES[name]()
    for bound, size in ((shakedown.upper_bound, 0.0), (shakedown.lower_bound, 1e-300)):
        exact, plain = (bound(problem, certify=c) for c in (True, False))
        assert plain.status == exact.status
        if bound is shakedown.upper_bound or name != "barely pressed":
            assert plain.load_factor == pytest.approx(exact.load_factor, rel=1e-9, abs=size, nan_ok=True)


@pytest.mark.parametrize("name", sorted(set(HARD_CASES) - UNRESOLVED))
def test_lower_never_exceeds_upper_and_both_are_certified(name: str) -> None:
    bounds = shakedown.shakedown_bounds(HARD_CASES[name]())
    if bounds.upper.status == "infeasible":
        assert bounds.lower.status == "infeasible"
        return
    if bounds.lower.status == "optimal":
        low, high = bounds.lower.certified
        assert low <= bounds.lower.load_factor <= high <= bounds.upper.certified[1]


@pytest.mark.parametrize("name", ["parallel rows", "far beyond critical friction", "wedged", "point loop"])
def test_unbounded_carries_an_exact_direction(name: str) -> None:
    upper = shakedown.upper_bound(HARD_CASES[name]())
    assert (upper.status, upper.exact, upper.certified) == ("unbounded", True, (np.inf, np.inf))
    assert upper.residual <= 1e-12


@needs_ccx
def test_slips_and_pressures_after_one_cycle_are_those_of_the_toolkit_as_the_penalty_grows() -> None:
    case = {"joint": "double lap", "relative": COMPARED["double lap"], "cycles": 1}
    soft, stiff = (measure(case | {"slope": slope}) for slope in (25, 250))
    for key, largest in (("slip_apart", 2e-3), ("pressure_apart", 5e-4)):
        assert stiff[key] < largest
        assert stiff[key] < soft[key] / 5  # in proportion to 1 / penalty
    assert np.count_nonzero(stiff["slip"][1]) >= 10  # of 26 nodes


@needs_ccx
@pytest.mark.parametrize(("relative", "said"), [(0.99, "no slip"), (1.01, "slips in every cycle")])
def test_calculix_comes_to_rest_below_the_transient_limit_only(relative: float, said: str) -> None:
    assert verdict(measure({"joint": "shrink fit", "relative": relative, "slope": 2500, "cycles": 2})) == said


def test_a_range_is_that_of_one_cycle() -> None:
    slip = np.array([[0.0], [3.0], [1.0], [1.0], [2.0], [2.0], [2.0], [2.0], [2.0]])
    assert ranges(slip).tolist() == [[3.0], [0.0]]
