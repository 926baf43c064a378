"""Sets of slipping nodes whose determinant vanishes, by friction; the stiffness scaled."""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, groupby, product
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import EPS, ROUND_OFF, FloatArray
from shakedown.ground.tolerances import FIRST_DIGIT, Tolerances
from shakedown.joint.law import Layout
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips, stiffness_error


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
    # largest error of eigenvalues of scaled matrices, in units of the error of their entries
    return replace(tolerances, zero_mode=max(tolerances.zero_mode, 4.0 * error))


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
class LostAt:
    """The factor on φ at which uniqueness is lost (inf: at none): by these slipping nodes, all others stuck.

    ``sides`` are those of their slip, and the nodes ``separated`` are open.
    """

    factor: float
    slipping: Nodes = ()
    sides: Nodes = ()
    separated: Nodes = ()


NEVER = LostAt(np.inf)


def slipping_sets(n: int, largest: int | None = None) -> list[Nodes]:
    """Every choice of up to so many slipping nodes, all of them by default."""
    return [nodes for k in range(1, (largest or n) + 1) for nodes in combinations(range(n), k)]


def first_to_lose(stiffness: ScaledStiffness, sets: list[Nodes]) -> LostAt:
    """Of these sets of slipping nodes the one that loses uniqueness at the smallest factor, on any sides."""
    first = NEVER
    for size, alike in groupby(sorted(sets, key=len), key=len):
        group, sides = np.array(list(alike), dtype=np.intp), all_sides(size)
        for some in np.array_split(
            group, len(group) * len(sides) // (1 << 16) + 1
        ):  # small matrices at one time
            first = min(first, *_lost_by(stiffness, some, sides), key=lambda lost: lost.factor)
    return first


def first_with_open_nodes(stiffness: ScaledStiffness) -> LostAt:
    """The same of every set of slipping nodes, beside every choice of open ones."""
    first, nodes = NEVER, range(stiffness.n)
    for separated in [(), *slipping_sets(stiffness.n, stiffness.n - 1)]:
        rest, joint = [i for i in nodes if i not in separated], stiffness.opened(separated)
        lost = NEVER if joint is None else first_to_lose(joint, slipping_sets(joint.n))
        if lost.factor < first.factor:
            first = replace(lost, slipping=tuple(rest[i] for i in lost.slipping), separated=separated)
    return first


def all_sides(k: int) -> FloatArray:
    """All sides of k nodes but for a common sign, (2ᵏ⁻¹, k).

    S and −S belong together: det(A′ − t S φ B′) = 0 where det(A′ + t S φ B′) = 0 has the root −t.
    """
    return np.array([(1.0, *rest) for rest in product((1.0, -1.0), repeat=k - 1)])


def _lost_by(stiffness: ScaledStiffness, sets: NDArray[np.intp], signs: FloatArray) -> list[LostAt]:
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
        LostAt(float(1.0 / abs(root)), tuple(slipping), tuple(side)) if root else NEVER
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
    largest = np.take_along_axis(sizes, place, axis=-1) * np.sign(
        np.take_along_axis(eigenvalues.real, place, axis=-1)
    )
    return np.asarray(largest[..., 0])
