"""Where slip begins, and where a contact that does not slip opens: closed forms for a given slip.

While no node slips the reactions are affine in the load factor, q = q⁰ + λ q¹ + A v and
p = p⁰ + λ p¹ + B v with the initial slip v, so that the first limit that one of them reaches is the least of
as many ratios, or roots, as there are nodes and load steps. Between load steps loads are affine and the
limits convex.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.constants import FloatArray
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked, checked_initial_slip
from shakedown.joint.constraints import loading, transient_path
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result


@dataclass(frozen=True, eq=False, repr=False)
class Onset(Result):
    """Up to which load factor no node slips, or none opens, from one slip.

    Attributes
    ----------
    load_factor
        The largest such load factor; inf where every load factor is one, 0 where a node slips or opens
        already without the varying part of the load.
    node, step
        The node, and the load step at which it does; those of the transient from −k to −1. −1 for a node
        that does not exist.
    status
        Optimal; unbounded or infeasible where the load factor is inf or 0 as above.
    reason
        Why it is infeasible; else empty.
    """

    DOCUMENT: ClassVar[str] = "load_factor node step status reason"

    load_factor: float
    node: int
    step: int
    status: Status
    reason: str = ""


@checked
def first_slip(
    problem: Problem, initial_slip: ArrayLike | None = None, *, tolerances: Tolerances = DEFAULT
) -> Onset:
    """The load factor up to which no node slips: |q⁰ + λ q¹ + A v| ≤ f (p⁰ + λ p¹ + B v) at all load steps.

    All nodes closed. Those without friction move freely, such that q = 0 there; they count where they open.

    Parameters
    ----------
    problem
        The joint and its loading; the load factor does not scale transient load steps.
    initial_slip : (dn,), optional
        The slip v at the start [length]; zero by default.
    tolerances
        The tolerances that decide.

    Raises
    ------
    UsageError
        If the slip has the wrong shape.

    Examples
    --------
    >>> import shakedown
    >>> found = first_slip(shakedown.example("two-node"))
    >>> round(found.load_factor, 6), found.node, found.step
    (0.087348, 1, 20)
    """
    law, found = problem.law, _reactions(problem, checked_initial_slip(problem, initial_slip))
    (q, p), (along_q, along_p), (terms_q, terms_p) = map(problem.layout.split, found)
    start, along = law.of_nodes(law.cone(q, p)), law.of_nodes(law.cone(along_q, along_p))
    reached = leaves_cone(start, along) if law.d > 1 else _changes_sign(start, along).min(axis=-1)
    excess, terms = law.excess(q, p), law.size(terms_q) + law.limit(terms_p)
    free = law.frictionless
    reached[:, free] = _changes_sign(p, along_p)[:, free]
    excess[:, free], terms[:, free] = -p[:, free], terms_p[:, free]
    return _first(problem, reached, excess > tolerances.feasibility * terms, "slips")


@checked
def first_opening(
    problem: Problem, initial_slip: ArrayLike | None = None, *, tolerances: Tolerances = DEFAULT
) -> Onset:
    """The load factor up to which no node opens if none slips: p⁰ + λ p¹ + B v ≥ 0 at all load steps.

    With friction a node slips before it opens, so that slip changes where nodes do: this is a property of the
    load and of where it presses, not of the motion. Nodes without friction move freely.

    Parameters and errors as for :func:`first_slip`.

    Examples
    --------
    >>> import shakedown
    >>> found = first_opening(shakedown.example("two-node"))
    >>> round(found.load_factor, 6), found.node, found.step
    (3.93109, 0, 37)
    """
    found = _reactions(problem, checked_initial_slip(problem, initial_slip))
    p, along_p, terms = (each[:, problem.layout.gaps] for each in found)
    return _first(problem, _changes_sign(p, along_p), -p > tolerances.feasibility * terms, "opens")


def _reactions(problem: Problem, slip: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Reactions (k + m, (d + 1) n) at λ = 0, how they change with λ, and the size of their constant terms.

    Transient load steps, which the load factor does not scale, come first. Only nodes without friction move.
    """
    loop, layout, stiffness = loading(problem), problem.layout, np.vstack([problem.A, problem.B])
    before, varying = transient_path(problem), layout.joined(loop.q1, loop.p1)
    held = np.vstack([before, np.broadcast_to(layout.joined(loop.q0, loop.p0), varying.shape)])
    start, along = held + stiffness @ slip, np.vstack([0.0 * before, varying])
    free = layout.slips_of(problem.law.frictionless)
    if len(free):
        for reactions in (start, along):
            moved = np.linalg.lstsq(stiffness[np.ix_(free, free)], reactions[:, free].T, rcond=None)[0].T
            reactions -= moved @ stiffness[:, free].T
    return start, along, np.abs(held) + np.abs(stiffness) @ np.abs(slip)


def _changes_sign(start: FloatArray, along: FloatArray) -> FloatArray:
    """The λ at which start + λ along becomes negative; inf where it does not."""
    with np.errstate(over="ignore"):
        return np.divide(start, -along, out=np.full(start.shape, np.inf), where=along < 0)


def _first(problem: Problem, reached: FloatArray, violated: NDArray[np.bool_], does: str) -> Onset:
    """The first limit to be reached, at load factors (k + m, n), unless some are violated at λ = 0."""
    before = len(reached) - problem.m
    if violated.any():
        row, node = np.argwhere(violated)[0]
        when = "in the transient" if row < before else "under the constant part of the load alone"
        reason = f"node {node} {does} already {when}"
        return Onset(0.0, int(node), int(row) - before, Status.INFEASIBLE, reason)
    row, node = np.unravel_index(int(reached.argmin()), reached.shape)
    load_factor = max(float(reached[row, node]), 0.0)
    if np.isinf(load_factor):
        return Onset(load_factor, -1, -1, Status.UNBOUNDED)
    return Onset(load_factor, int(node), int(row) - before, Status.OPTIMAL)


def leaves_cone(start: FloatArray, along: FloatArray) -> FloatArray:
    """The largest t ≥ 0 at which ``start + t along`` is in the cone |(x, y)| ≤ h, from its point ``start``.

    Vectors (…, 3) are (h, x, y). inf where it never leaves; 0 where it does so at once.

    Examples
    --------
    >>> leaves_cone(np.array([1.0, 0.0, 0.5]), np.array([[0.0, 0.0, 2.0], [2.0, 0.0, 2.0]]))
    array([0.25,  inf])
    """
    size = np.ldexp(1.0, np.frexp(np.abs(along).max(axis=-1))[1])
    c, x, y = np.moveaxis(start, -1, 0)  # |(x, y) + t b|² − (c + t d)² = α t² + 2 β t + γ, and γ ≤ 0
    d, b_x, b_y = np.moveaxis(along / size[..., None], -1, 0)
    alpha, beta = b_x**2 + b_y**2 - d**2, x * b_x + y * b_y - c * d
    gamma = np.minimum(x**2 + y**2 - c**2, 0.0)
    root = np.sqrt(np.maximum(beta**2 - alpha * gamma, 0.0))
    ends = (beta**2 >= alpha * gamma) & ((alpha > 0) | (beta > 0))
    top, below = np.where(beta > 0, -gamma, root - beta), np.where(beta > 0, beta + root, alpha)
    return np.divide(top, below, out=np.full_like(top, np.inf), where=ends) / size
