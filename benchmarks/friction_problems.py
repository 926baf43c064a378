"""Frictional contact problems in three dimensions that are given by a compliance, W of Delassus, of any rank.

Find reactions r and relative velocities u = W r + q with 0 ≤ u_N ⟂ r_N ≥ 0, |r_T| ≤ μ r_N and
r_T = −μ r_N u_T/|u_T| where a contact slips. W need not have an inverse, and no κ exists; so

    u = (W + α) r' + q − α r

is solved for r' again and again, each time from the r found before (the proximal point method): with
κ = (W + α)⁻¹ that is one implicit load step of a joint. Where r' = r it is the problem itself. α
shrinks as long as the steps are solved and gain: the smaller, the fewer are needed and the nearer is
each to the problem without it.
"""

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from shakedown import UsageError
from shakedown.ground.constants import FloatArray
from shakedown.ground.tolerances import DEFAULT
from shakedown.motion.space.implicit_step import ImplicitJoint

FIRST, LEAST, MOST = 1e-2, 1e-8, 100.0  # α, relative to the mean of the diagonal of W
SHRINKS, GROWS, ABOVE = 0.1, 10.0, 3.0
GAINS = 0.9  # a step leaves at most that share of the residual, or α is below what its round-off allows
SMALL = 1e-4  # α that may be
DIGITS = 1e-3  # α below which steps are solved the less sharply, as κ's round-off grows
TURNS = 6
MOST_STEPS = 300


class FrictionStatus(Enum):
    """Whether a frictional contact problem was solved."""

    SOLVED = "solved"
    UNSOLVED = "unsolved"


class FrictionSolution(NamedTuple):
    """What solves a frictional contact problem.

    Attributes
    ----------
    status
        ``SOLVED`` where the residual is within the tolerance asked for.
    r, u : (3n,)
        Reactions and relative velocities, contact by contact, normal component first; the best that
        were found where the problem is not solved.
    residual
        Largest departure of r from its projection on what the law allows at r − u/ω, ω the mean
        diagonal of W at the contact, relative to max |q| over the largest diagonal entry.
    steps
        Proximal steps taken.
    """

    status: FrictionStatus
    r: FloatArray
    u: FloatArray
    residual: float
    steps: int


def solve_friction_problem(
    W: ArrayLike, q: ArrayLike, mu: ArrayLike, tolerance: float = 1e-10
) -> FrictionSolution:
    """Solve u = W r + q with Coulomb's law at every contact.

    Parameters
    ----------
    W : (3n, 3n)
        Symmetric, positive semi-definite, of any rank; contact by contact, normal component first.
    q : (3n,)
        Velocities free of reactions.
    mu : (n,)
        Friction coefficients.
    tolerance
        Largest residual of what counts as solved.

    Raises
    ------
    UsageError
        If shapes do not go together, a number is not finite, μ < 0, or W is not symmetric and positive
        semi-definite.

    Examples
    --------
    A contact pressed by 1 and pulled along by 1, of which friction takes a half:

    >>> import numpy as np
    >>> found = solve_friction_problem(np.eye(3), [-1.0, 1.0, 0.0], [0.5])
    >>> found.status.value, found.r.round(9) + 0.0, found.u.round(9) + 0.0
    ('solved', array([ 1. , -0.5,  0. ]), array([0. , 0.5, 0. ]))
    """
    W, q, mu = _checked(W, q, mu)
    weight, steps, contacts = _Weight(), 0, None
    best = FrictionSolution(FrictionStatus.UNSOLVED, 0 * q, q, friction_residual(W, q, mu, 0 * q), 0)
    r = best.r
    while best.residual > tolerance and steps < MOST_STEPS and weight.alpha <= MOST:
        steps += 1
        if contacts is None or contacts.alpha != weight.alpha:
            contacts = _Contacts(W, q, mu, weight.alpha, best.u)
        found = contacts.step(q, r)
        if found is None:
            weight.fails()
            continue
        r, missed = found, friction_residual(W, q, mu, found)
        weight.leaves(missed)
        if missed < best.residual:
            best = FrictionSolution(FrictionStatus.UNSOLVED, r, W @ r + q, missed, steps)
    status = FrictionStatus.SOLVED if best.residual <= tolerance else FrictionStatus.UNSOLVED
    return best._replace(status=status, steps=steps)


