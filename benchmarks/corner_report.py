"""What happens where two nodes are at their limits at once and cannot simply slip (thesis chapter VI)."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from numbers import Integral

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import eigvals

from shakedown import Problem, UsageError
from shakedown.ground.constants import FloatArray

OPEN = 2  # the state of a node that is open, as in an EventHistory


@dataclass(frozen=True)
class CornerEnd:
    """Where a viscous motion from a corner ends if one node opens and the other goes on slipping.

    Attributes
    ----------
    node
        The node that opens: its pressure is used up first.
    G : (3, 3)
        ∂(out of balance)/∂(v₀, v₁, w of the open node) (6.55) [force/length].
    P : (3,)
        P*, what is out of balance at the corner once the node is free (6.55) [force].
    eigenvalues : (3,)
        Of −D⁻¹G (6.56); stable where all real parts are negative.
    change : (3,)
        G⁻¹P*, from the corner to the end (6.59) [length].
    slip, gap : (2,)
        End state (6.60) [length].
    contact
        States of the two nodes there: ±1 backward, forward slip, 2 open.
    possible
        Whether the end obeys the contact law and the motion towards it is stable.
    """

    node: int
    G: FloatArray
    P: FloatArray
    eigenvalues: NDArray[np.complex128]
    change: FloatArray
    slip: FloatArray
    gap: FloatArray
    contact: tuple[int, int]
    possible: bool


@dataclass(frozen=True)
class CornerReport:
    """Result of :func:`corner_report`.

    Attributes
    ----------
    nodes, sides
        The two nodes and their limits, +1 backward (q = f p), −1 forward (q = −f p).
    slip : (2,)
        Their slips at the corner (6.15), (6.16) [length].
    q, p : (2,)
        Their reactions there [force].
    H : (2, 2)
        Rate of a small perturbation while both slip, δv̇ = H δv (6.50).
    eigenvalues : (2,)
        Of H, in increasing order of their real parts (6.51).
    eigenvectors : (2, 2)
        One per row, of length 1 (6.52). The sign is such that the first node moves in
        the direction in which it slips.
    coefficients : (2, 2)
        δv̇(0) = coefficients · a for a perturbation Σ a_k x_k exp(λ_k t). It is admissible
        where both nodes move as they slip, −sides · δv̇(0) > 0 (6.54).
    grows
        Whether an admissible perturbation grows: the state leaves the corner by itself.
    opening_node
        The node whose pressure that growth uses up first; −1 where there is none.
    end
        Where the motion ends after that; None without an opening node or without C.
    both_open : (2,)
        Gaps that the two nodes would have without any contact (6.17) [length]; NaN without C.
    """

    nodes: tuple[int, int]
    sides: tuple[int, int]
    slip: FloatArray
    q: FloatArray
    p: FloatArray
    H: FloatArray
    eigenvalues: NDArray[np.complex128]
    eigenvectors: NDArray[np.complex128]
    coefficients: NDArray[np.complex128]
    grows: bool
    opening_node: int
    end: CornerEnd | None
    both_open: FloatArray

    @property
    def both_open_possible(self) -> bool:
        """Whether both nodes separated is an equilibrium (6.17)."""
        return bool((self.both_open >= 0).all())

    def admissible(self, amplitudes: ArrayLike) -> bool:
        """Whether a perturbation a₀ x₀ + a₁ x₁ begins with slip of both nodes at their limits (6.54)."""
        velocity = (self.coefficients @ np.asarray(amplitudes)).real
        return bool((-np.array(self.sides) * velocity > 0).all())


@dataclass(frozen=True)
class _Pair:
    """Two nodes with all others held: stiffness, friction, welded reactions, damping (v₀, v₁, w₀, w₁)."""

    A: FloatArray
    B: FloatArray
    C: FloatArray | None
    f: FloatArray
    q_w: FloatArray
    p_w: FloatArray
    damping: FloatArray
    sides: tuple[int, int]

    @property
    def rows(self) -> FloatArray:
        """∂(q − side f p)/∂v: what is out of balance while both slip, (2, 2) [force/length]."""
        return self.A - (np.array(self.sides) * self.f)[:, None] * self.B


def corner_report(
    problem: Problem,
    q_w: ArrayLike,
    p_w: ArrayLike,
    sides: Sequence[int] = (-1, 1),
    *,
    nodes: Sequence[int] = (0, 1),
    slip: ArrayLike | None = None,
    damping: ArrayLike | None = None,
) -> CornerReport:
    """How a state with two nodes at their limits goes on under a viscous motion (thesis §6.3, §6.4).

    Parameters
    ----------
    problem
        The joint; its loading plays no part.
    q_w, p_w : (n,)
        Welded reactions at the corner [force].
    sides
        The limits of the two nodes: +1 backward, −1 forward.
    nodes
        The two nodes; all others stick.
    slip : (n,), optional
        Slips of the other nodes [length]; zero by default.
    damping : (2n,), optional
        Diagonal of D for (v, w); ones by default, as in the thesis.

    Raises
    ------
    UsageError
        If an argument is out of range, or the two rows do not determine a corner.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("jump")
    >>> report = corner_report(joint, joint.q_w[0], joint.p_w[0])
    >>> report.slip.round(3), report.eigenvalues.real.round(4), report.opening_node
    (array([-20.727,  30.905]), array([-0.4716,  0.004 ]), 1)
    >>> report.end.slip.round(4), report.end.gap.round(4), report.both_open_possible
    (array([  3.564 , -24.5639]), array([0.    , 3.3443]), False)
    """
    pair, chosen = _checked_pair(problem, q_w, p_w, sides, nodes, slip, damping)
    rows, signs = pair.rows, np.array(pair.sides)
    out_of_balance = pair.q_w - signs * pair.f * pair.p_w
    try:
        corner = np.asarray(np.linalg.solve(rows, -out_of_balance), dtype=float)
    except np.linalg.LinAlgError:
        raise UsageError("corner: the two limits are parallel lines, expected one common point") from None
    q, p = pair.q_w + pair.A @ corner, pair.p_w + pair.B @ corner
    H = -rows / pair.damping[:2, None]
    values, vectors = _modes(H, pair.sides)
    coefficients = vectors.T * values
    mode, opening = _growth(pair, values, vectors, p)
    end = None if opening < 0 or pair.C is None else _end(pair, pair.C, corner, q, p, opening)
    return CornerReport(
        nodes=chosen,
        sides=pair.sides,
        slip=corner,
        q=q,
        p=p,
        H=H,
        eigenvalues=values,
        eigenvectors=vectors,
        coefficients=coefficients,
        grows=mode >= 0,
        opening_node=-1 if opening < 0 else chosen[opening],
        end=end,
        both_open=_gaps_without_contact(pair),
    )


def _checked_pair(
    problem: Problem,
    q_w: ArrayLike,
    p_w: ArrayLike,
    sides: Sequence[int],
    nodes: Sequence[int],
    slip: ArrayLike | None,
    damping: ArrayLike | None,
) -> tuple[_Pair, tuple[int, int]]:
    n = problem.n
    _check_pair(nodes, n)
    if len(sides) != 2 or not all(side in (-1, 1) for side in sides):
        raise UsageError(f"sides: expected two of +1 (backward) and -1 (forward), found {sides}")
    loads = [np.asarray(values, dtype=float) for values in (q_w, p_w)]
    others = np.zeros(n) if slip is None else np.asarray(slip, dtype=float)
    D = np.ones(2 * n) if damping is None else np.asarray(damping, dtype=float)
    given = {"q_w": loads[0], "p_w": loads[1], "slip": others, "damping": D}
    for name, values in given.items():
        shape = (2 * n,) if name == "damping" else (n,)
        if values.shape != shape:
            raise UsageError(f"{name}: expected shape {shape}, found {values.shape}")
    i, j = int(nodes[0]), int(nodes[1])
    two, held = [i, j], others.copy()
    held[two] = 0.0
    pair = _Pair(
        A=problem.A[np.ix_(two, two)],
        B=problem.B[np.ix_(two, two)],
        C=None if problem.C is None else problem.C[np.ix_(two, two)],
        f=problem.f[two],
        q_w=(loads[0] + problem.A @ held)[two],
        p_w=(loads[1] + problem.B @ held)[two],
        damping=D[[i, j, n + i, n + j]],
        sides=(int(sides[0]), int(sides[1])),
    )
    return pair, (i, j)


def _modes(H: FloatArray, sides: tuple[int, int]) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Eigenvalues and eigenvectors (rows) of H; each vector moves the first node as it slips."""
    values, columns = np.linalg.eig(H.astype(complex))
    order = np.argsort(values.real, kind="stable")
    values, vectors = values[order], columns.T[order]
    turned = np.where(-sides[0] * (values * vectors[:, 0]).real < 0, -1.0, 1.0)
    return values, vectors * turned[:, None]


