"""Whether the rates of slip in space are unique for all directions, so that no motion jumps."""

import numpy as np

from shakedown.bounds.every_state.scaled_joint import ScaledJoint
from shakedown.bounds.uniqueness.coupling import least_of_sums
from shakedown.bounds.uniqueness.in_contact import Uniqueness
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import EPS
from shakedown.ground.size_limits import DIRECTIONS


def unique_rates(joint: ScaledJoint) -> Uniqueness:
    """Whether every M(u) is a P-matrix, by energy or coupling ratio (docs/universal.md, statement 6.6).

    M_ij = u_i · A_ij u_j + f_i B_ij · u_j, for all unit vectors u of the nodes.
    """
    if joint.floats or not joint.held:
        return Uniqueness(
            None, "only friction holds the body: if all its nodes slip, nothing determines how fast"
        )
    if not joint.fB.any():
        return Uniqueness(True, "slip changes no friction limit (f B = 0)")
    if energy_margin(joint) > 0.0:
        return Uniqueness(True, "every motion stores more energy than friction can feed it")
    if (ratio := coupling_ratio(joint)) < 1.0:
        return Uniqueness(True, f"coupling ratio {ratio:.3g} below 1")
    return Uniqueness(None, "slip of some nodes may change the limits of others too strongly")


UnitSlips = tuple[FloatArray, FloatArray, FloatArray]


def energy_margin(joint: ScaledJoint, units: UnitSlips | None = None) -> float:
    """Above 0 where it proves vᵀ A v > Σ f_i |v_i| |(B v)_i| for every v ≠ 0, relative to vᵀ A v.

    Of a floating body for every v that is not rigid, less its rigid part.

    The sum is at most ½ vᵀ (c S F + Bᵀ F S⁻¹ B / c) v, F = diag f, S = the stiffnesses of the nodes, so
    that units do not matter, for every c > 0; the best c by golden section. ``units`` are the unit slips.
    """
    root, slips, pressures = unit_slips(joint) if units is None else units
    f, scale = np.sqrt(joint.f), np.sqrt(joint.stiffness)
    slip, pressure = slips * np.repeat(f * scale, joint.d), pressures * f / scale
    A = joint.kept_stiffness
    condition = float(np.abs(root).sum(axis=1).max() ** 2 * np.abs(A).sum(axis=1).max())
    largest = least_of_sums(slip @ slip.T, pressure @ pressure.T)
    return 1.0 - 0.5 * largest - 16 * len(root) * EPS * condition if largest > 0.0 else 1.0


def unit_slips(joint: ScaledJoint) -> UnitSlips:
    """Slips of unit energy, independent of each other, and the pressures that they cause.

    As rows: in the slips that are not pinned (k, k), in all (k, dn), and pressures (k, n). Of a floating body
    a rigid motion is added to each, so that Σ c_i f_i z_i · w_i = 0 for all rigid z, c_i being stiffnesses:
    then Σ c_i f_i |w_i|² is least.
    """
    kept = joint.kept
    root = np.asarray(np.linalg.inv(np.linalg.cholesky(joint.kept_stiffness)))
    pressures = root @ np.take(joint.B, kept, axis=1).T
    if not joint.floats:
        return root, root, pressures
    slips, Z = np.zeros((len(kept), joint.d * joint.n)), joint.motions
    slips[:, kept] = root
    weighted = np.repeat(joint.f * joint.stiffness, joint.d)[:, None] * Z
    return root, slips - np.linalg.solve(Z.T @ weighted, (slips @ weighted).T).T @ Z.T, pressures


def coupling_ratio(joint: ScaledJoint) -> float:
    """An upper bound of ρ(N), N_ij = (‖A_ij‖ + f_i |B_ij|) / min over u of (uᵀ A_ii u + f_i B_ii · u).

    By the quotients of a positive vector; inf where a node resists slip in some direction less than its
    own friction falls.
    """
    n = joint.n
    A = joint.A.reshape(n, 2, n, 2).transpose(0, 2, 1, 3)
    B = joint.fB.reshape(n, n, 2)
    angle = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    u = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    every = np.arange(n)
    own, pull = A[every, every], B[every, every]
    coupled = np.linalg.norm(A, 2, axis=(2, 3)) + np.hypot(B[..., 0], B[..., 1])
    steep = 2.0 * np.linalg.norm(own, 2, axis=(1, 2)) + np.hypot(pull[:, 0], pull[:, 1])
    held = np.einsum("ka,nab,kb->nk", u, own, u) + pull @ u.T
    least = held.min(axis=1) - 0.5 * (np.pi / DIRECTIONS) ** 2 * steep  # the slope vanishes where it is least
    if not (least > 0).all():
        return float("inf")
    coupled[every, every] = 0.0
    N = coupled / least[:, None]
    d = np.ones(n)
    for _ in range(100):
        d = N @ d + 1e-9 * d.max()
        d = d / d.max()
    return float(((N @ d) / d).max()) * (1.0 + 4 * n * EPS)
