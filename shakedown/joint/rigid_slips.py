"""Rigid slips: motions of a body that friction alone holds, distinguished from round-off, and pinned.

Where nothing but the contact holds a body, some slips Z change no reaction: A Z = 0 and B Z = 0. As
stored A Z is round-off. Linear programs, and exact ones above all, would take that round-off for a
spring and move the body as far as it takes to feel it: they answer for another joint. A slip is known only
up to Z, so as many slips as Z has columns are set to zero, and their columns leave every program.
"""

from dataclasses import dataclass, replace

import numpy as np

from shakedown.ground.constants import NEGLIGIBLE, RESOLVED, SIX_DIGITS, FloatArray
from shakedown.ground.tolerances import DEFAULT, FIRST_DIGIT
from shakedown.joint.arguments import once_per_problem
from shakedown.joint.fields import is_definite, printed_error
from shakedown.joint.law import Layout
from shakedown.joint.problem import Problem

NO_STIFFNESS = 2.0**-30  # largest relative stiffness of a rigid motion, as condensation costs a few digits
CLEAR = 1e4  # ratio by which true resistance exceeds round-off or printing errors
MOTION_ROUND_OFF = 16 * np.finfo(float).eps  # relative round-off of a projected stiffness
MEETS = "a rigid motion of a body meets {:.0e} of the stiffness"
ASKED = ": give stiffness_accuracy (of an import: accuracy in [stiffness])"


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
    n = problem.layout.slip_size
    A, lengths, power = _scaled(problem, problem.A)
    if problem.stiffness_accuracy is None and _clearly_held(A):
        return RigidSlips(np.zeros((n, 0)), ())
    of_nodes = problem.layout.by_node(lengths).max(axis=-1)
    B = np.ldexp(problem.B, -power) * lengths * of_nodes[:, None]
    # rows of B larger than 1 are divided by their largest entry: accuracy is by row
    M = np.vstack([A, B / np.maximum(np.abs(B).max(axis=1, keepdims=True), 1.0)])
    size = np.abs(M)
    most = float(np.sqrt(size.sum(axis=0).max() * size.sum(axis=1).max()))
    if most == 0.0:
        return _pinned(np.eye(n), lengths, "")
    motions = _closed(motions_of_a_body(problem)[0], problem.layout)
    known = _unresisted(M / most, motions / lengths[:, None], problem)
    if not stiffness_error(problem) and _clearly_held(A + most * (known @ known.T)):
        return _pinned(known, lengths, "")
    R = np.asarray(np.linalg.qr(M - (M @ known) @ known.T, mode="r"))
    values = np.linalg.svd(R, compute_uv=False)[::-1]
    count, doubt = _without_resistance(values / most, problem.stiffness_accuracy, stiffness_error(problem))
    if not count:
        return RigidSlips(np.zeros((n, 0)), (), doubt)
    return _pinned(_softest(R, values, count), lengths, doubt)


@once_per_problem
def free_stiffness(problem: Problem) -> FloatArray:
    """κ = [[A, Bᵀ], [B, C]] without what round-off or printing left of the stiffness against rigid motions.

    ((d + 1) n, (d + 1) n) [force/length]; zeros for C where no node may open. All motions of a joint are
    followed with it: a body that friction does not hold slides away, whatever the last digits are.

    Examples
    --------
    >>> loop = {"f": 0.5, "q_w": [[1.0, 0.0]], "p_w": [[3.0, 3.0]]}
    >>> A, B = [[1.0 + 1e-12, -1.0], [-1.0, 1.0]], [[0.2, -0.2], [0.1, -0.1]]
    >>> int(np.linalg.matrix_rank(free_stiffness(Problem(A=A, B=B, **loop))[:2]))
    1
    """
    kappa, basis = _stiffness(problem), _rigid_motions(problem)[0]
    if not basis.shape[1]:
        return kappa
    lengths = _scaled(problem, kappa)[1]
    scaled = deflated(kappa * lengths * lengths[:, None], basis) / lengths / lengths[:, None]
    # what was no coupling at all remains none
    own = np.sqrt(np.abs(np.diag(kappa)))  # a stiffness of round-off may be negative
    return np.where((kappa == 0.0) & (np.abs(scaled) <= MOTION_ROUND_OFF * np.outer(own, own)), 0.0, scaled)


