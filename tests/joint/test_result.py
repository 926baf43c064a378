"""Every public result shows itself on one screen, compares by value, and is written as JSON and as a table."""

import copy
import dataclasses
import functools
import inspect
import json
import pickle
import sys
import typing
from contextlib import suppress

import numpy as np
import pytest
from public_names import public

import shakedown
from shakedown.bounds.bound_result import Evidence
from shakedown.bounds.coupling import coupling, unique_in_contact
from shakedown.bounds.every_state.universal_bound import least_pressure_bound
from shakedown.bounds.independent_solver import conic_upper_bound
from shakedown.joint.constraints import constraints, loading
from shakedown.joint.result import WIDTH, Result

# dataclasses with rules of their own
OTHERS = {"BoundKind", "Layout", "Missing", "Problem", "Stiffness", "Tolerances"}
LARGEST = "block-33"


def classes_in(hint):
    """The classes that an annotation names, also those that it holds in brackets."""
    if isinstance(hint, type):
        yield hint
    for part in typing.get_args(hint):
        yield from classes_in(part)


def annotated_return(function):
    try:
        return typing.get_type_hints(function).get("return")
    except NameError:  # a name of matplotlib, imported for the type checker alone
        return None


def properties_of(kind):
    """What computes the public properties of a class."""
    things = [thing for name, thing in inspect.getmembers(kind) if not name.startswith("_")]
    yield from (thing.fget for thing in things if isinstance(thing, property))
    yield from (thing.func for thing in things if isinstance(thing, functools.cached_property))


def public_dataclasses():
    """Those that are public by name, those that public functions return, and what results work out."""
    found = set()
    for thing in public().values():
        if isinstance(thing, type):
            found.add(thing)
        elif inspect.isroutine(thing) or hasattr(thing, "__wrapped__"):
            found |= set(classes_in(annotated_return(thing)))
    for kind in [kind for kind in found if issubclass(kind, Result)]:
        found |= {held for get in properties_of(kind) for held in classes_in(annotated_return(get))}
    found = {kind for kind in found if dataclasses.is_dataclass(kind) and kind.__name__ not in OTHERS}
    return sorted(found, key=lambda kind: kind.__name__)


@pytest.mark.parametrize("kind", public_dataclasses(), ids=lambda kind: kind.__name__)
def test_every_public_dataclass_is_a_result(kind):
    assert issubclass(kind, Result)
    assert kind.__dataclass_params__.frozen
    for own in ("__eq__", "__hash__"):
        assert getattr(kind, own) is getattr(Result, own), f"{kind.__name__}: eq=False"
    assert not kind.__dataclass_params__.repr, f"{kind.__name__}: repr=False"
    for words in (kind.DOCUMENT, kind.TABLE):
        known = {kind, shakedown.Bound} if issubclass(kind, Evidence) else {kind}
        known |= {shakedown.LongTermState} if kind is shakedown.Simulation else set()
        assert all(any(hasattr(k, w) or w in k.__dataclass_fields__ for k in known) for w in words.split())


def two():
    return shakedown.example("two-node")


def many():
    return shakedown.example(LARGEST)


def jumping():
    return shakedown.example("jump")


