"""Contact and friction law at the nodes, re-checked independently of how a state was computed."""

from dataclasses import dataclass
from functools import reduce

import numpy as np

from shakedown.ground.constants import EPS, FloatArray, Mask
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import check_load_factor, checked
from shakedown.joint.constraints import first_load, loading, transient_path
from shakedown.joint.contact_zone import coupled_parts, of_nodes
from shakedown.joint.law import Law
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.rigid_slips import free_stiffness


@dataclass(frozen=True, eq=False, repr=False)
class Scales(Result):
    """The scales against which "small" is judged in one scene.

    Attributes
    ----------
    force
        Largest welded reaction over the loop and the transient [force].
    length
        Slip that changes a tangential reaction by ``force`` at the softest node [length].
    """

    force: float
    length: float


@checked
def scales(problem: Problem, load_factor: float) -> Scales:
    """Force and length scale of a problem at a load factor.

    Examples
    --------
    >>> import shakedown
    >>> scales(shakedown.example("one-node"), 1.0)
    Scales(force=2.8, length=2.8)
    """
    check_load_factor(load_factor, problem)
    return scales_of(problem, *loading(problem).at(load_factor), transient_path(problem))


def length_scales(problem: Problem, load_factor: float) -> FloatArray:
    """The length scale of every node, (n,) [length]: of the part of the joint that it is coupled with.

    Examples
    --------
    >>> import shakedown
    >>> length_scales(shakedown.example("one-node"), 1.0)
    array([2.8])
    """
    parts = coupled_parts(problem)
    return of_nodes(parts, (np.full(part.joint.n, scales(part.joint, load_factor).length) for part in parts))


def path_accuracy(problem: Problem, tolerances: Tolerances) -> float:
    """Error of a path over one cycle, relative to the scales; zero in the plane, where paths are exact."""
    return 0.0 if problem.directions == 1 else tolerances.path


def path_resolution(problem: Problem, tolerances: Tolerances) -> float:
    """What is resolved of slips over a period, relative to the length scale."""
    return 10.0 * path_accuracy(problem, tolerances) or tolerances.periodicity


def least_slip(problem: Problem, tolerances: Tolerances) -> float:
    """Slip per period, relative to the length scale, up to which a node counts as not slipping."""
    return 4.0 * path_resolution(problem, tolerances)


def law_resolution(problem: Problem, tolerances: Tolerances) -> float:
    """Largest relative violation of the law accepted in a path; in space given by its accuracy.

    Within a step, where a polynomial stands for the path, that is more than at its ends.
    """
    return max(tolerances.friction_law, 100.0 * path_accuracy(problem, tolerances))


def scales_of(problem: Problem, *paths: FloatArray) -> Scales:
    """Force and length scale of a problem under these welded reactions."""
    force = max(float(np.abs(path).max(initial=0.0)) for path in paths) or 1.0
    stiffness = np.diag(problem.A)[np.diag(problem.A) > 0]
    return Scales(force, force / float(stiffness.min()) if stiffness.size else 1.0)


def load_range(problem: Problem, load: FloatArray) -> float:
    """The largest change of a tangential reaction or of a friction limit over one period [force].

    A constant load causes no slip: slips are compared with the displacement that this force would cause at
    the node alone.

    Parameters
    ----------
    problem, load : (m, (d + 1) n)
        The joint; welded reactions of one period [force].

    Examples
    --------
    >>> joint = Problem(A=[[2.0]], B=[[0.0]], f=0.5, q_w=[[0.0]], p_w=[[1.0]])
    >>> [load_range(joint, np.array([[0.0, 4.0], [0.25, p]])) for p in (1.0, 4.0)]
    [1.5, 0.25]
    """
    of_q, of_p = problem.layout.split(np.ptp(load, axis=0))
    return max(float(of_q.max()), float((problem.f * of_p).max()))


def alone(problem: Problem, force: float) -> FloatArray:
    """The displacement of each node alone under a force, slip (stiffest direction) and gap, (2n,) [length].

    Zero stiffnesses are replaced by the smallest positive one of their kind.

    Examples
    --------
    >>> A, C, load = np.diag([2.0, 0.0, 4.0]), np.diag([0.0, 5.0, 10.0]), np.ones((1, 3))
    >>> alone(Problem(A=A, B=np.zeros((3, 3)), C=C, f=0.5, q_w=load, p_w=load), 10.0)
    array([5. , 5. , 2.5, 2. , 2. , 1. ])
    """
    of_slips = problem.layout.by_node(np.diag(problem.A)).max(axis=1)
    of_gaps = of_slips if problem.C is None else np.diag(problem.C)
    return force / np.append(_held(of_slips), _held(of_gaps))


