"""Arguments of a wrong kind, to every public function: one line, never a traceback, never a wrong answer."""

import inspect
import re
import typing
import warnings
from decimal import Decimal
from fractions import Fraction
from itertools import count

import numpy as np
import pytest
from public_names import public

import shakedown
from shakedown import ShakedownError, Tolerances, UsageError
from shakedown.bounds.critical import subset_count
from shakedown.bounds.independent_solver import conic_upper_bound
from shakedown.motion.evolution import evolve

JOINT = shakedown.example("two-node")
GIVEN = {
    "problem": JOINT,
    "joint": JOINT,
    "load_factor": 0.5,
    "radii": [0.5],
    "initial_slips": np.zeros((2, 2)),
    "q_w": JOINT.q_w[0],
    "p_w": JOINT.p_w[0],
    "node": 0,
    "vary": {"f": [0.2, 0.3]},
}
HUGE = 10**400
ODD = {
    "none": None,
    "huge": HUGE,
    "huge, negative": -HUGE,
    "huge, listed": [HUGE],
    "too long to be written": 10**5000,
    "too long, listed": [10**5000],
    "nan": float("nan"),
    "text": "x",
    "ragged": [[1.0], [1.0, 2.0]],
    "flags": np.ones(2, dtype=bool),
    "object": object(),
    "true": True,
    "complex": 1j,
    "infinite": float("inf"),
    "close to the end": 1e308,
    "close to the end, listed": [1e308, -1e308],
    "nothing, listed": [None],
    "nothing at all": [],
    "signalling": Decimal("sNaN"),
}
NUMBERS = [Fraction(1, 2), Decimal("0.5"), np.float32(0.5), np.array(0.5), np.float64(0.5)]
WHOLES = [np.int64(1), np.uint8(1), np.array(1)]
SLOW = {"verify", "sweep", "initial_state_map", "transient_limit", "long_term_states"}


FUNCTIONS = {name: thing for name, thing in public().items() if inspect.isfunction(thing)}
CALLABLE = {
    name: f
    for name, f in FUNCTIONS.items()
    if all(
        p.default is not inspect.Parameter.empty or p.name in GIVEN
        for p in inspect.signature(f).parameters.values()
    )
}


def line_of(function, arguments) -> str | None:
    """The one line with which a call is refused; None where it is answered."""
    line = None
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            function(**arguments)
        except ShakedownError as error:
            line = str(error)
    assert line is None or "\n" not in line
    return line


def arguments_of(name):
    parameters = inspect.signature(FUNCTIONS[name]).parameters.values()
    return {p.name: GIVEN[p.name] for p in parameters if p.default is inspect.Parameter.empty}


def parameters_with(test):
    for name, function in CALLABLE.items():
        for parameter in inspect.signature(function).parameters.values():
            if test(parameter):
                yield name, parameter.name


def typed(*kinds):
    """Parameters that their annotations say to be of one of these kinds."""
    types = {name: typing.get_type_hints(function) for name, function in CALLABLE.items()}
    return [
        (name, argument)
        for name, argument in parameters_with(lambda p: True)
        if types[name].get(argument) in kinds
    ]


WITH_TOLERANCES = list(parameters_with(lambda p: p.name == "tolerances"))
FLAGS = typed(bool, bool | None)
ANY = [
    pair
    for pair in parameters_with(lambda p: p.name not in ("path", "progress", "journal"))
    if pair[0] not in SLOW
]


@pytest.mark.parametrize("name", [name for name, _ in WITH_TOLERANCES])
@pytest.mark.parametrize("value", [None, 1e-9], ids=str)
def test_tolerances_are_tolerances(name, value):
    line = line_of(FUNCTIONS[name], arguments_of(name) | {"tolerances": value})
    assert line is not None
    assert line.startswith("tolerances: expected a Tolerances, found ")


@pytest.mark.parametrize(
    "value", ["1e-9", float("nan"), -1e-9, HUGE, True, np.ones(2)], ids=lambda v: repr(v)[:12]
)
@pytest.mark.parametrize("name", ["feasibility", "limit"])
def test_a_tolerance_is_a_number(name, value):
    with pytest.raises(UsageError, match=f"Tolerances: {name}: expected a number( >= 0)?, found "):
        Tolerances(**{name: value})


