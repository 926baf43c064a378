"""The conditions of the energy ball in space without round-off, for the numbers as they are stored."""

from fractions import Fraction
from typing import Any

import numpy as np

from shakedown.bounds.energy.exact_check import exact_vector, root_above
from shakedown.bounds.exact_rows import exact_numbers
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import THREE_DIGITS
from shakedown.joint.loading import loading, transient_path
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.programs.scaling import power_of_two

UNIT = Fraction(1, 2**53)  # round-off of one operation


class ExactDiscs:
    """Exact reactions, shares and bounds of γ² of a problem, against which slips and radii are checked.

    Slips are those relative to the pinned ones, zero there. Stored numbers are fractions; roots are
    avoided by comparing squares, and γ² is bounded from above, next to its value (docs/energy.md, section 8).
    ``regular`` is False where A without the pinned slips is not clearly positive definite, some f |c| is
    not below 1, or it is not clear whether the body floats: then nothing is proved.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("two-node-3d")
    >>> bound = shakedown.energy_bound(joint)
    >>> exact = ExactDiscs(joint, bound.share)
    >>> exact.holds(0.99 * bound.load_factor, bound.slip, bound.radius)
    True
    >>> exact.holds(1.01 * bound.load_factor, bound.slip, bound.radius)
    False
    """

    def __init__(self, problem: Problem, share: FloatArray) -> None:
        self._problem, self._n = problem, problem.n
        self._A, self._B = ([exact_vector(row) for row in part] for part in (problem.A, problem.B))
        self._f = exact_vector(problem.f)
        self._share = [exact_vector(c) for c in share]
        self._stretch = [
            1 + f * f * (c[0] ** 2 + c[1] ** 2) for f, c in zip(self._f, self._share, strict=True)
        ]
        self._means = _means(problem)
        found = _gamma_squares(problem, share)
        inside = all(f > 0 and a < 2 for f, a in zip(self._f, self._stretch, strict=True))
        self.regular = found is not None and inside
        self._gamma = [] if found is None else found

    def holds(self, load_factor: float, slip: FloatArray, radius: float) -> bool:
        """Whether a |q| + f γ R < f p at every node and load step, without any round-off."""
        if not self.regular:
            return False
        q, p = self._reactions_of(slip)
        square, factor = Fraction(radius) ** 2, Fraction(load_factor)
        for i, step in self._doubtful(load_factor, slip, radius):
            at = q[2 * i], q[2 * i + 1], p[i]
            q_x, q_y, pressure = (
                kept + load for kept, load in zip(at, self._load(i, step, factor), strict=True)
            )
            limit = self._f[i] * pressure
            drawn = self._stretch[i] * (q_x * q_x + q_y * q_y)
            spread = self._f[i] ** 2 * self._gamma[i] * square
            left = limit * limit - drawn - spread
            if not (limit > 0 and left > 0 and left * left > 4 * drawn * spread):
                return False
        return True

    def radius_to(self, slip: FloatArray, start: FloatArray, distance: float) -> Fraction:
        """A fraction just above the energy distance between two slips, plus a distance."""
        e = [a - b for a, b in zip(exact_vector(slip), exact_vector(start), strict=True)]
        return root_above(_product(e, [_product(row, e) for row in self._A])) + Fraction(distance)

    def _reactions_of(self, slip: FloatArray) -> tuple[list[Fraction], list[Fraction]]:
        v = exact_vector(slip)
        return [_product(row, v) for row in self._A], [_product(row, v) for row in self._B]

    def _load(self, node: int, step: int, factor: Fraction) -> tuple[Fraction, Fraction, Fraction]:
        """The welded reactions of a node, exactly; load steps below zero are those of the transient."""
        problem, columns = self._problem, (2 * node, 2 * node + 1, 2 * self._n + node)
        if step < 0:
            before = transient_path(problem)[step]
            return tuple(Fraction(before[k]) for k in columns)  # type: ignore[return-value]
        loop = problem.layout.joined(problem.q_w[step], problem.p_w[step])
        given = (self._means[k] + factor * (Fraction(loop[k]) - self._means[k]) for k in columns)
        still = problem.layout.joined(*(~np.any(part != 0, axis=0) for part in _periodic(problem)))
        return tuple(  # type: ignore[return-value]
            self._means[k] if still[k] else each for k, each in zip(columns, given, strict=True)
        )

    def _doubtful(self, load_factor: float, slip: FloatArray, radius: float) -> list[tuple[int, int]]:
        """The (node, load step) pairs for which floats alone do not show that the condition holds."""
        problem, f = self._problem, self._problem.f
        layout, before = problem.layout, transient_path(problem)
        loads = layout.joined(*loading(problem).at(load_factor))
        stretch = np.sqrt([float(a) for a in self._stretch])
        spread = f * np.sqrt([float(g) for g in self._gamma]) * radius
        found = []
        for first, part in ((0, loads), (-len(before), before)):
            q_w, p_w = layout.split(part)
            q, p = q_w + problem.A @ slip, p_w + problem.B @ slip
            terms_q = np.abs(q_w) + np.abs(problem.A) @ np.abs(slip)
            terms = (
                2 * problem.law.size(terms_q) + f * (np.abs(p_w) + np.abs(problem.B) @ np.abs(slip)) + spread
            )
            slack = f * p - stretch * problem.law.size(q) - spread
            # relative slack larger than the round-off of a million products
            steps, nodes = np.nonzero(~(slack > THREE_DIGITS * terms))
            found += list(zip(nodes.tolist(), (steps + first).tolist(), strict=True))
        return found


