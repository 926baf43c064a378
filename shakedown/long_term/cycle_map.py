"""The map from one cycle's start to the next, affine on a sequence of contact states, and its limit."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import schur, solve_sylvester

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.ground.status import STICK
from shakedown.motion.cycle_record import CycleRecord
from shakedown.motion.evolution import Evolution
from shakedown.motion.method import cycles_of
from shakedown.motion.plane.plane_events import PlaneEvents


@dataclass(frozen=True)
class CycleMap:
    """v ↦ v + d + J (v − v_start) for the slips v of the nodes stuck at the start of a period.

    Attributes
    ----------
    records
        What its cycles did.
    jacobian : (t, t)
        J, the derivative of the slips of these nodes over the period.
    """

    records: tuple[CycleRecord, ...]
    jacobian: FloatArray


@dataclass(frozen=True)
class Limit:
    """Limit of the iterated cycle map.

    Attributes
    ----------
    change : (t,)
        Slip from the start state to the limit, drift left out [length].
    drift : (t,)
        What the slips gain per period for ever [length].
    decaying
        Whether what remains dies out.
    contraction
        Factor by which it shrinks per period in the end; 0 where it ends after finitely many.
    """

    change: FloatArray
    drift: FloatArray
    decaying: bool
    contraction: float


def follow_period(evolution: Evolution, period: int) -> CycleMap | None:
    """Carry an evolution through a period, with the derivative of its cycle map; None where it stops."""
    stuck = np.flatnonzero(evolution.state.contact == STICK)
    tangent = tangent_basis(evolution, stuck)
    assert isinstance(evolution.method, PlaneEvents)
    with evolution.method.derivative(tangent):
        records = tuple(cycles_of(evolution, period))
    return CycleMap(records, tangent[stuck]) if evolution.stop is None else None


def tangent_basis(evolution: Evolution, stuck: np.ndarray) -> FloatArray:
    """∂(v, w)/∂v_stuck, where every other moving node follows from its equations."""
    assert isinstance(evolution.method, PlaneEvents)
    act, layout = evolution.method.active, evolution.problem.layout
    size = int((act.place >= 0).sum())
    basis = np.zeros((layout.size, len(stuck)))
    basis[stuck, np.arange(len(stuck))] = 1.0
    if size:
        cols, coef = act.col[:size], act.coef[:size]
        partner = np.where(cols < layout.slip_size, layout.gaps_of(cols), cols)
        rows = act.kappa[cols] - coef[:, None] * act.kappa[partner]
        basis[cols] = -act.inverse[:size, :size] @ rows[:, stuck]
    return basis


def limit(J: FloatArray, d: FloatArray) -> Limit:
    """Sum of the geometric series Σ Jᵏ d, split into what decays and what drifts.

    The invariant subspace of the eigenvalue 1 (nodes that never move; drifts) is
    separated by an ordered Schur form, which stays accurate where J is defective.
    """
    if not len(d):
        return Limit(d, d, True, 0.0)
    T, Q, k = schur(J, output="real", sort=lambda re, im=0.0: (re - 1.0) ** 2 + im**2 <= NEGLIGIBLE**2)
    rest = T[k:, k:]
    Z = np.zeros((k, len(d) - k))
    if 0 < k < len(d):
        Z = solve_sylvester(T[:k, :k], -rest, -T[:k, k:])
    c = Q.T @ d
    unit, other = c[:k] - Z @ c[k:], c[k:]
    total = np.linalg.solve(np.eye(len(other)) - rest, other)
    contraction = asymptotic_factor(rest, other)
    change = Q[:, :k] @ (Z @ total) + Q[:, k:] @ total
    return Limit(change, Q[:, :k] @ unit, contraction < 1.0, contraction)


def asymptotic_factor(matrix: FloatArray, vector: FloatArray) -> float:
    """lim ‖Mᵏ⁺¹ x‖ / ‖Mᵏ x‖, as accurately as round-off allows, by repeated squaring of M."""
    size = float(np.linalg.norm(vector))
    if size == 0.0:
        return 0.0
    vector, factor, steps, log = vector / size, 0.0, 1, 0.0
    for _ in range(40):  # vector = Mᵏ x / ‖Mᵏ x‖ with k = steps − 1; log = log ‖Mᵏ x‖
        image = matrix @ vector
        norm = float(np.linalg.norm(image))
        log += np.log(norm) if norm > 0 else -np.inf
        if log < np.log(1e-13):
            return factor
        factor = norm ** (1.0 / steps)
        if log > np.log(1e6):
            return factor
        vector, matrix, steps = image / norm, matrix @ matrix, 2 * steps
    return factor
