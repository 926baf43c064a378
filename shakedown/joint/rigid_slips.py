"""Rigid slips: motions of a body that friction alone holds, told from round-off, and pinned.

Where nothing but the contact holds a body, some slips Z change no reaction: A Z = 0 and B Z = 0. As
stored A Z is round-off. Linear programs, and exact ones above all, would take that round-off for a
spring and move the body as far as it takes to feel it: they answer for another joint. A slip is known only
up to Z, so as many slips as Z has columns are set to zero, and their columns leave every program.
"""

from dataclasses import dataclass, replace

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE, RESOLVED, SIX_DIGITS
from shakedown.ground.tolerances import DEFAULT, FIRST_DIGIT
from shakedown.joint.derived import once_per_problem
from shakedown.joint.problem import Problem

NO_STIFFNESS = 2.0**-30  # largest relative stiffness of a rigid motion, as condensation costs a few digits
CLEAR = 1e4  # ratio by which true resistance exceeds round-off or printing errors
CLEARLY_HELD = 1 / CLEAR  # smallest eigenvalue of the scaled A, relative, that needs no closer look
INVERSE_ITERATIONS = 3  # each gains eight digits at least


@dataclass(frozen=True)
class RigidSlips:
    """What is known of the slips of a joint without resistance.

    Attributes
    ----------
    motions : (dn, r)
        Z, a basis: column k is 1 at slip ``pinned[k]`` and 0 at the other pinned ones [–].
    pinned
        The slips that are set to zero, by number, in increasing order: with one direction, nodes.
    doubt
        Why it is not clear how many there are, in words; empty where it is. Where it is not,
        nothing is certified.
    """

    motions: FloatArray
    pinned: tuple[int, ...]
    doubt: str = ""

    def relative(self, slip: FloatArray) -> FloatArray:
        """Slips (…, n) less the rigid slip that the pinned nodes have: zero there."""
        if not self.pinned:
            return slip
        pinned = list(self.pinned)
        moved = np.asarray(slip - slip[..., pinned] @ self.motions.T)
        moved[..., pinned] = 0.0
        return moved

    def columns(self, matrix: FloatArray) -> FloatArray:
        """A matrix (k, n) that no rigid slip changes, in terms of :meth:`relative` slips: 0 where pinned."""
        if not self.pinned:
            return matrix
        kept = matrix.copy()
        kept[:, list(self.pinned)] = 0.0
        return kept

    def avoiding(self, node: int) -> "RigidSlips":
        """The same slips, pinned elsewhere than at one node, which takes part in the motion."""
        if node not in self.pinned:
            return self
        column = self.pinned.index(node)
        share = np.abs(self.motions[:, column])
        share[list(self.pinned)] = 0.0
        other = int(np.argmax(share))
        if share[other] == 0.0:  # the node moves alone
            return self
        motions = self.motions.copy()
        motions[:, column] /= motions[other, column]
        for k in set(range(len(self.pinned))) - {column}:
            motions[:, k] -= motions[other, k] * motions[:, column]
        return _sorted(motions, [*self.pinned[:column], other, *self.pinned[column + 1 :]], self.doubt)


@once_per_problem
def rigid_slips(problem: Problem) -> RigidSlips:
    """The rigid slips of a joint with all nodes closed; found once per problem.

    Only motions that keep every node closed count, A Z = 0 and B Z = 0. They are the right singular
    vectors of [A; B], every node in the units of its own stiffness, below a clear gap: up to there
    the singular values are round-off, and the next one is larger by four orders of magnitude. With
    ``problem.stiffness_accuracy`` it is known what is round-off.

    Examples
    --------
    Two nodes of a body that only friction holds:

    >>> loop = {"f": 0.5, "q_w": [[1.0, 0.0]], "p_w": [[3.0, 3.0]]}
    >>> A, B = [[1.0, -1.0], [-1.0, 1.0]], [[0.2, -0.2], [0.1, -0.1]]
    >>> found = rigid_slips(Problem(A=A, B=B, **loop))
    >>> found.pinned, found.motions.ravel()
    ((0,), array([1., 1.]))
    """
    n, accuracy = problem.layout.slip_size, problem.stiffness_accuracy
    held = RigidSlips(np.zeros((n, 0)), ())
    A, lengths, power = _scaled(problem)
    if accuracy is None and _clearly_held(A):
        return held
    M = np.vstack([A, _coupling(problem, lengths, power)])
    R = np.asarray(np.linalg.qr(M, mode="r"))
    values = np.linalg.svd(R, compute_uv=False)
    size = np.abs(M)
    most = float(np.sqrt(size.sum(axis=0).max() * size.sum(axis=1).max()))
    if most == 0.0:
        return _pinned(np.eye(n), lengths, "")
    relative = values[::-1] / most
    count, doubt = (
        _without_resistance(relative) if accuracy is None else _below(relative, FIRST_DIGIT * accuracy)
    )
    if not count:
        return replace(held, doubt=doubt)
    return _pinned(_softest(R, values[::-1], count), lengths, doubt)