def _growth(
    pair: _Pair, values: NDArray[np.complex128], vectors: NDArray[np.complex128], p: FloatArray
) -> tuple[int, int]:
    """The real mode that grows with both nodes slipping, and the node that it opens; −1 where there is none.

    Other amplitudes change the way and not, for long, the direction: what grows outlives what decays.
    """
    signs = np.array(pair.sides)
    for k in range(1, -1, -1):
        direction = vectors[k].real
        grows = values[k].real > 0 and values[k].imag == 0
        if grows and (-signs * direction > 0).all():
            falling = -(pair.B @ direction)
            until = np.where(falling > 0, p / np.where(falling > 0, falling, 1.0), np.inf)
            return k, int(until.argmin()) if np.isfinite(until).any() else -1
    return -1, -1


def _end(
    pair: _Pair, C: FloatArray, corner: FloatArray, q: FloatArray, p: FloatArray, opening: int
) -> CornerEnd:
    """Equilibrium with one node open and the other still slipping (6.55)–(6.60)."""
    slipping = 1 - opening
    side, f = pair.sides[slipping], pair.f[slipping]
    tangential = np.column_stack([pair.A, pair.B[opening]])
    normal = np.column_stack([pair.B, C[:, opening]])
    G = np.empty((3, 3))
    G[slipping] = tangential[slipping] - side * f * normal[slipping]
    G[opening], G[2] = tangential[opening], normal[opening]
    P = np.zeros(3)
    P[opening], P[2] = -q[opening], -p[opening]
    change = np.asarray(np.linalg.solve(G, P), dtype=float)
    damping = pair.damping[[0, 1, 2 + opening]]
    values = np.linalg.eigvals((-G / damping[:, None]).astype(complex))
    gap = np.zeros(2)
    gap[opening] = change[2]
    pressure = p[slipping] + normal[slipping] @ change
    contact = [side, side]
    contact[opening] = OPEN
    forward = -side * change[slipping] >= 0
    return CornerEnd(
        node=opening,
        G=G,
        P=P,
        eigenvalues=values[np.argsort(-values.real)],
        change=change,
        slip=corner + change[:2],
        gap=gap,
        contact=(contact[0], contact[1]),
        possible=bool(gap[opening] >= 0 and pressure >= 0 and forward and (values.real < 0).all()),
    )


