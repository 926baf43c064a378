"""Sets of nodes whose slip loses uniqueness; the coupling ratio ρ*; differences that no slip increases."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, groupby, product
from math import ceil, log, nan, sqrt

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import (
    EPS,
    HALVINGS,
    ITERATIONS,
    MANY_ROWS,
    NEGLIGIBLE,
    ROUND_OFF,
    SIX_DIGITS,
    SWEEPS,
    FloatArray,
)
from shakedown.ground.tolerances import DEFAULT, FIRST_DIGIT, Tolerances
from shakedown.joint.arguments import NO_SIGNS, checked, once_per_problem, require_plane
from shakedown.joint.contact_zone import part_numbers
from shakedown.joint.law import Layout
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.rigid_slips import rigid_slips, stiffness_error


@dataclass(frozen=True)
class ScaledStiffness:
    """A, B, C and f, divided by powers of two.

    Attributes
    ----------
    A, B : (n, n)
        Divided by the size of A, or of B where that is larger; entries of B that are
        round-off of the stiffness are 0, and so are those between uncoupled parts.
    C : (n, n) or None
        Divided likewise.
    weights : (n,)
        Friction coefficients φ, divided by their size.
    friction_unit
        That size: a factor t on φ is the factor t / ``friction_unit`` on the coefficients given.
    tolerances
        What counts as zero.
    pinned
        Nodes at which the rigid slips of a body that only friction holds are pinned, in programs.
    """

    A: FloatArray
    B: FloatArray
    C: FloatArray | None
    weights: FloatArray
    friction_unit: float
    tolerances: Tolerances
    pinned: tuple[int, ...] = ()

    @property
    def n(self) -> int:
        """Number of contact nodes."""
        return len(self.A)

    @property
    def layout(self) -> Layout:
        """Where the slip and the gap of a node stand in ``kappa``."""
        return Layout(self.n)

    @cached_property
    def kappa(self) -> FloatArray:
        """[[A, Bᵀ], [B, C]], for problems with C only."""
        assert self.C is not None
        return self.layout.of_blocks(self.A, self.B, self.C)

    @cached_property
    def weighted(self) -> FloatArray:
        """φ B, (n, n)."""
        return self.weights[:, None] * self.B

    def opened(self, separated: tuple[int, ...]) -> "ScaledStiffness | None":
        """That of the other nodes with some open and free; None where the others do not hold these."""
        if not separated:
            return self
        rest, gaps_of = np.setdiff1d(np.arange(self.n), separated), self.layout.gaps_of
        free, shut = (np.append(nodes, gaps_of(nodes)) for nodes in (np.array(separated), rest))
        inner, m = self.kappa[np.ix_(free, free)], len(rest)
        if not held(inner, self.tolerances):
            return None
        follow = np.linalg.solve(inner, self.kappa[np.ix_(free, shut)])
        kappa = self.kappa[np.ix_(shut, shut)] - self.kappa[np.ix_(shut, free)] @ follow
        return replace(self, A=kappa[:m, :m], B=kappa[m:, :m], C=None, weights=self.weights[rest])


def scaled_stiffness(problem: Problem, friction: FloatArray, tolerances: Tolerances) -> ScaledStiffness:
    """Bring the stiffness and the friction of a problem near the size 1, free of round-off.

    Examples
    --------
    >>> import numpy as np, shakedown
    >>> scaled = scaled_stiffness(shakedown.example("two-node"), np.full(2, 3.0), shakedown.Tolerances())
    >>> scaled.weights, scaled.friction_unit
    (array([0.75, 0.75]), 4.0)
    """
    # nothing below the accuracy of the data counts as resistance: eigenvalues of scaled matrices are off by
    # four times the error of their entries at most
    zero_mode = max(tolerances.zero_mode, 4.0 * stiffness_error(problem) / FIRST_DIGIT)
    power = exponent(max(np.abs(problem.A).max(), np.abs(problem.B).max()))
    own = exponent(friction.max())
    numbers = part_numbers(problem)
    apart = np.not_equal.outer(numbers, numbers)
    A, B = (np.where(apart, 0.0, np.ldexp(part, -power)) for part in (problem.A, problem.B))
    size = np.sqrt(np.diag(A))
    noise = tolerances.condensed_pattern * np.outer(size, size)
    return ScaledStiffness(
        A=A,
        B=np.where(np.abs(B) > noise, B, 0.0),
        C=None if problem.C is None else np.where(apart, 0.0, np.ldexp(problem.C, -power)),
        weights=np.ldexp(friction, -own),
        friction_unit=float(np.ldexp(1.0, own)),
        tolerances=replace(tolerances, zero_mode=zero_mode),
        pinned=rigid_slips(problem).pinned,
    )


def exponent(size: float) -> int:
    """k with 2ᵏ⁻¹ ≤ size < 2ᵏ, exactly, whatever power of two the size is multiplied by; 0 for the size 0."""
    return int(np.frexp(size)[1])


def held(matrices: FloatArray, tolerances: Tolerances) -> NDArray[np.bool_]:
    """Whether semi-definite matrices (…, k, k) have no rigid motion; scaled by their diagonals."""
    diagonal = np.diagonal(matrices, axis1=-2, axis2=-1)
    stiff = (diagonal > 0).all(axis=-1)
    size = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    eigenvalues = np.linalg.eigvalsh(matrices / (size[..., :, None] * size[..., None, :]))
    return np.asarray(stiff & (eigenvalues[..., 0] > tolerances.zero_mode * eigenvalues[..., -1]))


LARGEST_SET = 8  # nodes up to which all sets are tried


Nodes = tuple[int, ...]


@dataclass(frozen=True)
class Loss:
    """The factor on φ at which uniqueness is lost (inf: at none): by these slipping nodes, all others stuck.

    ``sides`` are those of their slip, and the nodes ``separated`` are open.
    """

    factor: float
    slipping: Nodes = ()
    sides: Nodes = ()
    separated: Nodes = ()


NEVER = Loss(np.inf)


def slipping_sets(n: int, largest: int | None = None) -> list[Nodes]:
    """Every choice of up to so many slipping nodes, all of them by default."""
    return [nodes for k in range(1, (largest or n) + 1) for nodes in combinations(range(n), k)]


def first_loss(stiffness: ScaledStiffness, sets: list[Nodes]) -> Loss:
    """Of these sets of slipping nodes the one that loses uniqueness at the smallest factor, on any sides."""
    first = NEVER
    for size, alike in groupby(sorted(sets, key=len), key=len):
        group = np.array(list(alike), dtype=np.intp)
        # all but for a common sign: where det(A′ − t S φ B′) has the root t, it has the root −t for −S
        sides = np.array([(1.0, *rest) for rest in product((1.0, -1.0), repeat=size - 1)])
        chunks = len(group) * len(sides) // (1 << 16) + 1  # small matrices at one time
        for some in np.array_split(group, chunks):
            first = min(first, *_losses(stiffness, some, sides), key=lambda lost: lost.factor)
    return first


def _losses(stiffness: ScaledStiffness, sets: NDArray[np.intp], signs: FloatArray) -> list[Loss]:
    """The same for sets (c, k) of equally many nodes, all at once, with these sides (s, k)."""
    rows, columns = sets[:, :, None], sets[:, None, :]
    A = stiffness.A[rows, columns]
    usable = held(A, stiffness.tolerances)
    A = np.where(usable[:, None, None], A, np.eye(sets.shape[1]))
    weighted = stiffness.weighted[rows, columns]
    roots = _largest_real(np.linalg.inv(A)[:, None] @ (signs[:, :, None] * weighted[:, None]))
    roots = np.where(usable[:, None], roots, 0.0)
    best = np.abs(roots).argmax(axis=1)
    largest = roots[np.arange(len(sets)), best]
    sides = (signs[best] * np.sign(largest)[:, None]).astype(int).tolist()  # A − t s φ B is singular
    return [
        Loss(float(1.0 / abs(root)), tuple(slipping), tuple(side)) if root else NEVER
        for slipping, root, side in zip(sets.tolist(), largest, sides, strict=True)
    ]


def _largest_real(matrices: FloatArray) -> FloatArray:
    """The real eigenvalue of largest size of every matrix (…, k, k); 0 where there is none."""
    eigenvalues = np.linalg.eigvals(matrices)
    size = np.abs(eigenvalues)
    # imaginary part, relative to the size, to which round-off parts a double root
    real = np.abs(eigenvalues.imag) <= 8 * sqrt(EPS) * size
    real &= size > ROUND_OFF * np.abs(matrices).max(axis=(-2, -1))[..., None]
    sizes = np.where(real, size, 0.0)
    place = sizes.argmax(axis=-1)[..., None]
    signs = np.sign(np.take_along_axis(eigenvalues.real, place, axis=-1))
    return np.asarray((np.take_along_axis(sizes, place, axis=-1) * signs)[..., 0])


WIDTH = 10.0  # largest distance of the best log c from the middle: e²⁰ in c²; any c is valid
GOLDEN = 0.5 * (sqrt(5) - 1)  # factor by which a step of a golden section shortens the range


@dataclass(frozen=True, eq=False, repr=False)
class Coupling(Result):
    """The coupling ratio ρ* of slips with each other's limits.

    With every other slip fixed, node i may slip between L_i and U_i, where its
    rows are met. If the other slips change by δ, U_i changes by at most (N₊ |δ|)_i and
    L_i by at most (N₋ |δ|)_i, N∓_ij = |A_ij ± f_i B_ij| / (A_ii ± f_i B_ii).

    Attributes
    ----------
    ratio
        ρ*, the least number for which some d > 0 has N₊ d ≤ ρ* d and N₋ d ≤ ρ* d; NaN where a node is
        at or above its own critical friction A_ii / (f_i |B_ii|), where it is not defined. Below 1
        the motion is unique and λ_1 is the limit of shakedown (docs/guarantee.md, Theorem 3).
    bound
        A number ≥ ρ* that the weights prove, rounded up.
    weights : (n,)
        These d > 0, largest entry 1: in their norm no limit moves by more than ρ* times the slips.
    """

    ratio: float
    bound: float
    weights: FloatArray


def relaxed(A: FloatArray, fB: FloatArray) -> FloatArray | None:
    """c with e_i = c_i · e where the backward and the forward limit of node i is met, (2, n, n), 0 at j = i.

    −(A_ij ∓ (fB)_ij) / (A_ii ∓ (fB)_ii): by |c_ij| the limit moves with slip of node j. None where a node is
    at or above its own critical friction, A_ii / |f_i B_ii|.
    """
    sides = np.stack([A - fB, A + fB])
    own = np.diagonal(sides, axis1=1, axis2=2)
    if not np.all(own > 0):
        return None
    c = -sides / own[:, :, None]
    nodes = np.arange(len(A))
    c[:, nodes, nodes] = 0.0
    return c


def row_coupling_ratio(A: FloatArray, fB: FloatArray) -> Coupling | None:
    """The least ρ* for which some d > 0 has N_s d ≤ ρ* d for the limits s of either side.

    It is the largest spectral radius of the matrices that take the row of each node from the side of
    its own choice. Policy iteration: at weights d every node chooses the side that moves more, and
    the largest quotient (N_s d)_i / d_i bounds ρ* from above, the least from below; inverse
    iteration with that bound as its shift (Noda) improves d.

    None where a node is at or above its own critical friction.
    """
    c = relaxed(A, fB)
    if c is None:
        return None
    n, N = len(A), np.abs(c)
    all_nodes, d, best = np.arange(n), np.ones(n), (np.inf, np.ones(n))
    # a trace of coupling between all nodes makes the weights positive where some act on no others
    M = N + ROUND_OFF * N.max()
    for _ in range(ITERATIONS):
        moved = M @ d
        quotient = moved.max(axis=0) / d
        best = min(best, (float(quotient.max()), d), key=lambda found: found[0])
        if quotient.max() - quotient.min() <= ROUND_OFF * quotient.max():
            break
        chosen = M[moved.argmax(axis=0), all_nodes]
        try:
            d = np.linalg.solve(quotient.max() * np.eye(n) - chosen, d)
        except np.linalg.LinAlgError:
            break
        d = np.abs(d)
        if not np.all(np.isfinite(d)):
            break
        d = np.maximum(d / d.max(), ROUND_OFF)  # for nodes that hardly take part in the coupling
    weights = best[1]
    bound = _rounded_up(A, fB, weights)
    return Coupling(min(float((N @ weights / weights).max()), bound), bound, weights)


def _rounded_up(A: FloatArray, fB: FloatArray, d: FloatArray) -> float:
    """max_i Σ_{j≠i} |A_ij ∓ f_i B_ij| d_j / ((A_ii ∓ f_i B_ii) d_i), never below the exact number.

    Each product f B, each difference and each of the n additions is off by half a unit at most of
    what the terms without cancellation come to; all of it is taken twice.
    """
    n = len(A)
    sizes = np.abs(A) + np.abs(fB)
    own, off = np.diagonal(sizes) * d, ~np.eye(n, dtype=bool)
    moved = np.stack([np.abs(A - fB) * off @ d, np.abs(A + fB) * off @ d])
    moved = moved + (n + 4) * EPS * (sizes * off @ d)
    held = np.stack([np.diagonal(A - fB), np.diagonal(A + fB)]) * d - 4 * EPS * own
    if not np.all(held > 0):
        return np.inf
    return float((moved / held).max()) * (1 + 2 * EPS)


def coupling_limit(stiffness: ScaledStiffness) -> float:
    """The factor t on φ where the coupling ratio ρ* reaches 1.

    Below it every A − t S φ B is an H-matrix with a positive diagonal, so that all its
    principal minors are positive. ρ* < 1 at t implies the same at every smaller factor: for given
    weights it is a set of inequalities that are convex and even in t.
    """
    a, b = np.diag(stiffness.A), np.abs(np.diag(stiffness.weighted))
    own = float(np.min(a / np.where(b > 0, b, 1.0), where=b > 0, initial=np.inf))
    if not weakly_coupled(stiffness, 0.0):
        return 0.0
    high = own * (1 - NEGLIGIBLE)  # at a node's own critical friction its limits move without bound
    if np.isinf(own):
        high = next((t for t in 2.0 ** np.arange(HALVINGS) if not weakly_coupled(stiffness, t)), np.inf)
    if np.isinf(high) or weakly_coupled(stiffness, high):
        return float(high)
    low = 0.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if weakly_coupled(stiffness, middle) else (low, middle)
    return float(low)


def weakly_coupled(stiffness: ScaledStiffness, factor: float) -> bool:
    """Whether ρ* < 1 at a factor on φ."""
    found = row_coupling_ratio(stiffness.A, factor * stiffness.weighted)
    return found is not None and found.bound < 1.0


def energy_limit(stiffness: ScaledStiffness, *, separation: bool) -> float:
    """The factor t on φ where uᵀκu + t Σ s φ v p could first vanish for some motion; 0 for a floating body.

    Below it all moving sets are unique. With p = G u the sum is at most
    ½ uᵀ (c φ + Gᵀφ G / c) u for any c > 0; the best c is searched for. The logarithm
    of the largest eigenvalue changes by no more than log c does, and is convex in it.
    """
    K = stiffness.kappa if separation else stiffness.A
    G = K[stiffness.layout.gaps] if separation else stiffness.B
    if not held(K, stiffness.tolerances):
        return 0.0
    try:
        root = np.linalg.inv(np.linalg.cholesky(K))
    except np.linalg.LinAlgError:  # indefinite by round-off
        return 0.0
    slip = root[:, stiffness.layout.slips] * np.sqrt(stiffness.weights)
    pressure = root @ G.T * np.sqrt(stiffness.weights)
    largest = least_of_sums(slip @ slip.T, pressure @ pressure.T)
    return 2.0 / largest if largest > 0.0 else np.inf


def least_of_sums(first: FloatArray, second: FloatArray) -> float:
    """The largest eigenvalue of c F + S / c at the best c > 0, found or not: that of any c is an upper bound.

    F and S are symmetric and positive semi-definite. Of many rows c is searched for with eigenvalues by
    iteration, each a tenth of the time of all of them.
    """
    sizes = np.trace(first), np.trace(second)
    if 0.0 in sizes:
        return 0.0
    middle = 0.5 * np.log(sizes[1] / sizes[0])

    def largest(log_c: float) -> float:
        c = np.exp(log_c)
        return float(np.linalg.eigvalsh(c * first + second / c)[-1])

    if len(first) < MANY_ROWS:
        return least_point(largest, middle - WIDTH, middle + WIDTH)[1]
    return largest(least_point(_about(first, second), middle - WIDTH, middle + WIDTH)[0])


def _about(first: FloatArray, second: FloatArray) -> Callable[[float], float]:
    """The largest eigenvalue of c F + S / c over log c, to a few digits."""
    from scipy.sparse.linalg import ArpackNoConvergence, eigsh

    start = np.random.default_rng(0).normal(size=len(first))

    def largest(log_c: float) -> float:
        c = np.exp(log_c)
        matrix = c * first + second / c
        try:
            # six digits of an eigenvalue: c is sought to 1e-4
            found = eigsh(matrix, k=1, which="LA", v0=start, tol=SIX_DIGITS, return_eigenvectors=False)
            return float(found[0])
        except ArpackNoConvergence:
            return float(np.linalg.eigvalsh(matrix)[-1])

    return largest


def least_point(convex: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    """Where a convex function is least, as a golden section finds it, and its value: one value a step.

    By hand, because to load scipy.optimize takes longer than what it is used for here.

    Examples
    --------
    >>> [round(number, 3) for number in least_point(lambda x: (x - 1.0) ** 2 + 3.0, -5.0, 5.0)]
    [1.0, 3.0]
    """
    ratio = GOLDEN
    a, b = high - ratio * (high - low), low + ratio * (high - low)
    at_a, at_b = convex(a), convex(b)
    for _ in range(ceil(log(1e-5) / log(GOLDEN))):  # to 1e-5 of the range
        if at_a < at_b:
            high, b, at_b = b, a, at_a
            a = high - ratio * (high - low)
            at_a = convex(a)
        else:
            low, a, at_a = a, b, at_b
            b = low + ratio * (high - low)
            at_b = convex(b)
    return (a, at_a) if at_a < at_b else (b, at_b)


@once_per_problem
def coupling(problem: Problem) -> Coupling:
    """The coupling ratio ρ* of a problem; worked out once per problem.

    Examples
    --------
    >>> import shakedown
    >>> round(coupling(shakedown.example("two-node")).ratio, 4)
    0.4274
    >>> coupling(shakedown.example("three-node")).bound < 1
    False
    """
    require_plane("coupling", problem, NO_SIGNS)
    found = row_coupling_ratio(problem.A, problem.law.limit_rows(problem.B))
    if found is None:
        return Coupling(nan, nan, np.full(problem.n, nan))
    least = 1.0 if rigid_slips(problem).pinned else 0.0  # A z = B z = 0 gives |z| <= N |z|, but for round-off
    return Coupling(max(found.ratio, least), max(found.bound, least), found.weights)


@dataclass(frozen=True, eq=False, repr=False)
class Uniqueness(Result):
    """Result of :func:`unique_in_contact`; true as a condition where uniqueness is proved.

    Attributes
    ----------
    unique
        True: every evolution with all nodes closed is unique. False: a set of slipping
        nodes loses its uniqueness. None: neither is known.
    argument
        What proves it, in words.
    slipping, sides
        Where uniqueness is lost: a set of slipping nodes, and the sides (+1 backward,
        −1 forward) for which their determinant vanishes at this friction or below.
    """

    unique: bool | None
    argument: str
    slipping: tuple[int, ...] = ()
    sides: tuple[int, ...] = ()

    def __bool__(self) -> bool:
        return self.unique is True


@checked
def unique_in_contact(problem: Problem, *, tolerances: Tolerances = DEFAULT) -> Uniqueness:
    """Whether every principal minor of A + S f B is positive for every diagonal S of signs ±1.

    Then the quasi-static evolution with all nodes closed is unique, for any loading and
    from any state (thesis (4.23), (6.4)–(6.10)). Exact up to eight nodes; beyond, the
    coupling ratio or the energy may prove it, a single node or a pair disprove it.
    Friction at a threshold, to the tolerance ``feasibility``, counts as above it.

    Parameters
    ----------
    problem
        The joint; its loading plays no part.
    tolerances
        What counts as zero.

    Examples
    --------
    >>> import shakedown
    >>> unique_in_contact(shakedown.example("two-node")).argument
    'coupling ratio below 1'
    >>> lost = unique_in_contact(shakedown.example("jump"))
    >>> lost.unique, lost.slipping
    (False, (0, 1))
    """
    require_plane("uniqueness", problem, NO_SIGNS)
    stiffness = scaled_stiffness(problem, problem.f, tolerances)
    friction = stiffness.friction_unit * (1 + tolerances.feasibility)  # the factor that f is on the weights
    if not held(stiffness.A, stiffness.tolerances):
        return Uniqueness(
            False, "only friction holds the body: if all its nodes slip, nothing determines how fast"
        )
    if not stiffness.weighted.any():
        return Uniqueness(True, "slip changes no friction limit (f B = 0)")
    if weakly_coupled(stiffness, friction):
        return Uniqueness(True, "coupling ratio below 1")
    every = stiffness.n <= LARGEST_SET
    sets = slipping_sets(stiffness.n, None if every else 2)
    lost = first_loss(stiffness, sets)
    if lost.factor <= friction:
        nodes = ", ".join(str(i) for i in lost.slipping)
        word = "node" if len(lost.slipping) == 1 else "nodes"
        at = f"at {lost.factor / stiffness.friction_unit:.5g} times the given friction"
        slip = f"slip of {word} {nodes} loses uniqueness {at}"
        return Uniqueness(False, slip, lost.slipping, lost.sides)
    if every:
        return Uniqueness(True, f"every set of slipping nodes tried ({len(sets)})")
    if energy_limit(stiffness, separation=False) > friction:
        return Uniqueness(True, "every motion stores more energy than friction can feed it")
    return Uniqueness(None, f"too many sets of slipping nodes to try all ({stiffness.n} nodes)")


@once_per_problem
def difference_gauge(problem: Problem) -> float | None:
    """A number below 1 that relaxing any one node keeps V(e) = max (e_a − e_b) / t_ab under, if one is found.

    For every slip e with V(e) ≤ 1, if node i is set to where either of its limits is met, no difference to
    another node, or to the ground at 0, exceeds this share of its scale t. With e_j = c_i·e where a limit of
    node i is met, Σ_k c_ik = 1 (what is missing is the weight of the ground, and nothing is missing where the
    body floats), the negative weights m are set off against the positive ones p in equal shares:

        c_i·e − e_j = (Σ_l p_l (e_l − e_j) + Σ_kl m_k p_l (e_l − e_k)) / Σ p
                    ≤ (Σ_l p_l t_lj + Σ_kl m_k p_l t_lk) / Σ p.

    The largest of these on both sides, as new scales, is a monotone map of the old ones; it is iterated
    until it makes all of them smaller. A node counts the way it goes in the softest slip of the joint. None
    where that does not end, where a node is at its own critical friction, and where a rigid slip leaves a
    node behind or there are two. Worked out once per problem.

    Examples
    --------
    >>> import shakedown
    >>> difference_gauge(shakedown.example("two-node")) < 1
    True
    >>> difference_gauge(shakedown.example("three-node")) is None
    True
    """
    weights = _weights(problem)
    if weights is None:
        return None
    n, nodes = weights.shape[1:]
    p, m = np.maximum(weights, 0.0), np.maximum(-weights, 0.0)
    total, apart = p.sum(axis=2), ~np.eye(nodes, dtype=bool)
    if not np.all(total > 0.0):
        return None

    def largest(t: FloatArray) -> FloatArray:
        """How far above node j node i comes at most when it is relaxed, on either side (n, nodes)."""
        above = p @ t
        offset = np.einsum("sik,sik->si", m, above)
        return np.asarray(((above + offset[:, :, None]) / total[:, :, None]).max(axis=0))

    t = 1.0 - np.eye(nodes)
    for _ in range(SWEEPS):
        new = np.zeros((nodes, nodes))
        new[:n] = largest(t)
        new[:, :n] = np.maximum(new[:, :n], largest(t.T).T)
        shares = new[apart] / t[apart]
        if shares.max() < 1.0 - NEGLIGIBLE:
            return float(shares.max())
        if shares.min() >= 1.0:
            return None
        t = np.where(apart, np.maximum(new / (new[apart].max() or 1.0), SIX_DIGITS), 0.0)
    return None


def _weights(problem: Problem) -> FloatArray | None:
    """c of both limits of every node, in units in which a rigid slip is 1 everywhere; the ground comes last.

    Where something holds the joint units are signs: those of the slip that meets least resistance.
    """
    A, fB, rigid = problem.A, problem.law.limit_rows(problem.B), rigid_slips(problem)
    floats = rigid.motions.shape[1]
    if floats:
        z = rigid.motions[:, 0]
    else:
        size = np.sqrt(np.where(np.diag(A) > 0.0, np.diag(A), 1.0))
        z = np.where(np.linalg.eigh(A / np.outer(size, size))[1][:, 0] < 0.0, -1.0, 1.0)
    if floats > 1 or not np.all(z) or rigid.doubt:
        return None
    weights = relaxed(A * z * z[:, None], fB * z * np.abs(z)[:, None])
    if weights is None or floats:
        return weights
    return np.concatenate([weights, (1.0 - weights.sum(axis=2))[:, :, None]], axis=2)