@once_per_problem
def with_free_rigid_slips(problem: Problem) -> Problem:
    """The joint, all nodes closed, in which rigid slips change no reaction at all; all else is as stored.

    Examples
    --------
    >>> loop = {"f": 0.5, "q_w": [[1.0, 0.0]], "p_w": [[3.0, 3.0]]}
    >>> A, B = [[1.0001, -1.0], [-1.0, 1.0001]], [[0.2, -0.2], [0.1, -0.1]]
    >>> with_free_rigid_slips(Problem(A=A, B=B, **loop, stiffness_accuracy=1e-4)).A.round(6)
    array([[ 1.0001, -1.0001],
           [-1.0001,  1.0001]])
    """
    rigid, n = rigid_slips(problem), problem.layout.slip_size
    if not rigid.pinned:
        return problem
    kept = np.setdiff1d(np.arange(n), rigid.pinned)
    relative = rigid.relative(np.eye(n)).T[kept]
    A = relative.T @ problem.A[np.ix_(kept, kept)] @ relative
    return replace(problem, A=0.5 * (A + A.T), B=problem.B[:, kept] @ relative, C=None)


@once_per_problem
def can_drift(problem: Problem) -> bool:
    """Whether some motion of the nodes changes no reaction: only then may slips grow for ever.

    A zero mode of κ, or of A where nodes cannot open (docs/energy.md, section 9), or one in doubt.

    Examples
    --------
    >>> import shakedown
    >>> can_drift(shakedown.example("two-node"))
    False
    """
    stiffness = problem.A if problem.C is None else problem.kappa
    lengths = 1.0 / np.sqrt(np.where(np.diag(stiffness) > 0, np.diag(stiffness), 1.0))
    values = np.abs(np.linalg.eigvalsh(stiffness * lengths * lengths[:, None]))
    accuracy, most = problem.stiffness_accuracy, float(values.max())
    relative = np.sort(values) / most if most > 0.0 else values
    count, doubt = (
        _without_resistance(relative) if accuracy is None else _below(relative, FIRST_DIGIT * accuracy)
    )
    return count > 0 or bool(doubt)


def _without_resistance(values: FloatArray) -> tuple[int, str]:
    """How many of the singular values, in increasing order, are round-off, and what is doubtful about it."""
    floor = len(values) * np.finfo(float).eps
    steps = np.maximum(np.append(values, np.inf), floor)
    jumps = steps[1:] / steps[:-1]
    rounded = np.where(values <= NO_STIFFNESS, jumps, 0.0)
    count, doubt = int(np.argmax(rounded)) + 1, ""
    if rounded[count - 1] < CLEAR:
        count, doubt = _below(values, floor)
    # the stiffness went through seven printed digits, and does not say so
    printed = (values[count:] <= SIX_DIGITS) & (jumps[count:] >= CLEAR)
    return count, doubt or (_doubt(values[count]) if printed.any() else "")


def _softest(R: FloatArray, values: FloatArray, count: int) -> FloatArray:
    """Right singular vectors (n, r) of the least singular values of a triangular R; all of them, increasing.

    By inverse iteration where the next one is larger by far: each round gains the square of their ratio.
    """
    from scipy.linalg import solve_triangular  # where a body floats only

    n, least = len(R), np.finfo(float).eps * values[-1]
    if count == n or not values[count] > CLEAR * values[count - 1]:
        return np.asarray(np.linalg.svd(R)[2][n - count :].T)
    factor = R.copy()
    diagonal = np.einsum("ii->i", factor)
    diagonal[np.abs(diagonal) < least] = least
    found = np.linalg.qr(np.random.default_rng(0).normal(size=(n, count)))[0]
    for _ in range(INVERSE_ITERATIONS):
        found = np.linalg.qr(solve_triangular(factor, solve_triangular(factor, found, trans=1)))[0]
    return np.asarray(found)