def friction_residual(W: FloatArray, q: FloatArray, mu: FloatArray, r: FloatArray) -> float:
    """The residual of :class:`FrictionSolution` of any reactions r (3n,)."""
    reaction, velocity = r.reshape(-1, 3), (W @ r + q).reshape(-1, 3)
    softness = np.diag(W).reshape(-1, 3).mean(axis=1, keepdims=True)
    aim = reaction - velocity / np.where(softness > 0, softness, softness.max() or 1.0)
    pressed = np.maximum(aim[:, 0], 0.0)
    size, most = np.linalg.norm(aim[:, 1:], axis=1), mu * pressed
    slipping = aim[:, 1:] * np.minimum(1.0, most / np.where(size > 0.0, size, 1.0))[:, None]
    apart = np.abs(r.reshape(-1, 3) - np.column_stack([pressed, slipping])).max()
    force = _force(W, q)
    return float(apart) / force if force else float(apart > 0)


def _force(W: FloatArray, q: FloatArray) -> float:
    """A reaction that takes the largest velocity back [force]."""
    softest = float(np.diag(W).max())
    return float(np.abs(q).max()) / softest if softest else 0.0


@dataclass
class _Weight:
    """α, relative to the mean of the diagonal of W, from step to step."""

    alpha: float = FIRST
    least: float = LEAST
    before: float = np.inf

    def fails(self) -> None:
        """A step was not solved: α grows, and stays above where it was."""
        self.least = ABOVE * self.alpha
        self.alpha *= GROWS

    def leaves(self, residual: float) -> None:
        """A step leaves a residual: where it gained little, α was too small for its round-off."""
        if residual > GAINS * self.before and self.alpha < SMALL:
            self.least = GROWS * self.alpha
        self.alpha, self.before = max(SHRINKS * self.alpha, self.least), residual


class _Contacts:
    """The joint whose stiffness is (W + α)⁻¹, with the state of the last step."""

    def __init__(self, W: FloatArray, q: FloatArray, mu: FloatArray, alpha: float, u: FloatArray) -> None:
        n = len(mu)
        each = np.arange(3 * n).reshape(n, 3)
        self.alpha, self.own = alpha, alpha * float(np.diag(W).mean())
        self.order = np.concatenate([each[:, 1:].ravel(), each[:, 0]])
        stiffness = np.linalg.inv(W + self.own * np.eye(3 * n))
        self.kappa = 0.5 * (stiffness + stiffness.T)
        kappa, slips = self.kappa[np.ix_(self.order, self.order)], 2 * n
        A, B, C = kappa[:slips, :slips], kappa[slips:, :slips], kappa[slips:, slips:]
        self.joint = ImplicitJoint(A, B, C, mu, _force(W, q) * max(1.0, DIGITS / alpha))
        self.joint.turns = TURNS
        self.tangential = 2 * n
        self.joint.begin(u[self.order[: 2 * n]], np.zeros(n), np.zeros(2 * n), np.zeros(n))

    def step(self, q: FloatArray, r: FloatArray) -> FloatArray | None:
        """The reactions (3n,) of the next proximal step, or None where it is not solved."""
        welded = -self.kappa @ (q - self.own * r)
        self.joint.forget()
        load = welded[self.order]
        done = self.joint.step(load[: self.tangential], load[self.tangential :])
        if not done.solved:
            return None
        u = np.empty_like(q)
        u[self.order] = np.concatenate([done.v[0], done.w[0]])
        return np.asarray(welded + self.kappa @ u)


def _checked(W: ArrayLike, q: ArrayLike, mu: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The data as private arrays; raises ``UsageError`` where they are no friction problem."""
    W, q, mu = (np.asarray(values, dtype=float) for values in (W, q, mu))
    n = mu.size
    for name, found, expected in (("W", W.shape, (3 * n, 3 * n)), ("q", q.shape, (3 * n,))):
        if found != expected:
            raise UsageError(f"{name}: expected shape {expected} for {n} contacts, found {found}")
    for name, values in (("W", W), ("q", q), ("mu", mu)):
        if not np.isfinite(values).all():
            raise UsageError(f"{name}: expected finite numbers, found {values[~np.isfinite(values)][0]}")
    if not n:
        raise UsageError("mu: expected at least one contact, found none")
    if (mu < 0).any():
        raise UsageError(f"mu: expected coefficients >= 0, found {mu.min():g} at contact {mu.argmin()}")
    largest = float(np.abs(W).max())
    if np.abs(W - W.T).max() > DEFAULT.printed_digits * largest:
        raise UsageError("W: expected a symmetric matrix, found one that is not")
    W = 0.5 * (W + W.T)
    least = float(np.linalg.eigvalsh(W)[0])
    if least < -DEFAULT.printed_digits * largest or not largest:
        raise UsageError(f"W: expected a positive semi-definite matrix, found the eigenvalue {least:g}")
    return W, q, mu