RESULTS = {  # one of every function that makes one
    "lower": lambda: shakedown.lower_bound(two()),
    "upper": lambda: shakedown.upper_bound(many()),
    "bounds": lambda: shakedown.shakedown_bounds(shakedown.example("one-node")),
    "assessment": lambda: shakedown.assess(two()),
    "limits": lambda: shakedown.assess(shakedown.example("block-9")).details,
    "safe": lambda: shakedown.safe_slip(many(), 0.5),
    "energy": lambda: shakedown.energy_bound(two()),
    "ball": lambda: shakedown.energy_ball(two(), 0.5),
    "friction": lambda: shakedown.friction_thresholds(two()),
    "universal": lambda: shakedown.universal_bound(two()),
    "pressures": lambda: least_pressure_bound(two()),
    "accumulated": lambda: shakedown.accumulated_bound(two()),
    "critical": lambda: shakedown.critical_load_factors(two(), values=True),
    "conic": lambda: conic_upper_bound(two()),
    "simulation": lambda: shakedown.simulate(many(), 0.5, cycles=2, record=True),
    "jump": lambda: shakedown.simulate(jumping(), 1.0, jumping().initial_slip[0]),
    "state": lambda: shakedown.long_term_state(two(), 0.9),
    "limit": lambda: shakedown.transient_limit(two()),
    "unique": lambda: unique_in_contact(two()),
    "verification": lambda: shakedown.verify(shakedown.example("one-node"), random_states=1),
    "run": lambda: made("verification").runs[0],
    "loading": lambda: loading(two()),
    "rows": lambda: constraints(many()),
    "sweep": lambda: shakedown.sweep(two(), {"f": np.linspace(0.1, 0.4, 4)}, bounds=["upper"]),
    "states": lambda: shakedown.long_term_states(two(), 0.9, np.zeros((3, 2))),
    "coupling": lambda: coupling(two()),
    "case": lambda: shakedown.LoadCase(history=np.arange(1000.0), force=np.zeros(5000)),
}


@functools.cache
def made(name):
    return RESULTS[name]()


@pytest.mark.parametrize("name", RESULTS)
def test_shows_itself_on_one_screen(name):
    lines = repr(made(name)).splitlines()
    assert len(lines) <= 24  # one screen
    assert max(map(len, lines)) <= WIDTH
    assert max(len(made(name).in_one_line(width)) - width for width in range(40, 99)) == 0  # as much as fits


@pytest.mark.parametrize(("count", "full", "rest"), [(21, 21, []), (22, 22, []), (23, 21, ["    … 2 more,"])])
def test_long_values_and_many_of_them_fill_the_screen(count, full, rest):
    names = [f"a_name_of_twenty_six_words{k:02}" for k in range(count)]
    options = {"frozen": True, "eq": False, "repr": False}
    kind = dataclasses.make_dataclass("Wordy", [(name, str) for name in names], bases=(Result,), **options)
    for length, width in ((43, WIDTH), (44, WIDTH - 1)):  # it just fits beside its name, or is cut
        head, *lines, end = repr(kind(*["x" * length] * count)).splitlines()
        assert (head, end, lines[full:]) == ("Wordy(", ")", rest)
        assert {(len(line), "…" in line) for line in lines[:full]} == {(width, length == 44)}


@pytest.mark.parametrize("name", RESULTS)
def test_compares_by_value_without_raising(name):
    result = made(name)
    again = pickle.loads(pickle.dumps(result))
    assert again == result
    assert copy.deepcopy(result) == result
    assert result != "result"
    assert result != made("loading" if name != "loading" else "rows")
    assert not result != again  # noqa: SIM202
    with pytest.raises(TypeError, match="unhashable"):
        hash(result)


def parts(value):
    """What a value keeps: its elements or attributes, those that are worked out at the first call included."""
    if isinstance(value, list | tuple):
        return list(value)
    if dataclasses.is_dataclass(value):
        for name, _ in inspect.getmembers_static(
            type(value), lambda a: isinstance(a, functools.cached_property)
        ):
            with suppress(shakedown.ShakedownError):  # what this one does not have
                getattr(value, name)
        value = {name: part for name, part in vars(value).items() if name != "_derived"}
    return list(value.values()) if isinstance(value, dict) else []


def arrays_in(value, seen):
    """All arrays that it keeps, and its parts keep."""
    for part in parts(value):
        if isinstance(part, np.ndarray):
            yield part
        elif id(part) not in seen and not isinstance(part, type):
            seen[id(part)] = part
            yield from arrays_in(part, seen)


