"""Shakedown analysis of elastic contacts with Coulomb friction.

Every public name is loaded when it is first used, so that a command pays only
for what it needs.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from shakedown.errors import BudgetExceeded as BudgetExceeded
    from shakedown.errors import ProblemError as ProblemError
    from shakedown.errors import ShakedownError as ShakedownError
    from shakedown.errors import SolverError as SolverError
    from shakedown.errors import UsageError as UsageError
    from shakedown.examples import example as example
    from shakedown.examples import example_names as example_names
    from shakedown.npz import load_problem as load_problem
    from shakedown.npz import save_problem as save_problem
    from shakedown.outcome import Outcome as Outcome
    from shakedown.problem import Problem as Problem
    from shakedown.simulation import Simulation as Simulation
    from shakedown.simulation import simulate as simulate

_HOMES = {
    "shakedown.errors": "ShakedownError ProblemError UsageError BudgetExceeded SolverError",
    "shakedown.problem": "Problem",
    "shakedown.npz": "load_problem save_problem",
    "shakedown.examples": "example example_names",
    "shakedown.outcome": "Outcome",
    "shakedown.simulation": "simulate Simulation",
}
_HOME = {name: module for module, names in _HOMES.items() for name in names.split()}

__all__ = [*sorted(_HOME), "__version__"]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'shakedown' has no attribute '{name}'")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
