"""Results as JSON-ready dictionaries, with the field names that other programs rely on."""

import json
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from shakedown.model.problem import Problem
from shakedown.visible_text import visible

if TYPE_CHECKING:
    from shakedown.bounds.guarantee_curve import GuaranteeCurve
    from shakedown.bounds.shakedown_bounds import ShakedownBounds
    from shakedown.bounds.upper import UpperBound
    from shakedown.energy.energy_bound import EnergyBound
    from shakedown.enumeration.critical import CriticalLoadFactors, Intersection
    from shakedown.friction.thresholds import FrictionThresholds, Threshold
    from shakedown.long_term.simulation import Simulation
    from shakedown.long_term.transient_limit import TransientLimit
    from shakedown.universal.universal_bound import UniversalBound
    from shakedown.verification.verify import Verification


def plain(value: Any) -> Any:
    """A value as JSON knows it: arrays as lists, infinities as "inf"/"-inf", undefined numbers as None.

    Examples
    --------
    >>> plain({"slip": np.array([1.0, np.nan]), "load_factor": math.inf})
    {'slip': [1.0, None], 'load_factor': 'inf'}
    """
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float):
        if math.isnan(value):
            return None
        return value if math.isfinite(value) else ("inf" if value > 0 else "-inf")
    if isinstance(value, str):  # an enumeration member becomes its text
        return str(value)
    return value


def as_text(document: dict[str, Any]) -> str:
    """A JSON document as it is written to files and to stdout, without characters that a terminal obeys."""
    text = json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False)
    return visible(text, keep="\n", escape=_json_escape)


def _json_escape(character: str) -> str:
    code = ord(character)
    return f"\\u{code:04x}" if code < 0x10000 else json.dumps(character)[1:-1]


def problem_document(problem: Problem) -> dict[str, Any]:
    """Name and size of a problem."""
    return {"name": problem.name, "n": problem.n, "m": problem.m}


def bounds_document(problem: Problem, bounds: "ShakedownBounds") -> dict[str, Any]:
    """Both bounds as ``shakedown-bounds solve --json`` writes them (without the friction part)."""
    lower, upper = bounds.lower, bounds.upper
    lower_keys = (
        "status load_factor node slip kind single_node_bound guarantee reason coupling_ratio "
        "lift_off_bound certified uncertified reduced_accuracy residual"
    )
    return plain(
        {
            "problem": problem_document(problem),
            "lower": {key: getattr(lower, key) for key in lower_keys.split()},
            "upper": upper_document(upper),
        }
    )


def upper_document(upper: "UpperBound") -> dict[str, Any]:
    """λ_max with its zone and its evidence."""
    keys = (
        "status load_factor least_load_factor slip open_nodes direction active certified uncertified exact "
        "reduced_accuracy reason residual"
    )
    return plain({key: getattr(upper, key) for key in keys.split()})


def quick_document(problem: Problem, energy: "EnergyBound", upper: "UpperBound") -> dict[str, Any]:
    """What ``shakedown-bounds solve --quick --json`` writes."""
    from shakedown.energy.energy_bound import energy_document

    document = {"problem": problem_document(problem), "energy": energy_document(energy)}
    return plain(document | {"upper": upper_document(upper)})


def proved_document(energy: "EnergyBound", universal: "UniversalBound") -> dict[str, Any]:
    """What is proved from one state (energy bound) and from every one, as ``solve --json`` writes it."""
    from shakedown.energy.energy_bound import energy_document  # loads Clarabel, but so did the bound

    return plain({"energy": energy_document(energy)} | universal.document())


def curve_document(curve: "GuaranteeCurve") -> dict[str, Any]:
    """λ_1(R) as ``shakedown-bounds solve --json`` writes it."""
    keys = ("status", "radii", "load_factors", "nodes", "unit", "weights", "invariant")
    return plain({key: getattr(curve, key) for key in keys})


