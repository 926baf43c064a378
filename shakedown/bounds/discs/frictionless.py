"""Nodes without friction: no reaction along the surface at any load step, equations and no slack.

A disc without a limit is |q_i| ≤ 0. These equations are solved first: v = start + λ · slope + ways · ζ, with
what is left of the joint in the unknowns ζ. Where they hold at one load factor only, it is that one.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.discs.disc_rows import DiscRows
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE, ROUND_OFF
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.rigid_slips import RigidSlips

Mask = NDArray[np.bool_]
SAME = 100 * ROUND_OFF  # relative size of a singular value below which it is round-off


@dataclass(frozen=True, eq=False)
class Frictionless:
    """A joint whose frictionless nodes are taken out.

    Attributes
    ----------
    whole
        The limits of all nodes.
    start, slope : (k,)
        Slips at which these have no reaction, at λ = 0 and their change with λ [length].
    ways : (k, K)
        The slips that leave it so.
    forced
        The only load factor at which they can have none; None where it is free.
    against : (j', 2)
        Multipliers of these discs that prove that they never have none; empty where they can.
    """

    whole: DiscRows
    start: FloatArray
    slope: FloatArray
    ways: FloatArray
    forced: float | None
    against: FloatArray

    @cached_property
    def rest(self) -> DiscRows:
        """The limits of the other nodes in (ζ, λ)."""
        rows, gaps = self.whole, self.whole.half_spaces
        kept = np.flatnonzero(~rows.smooth)
        names, node = np.unique(rows.node[kept], return_inverse=True)
        G, none = gaps.coefficients, RigidSlips(np.zeros((self.ways.shape[1], 0)), ())
        at_start, with_load = ((rows.flat @ v).reshape(-1, 3)[rows.node] for v in (self.start, self.slope))
        return replace(
            rows,
            stiffness=(rows.stiffness @ self.ways)[names],
            node=node,
            step=rows.step[kept],
            c=(rows.c + at_start)[kept],
            e=(rows.e + with_load)[kept],
            half_spaces=replace(
                gaps, G=G @ self.ways, g=gaps.g - G @ self.start, d=gaps.d + G @ self.slope, rigid=none
            ),
            names=rows.names[names],
        )

    def slips(self, zeta: FloatArray, load_factor: float) -> FloatArray:
        """The unknowns (k,) of the whole joint."""
        return np.asarray(self.start + load_factor * self.slope + self.ways @ zeta)

    def multipliers(self, y: FloatArray, z: FloatArray, slope: float) -> FloatArray:
        """Multipliers of all discs, from those of the others: they balance, and Σ yᵀ e = ``slope``."""
        rows, smooth = self.whole, self.whole.smooth
        found = np.zeros((len(smooth), 3))
        found[~smooth] = y
        E = _equations(rows, smooth)
        left = (rows.sums @ found).ravel() @ rows.flat - z @ rows.half_spaces.coefficients
        pull = float(np.vdot(found, rows.e)) - float(z @ rows.half_spaces.d) - slope
        sizes = np.linalg.norm(E, axis=0)
        sizes = np.maximum(sizes, NEGLIGIBLE * sizes.max())  # round-off of distant nodes balances nothing
        sizes = np.where(sizes > 0, sizes, 1.0)
        eta = np.linalg.lstsq((E / sizes).T, -np.append(left, pull) / sizes, rcond=None)[0]
        found[smooth, 1:] = eta.reshape(-1, 2)
        found[smooth, 0] = 2.0 * np.hypot(*found[smooth, 1:].T)  # as large as one likes: the limit is zero
        return found


def without_frictionless(rows: DiscRows, tolerances: Tolerances = DEFAULT) -> Frictionless | None:
    """The joint without its frictionless nodes; None where it has none.

    ``feasibility`` decides whether their equations can hold.

    Examples
    --------
    >>> from shakedown import Problem
    >>> from shakedown.bounds.discs.disc_rows import disc_rows
    >>> loop = {"q_w": [[1.0, 0.0], [1.0, 0.0]], "p_w": [[3.0], [2.0]]}
    >>> found = without_frictionless(disc_rows(Problem(A=2 * np.eye(2), B=[[0.5, 0.0]], f=0.0, **loop)))
    >>> found.start, found.ways.shape, found.forced
    (array([-0.5,  0. ]), (2, 0), None)
    """
    smooth = rows.smooth
    if not smooth.any():
        return None
    basis = rows.basis
    E = _equations(rows, smooth)
    right = -rows.c[smooth, 1:].ravel()
    sizes = np.repeat(basis.sizes[: len(rows.stiffness)][rows.node[smooth]], 2)
    sizes = np.where(sizes > 0, sizes, np.maximum(np.abs(right), np.abs(E[:, -1])))
    sizes = np.where(sizes > 0, sizes, 1.0)
    load = np.abs(E[:, -1] / sizes).max() or 1.0
    K = basis.to_slips.shape[1]
    matrix = np.column_stack([(E[:, :-1] @ basis.to_slips) / sizes[:, None], E[:, -1] / sizes / load])
    right = right / sizes
    Q, R = np.linalg.qr(matrix)
    U, values, V = np.linalg.svd(R)
    rank = int(np.count_nonzero(values > SAME * values.max(initial=0.0)))
    x = V[:rank].T @ ((U[:, :rank].T @ (Q.T @ right)) / values[:rank])
    rest = right - matrix @ x
    against = np.zeros((0, 2))
    if np.abs(rest).max() > tolerances.feasibility * max(np.abs(right).max(), np.abs(matrix @ x).max()):
        against = (-rest / sizes).reshape(-1, 2)
    free = V[rank:].T
    towards = free[K]
    length = float(np.linalg.norm(towards))
    start, slope, forced, ways = x[:K], np.zeros(K), None, free[:K]
    if length <= SAME:
        forced = float(x[K]) / load
    else:
        along = free @ (towards / length**2)
        start, slope = start - x[K] * along[:K], along[:K] * load
        across = np.linalg.svd(towards[None])[2][1:]
        ways = (free @ across.T)[:K]
    T = basis.to_slips
    return Frictionless(rows, T @ start, T @ slope, T @ ways, forced, against)


def _equations(rows: DiscRows, smooth: Mask) -> FloatArray:
    """The change of the reactions (q_x, q_y) of some discs with (v, λ), (2j', k + 1)."""
    of_slips = rows.stiffness[rows.node[smooth], 1:].reshape(-1, rows.stiffness.shape[-1])
    return np.column_stack([of_slips, rows.e[smooth, 1:].ravel()])