@once_per_problem
def _rigid_motions(problem: Problem) -> tuple[FloatArray, str]:
    """The motions ((d + 1) n, r) in scaled units that meet no resistance, and what is doubtful about it.

    An orthonormal basis; those that keep all nodes closed are the ones of :func:`rigid_slips`.
    """
    layout, slips = problem.layout, rigid_slips(problem)
    scaled, lengths, _ = _scaled(problem, _stiffness(problem))
    basis = np.zeros((layout.size, len(slips.pinned)))
    basis[layout.slips] = slips.motions
    basis = np.linalg.qr(basis / lengths[:, None])[0]
    if problem.C is None:
        return basis, slips.doubt
    if not slips.pinned and problem.stiffness_accuracy is None and _clearly_held(scaled):
        return basis, slips.doubt
    most = float(np.abs(scaled).sum(axis=0).max())
    if most == 0.0:
        return np.eye(layout.size), slips.doubt
    scaled = deflated(scaled, basis) / most
    known = _unresisted(scaled, motions_of_a_body(problem)[0] / lengths[:, None], problem)
    values, vectors = np.linalg.eigh(deflated(scaled, known))
    order = np.argsort(np.abs(values))
    count, doubt = _without_resistance(
        np.abs(values)[order], problem.stiffness_accuracy, stiffness_error(problem)
    )
    return vectors[:, order[:count]], slips.doubt or doubt


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


def can_drift(problem: Problem) -> bool:
    """Whether some motion of the nodes changes no reaction: only then may slips grow for ever.

    A zero mode of κ, or of A and B where nodes cannot open (docs/energy.md, Theorem 8), or one in doubt.

    Examples
    --------
    >>> import shakedown
    >>> can_drift(shakedown.example("two-node"))
    False
    """
    basis, doubt = _rigid_motions(problem)
    return bool(basis.shape[1] or doubt)


def can_creep(problem: Problem) -> bool:
    """Whether some slip with all nodes closed changes no reaction, or may: only then may a joint creep.

    Examples
    --------
    >>> import shakedown
    >>> can_creep(shakedown.example("two-node"))
    False
    """
    rigid = rigid_slips(problem)
    return bool(rigid.pinned or rigid.doubt)


def _without_resistance(values: FloatArray, accuracy: float | None, printed: float) -> tuple[int, str]:
    """How many of the singular values, in increasing order, are no resistance, and what is doubtful about it.

    ``printed``: the error of numbers that seem to be printed. Where no accuracy is given, what is soft by
    that, or below six digits and by a clear gap, counts as none too, but in doubt.
    """
    if accuracy is not None:
        return _below(values, FIRST_DIGIT * accuracy)
    floor = len(values) * np.finfo(float).eps
    steps = np.maximum(np.append(values, np.inf), floor)
    clear = np.flatnonzero((values <= SIX_DIGITS) & (steps[1:] / steps[:-1] >= CLEAR))
    count, doubt = (int(clear[-1]) + 1, "") if clear.size else _below(values, floor)
    count = max(count, int(np.count_nonzero(values <= printed)))
    if count and values[count - 1] > NO_STIFFNESS:
        doubt = doubt or f"{MEETS.format(values[count - 1])} and is taken for rigid{ASKED}"
    return count, doubt


@once_per_problem
def stiffness_error(problem: Problem) -> float:
    """Relative error of the entries of A and B: as given, or as they were printed with few digits; else 0."""
    given = problem.stiffness_accuracy
    return printed_error(problem.A, problem.B) if given is None else FIRST_DIGIT * given


def _unresisted(matrix: FloatArray, motions: FloatArray, problem: Problem) -> FloatArray:
    """An orthonormal basis of those of some motions (N, k) that a matrix (…, N) of size 1 does not resist."""
    basis = basis_of(motions)
    _, resistance, turn = np.linalg.svd(matrix @ basis, full_matrices=False)
    least = NO_STIFFNESS if problem.stiffness_accuracy is None else 0.0
    return np.asarray(basis @ turn[resistance <= max(stiffness_error(problem), least)].T)


def motions_of_a_body(problem: Problem) -> tuple[FloatArray, float]:
    """Slips and gaps ((d + 1) n, 6) in motions of one body as a whole; (…, 0) where places are not known.

    Three translations of size 1 and three rotations about the middle of the nodes in which no node moves
    further; and how far the farthest node is from there, by which a turn of 1 rad is larger.
    """
    layout, normal, places = problem.layout, problem.normal, problem.coordinates
    tangents = problem.tangents if problem.directions > 1 else problem.tangent
    if normal is None or places is None or tangents is None:
        return np.zeros((layout.size, 0)), 1.0
    arm = places - places.mean(axis=0)
    farthest = float(np.linalg.norm(arm, axis=1).max()) or 1.0
    arm = arm / farthest
    moved = np.concatenate([np.tile(np.eye(3), (problem.n, 1, 1)), np.cross(np.eye(3), arm[:, None])], axis=1)
    slips = np.einsum("ikx,idx->idk", moved, tangents.reshape(problem.n, -1, 3))
    gaps = np.einsum("ikx,ix->ik", moved, normal)
    return np.concatenate([slips.reshape(layout.slip_size, 6), gaps]), farthest