@pytest.mark.parametrize(("name", "flag"), FLAGS)
@pytest.mark.parametrize("value", [np.ones(2), "yes", 2], ids=lambda v: repr(v)[:12])
def test_flags_are_true_or_false(name, flag, value):
    line = line_of(FUNCTIONS[name], arguments_of(name) | {flag: value})
    assert line is not None
    assert line.startswith(f"{flag.replace('_', ' ')}: expected true or false")


@pytest.mark.parametrize(("name", "argument"), ANY)
def test_odd_values_are_answered_or_refused_in_one_line(name, argument):
    for value in ODD.values():
        line_of(FUNCTIONS[name], arguments_of(name) | {argument: value})


def of_kind(kind):
    """Parameters that are one number of a kind, and what one of it is everywhere."""
    return [pair for pair in typed(kind) if pair[0] not in SLOW]


@pytest.mark.parametrize(("name", "argument"), of_kind(float))
def test_what_numpy_takes_for_a_number_is_one(name, argument):
    plain = repr(outcome(name, argument, 0.5))
    if inspect.isgeneratorfunction(inspect.unwrap(FUNCTIONS[name])):
        plain = None  # nothing of it is done yet
    for number in NUMBERS:
        found = outcome(name, argument, number)
        assert plain is None or repr(found) == plain


@pytest.mark.parametrize(("name", "argument"), of_kind(int))
def test_whole_numbers_of_numpy_are_whole_numbers(name, argument):
    plain = repr(outcome(name, argument, 1))
    if "seconds on one core" not in plain:  # measured
        assert all(repr(outcome(name, argument, number)) == plain for number in WHOLES)
    assert "expected a whole number" in outcome(name, argument, True)
    assert "expected a whole number" in outcome(name, argument, 1.5)


def outcome(name, argument, value):
    """What a function answers, or the line with which it refuses."""
    try:
        return FUNCTIONS[name](**arguments_of(name) | {argument: value})
    except ShakedownError as error:
        return str(error)


