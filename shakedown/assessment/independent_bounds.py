"""Both bounds again by an independent solver, and a comparison of the two answers."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from shakedown.assessment.every_limit import ShakedownBounds
from shakedown.bounds.bound_result import Bound
from shakedown.bounds.independent_solver import ConicBound, conic_lower_bound, conic_upper_bound
from shakedown.ground.errors import Missing
from shakedown.ground.status import Status
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.problem import Problem

ALL_NODES = 60  # up to this size the independent solver checks every node; its cost grows as n³
FIRST_NODES = 8  # nodes checked in larger joints: those that collapse first


class SecondBounds(NamedTuple):
    """λ_1, where there is one, and λ_max by another solver, and the number of nodes checked for λ_1."""

    lower: ConicBound | None
    upper: ConicBound
    nodes: int


def second_bounds(problem: Problem, bounds: ShakedownBounds, tolerances: Tolerances) -> SecondBounds:
    """The bounds by Clarabel; for a large joint λ_1 only at the nodes that collapse first by HiGHS."""
    upper = conic_upper_bound(problem, open_nodes=bounds.upper.open_nodes, tolerances=tolerances)
    if isinstance(bounds.lower, Missing):
        return SecondBounds(None, upper, 0)
    nodes = nodes_asked(bounds.lower)
    return SecondBounds(conic_lower_bound(problem, nodes=nodes, tolerances=tolerances), upper, len(nodes))


def nodes_asked(lower: Bound) -> list[int]:
    """The nodes that the independent solver checks, in the order in which they collapse."""
    order = np.argsort(lower.collapse_limits, kind="stable").tolist()  # unknown limits come first
    if lower.node in order:
        order.remove(lower.node)
        order.insert(0, lower.node)
    return order if len(order) <= ALL_NODES else order[:FIRST_NODES]


def independent_findings(
    bounds: ShakedownBounds, second: SecondBounds, tolerances: Tolerances
) -> Iterator[tuple[bool | None, str]]:
    """(False, what differs) or (None, what the independent solver leaves open) for each bound."""
    # As a bound may be zero, differences are relative to λ_max, or to the nominal load.
    size = bounds.upper.load_factor if 0 < bounds.upper.load_factor < np.inf else 1.0
    lower, method = bounds.lower, "the cone program" if second.lower is None else "linear programming"
    for first, other in ((lower, second.lower), (bounds.upper, second.upper)):
        if isinstance(first, Missing) or other is None:
            continue
        name, one, two = first.symbol, first.load_factor, other.load_factor
        closest = tolerances.cross_check if first.reduced_accuracy else tolerances.agreement
        if other.status == Status.UNDECIDED:
            left = f"the value rests on {method} alone"
            yield None, f"{name}: the independent solver ({other.solver}) stopped without an answer; {left}"
        elif first.undecided:  # no zone found; the other bound is for all closed
            continue
        elif first.status != other.status:
            yield False, f"{name}: {first.status} by {method}, {other.status} by the independent solver"
        elif np.isfinite(one) and abs(one - two) > closest * max(abs(one), size):
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
        asked = f"{second.nodes} of {n} nodes, those that collapse first"
        yield None, f"λ_1: the independent solver has sought it at {asked}"
