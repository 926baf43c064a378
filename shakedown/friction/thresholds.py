"""Friction coefficients above which the evolution stops being unique, jumps or wedges.

Thesis (4.1), (4.23), (6.4)–(6.10).

With the nodes of a set J slipping in directions S, the nodes of a set O open and
all others stuck, the rates are unique as long as the determinant of the moving
nodes' equations stays positive. As friction grows from zero the first of these
determinants to vanish ends uniqueness. Each vanishes at the reciprocal of a
real eigenvalue of −A′⁻¹ S φ B′, A′ and B′ being A and B of the nodes J condensed
over the nodes O. Sets that nothing but the other contact nodes holds (all nodes
of a floating body) are left out: they move freely whatever the friction.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import combinations, product

import numpy as np

from shakedown.friction.wedging import Wedging, wedging_threshold
from shakedown.model.arguments import require_problem
from shakedown.model.problem import FloatArray, Problem

EXACT_IN_CONTACT, EXACT_WITH_SEPARATION = 8, 6  # nodes up to which all sets are tried
LARGEST_SET = 8  # moving nodes up to which sets grow
NEIGHBOURS = 8  # nodes that each one is paired with
REAL = 1e-9  # imaginary part of an eigenvalue, relative to its size, that counts as round-off
SINGULAR = 1e-12  # smallest eigenvalue, relative to the largest, that counts as zero
HUGE = 1e12  # friction at which the search for a coupling ratio of 1 gives up: it is never reached

MovingSet = tuple[tuple[int, ...], tuple[int, ...]]  # slipping nodes, separated nodes


@dataclass(frozen=True)
class Threshold:
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

    low: float
    high: float
    slipping: tuple[int, ...] = ()
    sides: tuple[int, ...] = ()
    separated: tuple[int, ...] = ()

    @property
    def value(self) -> float:
        """The threshold; NaN where only an interval is known."""
        return self.high if self.low == self.high else np.nan


@dataclass(frozen=True)
class FrictionThresholds:
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


def friction_thresholds(problem: Problem) -> FrictionThresholds:
    """Friction coefficients at which a single node, all nodes together or a wedged state make trouble.

    Exact up to eight nodes in contact (six with separation); beyond, an
    interval: below it the sum of dissipation and stored energy of every motion
    is positive or the coupling ratio is less than 1, above it a small set of
    nodes is known to lose uniqueness.

    Examples
    --------
    >>> import shakedown
    >>> limits = friction_thresholds(shakedown.example("two-node"))
    >>> limits.single_node.round(4), round(limits.uniqueness.value, 4), limits.uniqueness.slipping
    (array([0.7608, 2.0225]), 0.6306, (0, 1))
    """
    require_problem(problem)
    factor = bool(np.ptp(problem.f) > 0)
    phi = problem.f if factor else np.ones(problem.n)
    with np.errstate(divide="ignore", invalid="ignore"):
        single = np.diag(problem.A) / np.abs(np.diag(problem.B))
    contact, anywhere = _uniqueness(problem, phi, separation=False), None
    if problem.C is not None:
        anywhere = _uniqueness(problem, phi, separation=True)
        if contact.high < anywhere.high:  # no node open is one of the sets
            anywhere = replace(contact, low=min(anywhere.low, contact.high))
    return FrictionThresholds(
        single_node=single,
        factor=factor,
        uniqueness_in_contact=contact,
        uniqueness=anywhere,
        wedging=wedging_threshold(problem, phi),
    )


def _uniqueness(problem: Problem, phi: FloatArray, *, separation: bool) -> Threshold:
    n = problem.n
    if n <= (EXACT_WITH_SEPARATION if separation else EXACT_IN_CONTACT):
        sizes = range(n) if separation else range(1)
        open_sets = [o for k in sizes for o in combinations(range(n), k)]
        found = smallest_threshold(problem, phi, moving_sets(n, open_sets))
        return replace(found, low=found.high)
    low = energy_bound(problem, phi, separation=separation)
    if not separation:
        low = max(low, coupling_bound(problem, phi))
    found = grown_threshold(problem, phi, separation=separation)
    return replace(found, low=min(low, found.high))


def is_singular(matrix: FloatArray) -> bool:
    """Whether a semi-definite matrix is singular to round-off."""
    eigenvalues = np.linalg.eigvalsh(matrix)
    return bool(eigenvalues[0] <= SINGULAR * eigenvalues[-1])


def moving_sets(n: int, open_sets: list[tuple[int, ...]]) -> Iterator[MovingSet]:
    """Every choice of slipping nodes beside each set of open nodes."""
    for separated in open_sets:
        rest = [i for i in range(n) if i not in separated]
        for k in range(1, len(rest) + 1):
            for slipping in combinations(rest, k):
                yield slipping, separated


def smallest_threshold(problem: Problem, phi: FloatArray, sets: Iterable[MovingSet]) -> Threshold:
    """The smallest coefficient at which one of these sets of moving nodes loses uniqueness."""
    best = Threshold(np.inf, np.inf)
    for slipping, separated in sets:
        high, sides = set_threshold(problem, phi, slipping, separated)
        if high < best.high:
            best = Threshold(high, high, slipping, sides, separated)
    return best


def set_threshold(
    problem: Problem, phi: FloatArray, slipping: tuple[int, ...], separated: tuple[int, ...]
) -> tuple[float, tuple[int, ...]]:
    """Smallest t > 0 at which det(A' + t S φ B') vanishes for some S, and the sides of the slipping nodes.

    S and −S belong together: det(A' − t S φ B') = 0 where det(A' + t S φ B') = 0 has the root −t.
    """
    matrices = condensed(problem, slipping, separated)
    if matrices is None or is_singular(matrices[0]):
        return np.inf, ()
    A, B = matrices
    signs = np.array([(1.0, *rest) for rest in product((1.0, -1.0), repeat=len(slipping) - 1)])
    ratio = np.linalg.solve(A, np.eye(len(slipping)))
    eigenvalues = np.linalg.eigvals(ratio @ (signs[:, :, None] * (phi[list(slipping)][:, None] * B)))
    size = np.abs(eigenvalues)
    real = np.abs(eigenvalues.imag) <= REAL * size
    largest = np.where(real, size, 0.0)
    k, j = np.unravel_index(int(largest.argmax()), largest.shape)
    if largest[k, j] == 0.0:
        return np.inf, ()
    side = signs[k] if eigenvalues[k, j].real > 0 else -signs[k]  # A − s f B is singular
    return float(1.0 / largest[k, j]), tuple(int(s) for s in side)


def condensed(
    problem: Problem, slipping: tuple[int, ...], separated: tuple[int, ...]
) -> tuple[FloatArray, FloatArray] | None:
    """A and B of the slipping nodes, the separated ones free, the rest stuck; None where not held."""
    s, o, n = list(slipping), list(separated), problem.n
    if not o:
        return problem.A[np.ix_(s, s)], problem.B[np.ix_(s, s)]
    kappa, free = problem.kappa, [*o, *(n + i for i in o)]
    if is_singular(kappa[np.ix_(free, free)]):
        return None
    rows, normal = s, [n + i for i in s]
    follow = -np.linalg.solve(kappa[np.ix_(free, free)], kappa[np.ix_(free, rows)])
    return (
        kappa[np.ix_(rows, rows)] + kappa[np.ix_(rows, free)] @ follow,
        kappa[np.ix_(normal, rows)] + kappa[np.ix_(normal, free)] @ follow,
    )


def coupling_bound(problem: Problem, phi: FloatArray) -> float:
    """Where the coupling ratio ρ reaches 1; below it every principal minor is positive (an H-matrix).

    ρ is the spectral radius of N_ij = (|A_ij| + t φ_i |B_ij|) / (A_ii − t φ_i |B_ii|), N_ii = 0.
    """
    A, B, a, b = np.abs(problem.A), phi[:, None] * np.abs(problem.B), np.diag(problem.A), np.diag(problem.B)

    def ratio(t: float) -> float:
        N = (A + t * B) / (a - t * phi * np.abs(b))[:, None]
        np.fill_diagonal(N, 0.0)
        return float(np.abs(np.linalg.eigvals(N)).max())

    with np.errstate(divide="ignore"):
        high = float((a / (phi * np.abs(b))).min())
    if ratio(0.0) >= 1.0:
        return 0.0
    if not np.isfinite(high):
        high = 1.0
        while ratio(high) < 1.0 and high < HUGE:
            high *= 2.0
    low = 0.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if ratio(middle) < 1.0 else (low, middle)
    return low


def energy_bound(problem: Problem, phi: FloatArray, *, separation: bool) -> float:
    """Where uᵀκu + t Σ s φ v p could first vanish for some motion; below it all moving sets are unique.

    With p = G u the sum is at most ½ uᵀ (c φ + Gᵀφ G / c) u for any c > 0; the best c is searched for.
    """
    n = problem.n
    K = problem.kappa if separation else problem.A
    G = K[n:] if separation else problem.B
    if is_singular(K):
        return 0.0
    slip = np.zeros((len(K), len(K)))
    slip[:n, :n] = np.diag(phi)
    root = np.linalg.inv(np.linalg.cholesky(K))
    first, second = root @ slip @ root.T, root @ (G.T @ (phi[:, None] * G)) @ root.T

    def bound(log_c: float) -> float:
        c = np.exp(log_c)
        return float(np.linalg.eigvalsh(c * first + second / c)[-1])

    middle = 0.5 * np.log(max(np.linalg.eigvalsh(second)[-1], 1e-300) / np.linalg.eigvalsh(first)[-1])
    low, high = middle - 10.0, middle + 10.0  # `bound` is convex in log c
    for _ in range(60):
        a, b = low + 0.382 * (high - low), low + 0.618 * (high - low)
        low, high = (low, b) if bound(a) < bound(b) else (a, high)
    largest = bound(0.5 * (low + high))
    return 2.0 / largest if largest > 0 else np.inf


def neighbours(problem: Problem) -> list[tuple[int, int]]:
    """Ordered pairs of nodes, each node with those that it is coupled to most."""
    size = np.sqrt(np.diag(problem.A))
    coupling = (np.abs(problem.A) + np.abs(problem.B) + np.abs(problem.B.T)) / np.outer(size, size)
    np.fill_diagonal(coupling, -1.0)
    most = np.argsort(-coupling, axis=1)[:, : min(problem.n - 1, NEIGHBOURS)]
    return [(i, int(j)) for i in range(problem.n) for j in most[i]]


def grown_threshold(problem: Problem, phi: FloatArray, *, separation: bool) -> Threshold:
    """A small threshold found by letting moving sets grow, node by node, from the best ones of two nodes."""
    n = problem.n
    near = neighbours(problem)
    starts: list[MovingSet] = [((i,), ()) for i in range(n)]
    starts += [(pair, ()) for pair in sorted({(min(i, j), max(i, j)) for i, j in near})]
    if separation:
        starts += [((i,), (j,)) for i, j in near]
    best = smallest_threshold(problem, phi, starts)
    while len(best.slipping) + len(best.separated) < LARGEST_SET:
        rest = [i for i in range(n) if i not in best.slipping and i not in best.separated]
        bigger: list[MovingSet] = [((*best.slipping, i), best.separated) for i in rest]
        if separation:
            bigger += [(best.slipping, (*best.separated, i)) for i in rest]
        found = smallest_threshold(problem, phi, bigger)
        if found.high >= best.high:
            break
        best = found
    return best