def _below(values: FloatArray, accuracy: float) -> tuple[int, str]:
    """The rigid slips where the accuracy of the data is known."""
    noise = max(accuracy, len(values) * np.finfo(float).eps)
    count = int(np.count_nonzero(values <= noise))
    return count, _doubt(values[count]) if np.any(values[count:] <= RESOLVED * noise) else ""


def _scaled(problem: Problem) -> tuple[FloatArray, FloatArray, int]:
    """A with every slip in units in which its stiffness is 1, these units, and the power of two of A.

    Nothing of this is stored, so powers of two in the units cancel.
    """
    diagonal = np.diagonal(problem.A)
    largest = float(diagonal.max(initial=0.0))
    relative = np.ldexp(diagonal, -int(np.frexp(largest)[1]))
    lengths = 1.0 / np.sqrt(np.where(diagonal > 0, relative, 1.0))
    power = int(np.frexp(largest or float(np.abs(problem.B).max(initial=0.0)))[1])
    return np.ldexp(problem.A, -power) * lengths * lengths[:, None], lengths, power


def _coupling(problem: Problem, lengths: FloatArray, power: int) -> FloatArray:
    """B likewise. Rows that are larger than 1 then are divided by their largest entry: accuracy is by row."""
    of_nodes = problem.layout.by_node(lengths).max(axis=-1)
    B = np.ldexp(problem.B, -power) * lengths * of_nodes[:, None]
    return np.asarray(B / np.maximum(np.abs(B).max(axis=1, keepdims=True), 1.0))


def _clearly_held(A: FloatArray) -> bool:
    """Whether A alone shows that there is nothing rigid; quick."""
    values = np.linalg.eigvalsh(A)
    return bool(values[0] > CLEARLY_HELD * values[-1])


def _doubt(softest: float) -> str:
    return (
        f"a slip that keeps all nodes closed meets {softest:.0e} of the stiffness, too little to be a "
        "support and too much to be round-off: give stiffness_accuracy"
    )


def _pinned(basis: FloatArray, lengths: FloatArray, doubt: str) -> RigidSlips:
    """Pins where the slips of a basis (n, r), in scaled units, are largest: complete pivoting."""
    left, pinned = basis.copy(), list[int]()
    for _ in range(basis.shape[1]):
        size = np.linalg.norm(left, axis=1)
        size[pinned] = 0.0
        # of pivots that are equal but for round-off the one of the lowest node is taken
        node = int(np.flatnonzero(size >= (1.0 - SIX_DIGITS) * size.max())[0])
        pinned.append(node)
        along = left[node] / np.linalg.norm(left[node])
        left = left - np.outer(left @ along, along)
    motions = np.linalg.solve(basis[pinned].T, basis.T).T
    motions[np.abs(motions) <= NEGLIGIBLE * np.abs(motions).max(axis=0)] = 0.0
    return _sorted(lengths[:, None] * motions / lengths[pinned], pinned, doubt)


def _sorted(motions: FloatArray, pinned: list[int], doubt: str) -> RigidSlips:
    """With the pinned nodes in increasing order, and exactly one there."""
    order = np.argsort(pinned)
    nodes = [pinned[k] for k in order]
    motions = motions[:, order]
    motions[nodes] = np.eye(len(nodes))
    return RigidSlips(motions, tuple(nodes), doubt)


def zero_modes(stiffness: FloatArray) -> int:
    """Number of eigenvalues of a symmetric matrix that are zero to round-off.

    Examples
    --------
    >>> zero_modes(np.array([[1.0, -1.0], [-1.0, 1.0]]))
    1
    """
    eigenvalues = np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T))
    return int((np.abs(eigenvalues) <= DEFAULT.zero_mode * np.abs(eigenvalues).max()).sum())
