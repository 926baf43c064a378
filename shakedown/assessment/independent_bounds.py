"""Both bounds once more by an independent solver, and what the two answers say of each other."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from shakedown.assessment.shakedown_bounds import ShakedownBounds
from shakedown.bounds.collapse.lower import LowerBound
from shakedown.bounds.independent_solver import ConicBound, conic_lower_bound, conic_upper_bound
from shakedown.bounds.results import UpperBound
from shakedown.ground.errors import Missing
from shakedown.ground.status import Status
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.problem import Problem

ALL_NODES = 60  # up to so many nodes every one is asked by the independent solver; its programs grow as n³
FIRST_NODES = 8  # of larger joints those that collapse first


class SecondBounds(NamedTuple):
    """λ_1, where there is one, and λ_max by another solver, and how many nodes λ_1 was sought at."""

    lower: ConicBound | None
    upper: ConicBound
    nodes: int


def second_bounds(problem: Problem, bounds: ShakedownBounds, tolerances: Tolerances) -> SecondBounds:
    """The bounds by Clarabel; λ_1 of a large joint at the nodes alone that collapse first by HiGHS."""
    upper = conic_upper_bound(problem, open_nodes=bounds.upper.open_nodes, tolerances=tolerances)
    if isinstance(bounds.lower, Missing):
        return SecondBounds(None, upper, 0)
    nodes = nodes_asked(bounds.lower)
    return SecondBounds(conic_lower_bound(problem, nodes=nodes, tolerances=tolerances), upper, len(nodes))


def nodes_asked(lower: LowerBound) -> list[int]:
    """The nodes that are asked by the independent solver, the first to collapse foremost."""
    order = np.argsort(lower.collapse_limits, kind="stable").tolist()  # where nothing is known: foremost
    if lower.node in order:
        order.remove(lower.node)
        order.insert(0, lower.node)
    return order if len(order) <= ALL_NODES else order[:FIRST_NODES]


def _closest(bound: LowerBound | UpperBound, tolerances: Tolerances) -> float:
    """How far both answers may be apart: what says that it is of reduced accuracy proves no disagreement."""
    return tolerances.cross_check if bound.reduced_accuracy else tolerances.agreement


def independent_findings(
    bounds: ShakedownBounds, second: SecondBounds, tolerances: Tolerances
) -> Iterator[tuple[bool | None, str]]:
    """(False, what differs) or (None, what the independent solver leaves open) for each bound."""
    # A bound may be zero: it is compared on the scale of λ_max, or of the nominal loop.
    size = bounds.upper.load_factor if 0 < bounds.upper.load_factor < np.inf else 1.0
    lower = bounds.lower
    pairs: list[tuple[str, LowerBound | UpperBound, ConicBound]] = [("λ_max", bounds.upper, second.upper)]
    if second.lower is not None and not isinstance(lower, Missing):
        pairs.insert(0, ("λ_1", lower, second.lower))
    method = "linear programming" if second.lower is not None else "the cone program"
    for name, first, other in pairs:
        one, two = first.load_factor, other.load_factor
        if other.status == Status.UNDECIDED:
            left = f"the value rests on {method} alone"
            yield None, f"{name}: the independent solver ({other.solver}) stopped without an answer; {left}"
        elif first.status == Status.UNDECIDED:  # no zone was found: the other is about all nodes closed
            continue
        elif first.status != other.status:
            yield False, f"{name}: {first.status} by {method}, {other.status} by the independent solver"
        elif np.isfinite(one) and abs(one - two) > _closest(first, tolerances) * max(abs(one), size):
            seen = abs(one - two) > tolerances.agreement * other.unit
            end = "" if seen else ", which tells no smaller ones apart"
            text = f"{name}: {one:.10g} by {method}, {two:.10g} by the independent solver{end}"
            yield False if seen else None, text
        elif first.reduced_accuracy:
            yield None, f"{name}: by {method} only to reduced accuracy (1e-7)"
    if isinstance(lower, Missing):
        return
    n = lower.problem.n
    if second.nodes < n and lower.load_factor > tolerances.feasibility:
        yield (
            None,
            f"λ_1: the independent solver has sought it at {second.nodes} of {n} nodes, those that collapse "
            "first",
        )
