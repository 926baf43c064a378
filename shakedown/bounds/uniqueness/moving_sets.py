"""Sets of slipping nodes whose determinant vanishes, by friction; the stiffness scaled."""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, groupby, product
from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import AT_ONCE, EPS, ROUND_OFF, FloatArray
from shakedown.ground.tolerances import FIRST_DIGIT, Tolerances
from shakedown.joint.law import Layout
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips, stiffness_error

SPREAD = 4.0  # largest error of eigenvalues of scaled matrices, in units of the error of their entries


@dataclass(frozen=True)
class ScaledStiffness:
    """A, B, C and f, divided by powers of two.

    Attributes
    ----------
    A, B : (n, n)
        Divided by the size of A, or of B where that is larger; entries of B that are
        round-off of the stiffness are 0.
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


def scaled_stiffness(problem: Problem, friction: FloatArray, tolerances: Tolerances) -> ScaledStiffness:
    """Bring the stiffness and the friction of a problem near the size 1, free of round-off.

    Examples
    --------
    >>> import numpy as np, shakedown
    >>> scaled = scaled_stiffness(shakedown.example("two-node"), np.full(2, 3.0), shakedown.Tolerances())
    >>> scaled.weights, scaled.friction_unit
    (array([0.75, 0.75]), 4.0)
    """
    power = exponent(max(np.abs(problem.A).max(), np.abs(problem.B).max()))
    own = exponent(friction.max())
    A, B = np.ldexp(problem.A, -power), np.ldexp(problem.B, -power)
    size = np.sqrt(np.diag(A))
    noise = tolerances.condensed_pattern * np.outer(size, size)
    return ScaledStiffness(
        A=A,
        B=np.where(np.abs(B) > noise, B, 0.0),
        C=None if problem.C is None else np.ldexp(problem.C, -power),
        weights=np.ldexp(friction, -own),
        friction_unit=float(np.ldexp(1.0, own)),
        tolerances=_of_the_data(problem, tolerances),
        pinned=rigid_slips(problem).pinned,
    )


def _of_the_data(problem: Problem, tolerances: Tolerances) -> Tolerances:
    """The tolerances, with nothing below the accuracy of the data counted as resistance."""
    error = stiffness_error(problem) / FIRST_DIGIT
    return replace(tolerances, zero_mode=max(tolerances.zero_mode, SPREAD * error))


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


DOUBLE_ROOT = 8 * sqrt(EPS)  # imaginary part, relative to the size, to which round-off parts a double root
LARGEST_SET = 8  # nodes up to which all sets are tried; neighbours that a node is paired with


class MovingSet(NamedTuple):
    """Slipping nodes and open nodes; all others are stuck."""

    slipping: tuple[int, ...]
    separated: tuple[int, ...] = ()


@dataclass(frozen=True)
class LostAt:
    """The factor on φ at which a moving set loses uniqueness (inf: at none), and the sides of its slip."""

    factor: float
    moving: MovingSet
    sides: tuple[int, ...]


NEVER = LostAt(np.inf, MovingSet(()), ())


def every_set(n: int, *, separation: bool) -> list[MovingSet]:
    """Every choice of slipping nodes, beside no open node or beside every choice of open nodes."""
    sets = []
    for size in range(n if separation else 1):
        for separated in combinations(range(n), size):
            rest = [i for i in range(n) if i not in separated]
            for k in range(1, len(rest) + 1):
                sets += [MovingSet(slipping, separated) for slipping in combinations(rest, k)]
    return sets


def first_to_lose(stiffness: ScaledStiffness, sets: list[MovingSet]) -> LostAt:
    """Of these moving sets the one that loses uniqueness at the smallest factor, with any sides."""

    def size(moving: MovingSet) -> tuple[int, int]:
        return len(moving.slipping), len(moving.separated)

    first = NEVER
    for (slipping, _), alike in groupby(sorted(sets, key=size), key=size):
        group, sides = list(alike), all_sides(slipping)
        step = max(1, AT_ONCE // len(sides))
        for start in range(0, len(group), step):
            found = _lost_by(stiffness, group[start : start + step], sides)
            first = min(first, *found, key=lambda lost: lost.factor)
    return first


def all_sides(k: int) -> FloatArray:
    """All sides of k nodes but for a common sign, (2ᵏ⁻¹, k).

    S and −S belong together: det(A′ − t S φ B′) = 0 where det(A′ + t S φ B′) = 0 has the root −t.
    """
    return np.array([(1.0, *rest) for rest in product((1.0, -1.0), repeat=k - 1)])


def _lost_by(stiffness: ScaledStiffness, sets: list[MovingSet], signs: FloatArray) -> list[LostAt]:
    """The same for moving sets of equally many nodes, all at once, with these sides (s, k)."""
    slipping = np.array([moving.slipping for moving in sets], dtype=np.intp)
    separated = np.array([moving.separated for moving in sets], dtype=np.intp).reshape(len(sets), -1)
    A, B, usable = condensed(stiffness, slipping, separated)
    usable &= held(A, stiffness.tolerances)
    A = np.where(usable[:, None, None], A, np.eye(slipping.shape[1]))
    weighted = stiffness.weights[slipping][:, :, None] * B
    roots = _largest_real(np.linalg.inv(A)[:, None] @ (signs[:, :, None] * weighted[:, None]))
    roots = np.where(usable[:, None], roots, 0.0)
    best = np.abs(roots).argmax(axis=1)
    largest = roots[np.arange(len(sets)), best]
    sides = (signs[best] * np.sign(largest)[:, None]).astype(int).tolist()  # A − t s φ B is singular
    return [
        LostAt(float(1.0 / abs(root)), moving, tuple(side)) if root else LostAt(np.inf, moving, ())
        for moving, root, side in zip(sets, largest, sides, strict=True)
    ]


def _largest_real(matrices: FloatArray) -> FloatArray:
    """The real eigenvalue of largest size of every matrix (…, k, k); 0 where there is none."""
    eigenvalues = np.linalg.eigvals(matrices)
    size = np.abs(eigenvalues)
    real = np.abs(eigenvalues.imag) <= DOUBLE_ROOT * size
    real &= size > ROUND_OFF * np.abs(matrices).max(axis=(-2, -1))[..., None]
    sizes = np.where(real, size, 0.0)
    place = sizes.argmax(axis=-1)[..., None]
    largest = np.take_along_axis(sizes, place, axis=-1) * np.sign(
        np.take_along_axis(eigenvalues.real, place, axis=-1)
    )
    return np.asarray(largest[..., 0])


def condensed(
    stiffness: ScaledStiffness, slipping: NDArray[np.intp], separated: NDArray[np.intp]
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """A′ and B′ (m, k, k) of the slipping nodes (m, k), the separated ones (m, l) free, the rest stuck.

    The third result says where the separated nodes are held by the stuck ones.
    """
    if separated.shape[1] == 0:
        rows, columns = slipping[:, :, None], slipping[:, None, :]
        return stiffness.A[rows, columns], stiffness.B[rows, columns], np.ones(len(slipping), dtype=bool)
    kappa, gaps_of = stiffness.kappa, stiffness.layout.gaps_of
    free, normal = np.hstack([separated, gaps_of(separated)]), gaps_of(slipping)

    def part(rows: NDArray[np.intp], columns: NDArray[np.intp]) -> FloatArray:
        return np.asarray(kappa[rows[:, :, None], columns[:, None, :]])

    inner = part(free, free)
    usable = held(inner, stiffness.tolerances)
    inner = np.where(usable[:, None, None], inner, np.eye(free.shape[1]))
    follow = -np.linalg.solve(inner, part(free, slipping))
    return (
        part(slipping, slipping) + part(slipping, free) @ follow,
        part(normal, slipping) + part(normal, free) @ follow,
        usable,
    )


def few_nodes(stiffness: ScaledStiffness, *, separation: bool) -> list[MovingSet]:
    """Every node by itself, and every pair of neighbours: each node with those that it is coupled to most.

    With separation every node beside an open neighbour, too.
    """
    n, diagonal = stiffness.n, np.diag(stiffness.A)
    size = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    B = np.abs(stiffness.B)
    strength = (np.abs(stiffness.A) + B + B.T) / np.outer(size, size)
    np.fill_diagonal(strength, -1.0)
    nearest = np.argsort(-strength, axis=1)[:, : min(n - 1, LARGEST_SET)]
    pairs = [(i, int(j)) for i in range(n) for j in nearest[i]]
    together = [MovingSet(pair) for pair in sorted({(min(pair), max(pair)) for pair in pairs})]
    opened = [MovingSet((i,), (j,)) for i, j in pairs] if separation else []
    return [MovingSet((i,)) for i in range(n)] + together + opened
