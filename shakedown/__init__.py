"""Shakedown analysis of elastic contacts with Coulomb friction.

Every public name is loaded when it is first used, so that a command pays only
for what it needs.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from shakedown.bounds import ShakedownBounds as ShakedownBounds
    from shakedown.bounds import shakedown_bounds as shakedown_bounds
    from shakedown.condensation import Condensation as Condensation
    from shakedown.condensation import condense as condense
    from shakedown.condensation import condensed_stiffness as condensed_stiffness
    from shakedown.conic import ConicBound as ConicBound
    from shakedown.conic import conic_lower_bound as conic_lower_bound
    from shakedown.conic import conic_upper_bound as conic_upper_bound
    from shakedown.curve import GuaranteeCurve as GuaranteeCurve
    from shakedown.curve import guarantee_curve as guarantee_curve
    from shakedown.enumeration import CriticalLoadFactors as CriticalLoadFactors
    from shakedown.enumeration import collapse_by_enumeration as collapse_by_enumeration
    from shakedown.enumeration import critical_load_factors as critical_load_factors
    from shakedown.enumeration import load_factors_above as load_factors_above
    from shakedown.enumeration import subset_count as subset_count
    from shakedown.errors import BudgetExceeded as BudgetExceeded
    from shakedown.errors import ProblemError as ProblemError
    from shakedown.errors import ShakedownError as ShakedownError
    from shakedown.errors import SolverError as SolverError
    from shakedown.errors import UsageError as UsageError
    from shakedown.event_history import EventHistory as EventHistory
    from shakedown.event_history import EventKind as EventKind
    from shakedown.evolution import Evolution as Evolution
    from shakedown.evolved import EvolutionResult as EvolutionResult
    from shakedown.evolved import evolve as evolve
    from shakedown.examples import example as example
    from shakedown.examples import example_names as example_names
    from shakedown.importing import Import as Import
    from shakedown.importing import import_model as import_model
    from shakedown.importing import import_problem as import_problem
    from shakedown.intersection import Intersection as Intersection
    from shakedown.jump import Jump as Jump
    from shakedown.load_case import LoadCase as LoadCase
    from shakedown.long_term import long_term_state as long_term_state
    from shakedown.long_term_record import LongTermState as LongTermState
    from shakedown.lower import LowerBound as LowerBound
    from shakedown.lower import lower_bound as lower_bound
    from shakedown.margin import SafeSlip as SafeSlip
    from shakedown.margin import safe_slip as safe_slip
    from shakedown.npz import load_problem as load_problem
    from shakedown.npz import save_problem as save_problem
    from shakedown.outcome import Cycles as Cycles
    from shakedown.outcome import Outcome as Outcome
    from shakedown.problem import Problem as Problem
    from shakedown.report import report_path as report_path
    from shakedown.report import write_report as write_report
    from shakedown.scene import Scene as Scene
    from shakedown.scene import reduced_scene as reduced_scene
    from shakedown.simulation import Simulation as Simulation
    from shakedown.simulation import save_history as save_history
    from shakedown.simulation import simulate as simulate
    from shakedown.stepping import History as History
    from shakedown.thresholds import FrictionThresholds as FrictionThresholds
    from shakedown.thresholds import Threshold as Threshold
    from shakedown.thresholds import friction_thresholds as friction_thresholds
    from shakedown.transient import TransientLimit as TransientLimit
    from shakedown.transient import transient_limit as transient_limit
    from shakedown.upper import UpperBound as UpperBound
    from shakedown.upper import upper_bound as upper_bound
    from shakedown.verification import Run as Run
    from shakedown.verification import Verification as Verification
    from shakedown.verification import verify as verify
    from shakedown.wedging import Wedging as Wedging

_HOMES = {
    "shakedown.errors": "ShakedownError ProblemError UsageError BudgetExceeded SolverError",
    "shakedown.problem": "Problem",
    "shakedown.npz": "load_problem save_problem",
    "shakedown.condensation": "Condensation condense condensed_stiffness",
    "shakedown.importing": "Import import_model import_problem",
    "shakedown.load_case": "LoadCase",
    "shakedown.margin": "SafeSlip safe_slip",
    "shakedown.bounds": "ShakedownBounds shakedown_bounds",
    "shakedown.enumeration": (
        "CriticalLoadFactors critical_load_factors subset_count collapse_by_enumeration load_factors_above"
    ),
    "shakedown.upper": "UpperBound upper_bound",
    "shakedown.lower": "LowerBound lower_bound",
    "shakedown.curve": "GuaranteeCurve guarantee_curve",
    "shakedown.intersection": "Intersection",
    "shakedown.conic": "ConicBound conic_lower_bound conic_upper_bound",
    "shakedown.examples": "example example_names",
    "shakedown.event_history": "EventHistory EventKind",
    "shakedown.evolution": "Evolution",
    "shakedown.evolved": "EvolutionResult evolve",
    "shakedown.scene": "Scene reduced_scene",
    "shakedown.transient": "TransientLimit transient_limit",
    "shakedown.thresholds": "FrictionThresholds Threshold friction_thresholds",
    "shakedown.jump": "Jump",
    "shakedown.long_term": "long_term_state",
    "shakedown.long_term_record": "LongTermState",
    "shakedown.stepping": "History",
    "shakedown.wedging": "Wedging",
    "shakedown.outcome": "Cycles Outcome",
    "shakedown.simulation": "Simulation save_history simulate",
    "shakedown.verification": "Run Verification verify",
    "shakedown.report": "report_path write_report",
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
