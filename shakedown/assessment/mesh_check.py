"""Whether the edge of the mesh determines a limit, judged from one mesh (docs/mesh.md)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite, isinf, nan
from typing import Any, ClassVar

import numpy as np

from shakedown.ground.constants import EACH_SHOWN, MUCH, FloatArray
from shakedown.ground.errors import SolverError
from shakedown.ground.status import Status
from shakedown.joint.constraints import constraints
from shakedown.joint.contact_surface import surface_of
from shakedown.joint.hat_functions import coarsened
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result

MOST = 0.5  # share of the multipliers at the edge from which on it determines the limit
WORDS = ("impossible_above", "proved_from_this_state", "proved_from_every_state")


@dataclass(frozen=True, eq=False, repr=False)
class MeshCheck(Result):
    """How far limits depend on a single element.

    Attributes
    ----------
    edge_share
        Of the multipliers y with yᵀd = 1 that prove λ_max, the share of nodes at an end of the contact, in
        space at its rim; NaN where there are none, or the joint does not know where its nodes are.
    edge_nodes
        Those that have more than a tenth each.
    coarser
        The limits on every second node (:func:`averaged` says how) over those on all, less 1: by the words of
        :meth:`Assessment.to_dict`, inf where a limit is 0 on all. Empty where the joint has too few nodes
        or some are open.
    warning
        What decides, and the change of the limits, where one changes by more than a tenth; else None.
    """

    DOCUMENT: ClassVar[str] = "edge_share coarser warning"

    edge_share: float
    edge_nodes: tuple[int, ...]
    coarser: dict[str, float]
    warning: str | None


def mesh_check(limits: Any) -> MeshCheck:
    """Check limits on one mesh: whether its edge determines λ_max, and their values on a coarser mesh."""
    problem = limits.problem
    surface = surface_of(problem)
    # nodes, in the plane or in space; fewer cannot be coarsened
    if surface is None or problem.n < (9 if surface.in_plane else 16) or limits.open_nodes:
        return MeshCheck(nan, (), {}, None)
    edge = _shares(limits) * surface.edge
    ranked = np.argsort(-edge, kind="stable")
    deciding = tuple(int(node) for node in ranked[:EACH_SHOWN] if edge[node] > MUCH)
    coarser = _coarser(limits)
    share = float(edge.sum())
    return MeshCheck(share, deciding, coarser, _warning(share, sorted(deciding), coarser))


def on_mesh(limits: Any, problem: Problem) -> Any:
    """The same limits for an averaged joint; its first initial slip is the state in question."""
    start = None if problem.initial_slip is None else problem.initial_slip[0]
    changes: dict[str, Any] = {"problem": problem, "initial_slip": start}
    if not isinstance(limits.zone, str):
        changes["zone"] = ()
    return replace(limits, **changes)


def _shares(limits: Any) -> FloatArray:
    """The share of every node in the multipliers that prove λ_max, (n,); NaN where there are none."""
    problem, upper = limits.problem, limits.upper
    rows = constraints(problem)
    if upper.status != Status.OPTIMAL or len(upper.multipliers) != len(rows.d):
        return np.full(problem.n, nan)
    parts = np.abs(np.bincount(rows.node, upper.multipliers * rows.d, minlength=problem.n))
    return np.asarray(parts / parts.sum())


def _coarser(limits: Any) -> dict[str, float]:
    """Ratios, less 1, of the known limits on every second node to those on all nodes."""
    start = limits.energy.initial_slip
    between = coarsened(replace(limits.problem, initial_slip=start if np.isfinite(start).all() else None))
    assert between is not None  # its surface is known
    coarse = replace(on_mesh(limits, between), certify=False)
    found = {}
    for name in WORDS:
        try:
            one = getattr(limits, name)
            if one == 0 and name == "proved_from_this_state":  # the costliest, and nothing to compare with
                continue
            other = getattr(coarse, name)
        except SolverError:
            continue
        if isfinite(one) and isfinite(other):
            found[name] = other / one - 1.0 if one > 0 else (inf if other > 0 else 0.0)
    return found


def _warning(share: float, nodes: Sequence[int], coarser: dict[str, float]) -> str | None:
    """Two sentences, where a limit changes by more than a tenth."""
    changed = {name.replace("_", " "): _change(by) for name, by in coarser.items() if abs(by) > MUCH}
    if not changed:
        return None
    named = f" (node {', '.join(map(str, nodes))})" if nodes else ""
    edge = f"The edge determines λ_max{named}. " if share >= MOST else ""
    said = ", ".join(f"{name} is {change}" for name, change in changed.items())
    if len(changed) > len(set(changed.values())) == 1 and len(changed) == len(WORDS):
        said = f"all three limits are {changed.popitem()[1]}"
    finer = "; a finer mesh may lower them" * any(MUCH < by < inf for by in coarser.values())
    return f"{edge}On the coarser mesh (every second node) {said}{finer}."


def _change(by: float) -> str:
    """The change of a limit on the coarser mesh."""
    if isinf(by):
        return "positive, here 0"
    if by > 2.0:  # a larger relative change is given as a factor
        return f"{1 + by:.3g} times as high"
    return f"{100 * abs(by):.0f} % {'higher' if by > 0 else 'lower'}"
