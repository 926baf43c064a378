"""The load factor up to which a joint is proved to shake down from a state, checked without round-off too."""

from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction
from math import inf, isfinite, isqrt, nan, nextafter
from numbers import Real
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.bounds.bound_result import Bound
from shakedown.bounds.certificate import LOWER_CERTIFIED_UP_TO, exact_numbers
from shakedown.bounds.energy import energy_ball
from shakedown.bounds.energy.ball_limits import (
    BallLimits,
    ball_limits,
    check_resolved,
    pressed_limits,
    without_margin,
)
from shakedown.bounds.energy.ball_search import FoundBall, ball_margin, largest_load_factor, least_load
from shakedown.bounds.energy.energy_ball import BallEvidence, EnergyCertificate, closed_radius, no_bound
from shakedown.bounds.largest_load_factor import chosen_zone
from shakedown.ground.constants import CONVERGED, NEGLIGIBLE, ROUND_OFF, THREE_DIGITS, FloatArray
from shakedown.ground.errors import Missing, UsageError, attempt
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked, checked_initial_slip
from shakedown.joint.constraints import loading, transient_path
from shakedown.joint.contact_zone import Part, Zone, coupled_parts, of_slips, weakest
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.programs.program import power_of_two


@checked
def energy_bound(
    problem: Problem,
    initial_slip: ArrayLike | None = None,
    distance: float = 0.0,
    *,
    open_nodes: Iterable[int] | Literal["auto"] = (),
    split: bool = True,
    certify: bool | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Bound:
    """The load factor λ_E up to which shakedown is proved from an initial slip v₀, known within δ.

    Maximise λ subject to f p ∓ q ≥ f_i γ_i R for every node, side and load step at the
    slip v*, and ‖v₀ − v*‖_A + δ ≤ R: one second-order cone program in (v*, R, λ). With two tangential
    directions a_i |q| + f_i γ_i R ≤ f p at every load step (docs/energy.md, eq. 3).

    Parameters
    ----------
    problem
        The joint and its loading; transient load steps are those after ``initial_slip``.
    initial_slip : (n,), optional
        v₀ [length]; zero by default, a joint assembled without locked-in slip.
    distance
        δ ≥ 0, how far the state may be from v₀ in the energy norm [√(force · length)].
    open_nodes
        Nodes that are open from the start through every period, all others closed;
        ``"auto"`` for those of the best zone found (:func:`upper_bound`). What is given
        as their initial slip is ignored.
    split
        With two directions, whether the part c_i of a pressure that the node's own reaction determines is
        taken out of γ_i, in a few rounds; else c = 0. In the plane it always is. Only
        where no node can open inside the ball, come what may (docs/energy.md, Theorem 5): where that does not
        hold by itself the ball is made so small, or c = 0, whichever proves more.
    certify
        Whether to find a load factor that satisfies the conditions in exact arithmetic;
        by default up to 40 nodes; only with all nodes closed.
    tolerances
        What counts as zero and as feasible (:class:`Tolerances`).

    Raises
    ------
    UsageError
        If an argument has the wrong shape or is out of range.

    Examples
    --------
    >>> import shakedown
    >>> bound = shakedown.energy_bound(shakedown.example("two-node"))
    >>> round(bound.load_factor, 7), bound.slip.round(4), bound.certified <= bound.load_factor
    (0.6619611, array([0.0336, 1.3412]), True)
    """
    start = checked_initial_slip(problem, initial_slip)
    if not (isinstance(distance, Real) and isfinite(distance) and distance >= 0):
        raise UsageError(f"distance: expected a number >= 0, found {distance!r}")
    zone, _ = chosen_zone(problem, open_nodes, tolerances)
    parts = coupled_parts(problem, zone.open_nodes)
    if len(parts) > 1:
        settings: dict[str, Any] = {"split": split, "certify": certify, "tolerances": tolerances}
        opened = [part.among(zone.open_nodes) for part in parts]
        found = [
            energy_bound(part.joint, start[part.slips], distance, open_nodes=own, **settings)
            for part, own in zip(parts, opened, strict=True)
        ]
        return _of_parts(parts, found)
    given = start[problem.layout.slips_of(zone.closed_nodes)]
    bound = _of_closed(zone, given, float(distance), tolerances, split=split)
    wanted = problem.n <= LOWER_CERTIFIED_UP_TO if certify is None else certify
    if wanted and bound.status == Status.OPTIMAL and not zone.open_nodes:
        proof = attempt(_certificate, zone, bound, tolerances)
        if isinstance(proof, Missing):
            bound = replace(bound, uncertified=proof.reason)
        else:
            bound = bound.but(certificate=proof, certified=proof.load_factor)
    return _in_zone(zone, given, bound)


def of_joint(limits: Any) -> Bound:
    """λ_E of a joint whose limits are computed, for the zone where nodes are open (``registry.BOUNDS``)."""
    return energy_bound(
        limits.problem,
        limits.initial_slip,
        limits.distance,
        open_nodes=limits.open_nodes,
        certify=limits.certify,
        tolerances=limits.tolerances,
    )


def _of_parts(parts: tuple[Part, ...], found: list[Bound]) -> Bound:
    """The bound of a joint in uncoupled parts, from those of each."""
    deciding = weakest(found)
    part, bound = parts[deciding], found[deciding]
    start = of_slips(parts, (each.initial_slip for each in found))
    least = float(np.max([each.least_load_factor for each in found]))
    if bound.status in (Status.OPTIMAL, Status.UNBOUNDED) and not least < bound.load_factor:
        reason = "no load factor is proved for all of its uncoupled parts at once"
        return replace(no_bound(start, bound.distance, reason), parts=tuple(found))
    slip = np.full_like(start, nan)
    if bound.status == Status.OPTIMAL:
        centres = (each.slip if each.status == Status.OPTIMAL else each.initial_slip for each in found)
        slip = of_slips(parts, centres)
    numbers = [(each, p.slips, p.nodes) for p, each in zip(parts, found, strict=True)]
    known = [each.certificate for each in found if each.certificate is not None]
    certificate, doubts = None, [each.uncertified for each in found if each.uncertified]
    # those that hold without the periodic load, too, do at every smaller one
    if len(known) == len(found) and all(
        ExactBall(p.joint, each.share).holds(0.0, each.certificate.slip, each.certificate.radius)
        for p, each in zip(parts, found, strict=True)
    ):
        least_of_all = min(known, key=lambda each: each.load_factor)
        certificate = replace(least_of_all, slip=of_slips(parts, (each.slip for each in known)))
    elif known:
        doubts.append("confirmed part by part, but not of all parts at one load factor")
    return bound.but(
        least_load_factor=least,
        slip=slip,
        initial_slip=start,
        active=tuple((part.number(node), side) for node, side in bound.active),
        certificate=certificate,
        certified=None if certificate is None else certificate.load_factor,
        uncertified="" if certificate else next(iter(doubts), ""),
        reason=part.renumbered(bound.reason),
        open_nodes=tuple(sorted(int(nodes[k]) for each, _, nodes in numbers for k in each.open_nodes)),
        pinned=tuple(sorted(int(slips[k]) for each, slips, _ in numbers for k in each.pinned)),
        parts=tuple(found),
    )


def _in_zone(zone: Zone, given: FloatArray, bound: Bound) -> Bound:
    """A bound for the closed nodes, from the slip that was given, in terms of all nodes."""
    if not zone.open_nodes:
        return bound.but(initial_slip=given)
    return bound.but(
        slip=zone.slips(bound.slip),
        initial_slip=zone.slips(given),
        open_nodes=zone.open_nodes,
        pinned=zone.pinned,
    )


def _certificate(zone: Zone, bound: Bound, tolerances: Tolerances) -> EnergyCertificate | Missing:
    """Move from the optimum towards the point with the largest margins until all conditions are strict."""
    limits = ball_limits(zone, tolerances=tolerances).shared(bound.share)
    exact = ExactBall(zone.joint, bound.share)
    if not exact.regular:
        unclear = "as stored A without the pinned slips is not clearly positive definite"
        return Missing(limits.rigid.doubt or unclear)
    inner, below, _ = ball_margin(limits, bound.initial_slip, bound.distance)
    for part in (10.0**digits for digits in range(-14, -2)):
        slip = (1 - part) * bound.slip + part * inner
        lower = (1 - part) * bound.load_factor + part * below
        radius = nextafter(float(exact.radius_to(slip, bound.initial_slip, bound.distance)), inf)
        least = closed_radius(zone.joint, limits.metric, slip, (0.0, lower)) if bound.share.any() else inf
        if exact.holds(lower, slip, radius) and radius < (1.0 - NEGLIGIBLE) * least:
            return EnergyCertificate(lower, slip, radius)
    return Missing("near the optimum no slip and radius satisfy all conditions strictly")


def _of_closed(
    zone: Zone, given: FloatArray, distance: float, tolerances: Tolerances, *, split: bool
) -> Bound:
    """The bound of the closed nodes of a zone."""
    limits = ball_limits(zone, tolerances=tolerances)
    start = limits.rigid.relative(given)
    if reason := without_margin(zone, limits):
        return no_bound(start, distance, reason).but(share=limits.share, pinned=limits.rigid.pinned)
    check_resolved(limits, start, distance, tolerances)

    def largest(limits: BallLimits, *, split: bool) -> Bound:
        found = attempt(_largest, zone, limits, start, distance, tolerances, split=split)
        if isinstance(found, Missing):
            found = no_bound(start, distance, found.reason, Status.UNDECIDED).but(share=limits.share)
        return replace(found, pinned=limits.rigid.pinned)

    found = largest(limits, split=split)
    if not _may_open_in_a_jump(zone.joint, limits, found):
        return found
    # no shares, or all pressures positive within the ball: what proves more
    plain, pressed = largest(limits, split=False), largest(pressed_limits(limits, zone.joint), split=True)
    if plain.load_factor >= pressed.load_factor or pressed.status != Status.OPTIMAL:
        return plain
    return plain if _may_open_in_a_jump(zone.joint, limits, pressed) else pressed


def _may_open_in_a_jump(joint: Problem, limits: BallLimits, found: Bound) -> bool:
    """Whether the proof with shares is not complete: a node might open in a jump, at some λ from 0 on."""
    if not found.share.any():
        return False
    if found.status != Status.OPTIMAL:
        return found.status == Status.UNBOUNDED
    if found.radius >= closed_radius(joint, limits.metric, found.slip, (0.0, found.load_factor)):
        return True
    slack = limits.shared(found.share).relative_slack(found.slip, 0.0, found.radius / limits.metric.unit)
    under_constant_load = slack[: len(limits.node)][limits.step >= 0]  # which may be one of the load steps
    return not _is_centred(joint) and bool((under_constant_load < -ROUND_OFF).any())


def _is_centred(joint: Problem) -> bool:
    """Whether the constant part is the mean, which allows at least the mean of what the loop allows."""
    return joint.q_mean is None and joint.p_mean is None


def _largest(
    zone: Zone,
    limits: BallLimits,
    start: FloatArray,
    distance: float,
    tolerances: Tolerances,
    *,
    split: bool,
) -> Bound:
    found = largest_load_factor(limits, start, distance, split=split)
    limits = found.limits

    def nothing(reason: str, status: Status = Status.INFEASIBLE, **more: Any) -> Bound:
        return no_bound(start, distance, reason, status).but(share=limits.share, **more)

    if found.status == Status.INFEASIBLE:
        left = found.contradiction
        if left > tolerances.feasibility:
            return nothing("the limits contradict each other, but no multipliers prove it", Status.UNDECIDED)
        return nothing(energy_ball.TOO_FAR, active=limits.names(found.active), residual=left)
    growing = found.status == Status.UNBOUNDED
    if growing and not ball_margin(limits, start, distance)[-1] > tolerances.feasibility:
        return nothing(energy_ball.TOO_FAR)  # a direction of growth, but nothing to start from
    falling = _is_centred(zone.joint) or limits.hold_below
    least = 0.0 if falling else least_load(limits, start, distance)
    if growing:
        reason = "the ball about some safe slip holds the initial slip at every load factor"
        return nothing(reason, Status.UNBOUNDED, load_factor=inf, least_load_factor=least)
    if not energy_ball.leaves_margins(limits, found.slip, 0.5 * (least + found.value), tolerances):
        return nothing(energy_ball.NO_SLACK)
    return _optimal(found, start, distance, least)


def _optimal(found: FoundBall, start: FloatArray, distance: float, least: float) -> Bound:
    limits = found.limits
    load_factor = max(found.value, 0.0)
    sizes = limits.sizes(found.slip, load_factor, found.radius)
    uncertain = max(CONVERGED, found.solution.accuracy) * float(found.every_multiplier @ sizes)
    if uncertain > NEGLIGIBLE * load_factor:  # digits are lost beside the constant load: rounded down by all
        load_factor = max(load_factor - uncertain, 0.0)
    return Bound(
        kind="energy",
        status=Status.OPTIMAL,
        load_factor=load_factor,
        evidence=BallEvidence(
            found.radius * limits.metric.unit, start, distance, found.gap, share=limits.share
        ),
        slip=found.slip,
        active=limits.names(found.active),
        multipliers=found.multipliers,
        residual=limits.residual(found.slip, load_factor, found.radius),
        least_load_factor=least,
    )


ROOT_DENOMINATOR = 2**80  # denominator to which a square root is rounded up


class ExactBall:
    """Exact reactions, shares and bounds of γ² of a joint with friction, to check slips and radii against.

    Slips are those relative to the pinned ones, zero there. Stored numbers are fractions; roots are
    avoided by comparing squares, and γ² is bounded from above, next to its value (docs/energy.md, section 4).
    With two directions the shares are those given; with one each side has the best that it may have.
    ``regular`` is False where A without the pinned slips is not clearly positive definite, some share is
    out of its range, or it is not clear whether the body floats: then nothing is proved.

    Examples
    --------
    >>> import numpy as np, shakedown
    >>> exact = ExactBall(shakedown.example("two-node"), np.zeros((0, 2)))
    >>> centre = np.array([0.0336, 1.3412])
    >>> exact.holds(0.66, centre, 20.0), exact.holds(0.66, centre, 30.0)
    (True, False)
    """

    def __init__(self, problem: Problem, share: FloatArray) -> None:
        self._problem, self._d = problem, problem.directions
        self._A, self._B, self._f = (exact_numbers(part) for part in (problem.A, problem.B, problem.f))
        self._means = _means(problem)
        loop = loading(problem)
        self._moving = problem.layout.joined(*((part != 0).any(axis=0) for part in (loop.q1, loop.p1)))
        c = self._shares(share)
        self._stretch = 1 + self._f**2 * (c[:, 0] ** 2).sum(axis=1)
        gamma = None if self._d > 1 and max(self._stretch) >= 2 else _gamma_squares(problem, c)
        self.regular = gamma is not None
        self._spread = np.zeros((0, 1)) if gamma is None else gamma * self._f[:, None] ** 2

    def holds(self, load_factor: float, slip: FloatArray, radius: float | Fraction) -> bool:
        """Whether a |q| + f γ R < f p at every node and load step, without any round-off."""
        if not self.regular:
            return False
        problem, layout, d = self._problem, self._problem.layout, self._d
        step, node = self._doubtful(load_factor, slip, float(radius))
        columns = np.column_stack([*(d * node + k for k in range(d)), layout.slip_size + node])
        path = transient_path(problem)
        steps = np.vstack([path, layout.joined(problem.q_w, problem.p_w)])
        v, square = exact_numbers(slip), _exact(Fraction(radius) ** 2)
        loads, mean = exact_numbers(steps[step[:, None], columns]), self._means[columns]
        factor = exact_numbers(np.array([load_factor]))[0]
        varied = mean + factor * (loads - mean) * self._moving[columns].astype(int)
        loads = np.where((step < len(path))[:, None], loads, varied)
        u = np.concatenate([self._A @ v, self._B @ v])[columns] + loads
        q, limit = u[:, :d], self._f[node] * u[:, d]
        if d == 1:
            most, drawn = np.stack([limit - q[:, 0], limit + q[:, 0]], axis=1), np.zeros((1, 1), dtype=int)
        else:
            most, drawn = limit[:, None], (self._stretch[node] * (q * q).sum(axis=1))[:, None]
        spread = self._spread[node] * square
        left = most * most - drawn - spread
        return bool(np.all((most > 0) & (left > 0) & (left * left > 4 * drawn * spread)))

    def radius_to(self, slip: FloatArray, start: FloatArray, distance: float) -> Fraction:
        """A fraction just above the energy distance between two slips, plus a distance."""
        e = exact_numbers(slip) - exact_numbers(start)
        return root_above(_fraction(e @ (self._A @ e))) + Fraction(distance)

    def _shares(self, share: FloatArray) -> Any:
        """c of every node and side, (n, sides, d)."""
        if self._d > 1:
            return exact_numbers(share)[:, None]
        own, stiffness = np.diagonal(self._B), np.diagonal(self._A)
        found = np.array([b / a if a > 0 else b * 0 for b, a in zip(own, stiffness, strict=True)])
        most = 1 / self._f
        return np.stack([np.minimum(found, most), np.maximum(found, -most)], axis=1)[..., None]

    def _doubtful(
        self, load_factor: float, slip: FloatArray, radius: float
    ) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Steps of transient and loop, and nodes, of which floats alone do not show that all is well."""
        problem, f, law = self._problem, self._problem.f, self._problem.law
        loop = problem.layout.joined(*loading(problem).at(load_factor))
        q_w, p_w = problem.layout.split(np.vstack([transient_path(problem), loop]))
        q, p = q_w + problem.A @ slip, p_w + problem.B @ slip
        terms_q = np.abs(q_w) + np.abs(problem.A) @ np.abs(slip)
        spread = np.sqrt(_floats(self._spread).max(axis=1)) * radius
        terms = 2 * law.size(terms_q) + f * (np.abs(p_w) + np.abs(problem.B) @ np.abs(slip)) + spread
        stretch = np.sqrt(_floats(self._stretch)) if self._d > 1 else 1.0
        slack = f * p - stretch * law.size(q) - spread
        # relative slack larger than the round-off of a million products
        step, node = np.nonzero(~(slack > THREE_DIGITS * terms))
        return step, node


def root_above(square: Fraction) -> Fraction:
    """The square root of a fraction, rounded up."""
    if square <= 0:
        return Fraction(0)
    size = Fraction(2) ** ((square.numerator.bit_length() - square.denominator.bit_length()) // 2)
    whole = square / size**2 * ROOT_DENOMINATOR**2
    return Fraction(isqrt(int(whole)) + 1, ROOT_DENOMINATOR) * size


def _means(problem: Problem) -> Any:
    """The constant part of the loading, tangential then normal, exactly."""
    parts = ((problem.q_w, problem.q_mean), (problem.p_w, problem.p_mean))
    exact = [
        exact_numbers(samples).sum(axis=0) / len(samples) if mean is None else exact_numbers(mean)
        for samples, mean in parts
    ]
    return problem.layout.joined(*exact)


def _gamma_squares(problem: Problem, share: Any) -> Any:
    """Bounds of γ(c)² from above, next to it, (n, sides); None where A is not clearly positive definite.

    For any x, with b = B_i − cᵀA_i and r = b − A x: bᵀA⁻¹b = b·x + x·r + rᵀA⁻¹r, and the last is at most
    |D r|² over the smallest eigenvalue of D A D.
    """
    rigid, n, size = rigid_slips(problem), problem.n, problem.layout.slip_size
    kept = [k for k in range(size) if k not in rigid.pinned]
    inner = problem.A[np.ix_(kept, kept)]
    lengths = np.array([1.0 / power_of_two(float(np.sqrt(a))) for a in np.diagonal(inner)])
    least = _least_eigenvalue(inner * lengths * lengths[:, None]) if kept else Fraction(1)
    if rigid.doubt or least is None:
        return None
    if not kept:
        return exact_numbers(np.zeros(share.shape[:2]))
    A, B = exact_numbers(problem.A[:, kept]), exact_numbers(problem.B[:, kept])
    b = B[:, None] - (share[..., None] * A.reshape(n, 1, -1, len(kept))).sum(axis=2)
    b = b.reshape(-1, len(kept))
    x = exact_numbers(np.asarray(np.linalg.solve(inner, _floats(b).T).T, dtype=np.float64))
    r = b - x @ exact_numbers(inner).T
    beyond = ((exact_numbers(lengths) * r) ** 2).sum(axis=1) / _exact(least)
    return ((x * (b + r)).sum(axis=1) + beyond).reshape(share.shape[:2])


def _fraction(exact: Any) -> Fraction:
    """A fraction of FLINT's as one of Python's."""
    return Fraction(int(exact.p), int(exact.q))


def _floats(exact: Any) -> FloatArray:
    """Fractions of FLINT's as floats."""
    return np.array([float(_fraction(each)) for each in exact.ravel()]).reshape(exact.shape)


def _exact(fraction: Fraction) -> Any:
    """A fraction of Python's as one of FLINT's."""
    from flint import fmpq  # not needed where only floats are used

    return fmpq(fraction.numerator, fraction.denominator)


def _least_eigenvalue(matrix: FloatArray) -> Fraction | None:
    """A number > 0 below the smallest eigenvalue of a symmetric matrix, without round-off; None: unclear.

    Where Cholesky's factors of M − t I exist in floats, no eigenvalue of it is below
    −γ/(1 − γ) times its trace, γ = (k + 1) u/(1 − (k + 1) u) (Rump 2006).
    """
    k, smallest = len(matrix), float(np.linalg.eigvalsh(matrix)[0])
    if not smallest > 0:
        return None
    shift = power_of_two(smallest) / 4.0
    shifted = matrix - shift * np.eye(k)
    try:
        np.linalg.cholesky(shifted)
    except np.linalg.LinAlgError:
        return None
    trace = sum((abs(Fraction(x)) for x in np.diagonal(matrix).tolist()), Fraction(0))
    # round-off of one operation is 2⁻⁵³; what was rounded on the diagonal is included
    found = Fraction(shift) - 2 * (k + 4) * Fraction(1, 2**53) * trace
    return found if found > 0 else None