def _gaps_without_contact(pair: _Pair) -> FloatArray:
    if pair.C is None:
        return np.full(2, np.nan)
    kappa = np.block([[pair.A, pair.B.T], [pair.B, pair.C]])
    try:
        return np.linalg.solve(kappa, -np.concatenate([pair.q_w, pair.p_w]))[2:]
    except np.linalg.LinAlgError:
        return np.full(2, np.nan)


def _check_pair(nodes: Sequence[int], n: int) -> None:
    whole = all(isinstance(node, Integral) and 0 <= node < n for node in nodes)
    if len(nodes) != 2 or not whole or nodes[0] == nodes[1]:
        raise UsageError(f"nodes: expected two different nodes of 0 to {n - 1}, found {nodes}")


def pair_thresholds(problem: Problem, nodes: Sequence[int] = (0, 1)) -> FloatArray:
    """Friction coefficients at which the slip of two nodes loses its stiffness, all eight of them (6.47).

    Roots of det(A − f S B) for the four choices of sides S = diag(±1, ±1), each with
    one friction coefficient f for both nodes; every root comes with its negative.

    Parameters
    ----------
    problem
        The joint; its own friction plays no part.
    nodes
        The two nodes; all others stick.

    Returns
    -------
    (8,)
        In increasing order of size, the positive one first; infinite or NaN (not real) last.

    Raises
    ------
    UsageError
        If the nodes are not two of the joint.

    Examples
    --------
    >>> import shakedown
    >>> pair_thresholds(shakedown.example("jump"))[::2].round(4)
    array([0.3557, 0.4078, 4.301 , 4.9312])
    """
    n = problem.n
    _check_pair(nodes, n)
    block = np.ix_(list(nodes), list(nodes))
    A, B = problem.A[block], problem.B[block]
    roots: list[float] = []
    for signs in product((1.0, -1.0), repeat=2):
        found = eigvals(A, np.array(signs)[:, None] * B)
        roots += [float(x.real) if x.imag == 0 else np.nan for x in found]
    return np.array(sorted(roots, key=lambda x: (np.isnan(x), abs(x), -x)))