@pytest.mark.parametrize("name", RESULTS)
def test_no_array_in_it_can_be_written(name):
    result = made(name)
    for one in (result, copy.deepcopy(result), pickle.loads(pickle.dumps(result))):
        assert not [array.shape for array in arrays_in(one, {}) if array.flags.writeable]


def test_what_somebody_else_holds_stays_writable():
    slip, force = np.zeros(2), np.ones(3)
    case = shakedown.LoadCase(history=[1.0, 0.0], force=force)
    holders = shakedown.long_term_state(two(), 0.5, slip), case
    assert not [array for holder in holders for array in arrays_in(holder, {}) if array.flags.writeable]
    assert all(array.flags.writeable for array in (slip, force))


def changed(value):
    """A field with one of its values another one, or None where it is no number."""
    if isinstance(value, np.ndarray) and value.dtype.kind == "f" and value.size:
        other = value.copy()
        other.flat[-1] = 17.25
        return other
    return 17.25 if isinstance(value, float) else None


@pytest.mark.parametrize("name", RESULTS)
def test_sees_every_difference(name):
    result = made(name)
    for field in dataclasses.fields(result):
        other = changed(getattr(result, field.name))
        if other is None or not field.init:
            continue
        elsewhere = copy.copy(result)
        object.__setattr__(elsewhere, field.name, other)
        assert (elsewhere != result) is field.compare, field.name


@pytest.mark.parametrize("name", RESULTS)
def test_is_json_and_a_table(name):
    document, table = made(name).to_dict(), made(name).to_frame()
    assert document
    assert json.loads(json.dumps(document, allow_nan=False)) == document
    assert min(table.shape) >= 1


def test_a_table_of_nodes_names_them():
    block = dataclasses.replace(shakedown.example(LARGEST), label=[f"P{i}" for i in range(33)])
    table = made("simulation").to_frame(block)
    assert (table.index.name, table.columns[0]) == ("node", "label")
    assert table["label"].iloc[[0, -1]].tolist() == ["P0", "P32"]
    assert np.array_equal(table["slip_per_cycle"], made("simulation").slip_per_cycle)
    assert shakedown.lower_bound(
        dataclasses.replace(shakedown.example("two-node"), label=["a", "b"])
    ).to_frame()["label"].tolist() == ["a", "b"]


def test_tables_have_the_rows_that_one_expects():
    last = ["G[30]", "G[31]", "G[32]", "d", "g", "node", "side", "step"]
    assert made("rows").to_frame().columns.tolist()[30:] == last
    assert made("limit").to_frame().columns.tolist() == ["scanned", "outcomes"]
    assert len(made("critical").to_frame()) == made("critical").regular
    assert len(made("verification").to_frame()) == len(made("verification").runs)
    assert made("bounds").to_frame().columns.tolist()[:2] == ["safe_slip", "witness"]


def test_a_missing_pandas_is_said_in_one_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(shakedown.UsageError, match=r"pip install '\.\[frames\]'"):
        made("upper").to_frame()


@pytest.mark.parametrize(
    ("values", "words"), [([0.1], "0.1"), ([0.1, 0.2], "0.1 … 0.2 (2)"), ([1, 3, 9], "1 … 9 (3)")]
)
def test_a_sweep_shows_its_grid(values, words):
    found = dataclasses.replace(made("sweep"), values=(np.array(values),))
    assert repr(found) == f"Sweep('two-node system (5.3.1)', f = {words}, bounds=upper)"


def test_problems_and_tolerances_are_short():
    assert repr(two()) == "<Problem 'two-node system (5.3.1)', n=2, m=50>"
    long = dataclasses.replace(two(), name="n" * 100, units="u" * 50)
    assert repr(long) == f"<Problem '{'n' * 29}…{'n' * 29}', n=2, m=50, '{'u' * 9}…{'u' * 9}'>"
    assert repr(shakedown.Tolerances()) == "Tolerances()"
    assert repr(shakedown.Tolerances(limit=1e-12)) == "Tolerances(limit=1e-12)"