MASKED = np.ma.array([[1.0]], mask=[[True]])
WRONG = [
    (lambda: shakedown.simulate(JOINT, 0.5, "nought"), "initial slip: expected numbers or one of zero, given, .* found 'nought'"),
    (lambda: shakedown.simulate(JOINT, 0.5, [0, 1j]), r"initial slip: expected real numbers, found \[0, 1j\]"),
    (lambda: shakedown.simulate(JOINT, 1e308), r"load factor: expected reactions up to 1e\+100, found 1e\+308"),
    (lambda: shakedown.simulate(JOINT, 0.5, tolerances=None), "tolerances: expected a Tolerances, found"),
    (lambda: shakedown.safe_slip(JOINT, None), "load factor: expected a number, found None"),
    (lambda: shakedown.long_term_state(JOINT, 0.5, longest_period=0), "longest_period: expected a whole number from 1"),
    (lambda: evolve(JOINT, 0.5, damping=[-1.0] * 4), "damping: expected 4 positive numbers"),
    (lambda: shakedown.verify(JOINT, seed=-1), "seed: expected a whole number >= 0, found -1"),
    (lambda: shakedown.verify(JOINT, seed="a"), "seed: expected a whole number, found 'a'"),
    (lambda: shakedown.verify(JOINT, load_factors=[None]), "load factors: expected several numbers"),
    (lambda: shakedown.verify(JOINT, random_states=True), "random states: expected a whole number"),
    (lambda: shakedown.verify(JOINT, random_states=2**62), "random states: expected a whole number from 0 to 1,000,000"),
    (lambda: shakedown.initial_state_map(JOINT, 1e308, states=8), "load factor: expected reactions up to"),
    (lambda: shakedown.sweep(JOINT, {}), "expected one or two parameters by name"),
    (lambda: shakedown.sweep(JOINT, "f"), "vary: expected a dictionary, found 'f'"),
    (lambda: shakedown.sweep(JOINT, {"friktion": [0.1]}), "expected one of f, friction, .* found 'friktion'"),
    (lambda: shakedown.sweep(JOINT, {"f": []}), "vary f: expected rising values, at least one, found"),
    (lambda: shakedown.sweep(JOINT, {"f": [0.1, np.nan]}), "vary f: expected finite numbers, found nan"),
    (lambda: shakedown.sweep(JOINT, {"f": [0.3, 0.2]}), r"vary f: expected rising values, at least one, found \[0.3, 0.2\]"),
    (lambda: shakedown.sweep(JOINT, {"f": 0.3}, bounds=["lover"]), "bounds: expected some of lower, .* found lover"),
    (lambda: shakedown.sweep(JOINT, {"f": 0.3}, bounds=["upper", "upper"]), "each once"),
    (lambda: shakedown.sweep(JOINT, {"f": 0.3}, open_nodes="all"), "open nodes: expected several whole numbers or 'auto', found 'all'"),
    (lambda: shakedown.sweep(JOINT, {"f": 0.3}, open_nodes=[2]), "open nodes: expected node numbers from 0 to 1, found 2"),
    (lambda: shakedown.sweep(JOINT, {"f": 0.3}, output="table.txt"), "ends in .csv or .parquet"),
    (lambda: shakedown.sweep("two-node", {"f": 0.3}), "expected a Problem or an Import or a function, found 'two-node'"),
    (lambda: shakedown.initial_state_map(JOINT, -1.0), "load factor: expected a finite number >= 0"),
    (lambda: shakedown.initial_state_map(JOINT, []), "load factor: expected a number, found"),
    (lambda: shakedown.initial_state_map(JOINT, 0.7, workers=0), "workers: expected a whole number >= 1"),
    (lambda: shakedown.initial_state_map(JOINT, 0.7, max_cycles=0), "max_cycles: expected a whole number >= 1"),
    (lambda: shakedown.initial_state_map(JOINT, 0.7, sampler="monte-carlo"), "sampler: expected one of grid, sobol, ball, transients"),
    (lambda: shakedown.initial_state_map(JOINT, 0.7, states=0), "states: expected a whole number from 1"),
    (lambda: shakedown.initial_state_map(JOINT, 0.7, seed=-1), "seed: expected a whole number >= 0"),
    (lambda: shakedown.initial_state_map(JOINT, 0.7, reach=0.0), "reach: expected a number > 0"),
    (lambda: shakedown.initial_state_map(JOINT, 0.7, coordinates=(0, 0)), "two different nodes from 0 to 1"),
    (lambda: shakedown.initial_state_map(JOINT, 0.7, coordinates=(0, 2)), "two different nodes from 0 to 1"),
    (lambda: shakedown.refine(shakedown.example, []), "sizes"),
    (lambda: shakedown.refine(shakedown.example, ["two-node"], radius=-1.0), "radius"),
    (lambda: shakedown.refine(shakedown.example, ["two-node"], load_factor=-1.0), "load factor"),
    (lambda: shakedown.refine(shakedown.example, ["two-node"], slip_below=0.0), "slip"),
    (lambda: shakedown.critical_load_factors(JOINT, threads=-1), "threads: expected a whole number >= 1, found -1"),
    (lambda: conic_upper_bound(JOINT, open_nodes=count()), "expected several whole numbers"),
    (lambda: subset_count(-1), "n: expected a number of nodes from 0 to 10,000, found -1"),
    (lambda: shakedown.load_problem(None), "path: expected text or a path, found None"),
    (lambda: shakedown.load_problem(""), "^: no such file"),
    (lambda: shakedown.Problem(A=MASKED, B=[[0.0]], f=0.3, q_w=[[1.0]], p_w=[[1.0]]), "key 'A': expected every number, found masked"),
]  # fmt: skip


@pytest.mark.parametrize(("call", "said"), WRONG)
def test_what_is_refused_is_said_in_one_line(call, said):
    assert re.search(said, line_of(call, {}) or "answered")


SPACE = shakedown.example("two-node-3d")
IN_SPACE = {
    "problem": SPACE,
    "joint": SPACE,
    "initial_slips": np.zeros((2, 4)),
    "q_w": SPACE.q_w[0],
    "p_w": SPACE.p_w[0],
}


@pytest.mark.parametrize("value", ["nan", "huge", "nothing at all"])
def test_odd_values_beside_a_joint_in_space_are_answered_or_refused_in_one_line(value):
    for name, argument in ANY:
        given = arguments_of(name)
        given |= {key: there for key, there in IN_SPACE.items() if key in given}
        line_of(FUNCTIONS[name], given | {argument: ODD[value]})
