"""The conditions of an energy ball, checked without round-off."""

from fractions import Fraction
from math import isqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.certificate import exact_numbers
from shakedown.ground.constants import THREE_DIGITS, FloatArray
from shakedown.joint.constraints import loading, transient_path
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.programs.program import power_of_two

DIGITS = 2**80  # denominator to which a square root is rounded up


class ExactBall:
    """Exact reactions, shares and bounds of γ² of a problem, against which slips and radii are checked.

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
        smooth = bool((problem.f == 0.0).any())
        c = np.zeros((0, 1, self._d)) if smooth else self._shares(share)
        self._stretch = 1 + self._f[: len(c)] ** 2 * (c[:, 0] ** 2).sum(axis=1)
        gamma = None if smooth or (self._d > 1 and max(self._stretch) >= 2) else _gamma_squares(problem, c)
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
    whole = square / size**2 * DIGITS**2
    return Fraction(isqrt(int(whole)) + 1, DIGITS) * size


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