def _closed(motions: FloatArray, layout: Layout) -> FloatArray:
    """The slips (dn, k) in those combinations of some motions that keep all nodes closed."""
    slips, gaps = motions[layout.slips], motions[layout.gaps]
    sizes, turn = np.linalg.svd(np.vstack([gaps, np.zeros((gaps.shape[1],) * 2)]))[1:]
    return np.asarray(slips @ turn[sizes <= DEFAULT.printed_digits * np.sqrt(layout.n)].T)


def basis_of(motions: FloatArray) -> FloatArray:
    """An orthonormal basis of some motions (N, k), of any size, that may depend on each other."""
    basis, sizes, _ = np.linalg.svd(motions, full_matrices=False)
    return np.asarray(basis[:, sizes > DEFAULT.printed_digits * sizes.max(initial=0.0)])


def deflated(matrix: FloatArray, basis: FloatArray) -> FloatArray:
    """A symmetric matrix without what it has in the directions of an orthonormal basis (N, r).

    Examples
    --------
    >>> deflated(np.array([[1.0, -0.8], [-0.8, 1.0]]), basis_of(np.array([[1.0], [1.0]]))).round(12)
    array([[ 0.9, -0.9],
           [-0.9,  0.9]])
    """
    left = matrix - (matrix @ basis) @ basis.T
    left = left - basis @ (basis.T @ left)
    return np.asarray(0.5 * (left + left.T))


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
    for _ in range(3):  # each gains eight digits at least
        found = np.linalg.qr(solve_triangular(factor, solve_triangular(factor, found, trans=1)))[0]
    return np.asarray(found)


def _below(values: FloatArray, accuracy: float) -> tuple[int, str]:
    """The rigid slips where the accuracy of the data is known."""
    noise = max(accuracy, len(values) * np.finfo(float).eps)
    count = int(np.count_nonzero(values <= noise))
    near = np.any(values[count:] <= RESOLVED * noise)
    return count, f"{MEETS.format(values[count])}, hardly more than its error{ASKED}" if near else ""


def _stiffness(problem: Problem) -> FloatArray:
    """κ as stored, with zeros for C where no node may open."""
    C = np.zeros((problem.n, problem.n)) if problem.C is None else problem.C
    return problem.layout.of_blocks(problem.A, problem.B, C)


def _scaled(problem: Problem, stiffness: FloatArray) -> tuple[FloatArray, FloatArray, int]:
    """A or κ with displacements in units in which their stiffness is 1, these units, the power of two of A.

    Nothing of this is stored, so powers of two in the units cancel.
    """
    largest = float(np.diagonal(problem.A).max(initial=0.0))
    power = int(np.frexp(largest or float(np.abs(problem.B).max(initial=0.0)))[1])
    relative = np.ldexp(np.diagonal(stiffness), -power)
    lengths = 1.0 / np.sqrt(np.where(relative > 0, relative, 1.0))
    return np.ldexp(stiffness, -power) * lengths * lengths[:, None], lengths, power


def _clearly_held(stiffness: FloatArray) -> bool:
    """Whether a scaled stiffness shows at once that there is nothing rigid; quick."""
    # smallest eigenvalue of a scaled stiffness, relative, that needs no closer look
    return is_definite(stiffness, float(np.linalg.norm(stiffness, 1)) / CLEAR)


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
    motions[np.abs(motions) <= NEGLIGIBLE] = 0.0  # the largest are about 1
    order = np.argsort(pinned)
    nodes = [pinned[k] for k in order]
    motions = (lengths[:, None] * motions / lengths[pinned])[:, order]
    motions[nodes] = np.eye(len(nodes))  # exactly
    return RigidSlips(motions, tuple(nodes), doubt)


def zero_modes(stiffness: FloatArray, accuracy: float | None = None) -> int:
    """Number of motions that a symmetric stiffness does not resist, by the rule of :func:`rigid_slips`.

    Examples
    --------
    >>> zero_modes(np.array([[1.0, -1.0], [-1.0, 1.0]]))
    1
    """
    diagonal = np.diagonal(stiffness)
    own = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    scaled = 0.5 * (stiffness + stiffness.T) / own / own[:, None]
    values = np.sort(np.abs(np.linalg.eigvalsh(scaled / (np.abs(scaled).sum(axis=0).max() or 1.0))))
    return _without_resistance(values, accuracy, 0.0 if accuracy else printed_error(stiffness))[0]