def _held(stiffness: FloatArray) -> FloatArray:
    """Stiffnesses, with zeros replaced by the smallest of the others."""
    some = stiffness[stiffness > 0]
    return np.where(stiffness > 0, stiffness, some.min() if some.size else 1.0)


def admissible(
    problem: Problem, load_factor: float, slips: FloatArray, tolerances: Tolerances = DEFAULT
) -> Mask:
    """Which slips (s, dn) keep every node closed and within its friction limits at the first load, (s,).

    Examples
    --------
    >>> import shakedown
    >>> admissible(shakedown.example("two-node"), 0.7, np.array([[0.0, 1.0], [9.0, 9.0]]))
    array([ True, False])

    Nothing carries nothing, and no tension, however small:

    >>> joints = [Problem(A=[[1.0]], B=[[0.0]], f=0.0, q_w=[[0.0]], p_w=[[p]]) for p in (0.0, -1e-9)]
    >>> [bool(admissible(joint, 1.0, np.zeros((1, 1)))[0]) for joint in joints]
    [True, False]
    """
    law, (q_w, p_w) = problem.law, problem.layout.split(first_load(problem, load_factor))
    A, B, _ = problem.layout.blocks(free_stiffness(problem))
    q, q_terms = q_w + slips @ A.T, np.abs(q_w) + np.abs(slips) @ np.abs(A).T
    p, p_terms = p_w + slips @ B.T, np.abs(p_w) + np.abs(slips) @ np.abs(B).T
    within = law.excess(q, p) <= tolerances.feasibility * (law.size(q_terms) + law.limit(p_terms))
    return np.asarray((within & (p >= -tolerances.feasibility * p_terms)).all(axis=1))


@checked
def reactions(
    problem: Problem, q_w: FloatArray, p_w: FloatArray, v: FloatArray, w: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Nodal reactions (q, p) at one instant or, row by row, at several (thesis (2.10), (2.11)).

    Parameters
    ----------
    q_w, p_w : (..., dn), (..., n)
        Welded reactions [force].
    v, w : (..., dn), (..., n)
        Slips and gaps [length].

    Returns
    -------
    q, p : (..., dn), (..., n)
        Tangential and normal reactions [force], compression positive.
    """
    A, B, C = problem.layout.blocks(free_stiffness(problem))
    q, p = q_w + v @ A, p_w + v @ B.T
    if np.any(w):
        q, p = q + w @ B, p + w @ C
    return q, p


def reaction_round_off(kappa: FloatArray, u: FloatArray, scale: Scales) -> float:
    """Round-off of the reactions to displacements, relative: far away it exceeds that of the loads.

    Examples
    --------
    >>> far = np.array([1e9, 1e9])
    >>> reaction_round_off(np.array([[2.0, -1.0], [-1.0, 3.0]]), far, Scales(4.0, 1.0)) / EPS
    1000000000.0
    """
    return EPS * float((np.abs(kappa) @ np.abs(u)).max()) / scale.force


@checked
def law_violation(
    f: FloatArray, q: FloatArray, p: FloatArray, w: FloatArray, slip: FloatArray, scale: Scales
) -> FloatArray:
    """The violation of the contact and friction law by a state (thesis (2.3)–(2.9)).

    Complementary pairs enter as the smaller of the two relative sizes, so that
    no threshold decides whether a node "is" open or slipping.

    Parameters
    ----------
    f : (n,)
        Friction coefficients.
    q, p : (..., dn), (..., n)
        Reactions [force].
    w : (..., n)
        Gaps [length].
    slip : (..., dn)
        Slip in contact since the instant before [length]; its sign is the direction.
    scale
        Force and length scale.

    Returns
    -------
    violation : (..., n)
        Relative violation, 0 where the law holds.

    Examples
    --------
    A node that slips forward must be at q = −f p:

    >>> import numpy as np
    >>> f, one = np.array([0.5]), np.array([1.0])
    >>> law_violation(f, -0.5 * one, one, 0 * one, one, Scales(1.0, 1.0))
    array([0.])
    >>> law_violation(f, 0.5 * one, one, 0 * one, one, Scales(1.0, 1.0))
    array([1.])
    """
    q, p = q / scale.force, p / scale.force
    w, slip = w / scale.length, slip / scale.length
    law = Law(f, 1 if q.shape == p.shape else 2)
    parts = [
        -w,  # no penetration
        -p,  # no tension
        np.minimum(w, np.maximum(np.abs(p), law.size(q))),  # an open node carries nothing
        law.violation(q, p, slip),
    ]
    return np.maximum(reduce(np.maximum, parts), 0.0)
