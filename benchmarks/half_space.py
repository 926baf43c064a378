"""Joints in space made of an elastic half-space: its compliance on a grid of square patches, inverted."""

import numpy as np

from shakedown import Problem
from shakedown.ground.constants import FloatArray

POISSON, FRICTION = 0.3, 0.5


def grid(columns: int, rows: int) -> FloatArray:
    """The centres of unit squares (n, 2), row by row."""
    return np.array([(float(i), float(j)) for j in range(rows) for i in range(columns)])


def compliance(x: FloatArray) -> FloatArray:
    """Displacements (u_x, u_y, u_z) at the centres of unit squares by their forces, (3n, 3n); E = 1.

    Boussinesq's and Cerruti's point forces at the other squares, uniform tractions on a square itself
    (Johnson, Contact Mechanics, 3.2 and 3.6). z goes into the half-space.
    """
    n, poisson = len(x), POISSON
    shear = 1.0 / (2.0 * (1.0 + poisson))
    apart = x[:, None] - x
    r = np.hypot(apart[..., 0], apart[..., 1])
    np.fill_diagonal(r, 1.0)
    by = np.zeros((n, 3, n, 3))
    for a in range(2):
        by[:, a, :, a] = (1 - poisson) / r + poisson * apart[..., a] ** 2 / r**3
        by[:, a, :, 1 - a] = poisson * apart[..., 0] * apart[..., 1] / r**3
        by[:, a, :, 2] = -(1 - 2 * poisson) / 2 * apart[..., a] / r**2
        by[:, 2, :, a] = (1 - 2 * poisson) / 2 * apart[..., a] / r**2
    by[:, 2, :, 2] = (1 - poisson) / r
    own, each = 4.0 * np.log(1.0 + np.sqrt(2.0)), np.arange(n)  # the integral of 1/r over the square
    by[each, :, each] = own * np.diag([1 - poisson / 2, 1 - poisson / 2, 1 - poisson])
    found = by.reshape(3 * n, 3 * n) / (2 * np.pi * shear)
    return 0.5 * (found + found.T)


def blocks(kappa: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A, B and C of a stiffness (3n, 3n) with the displacements of a node together."""
    n = len(kappa) // 3
    each = np.arange(3 * n).reshape(n, 3)
    order = np.concatenate([each[:, :2].ravel(), each[:, 2]])
    kappa = 0.5 * (kappa + kappa.T)[np.ix_(order, order)]
    return kappa[: 2 * n, : 2 * n], kappa[2 * n :, : 2 * n], kappa[2 * n :, 2 * n :]


def half_space(columns: int, rows: int, pull: float = 0.9, tilt: float = 0.0) -> Problem:
    """A grid of patches under a force that goes around, stronger on one side, and a moment with it.

    ``pull`` is its largest share of f p, ``tilt`` the moment; from 1 on it lifts the edges.
    """
    x, t = grid(columns, rows), 2 * np.pi * np.arange(40)[:, None] / 40
    place = (x - x.mean(axis=0)) / np.ptp(x, axis=0).max()
    p = 1.0 + 0.2 * np.cos(t) + tilt * (np.cos(t) * place[:, 0] + np.sin(t) * place[:, 1])
    q = np.stack([np.cos(t) * (1 + 0.5 * place[:, 1]), np.sin(t) * (1 + 0.5 * place[:, 0])], axis=2)
    A, B, C = blocks(np.linalg.inv(compliance(x)))
    return Problem(A=A, B=B, C=C, f=FRICTION, q_w=pull * FRICTION * q.reshape(40, -1), p_w=p, x=x)
