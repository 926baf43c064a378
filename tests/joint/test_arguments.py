"""Whatever is given to a public function, what it refuses is a ShakedownError with one line."""

import numpy as np
import pytest

import shakedown
from shakedown.models.importing.import_model import import_problem
from shakedown.motion.evolution import evolve
from shakedown.report.html import write_report

JOINT = shakedown.example("two-node")
MISUSE = {
    "slip a word": lambda: shakedown.simulate(JOINT, 0.5, "nought"),
    "slip complex": lambda: shakedown.simulate(JOINT, 0.5, [0, 1j]),
    "slip ragged": lambda: shakedown.simulate(JOINT, 0.5, [[0.0], [1.0, 2.0]]),
    "load factor a word": lambda: shakedown.simulate(JOINT, "a", [0, 0]),
    "load factor none": lambda: shakedown.safe_slip(JOINT, None),
    "load factor a list": lambda: shakedown.safe_slip(JOINT, [1, 2]),
    "load factor overflows": lambda: shakedown.simulate(JOINT, 1e308),
    "cycles a fraction": lambda: shakedown.simulate(JOINT, 0.5, cycles=2.5),
    "cycles a word": lambda: evolve(JOINT, 0.5, cycles="a"),
    "longest period zero": lambda: shakedown.long_term_state(JOINT, 0.5, longest_period=0),
    "damping negative": lambda: evolve(JOINT, 0.5, damping=[-1.0] * 4),
    "seed negative": lambda: shakedown.verify(JOINT, seed=-1),
    "seed a word": lambda: shakedown.verify(JOINT, seed="a"),
    "load factors a number": lambda: shakedown.verify(JOINT, load_factors=0.5),
    "load factors a word": lambda: shakedown.verify(JOINT, load_factors="x"),
    "budget a word": lambda: shakedown.critical_load_factors(JOINT, budget="x"),
    "threads negative": lambda: shakedown.critical_load_factors(JOINT, threads=-1),
    "nodes a fraction": lambda: shakedown.subset_count(2.5),
    "nodes negative": lambda: shakedown.subset_count(-1),
    "example a list": lambda: shakedown.example(["two-node"]),
    "path none": lambda: shakedown.load_problem(None),
    "path a number": lambda: shakedown.load_problem(3),
    "path empty": lambda: shakedown.load_problem(""),
    "save to none": lambda: shakedown.save_problem(None, JOINT),
    "save nothing": lambda: shakedown.save_problem("x.npz", None),
    "import nothing": lambda: import_problem(None),
    "report nothing": lambda: write_report("x.html", None),
    "history of nothing": lambda: shakedown.save_history("x.npz", None),
    "masked array": lambda: shakedown.Problem(
        A=np.ma.array([[1.0]], mask=[[True]]), B=[[0.0]], f=0.3, q_w=[[1.0]], p_w=[[1.0]]
    ),
}


@pytest.mark.parametrize("kind", MISUSE)
def test_misuse_is_refused_in_one_line(kind):
    with pytest.raises(shakedown.ShakedownError) as caught:
        MISUSE[kind]()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "function",
    [
        shakedown.lower_bound,
        shakedown.upper_bound,
        shakedown.shakedown_bounds,
        shakedown.critical_load_factors,
        shakedown.friction_thresholds,
        shakedown.transient_limit,
        shakedown.verify,
        lambda problem: shakedown.safe_slip(problem, 1.0),
        lambda problem: shakedown.simulate(problem, 1.0),
        lambda problem: shakedown.simulate(problem, 1.0, method="gauss-seidel"),
        lambda problem: evolve(problem, 1.0),
        lambda problem: shakedown.long_term_state(problem, 1.0),
    ],
)
@pytest.mark.parametrize("thing", [None, {"A": 1}, "two-node"])
def test_a_problem_must_be_a_problem(function, thing):
    with pytest.raises(shakedown.UsageError, match="expected a Problem, found"):
        function(thing)