def transient_document(limit: "TransientLimit") -> dict[str, Any]:
    """The transient limit λ_T, with every load factor that was simulated for it."""
    keys = "load_factor low high proved cycling initial_slip scanned outcomes monotone"
    return plain({key: getattr(limit, key) for key in keys.split()})


def verification_document(verification: "Verification") -> dict[str, Any]:
    """A verification as ``shakedown-bounds verify --json`` and the report's JSON file have it."""
    v = verification
    document = bounds_document(v.problem, v.bounds) | proved_document(v.energy, v.universal)
    runs = [
        {
            "region": run.region,
            "initial": run.initial,
            "initially_open": run.open_nodes,
            "predicted": run.predicted,
            "agrees": run.agrees,
            "seconds": run.seconds,
            **simulation_document(run.simulation),
        }
        for run in v.runs
    ]
    return document | plain(
        {
            "agrees": v.agrees,
            "disagreements": v.disagreements,
            "open_questions": v.open_questions,
            "notes": v.notes,
            "second_road": {
                "solver": v.second_upper.solver,
                "lower": {"status": v.second_lower.status, "load_factor": v.second_lower.load_factor},
                "upper": {"status": v.second_upper.status, "load_factor": v.second_upper.load_factor},
            },
            "critical": {"total": v.subsets} | ({} if v.critical is None else critical_document(v.critical)),
            "friction": friction_document(v.friction),
            "transient": None if v.transient is None else transient_document(v.transient),
            "guarantee_curve": None if v.curve is None else curve_document(v.curve),
            "runs": runs,
        }
    )


def simulation_document(run: "Simulation") -> dict[str, Any]:
    """A simulation as ``shakedown-bounds simulate --json`` writes it."""
    keys = (
        "load_factor outcome reason period initial_slip final_slip drift slip_per_cycle "
        "dissipation_per_cycle friction_dissipation_per_cycle jump_dissipation_per_cycle jumps_per_cycle "
        "open_nodes proved energy_margin cycles_simulated method events residual"
    )
    jump_keys = ("cycle", "energy_released", "friction_work", "damping_work")
    jumps = [{key: getattr(jump, key) for key in jump_keys} for jump in run.jumps]
    return plain({key: getattr(run, key) for key in keys.split()} | {"jumps": jumps})


def critical_document(critical: "CriticalLoadFactors") -> dict[str, Any]:
    """The critical load factors as ``shakedown-bounds critical --json`` writes them."""
    document = {
        "total": critical.total,
        "regular": critical.regular,
        "degenerate": critical.degenerate,
        "degenerate_rows": critical.degenerate_rows,
        "smallest_positive": _intersection_document(critical.smallest_positive),
        "smallest_feasible": _intersection_document(critical.smallest_feasible),
    }
    if critical.load_factors is not None:
        document["load_factors"] = critical.load_factors
    return plain(document)


def _intersection_document(intersection: "Intersection") -> dict[str, Any]:
    keys = ("load_factor", "slip", "rows", "residual")
    return {key: getattr(intersection, key) for key in keys}


def friction_document(limits: "FrictionThresholds") -> dict[str, Any]:
    """Friction thresholds as ``shakedown-bounds solve --json`` writes them.

    A threshold of which only an interval is known is None; the interval stands beside it.
    """
    return plain(
        {
            "single_node": limits.single_node,
            "uniqueness_in_contact": limits.uniqueness_in_contact.value,
            "uniqueness_in_contact_interval": _interval(limits.uniqueness_in_contact),
            "uniqueness": None if limits.uniqueness is None else limits.uniqueness.value,
            "uniqueness_interval": None if limits.uniqueness is None else _interval(limits.uniqueness),
            "wedging": limits.wedging.value,
            "wedging_interval": [limits.wedging.low, limits.wedging.high],
            "unit": "factor on f" if limits.factor else "friction coefficient",
        }
    )


def _interval(threshold: "Threshold") -> list[float]:
    return [threshold.low, threshold.high]
