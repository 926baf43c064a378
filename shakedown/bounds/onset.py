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
from shakedown.joint.constraints import loading
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.programs.cone_rays import leaves_cone


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
        Optimal; unbounded or infeasible where the load factor is inf or 0 as said above.
    reason
        Why it is infeasible; else empty.
    """

    DOCUMENT: ClassVar[str] = "load_factor node step status reason"

    load_factor: float
    node: int
    step: int
    status: Status
    reason: str = ""


@dataclass(frozen=True)
class _Reactions:
    """Reactions (k + m, …) at every load step, transient first, and the size of their constant terms."""

    q: FloatArray
    p: FloatArray
    along_q: FloatArray
    along_p: FloatArray
    terms_q: FloatArray
    terms_p: FloatArray


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
    found, law = _reactions(problem, checked_initial_slip(problem, initial_slip)), problem.law
    start = law.of_nodes(law.cone(found.q, found.p))
    along = law.of_nodes(law.cone(found.along_q, found.along_p))
    left = leaves_cone(start, along) if law.d > 1 else _changes_sign(start, along).min(axis=-1)
    excess, terms = law.excess(found.q, found.p), law.size(found.terms_q) + law.limit(found.terms_p)
    free = law.smooth
    left[:, free] = _changes_sign(found.p, found.along_p)[:, free]
    excess[:, free], terms[:, free] = -found.p[:, free], found.terms_p[:, free]
    return _first(problem, left, excess > tolerances.feasibility * terms, "slips")


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
    left = _changes_sign(found.p, found.along_p)
    return _first(problem, left, -found.p > tolerances.feasibility * found.terms_p, "opens")


def _reactions(problem: Problem, slip: FloatArray) -> _Reactions:
    """The reactions of a slip that only nodes without friction change."""
    loop, A, B = loading(problem), problem.A, problem.B
    load_q, along_q = _steps(problem.q_transient, loop.q0, loop.q1)
    load_p, along_p = _steps(problem.p_transient, loop.p0, loop.p1)
    q, p = load_q + A @ slip, load_p + B @ slip
    terms_q = np.abs(load_q) + np.abs(A) @ np.abs(slip)
    terms_p = np.abs(load_p) + np.abs(B) @ np.abs(slip)
    free = problem.layout.slips_of(problem.law.smooth)
    if len(free):
        stiffness = A[np.ix_(free, free)]
        for tangential, normal in ((q, p), (along_q, along_p)):
            moved = -np.linalg.lstsq(stiffness, tangential[:, free].T, rcond=None)[0].T
            tangential += moved @ A[:, free].T
            normal += moved @ B[:, free].T
            tangential[:, free] = 0.0
    return _Reactions(q, p, along_q, along_p, terms_q, terms_p)


def _steps(
    before: FloatArray | None, constant: FloatArray, varying: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Load steps, transient ones first: what the load factor does not scale, and what it does."""
    transient = np.empty((0, varying.shape[1])) if before is None else before
    held = np.vstack([transient, np.broadcast_to(constant, varying.shape)])
    return held, np.vstack([np.zeros_like(transient), varying])


def _changes_sign(start: FloatArray, along: FloatArray) -> FloatArray:
    """The λ at which start + λ along becomes negative; inf where it does not."""
    with np.errstate(over="ignore"):
        return np.divide(start, -along, out=np.full(start.shape, np.inf), where=along < 0)


def _first(problem: Problem, left: FloatArray, violated: NDArray[np.bool_], does: str) -> Onset:
    """The first of the limits (k + m, n) to be reached, unless some are violated at λ = 0."""
    before = len(left) - problem.m
    if violated.any():
        row, node = np.argwhere(violated)[0]
        when = "in the transient" if row < before else "under the constant part of the load alone"
        reason = f"node {node} {does} already {when}"
        return Onset(0.0, int(node), int(row) - before, Status.INFEASIBLE, reason)
    row, node = np.unravel_index(int(left.argmin()), left.shape)
    load_factor = max(float(left[row, node]), 0.0)
    if np.isinf(load_factor):
        return Onset(load_factor, -1, -1, Status.UNBOUNDED)
    return Onset(load_factor, int(node), int(row) - before, Status.OPTIMAL)