def _periodic(problem: Problem) -> tuple[FloatArray, FloatArray]:
    loop = loading(problem)
    return loop.q1, loop.p1


def _means(problem: Problem) -> list[Fraction]:
    """The constant part of the loading, tangential then normal, exactly."""
    found: list[Fraction] = []
    for samples, mean in ((problem.q_w, problem.q_mean), (problem.p_w, problem.p_mean)):
        if mean is not None:
            found += exact_vector(mean)
        else:
            found += [sum(exact_vector(column), Fraction(0)) / len(samples) for column in samples.T]
    return found


def _product(a: list[Fraction], b: list[Fraction]) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True) if x and y), Fraction(0))


def _gamma_squares(problem: Problem, share: FloatArray) -> list[Fraction] | None:
    """Bounds of γ(c)² from above, next to it; None where A is not clearly positive definite.

    For any x, with b = B_i − cᵀA_i and r = b − A x: bᵀA⁻¹b = b·x + x·r + rᵀA⁻¹r, and the last is at most
    |D r|² over the smallest eigenvalue of D A D.
    """
    rigid, size = rigid_slips(problem), problem.layout.slip_size
    kept = [k for k in range(size) if k not in rigid.pinned]
    inner = problem.A[np.ix_(kept, kept)]
    lengths = np.array([1.0 / power_of_two(float(np.sqrt(a))) for a in np.diagonal(inner)])
    least = _least_eigenvalue(inner * lengths * lengths[:, None]) if kept else Fraction(1)
    if rigid.doubt or least is None:
        return None
    if not kept:
        return [Fraction(0)] * problem.n
    A, B, c = (exact_numbers(part) for part in (problem.A, problem.B, share))
    b = (B - c[:, :1] * A[::2] - c[:, 1:] * A[1::2])[:, kept]
    rounded = np.array([[_fraction(each) for each in row] for row in b], dtype=np.float64)
    x = exact_numbers(np.asarray(np.linalg.solve(inner, rounded.T).T, dtype=np.float64))
    r = b - x @ exact_numbers(inner).T
    beyond = ((exact_numbers(lengths) * r) ** 2).sum(axis=1) * least.denominator / least.numerator
    return [_fraction(each) for each in (x * (b + r)).sum(axis=1) + beyond]


def _fraction(exact: Any) -> Fraction:
    """A fraction of FLINT's as one of Python's."""
    return Fraction(int(exact.p), int(exact.q))


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
    found = Fraction(shift) - 2 * (k + 4) * UNIT * trace  # what was rounded on the diagonal included
    return found if found > 0 else None
