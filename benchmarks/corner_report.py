"""What happens where two nodes are at their limits at once and cannot simply slip (thesis chapter VI)."""

from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigvals

from shakedown import Problem
from shakedown.ground.constants import FloatArray

Complex = NDArray[np.complex128]
SIDES = (-1, 1)  # the limits of the two nodes: +1 backward (q = f p), −1 forward (q = −f p)
OPEN = 2  # the state of a node that is open, as in an EventHistory


class CornerEnd(NamedTuple):
    """Where a viscous motion from a corner ends if one node opens and the other goes on slipping."""

    node: int  # that opens: its pressure is used up first
    G: FloatArray  # (3, 3): ∂(out of balance)/∂(v₀, v₁, w of the open node) (6.55) [force/length]
    P: FloatArray  # (3,): P*, what is out of balance at the corner once the node is free (6.55) [force]
    eigenvalues: Complex  # (3,): of −G (6.56); stable where all real parts are negative
    change: FloatArray  # (3,): G⁻¹P*, from the corner to the end (6.59) [length]
    slip: FloatArray  # (2,): end state (6.60) [length]
    gap: FloatArray  # (2,)
    contact: tuple[int, int]  # states of the two nodes there: ±1 backward, forward slip, 2 open
    possible: bool  # whether the end obeys the contact law and the motion towards it is stable


class CornerReport(NamedTuple):
    """Result of :func:`corner_report`."""

    slip: FloatArray  # (2,): their slips at the corner (6.15), (6.16) [length]
    q: FloatArray  # (2,): their reactions there [force]
    p: FloatArray
    H: FloatArray  # (2, 2): rate of a small perturbation while both slip, δv̇ = H δv (6.50)
    eigenvalues: Complex  # (2,): of H, in increasing order of their real parts (6.51)
    eigenvectors: Complex  # (2, 2): one per row, of length 1, the first node moving as it slips (6.52)
    coefficients: Complex  # (2, 2): δv̇(0) = coefficients · a for a perturbation Σ a_k x_k exp(λ_k t)
    grows: bool  # whether an admissible perturbation grows: the state leaves the corner by itself
    opening_node: int  # whose pressure that growth uses up first; −1 where there is none
    end: CornerEnd | None  # where the motion ends after that; None without an opening node
    both_open: FloatArray  # (2,): gaps that the nodes would have without any contact (6.17) [length]

    @property
    def both_open_possible(self) -> bool:
        """Whether both nodes separated is an equilibrium (6.17)."""
        return bool((self.both_open >= 0).all())

    def admissible(self, amplitudes: FloatArray) -> bool:
        """Whether a perturbation a₀ x₀ + a₁ x₁ begins with slip of both nodes at their limits (6.54)."""
        velocity = (self.coefficients @ amplitudes).real
        return bool((-np.array(SIDES) * velocity > 0).all())


def corner_report(
    # A joint of two nodes with normal stiffness; its loading plays no part. The damping D is one
    problem: Problem,
    q_w: FloatArray,  # q_w, p_w: (2,): welded reactions at the corner [force]
    p_w: FloatArray,
) -> CornerReport:
    """How a state with both nodes of a joint at their limits goes on under a viscous motion (§6.3, §6.4).

    Node 0 is at its forward limit, node 1 at its backward one.

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
    signs = np.array(SIDES)
    rows = problem.A - (signs * problem.f)[:, None] * problem.B  # what is out of balance while both slip
    corner = np.linalg.solve(rows, signs * problem.f * p_w - q_w)
    q, p = q_w + problem.A @ corner, p_w + problem.B @ corner
    values, vectors = _modes(-rows)
    mode, opening = _growth(problem.B, signs, values, vectors, p)
    return CornerReport(
        slip=corner,
        q=q,
        p=p,
        H=-rows,
        eigenvalues=values,
        eigenvectors=vectors,
        coefficients=vectors.T * values,
        grows=mode >= 0,
        opening_node=opening,
        end=None if opening < 0 else _end(problem, corner, q, p, opening),
        both_open=np.linalg.solve(problem.kappa, -np.concatenate([q_w, p_w]))[2:],
    )


def _modes(H: FloatArray) -> tuple[Complex, Complex]:
    """Eigenvalues and eigenvectors (rows) of H; each vector moves the first node as it slips."""
    values, columns = np.linalg.eig(H.astype(complex))
    order = np.argsort(values.real, kind="stable")
    values, vectors = values[order], columns.T[order]
    turned = np.where(-SIDES[0] * (values * vectors[:, 0]).real < 0, -1.0, 1.0)
    return values, vectors * turned[:, None]


def _growth(
    B: FloatArray, signs: FloatArray, values: FloatArray, vectors: FloatArray, p: FloatArray
) -> tuple[int, int]:
    """The real mode that grows with both nodes slipping, and the node that it opens; −1 where there is none.

    Other amplitudes change the way and not, for long, the direction: what grows outlives what decays.
    """
    for k in (1, 0):
        direction = vectors[k].real
        grows = values[k].real > 0 and values[k].imag == 0
        if grows and (-signs * direction > 0).all():
            falling = -(B @ direction)
            until = np.where(falling > 0, p / np.where(falling > 0, falling, 1.0), np.inf)
            return k, int(until.argmin()) if np.isfinite(until).any() else -1
    return -1, -1


def _end(problem: Problem, corner: FloatArray, q: FloatArray, p: FloatArray, opening: int) -> CornerEnd:
    """Equilibrium with one node open and the other still slipping (6.55)–(6.60)."""
    assert problem.C is not None
    slipping = 1 - opening
    side, f = SIDES[slipping], problem.f[slipping]
    tangential = np.column_stack([problem.A, problem.B[opening]])
    normal = np.column_stack([problem.B, problem.C[:, opening]])
    G = np.empty((3, 3))
    G[slipping] = tangential[slipping] - side * f * normal[slipping]
    G[opening], G[2] = tangential[opening], normal[opening]
    P = np.zeros(3)
    P[opening], P[2] = -q[opening], -p[opening]
    change = np.linalg.solve(G, P)
    values = np.linalg.eigvals(-G.astype(complex))
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


def pair_thresholds(problem: Problem) -> FloatArray:
    """Friction coefficients at which the slip of two nodes loses its stiffness, all eight of them (6.47).

    Roots of det(A − f S B) for the four choices of sides S = diag(±1, ±1), each with one friction coefficient
    f for both nodes; every root comes with its negative. In increasing order of size, the positive one first;
    infinite or NaN (not real) last.

    Examples
    --------
    >>> import shakedown
    >>> pair_thresholds(shakedown.example("jump"))[::2].round(4)
    array([0.3557, 0.4078, 4.301 , 4.9312])
    """
    roots: list[float] = []
    for signs in product((1.0, -1.0), repeat=2):
        found = eigvals(problem.A, np.array(signs)[:, None] * problem.B)
        roots += [float(x.real) if x.imag == 0 else np.nan for x in found]
    return np.array(sorted(roots, key=lambda x: (np.isnan(x), abs(x), -x)))
