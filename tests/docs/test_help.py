"""What ``help`` opens with: the name and its arguments, not the inside of NumPy's types."""

import inspect
import pydoc

import pytest

import shakedown
from shakedown import fem, plot

CALLABLE = {
    f"{module.__name__}.{name}": getattr(module, name)
    for module in (shakedown, fem, plot)
    for name in dir(module)
    if not name.startswith("_")
}
FUNCTIONS = {name: thing for name, thing in CALLABLE.items() if inspect.isfunction(thing)}
MADE = {  # what users construct
    "Problem": shakedown.Problem,
    "LoadCase": shakedown.LoadCase,
    "Tolerances": shakedown.Tolerances,
    **{name: vars(fem)[name] for name in sorted(vars(fem)) if inspect.isclass(vars(fem)[name])},
}
INTERNAL = ("_typing", "numpy.ndarray", "Union[", "ForwardRef")


def opening(thing) -> str:
    """The line of ``help`` with the arguments."""
    lines = pydoc.plain(pydoc.render_doc(thing)).splitlines()
    return next(line for line in lines[2:] if "(" in line and not line.startswith("class "))


@pytest.mark.parametrize("name", FUNCTIONS)
def test_help_of_a_function_opens_with_its_name_and_arguments(name):
    line = opening(FUNCTIONS[name])
    assert line.startswith(f"{name.rpartition('.')[2]}(")
    assert not [word for word in INTERNAL if word in line]
    assert len(line) < 300


@pytest.mark.parametrize("name", MADE)
def test_help_of_a_class_shows_no_internals_of_numpy(name):
    line = opening(MADE[name])
    assert not [word for word in INTERNAL if word in line]


def test_the_types_stay_for_type_checkers_and_tools():
    function = inspect.unwrap(shakedown.simulate)
    assert inspect.get_annotations(shakedown.simulate) == function.__annotations__ != {}
