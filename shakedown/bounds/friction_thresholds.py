"""Friction at which uniqueness ends, and at which a joint wedges."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from scipy.linalg import null_space

from shakedown.bounds import coupling
from shakedown.bounds.coupling import (
    LARGEST_SET,
    ScaledStiffness,
    first_loss,
    scaled_stiffness,
    slipping_sets,
)
from shakedown.ground.constants import (
    ALL_SUBSETS_UP_TO,
    NEGLIGIBLE,
    ROUND_OFF,
    SIX_DIGITS,
    THREE_DIGITS,
    FloatArray,
)
from shakedown.ground.errors import Missing, attempt
from shakedown.ground.shown_values import plain
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.ground.work_limit import on_one_thread
from shakedown.joint.arguments import NO_SIGNS, checked, require_plane
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.programs.program import INF, Program
from shakedown.programs.simplex import solve

LARGEST_PROBLEM = 100  # nodes
PROGRAMS = 60  # linear programs that one search may take
MOST_FRICTION = 1e8  # up to which a wedged state is looked for, relative to max |A| over max |φ B|
NO_REACTION = 100 * ROUND_OFF  # reactions, relative to the terms of their sum, that count as zero


@dataclass(frozen=True, eq=False, repr=False)
class Wedging(Result):
    """The friction coefficient from which on a joint can hold itself wedged.

    Attributes
    ----------
    low, high
        Below ``low`` no slip v ≠ 0 has |A v| ≤ f B v, for ``high`` the wedging slip
        has; infinite where none has for any friction, or was not looked for.
    slip : (n,)
        The wedging slip: locked-in slip, scaled to max |v| = 1; NaN where there is none.
    programs
        Linear programs solved.
    reason
        Why only an interval is known; empty where the threshold is.
    """

    low: float
    high: float
    slip: FloatArray
    programs: int = 0
    reason: str = ""

    @property
    def value(self) -> float:
        """The threshold; NaN where only an interval is known."""
        return np.nan if self.reason else self.high


def wedging_threshold(stiffness: ScaledStiffness, safe: float) -> Wedging:
    """Smallest t for which some v ≠ 0 satisfies |A v| ≤ t φ B v, by linear programs in v with Σ B v = 1.

    A bracket: above it a wedging slip, below it a program without solution. Each such slip gives
    an upper value t = max |A v|_j / (φ B v)_j, as a rule far below the friction it was
    looked for at, so that the next program stands just below it (Dinkelbach's method);
    where that does not end soon, the programs halve the bracket.

    Parameters
    ----------
    stiffness
        The joint.
    safe
        A factor on φ below which no wedged state is known to exist, such as the
        threshold of uniqueness.

    Examples
    --------
    >>> import numpy as np, shakedown
    >>> from shakedown.bounds.coupling import scaled_stiffness
    >>> one = scaled_stiffness(shakedown.example("one-node"), np.ones(1), shakedown.Tolerances())
    >>> round(wedging_threshold(one, 0.0).value, 6)
    2.0
    """
    unit, none = stiffness.friction_unit, np.full(stiffness.n, np.nan)
    if not stiffness.weighted.any():
        return Wedging(np.inf, np.inf, none)
    if stiffness.n > LARGEST_PROBLEM:  # the programs would take minutes
        reason = f"a wedged state is looked for up to {LARGEST_PROBLEM} nodes only"
        return Wedging(safe / unit, np.inf, none, reason=reason)
    least = NEGLIGIBLE * np.abs(stiffness.A).max() / np.abs(stiffness.weighted).max()
    factor = largest = MOST_FRICTION * least / NEGLIGIBLE
    basis, spare = slips_held_by_friction(stiffness), np.ones(stiffness.n)
    low, high, slip, programs = safe, np.inf, none, 0
    below = max(low, least)  # without a wedged state, or where round-off hides one
    while programs < PROGRAMS and max(low, least) < min(high, largest) and below < high * (1 - NEGLIGIBLE):
        programs += 1
        found, violation = wedged_slip(stiffness, factor, spare, basis)
        used = friction_used(stiffness, found) if violation <= ROUND_OFF else np.inf
        lowered = used < high
        if lowered:
            high, slip = used, found
            pressure = np.abs(stiffness.weighted @ slip)
            spare = np.maximum(
                pressure / pressure.max(), THREE_DIGITS
            )  # so that every program has a solution
        elif violation > ROUND_OFF:
            low = max(low, factor)
        if np.isinf(high):
            break
        below = max(below, low if lowered else factor)
        # so many just below the last slip that wedges; the others halve the bracket
        quick = lowered and programs < 16
        factor = min(high if quick else np.sqrt(high * below), high * (1 - NEGLIGIBLE))
    closed = low >= min(high, largest) * (1 - SIX_DIGITS) or high <= least
    low = np.inf if closed and np.isinf(high) else min(low, high)
    reason = "" if closed else f"round-off hides where a wedged state exists, after {programs} programs"
    return Wedging(low / unit, high / unit, slip / np.abs(slip).max(), programs, reason)


def friction_used(stiffness: ScaledStiffness, slip: FloatArray) -> float:
    """Smallest t with |A v| ≤ t φ B v for a given v; infinite where there is none."""
    A, B = stiffness.A, stiffness.weighted
    q, p = np.abs(A @ slip), B @ slip
    no_q, no_p = NO_REACTION * (np.abs(A) @ np.abs(slip)), NO_REACTION * (np.abs(B) @ np.abs(slip))
    pressed = p > no_p
    idle = (q <= no_q) & (p >= -no_p)
    ratios = np.where(pressed, q / np.where(pressed, p, 1.0), np.where(idle, 0.0, np.inf))
    return float(ratios.max())


def slips_held_by_friction(stiffness: ScaledStiffness) -> FloatArray:
    """The slips v, as columns, with (A v)_i = 0 wherever no slip gives node i a friction limit: (φ B)_i = 0.

    As a row of a program |(A v)_i| ≤ 0 would be left to its tolerance.
    """
    unlimited = ~stiffness.weighted.any(axis=1)
    return np.asarray(null_space(stiffness.A[unlimited])) if unlimited.any() else np.eye(stiffness.n)


def wedged_slip(
    stiffness: ScaledStiffness, factor: float, weights: FloatArray, basis: FloatArray
) -> tuple[FloatArray, float]:
    """The v with Σ B v = 1 that violates |A v| ≤ t φ B v least, and by how much (negative: to spare).

    v is a sum of the columns ``basis``. What is to spare is measured by weights, one per row. With the
    pressures φ B v of a wedging slip it is how far friction can fall, which makes the next overshoot most.
    All stiffnesses are divided by their size, so that v and the violation are numbers near 1.
    """
    limited = stiffness.weighted.any(axis=1)
    free = basis.copy()
    free[list(stiffness.pinned)] = 0.0  # no friction limit knows the rigid slips
    A, B = stiffness.A[limited] @ free, factor * stiffness.weighted[limited] @ free
    size = np.maximum(np.abs(A).max(axis=1, initial=0.0), np.abs(B).max(axis=1, initial=0.0))
    size = np.where(size > 0, size, 1.0)[:, None]
    A, B, row = A / size, B / size, -weights[limited, None]
    pressure = stiffness.B.sum(axis=0) @ free / np.abs(stiffness.B).max()
    matrix = np.vstack([np.hstack([A - B, row]), np.hstack([-A - B, row]), [[*pressure, 0.0]]])
    left, right = (np.append(np.full(len(matrix) - 1, end), 1.0) for end in (-INF, 0.0))
    found = solve(Program(matrix, right, cost=np.append(np.zeros(basis.shape[1]), 1.0), left=left))
    if not found.optimal:  # no slip presses the nodes together at all
        return np.full(stiffness.n, np.nan), np.inf
    return basis @ found.x[:-1], float(found.x[-1])


@dataclass(frozen=True, eq=False, repr=False)
class Threshold(Result):
    """Where uniqueness ends, in the unit of :class:`FrictionThresholds`.

    Attributes
    ----------
    low, high
        It is certainly not lost below ``low``, and it is lost at ``high``; equal
        where all sets of nodes have been tried, infinite where it is never lost.
    slipping, sides, separated
        The set for which it is lost at ``high``: slipping nodes, their sides
        (+1 backward, −1 forward) and the open nodes.
    """

    DOCUMENT: ClassVar[str] = "low high value slipping sides separated"

    low: float
    high: float
    slipping: tuple[int, ...] = ()
    sides: tuple[int, ...] = ()
    separated: tuple[int, ...] = ()

    @property
    def value(self) -> float:
        """The threshold; NaN where only an interval is known."""
        return self.high if self.low == self.high else np.nan


@dataclass(frozen=True, eq=False, repr=False)
class FrictionThresholds(Result):
    """Result of :func:`friction_thresholds`.

    Thresholds other than ``single_node`` are friction coefficients where all
    nodes have the same one, else the common factor on the given coefficients.

    Attributes
    ----------
    single_node : (n,)
        A_jj / |B_jj|, a friction coefficient: where node j alone, all others
        stuck, loses uniqueness (4.1).
    factor
        Whether the other thresholds are factors on f.
    uniqueness_in_contact
        Where the evolution with all nodes closed stops being unique.
    uniqueness
        The same over every set of separated nodes; None without C.
    wedging
        Where a state of self-stress can hold the body without load.
    """

    single_node: FloatArray
    factor: bool
    uniqueness_in_contact: Threshold
    uniqueness: Threshold | None
    wedging: Wedging

    def to_dict(self) -> dict[str, Any]:
        """A threshold of which only an interval is known is None; the interval stands beside it."""
        known: dict[str, Any] = {"single_node": self.single_node}
        for name in ("uniqueness_in_contact", "uniqueness", "wedging"):
            threshold: Threshold | Wedging | None = getattr(self, name)
            ends = None if threshold is None else [threshold.low, threshold.high]
            known |= {name: None if threshold is None else threshold.value, f"{name}_interval": ends}
        return plain(known | {"unit": "factor on f" if self.factor else "friction coefficient"})


@checked
@on_one_thread
def friction_thresholds(problem: Problem, *, tolerances: Tolerances = DEFAULT) -> FrictionThresholds:
    """Friction coefficients above which motion need not be unique, or slip can wedge the joint.

    Exact up to eight nodes in contact (six with separation); beyond, an
    interval: below it the sum of dissipation and stored energy of every motion
    is positive or the coupling ratio is less than 1, above it a node or a pair, all others closed, is known
    to lose uniqueness.

    Parameters
    ----------
    problem
        The joint; its loading plays no part.
    tolerances
        What counts as zero.

    Examples
    --------
    >>> import shakedown
    >>> limits = friction_thresholds(shakedown.example("two-node"))
    >>> limits.single_node.round(4), round(limits.uniqueness.value, 4), limits.uniqueness.slipping
    (array([0.7608, 2.0225]), 0.6306, (0, 1))
    """
    require_plane("friction thresholds", problem, NO_SIGNS)
    factor = bool(np.ptp(problem.f) > NEGLIGIBLE * problem.f.max())
    stiffness = scaled_stiffness(problem, problem.f if factor else np.ones(problem.n), tolerances)
    contact, anywhere = _uniqueness(stiffness, separation=False), None
    if problem.C is not None:
        anywhere = _uniqueness(stiffness, separation=True)
        if contact.high < anywhere.high:  # no node open is one of the sets
            anywhere = replace(contact, low=min(anywhere.low, contact.high))
    # Self-stress A v = t S φ B v, S between −1 and 1, needs a determinant that vanishes at t or below.
    safe = contact.low * stiffness.friction_unit if coupling.held(stiffness.A, stiffness.tolerances) else 0.0
    wedging = attempt(wedging_threshold, stiffness, safe)
    if isinstance(wedging, Missing):  # a program of the search failed: what is known without it
        low, no_slip = safe / stiffness.friction_unit, np.full(stiffness.n, np.nan)
        wedging = Wedging(low, np.inf, no_slip, reason=wedging.reason)
    a, b = np.diag(stiffness.A), np.abs(np.diag(stiffness.B))
    return FrictionThresholds(
        single_node=np.where(b > 0, a / np.where(b > 0, b, 1.0), np.inf),
        factor=factor,
        uniqueness_in_contact=contact,
        uniqueness=anywhere,
        wedging=wedging,
    )


def first_with_open_nodes(stiffness: ScaledStiffness) -> coupling.Loss:
    """Where uniqueness is lost first, by any slipping nodes beside any choice of open ones."""
    first, nodes = coupling.NEVER, range(stiffness.n)
    for separated in [(), *slipping_sets(stiffness.n, stiffness.n - 1)]:
        rest, joint = [i for i in nodes if i not in separated], stiffness.opened(separated)
        lost = coupling.NEVER if joint is None else first_loss(joint, slipping_sets(joint.n))
        if lost.factor < first.factor:
            first = replace(lost, slipping=tuple(rest[i] for i in lost.slipping), separated=separated)
    return first


def _uniqueness(stiffness: ScaledStiffness, *, separation: bool) -> Threshold:
    n, unit = stiffness.n, stiffness.friction_unit
    if n > (ALL_SUBSETS_UP_TO if separation else LARGEST_SET):
        lost = first_loss(stiffness, slipping_sets(n, 2))
        proved = 0.0 if separation else coupling.coupling_limit(stiffness)
        low = min(lost.factor, max(proved, coupling.energy_limit(stiffness, separation=separation)))
    else:
        lost = first_with_open_nodes(stiffness) if separation else first_loss(stiffness, slipping_sets(n))
        low = lost.factor
    return Threshold(low / unit, lost.factor / unit, lost.slipping, lost.sides, lost.separated)
