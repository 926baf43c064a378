"""Shakedown analysis of elastic contacts with Coulomb friction.

Every public name is loaded when it is first used, so that a command pays only
for what it needs.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.2.0"

if TYPE_CHECKING:
    from shakedown.assessment.shakedown_bounds import ShakedownBounds as ShakedownBounds
    from shakedown.assessment.shakedown_bounds import shakedown_bounds as shakedown_bounds
    from shakedown.assessment.transient_limit import TransientLimit as TransientLimit
    from shakedown.assessment.transient_limit import transient_limit as transient_limit
    from shakedown.bounds.energy.energy_ball import EnergyBall as EnergyBall
    from shakedown.bounds.energy.energy_ball import energy_ball as energy_ball
    from shakedown.bounds.energy.energy_bound import EnergyBound as EnergyBound
    from shakedown.bounds.energy.energy_bound import EnergyCertificate as EnergyCertificate
    from shakedown.bounds.energy.energy_bound import energy_bound as energy_bound
    from shakedown.bounds.energy.energy_bound import energy_document as energy_document
    from shakedown.bounds.interior_point import ConicBound as ConicBound
    from shakedown.bounds.interior_point import conic_lower_bound as conic_lower_bound
    from shakedown.bounds.interior_point import conic_upper_bound as conic_upper_bound
    from shakedown.bounds.safe_slip import SafeSlip as SafeSlip
    from shakedown.bounds.safe_slip import safe_slip as safe_slip
    from shakedown.bounds.upper import UpperBound as UpperBound
    from shakedown.bounds.upper import upper_bound as upper_bound
    from shakedown.condensation.condense import Condensation as Condensation
    from shakedown.condensation.condense import condense as condense
    from shakedown.condensation.condense import condensed_stiffness as condensed_stiffness
    from shakedown.condensation.load_case import LoadCase as LoadCase
    from shakedown.files.atomic_write import check_target as check_target
    from shakedown.files.examples import example as example
    from shakedown.files.examples import example_names as example_names
    from shakedown.files.npz import load_initial_slip as load_initial_slip
    from shakedown.files.npz import load_problem as load_problem
    from shakedown.files.npz import save_initial_slip as save_initial_slip
    from shakedown.files.npz import save_problem as save_problem
    from shakedown.ground.errors import BudgetExceeded as BudgetExceeded
    from shakedown.ground.errors import ProblemError as ProblemError
    from shakedown.ground.errors import ShakedownError as ShakedownError
    from shakedown.ground.errors import SolverError as SolverError
    from shakedown.ground.errors import UsageError as UsageError
    from shakedown.ground.float_array import FloatArray as FloatArray
    from shakedown.ground.status import Outcome as Outcome
    from shakedown.ground.status import Status as Status
    from shakedown.ground.tolerances import Tolerances as Tolerances
    from shakedown.importing.contact_figure import contact_picture as contact_picture
    from shakedown.importing.import_model import Import as Import
    from shakedown.importing.import_model import import_model as import_model
    from shakedown.importing.import_model import import_problem as import_problem
    from shakedown.importing.load_evidence import LoadEvidence as LoadEvidence
    from shakedown.importing.templates import import_template as import_template
    from shakedown.importing.templates import import_template_names as import_template_names
    from shakedown.importing.templates import write_import_example as write_import_example
    from shakedown.joint.constraints import SIDE_NAMES as SIDE_NAMES
    from shakedown.joint.constraints import Constraints as Constraints
    from shakedown.joint.constraints import constraints as constraints
    from shakedown.joint.loading import Loading as Loading
    from shakedown.joint.loading import loading as loading
    from shakedown.joint.problem import Problem as Problem
    from shakedown.joint.units import units_of as units_of
    from shakedown.joint.units import work_unit as work_unit
    from shakedown.long_term.cycle_log import Cycles as Cycles
    from shakedown.long_term.find_state import long_term_state as long_term_state
    from shakedown.long_term.fixed_steps import History as History
    from shakedown.long_term.many_states import LongTermStates as LongTermStates
    from shakedown.long_term.many_states import long_term_states as long_term_states
    from shakedown.long_term.simulation import Simulation as Simulation
    from shakedown.long_term.simulation import save_history as save_history
    from shakedown.long_term.simulation import simulate as simulate
    from shakedown.long_term.state import LongTermState as LongTermState
    from shakedown.long_term.state import SettledState as SettledState
    from shakedown.motion.contact_law import Scales as Scales
    from shakedown.motion.contact_law import law_violation as law_violation
    from shakedown.motion.contact_law import reactions as reactions
    from shakedown.motion.contact_law import scales as scales
    from shakedown.motion.event_history import EventHistory as EventHistory
    from shakedown.motion.event_history import EventKind as EventKind
    from shakedown.motion.evolve import EvolutionResult as EvolutionResult
    from shakedown.motion.evolve import evolve as evolve
    from shakedown.motion.integrator import Evolution as Evolution
    from shakedown.motion.reduced_scene import Scene as Scene
    from shakedown.motion.reduced_scene import reduced_scene as reduced_scene
    from shakedown.motion.viscous_jump import Jump as Jump
    from shakedown.planar.collapse.box_bound import BoxBound as BoxBound
    from shakedown.planar.collapse.box_bound import box_bound as box_bound
    from shakedown.planar.collapse.lower import LowerBound as LowerBound
    from shakedown.planar.collapse.lower import lower_bound as lower_bound
    from shakedown.planar.collapse.single_node_cycle import single_node_cycle as single_node_cycle
    from shakedown.planar.enumeration.critical import CriticalLoadFactors as CriticalLoadFactors
    from shakedown.planar.enumeration.critical import collapse_by_enumeration as collapse_by_enumeration
    from shakedown.planar.enumeration.critical import critical_load_factors as critical_load_factors
    from shakedown.planar.enumeration.critical import load_factors_above as load_factors_above
    from shakedown.planar.enumeration.critical import subset_count as subset_count
    from shakedown.planar.enumeration.intersection import Intersection as Intersection
    from shakedown.planar.friction.thresholds import FrictionThresholds as FrictionThresholds
    from shakedown.planar.friction.thresholds import Threshold as Threshold
    from shakedown.planar.friction.thresholds import friction_thresholds as friction_thresholds
    from shakedown.planar.friction.wedging import Wedging as Wedging
    from shakedown.planar.uniqueness.coupling import coupling as coupling
    from shakedown.planar.uniqueness.in_contact import Uniqueness as Uniqueness
    from shakedown.planar.uniqueness.in_contact import unique_in_contact as unique_in_contact
    from shakedown.planar.universal.guarantee_curve import GuaranteeCurve as GuaranteeCurve
    from shakedown.planar.universal.guarantee_curve import guarantee_curve as guarantee_curve
    from shakedown.planar.universal.swing_bound import SwingBound as SwingBound
    from shakedown.planar.universal.swing_bound import swing_bound as swing_bound
    from shakedown.planar.universal.universal_bound import UniversalBound as UniversalBound
    from shakedown.planar.universal.universal_bound import universal_bound as universal_bound
    from shakedown.report.html import report_path as report_path
    from shakedown.report.html import write_report as write_report
    from shakedown.studies.designs.design_point import DesignPoint as DesignPoint
    from shakedown.studies.designs.design_point import Limit as Limit
    from shakedown.studies.designs.diagram import Boundaries as Boundaries
    from shakedown.studies.designs.diagram import Region as Region
    from shakedown.studies.designs.diagram import Sweep as Sweep
    from shakedown.studies.designs.parameters import with_parameter as with_parameter
    from shakedown.studies.designs.smallest_cycle import SmallestCycle as SmallestCycle
    from shakedown.studies.designs.smallest_cycle import smallest_cycle as smallest_cycle
    from shakedown.studies.designs.sweep import sweep as sweep
    from shakedown.studies.designs.table_file import check_table as check_table
    from shakedown.studies.maps.basin_boundary import basin_boundary as basin_boundary
    from shakedown.studies.maps.basin_map import InitialStateMap as InitialStateMap
    from shakedown.studies.maps.limit_cycles import LimitCycle as LimitCycle
    from shakedown.studies.maps.mapping import initial_state_map as initial_state_map
    from shakedown.studies.maps.samplers import Sampler as Sampler
    from shakedown.studies.maps.several_maps import InitialStateMaps as InitialStateMaps
    from shakedown.thesis.corner_report import CornerEnd as CornerEnd
    from shakedown.thesis.corner_report import CornerReport as CornerReport
    from shakedown.thesis.corner_report import corner_report as corner_report
    from shakedown.thesis.corner_report import pair_thresholds as pair_thresholds
    from shakedown.verification.random_paths import random_paths as random_paths
    from shakedown.verification.verify import Run as Run
    from shakedown.verification.verify import Verification as Verification
    from shakedown.verification.verify import verify as verify

_HOMES = {
    "shakedown.joint.units": "units_of work_unit",
    "shakedown.ground.status": "Outcome Status",
    "shakedown.studies.designs.design_point": "DesignPoint Limit",
    "shakedown.studies.designs.diagram": "Boundaries Region Sweep",
    "shakedown.studies.designs.parameters": "with_parameter",
    "shakedown.studies.designs.smallest_cycle": "SmallestCycle smallest_cycle",
    "shakedown.studies.designs.sweep": "sweep",
    "shakedown.studies.designs.table_file": "check_table",
    "shakedown.bounds.energy.energy_ball": "EnergyBall energy_ball",
    "shakedown.bounds.energy.energy_bound": "EnergyBound EnergyCertificate energy_bound energy_document",
    "shakedown.motion.contact_law": "Scales law_violation reactions scales",
    "shakedown.planar.collapse.single_node_cycle": "single_node_cycle",
    "shakedown.planar.uniqueness.coupling": "coupling",
    "shakedown.ground.tolerances": "Tolerances",
    "shakedown.planar.uniqueness.in_contact": "Uniqueness unique_in_contact",
    "shakedown.studies.maps.basin_boundary": "basin_boundary",
    "shakedown.studies.maps.basin_map": "InitialStateMap",
    "shakedown.studies.maps.limit_cycles": "LimitCycle",
    "shakedown.studies.maps.mapping": "initial_state_map",
    "shakedown.studies.maps.samplers": "Sampler",
    "shakedown.studies.maps.several_maps": "InitialStateMaps",
    "shakedown.joint.loading": "Loading loading",
    "shakedown.joint.constraints": "Constraints constraints SIDE_NAMES",
    "shakedown.ground.errors": "ShakedownError ProblemError UsageError BudgetExceeded SolverError",
    "shakedown.ground.float_array": "FloatArray",
    "shakedown.joint.problem": "Problem",
    "shakedown.files.atomic_write": "check_target",
    "shakedown.files.npz": "load_initial_slip load_problem save_initial_slip save_problem",
    "shakedown.condensation.condense": "Condensation condense condensed_stiffness",
    "shakedown.importing.import_model": "Import import_model import_problem",
    "shakedown.importing.contact_figure": "contact_picture",
    "shakedown.importing.load_evidence": "LoadEvidence",
    "shakedown.importing.templates": "import_template import_template_names write_import_example",
    "shakedown.condensation.load_case": "LoadCase",
    "shakedown.bounds.safe_slip": "SafeSlip safe_slip",
    "shakedown.assessment.shakedown_bounds": "ShakedownBounds shakedown_bounds",
    "shakedown.planar.enumeration.critical": (
        "CriticalLoadFactors critical_load_factors subset_count collapse_by_enumeration load_factors_above"
    ),
    "shakedown.planar.collapse.box_bound": "BoxBound box_bound",
    "shakedown.bounds.upper": "UpperBound upper_bound",
    "shakedown.planar.collapse.lower": "LowerBound lower_bound",
    "shakedown.planar.universal.guarantee_curve": "GuaranteeCurve guarantee_curve",
    "shakedown.planar.enumeration.intersection": "Intersection",
    "shakedown.bounds.interior_point": "ConicBound conic_lower_bound conic_upper_bound",
    "shakedown.files.examples": "example example_names",
    "shakedown.thesis.corner_report": "CornerEnd CornerReport corner_report pair_thresholds",
    "shakedown.motion.event_history": "EventHistory EventKind",
    "shakedown.motion.integrator": "Evolution",
    "shakedown.motion.evolve": "EvolutionResult evolve",
    "shakedown.motion.reduced_scene": "Scene reduced_scene",
    "shakedown.assessment.transient_limit": "TransientLimit transient_limit",
    "shakedown.planar.friction.thresholds": "FrictionThresholds Threshold friction_thresholds",
    "shakedown.motion.viscous_jump": "Jump",
    "shakedown.long_term.find_state": "long_term_state",
    "shakedown.long_term.many_states": "LongTermStates long_term_states",
    "shakedown.long_term.state": "LongTermState SettledState",
    "shakedown.long_term.fixed_steps": "History",
    "shakedown.planar.friction.wedging": "Wedging",
    "shakedown.long_term.cycle_log": "Cycles",
    "shakedown.long_term.simulation": "Simulation save_history simulate",
    "shakedown.planar.universal.swing_bound": "SwingBound swing_bound",
    "shakedown.planar.universal.universal_bound": "UniversalBound universal_bound",
    "shakedown.verification.random_paths": "random_paths",
    "shakedown.verification.verify": "Run Verification verify",
    "shakedown.report.html": "report_path write_report",
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
