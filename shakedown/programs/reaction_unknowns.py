"""A ``DiscProgram`` of many nodes in other unknowns: their reactions, two of three numbers of a node."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import blas

from shakedown.ground.constants import CONE, MANY_ROWS, SIX_DIGITS, FloatArray
from shakedown.programs.cones import Cones, Scaling
from shakedown.programs.disc_program import DiscProgram, by_cholesky
from shakedown.programs.self_dual import Solve
from shakedown.programs.shared_blocks import Reactions, SharedBlocks

DISTORTED = 1 / SIX_DIGITS  # condition number beyond which reactions are not used as unknowns


@dataclass(frozen=True, eq=False)
class ReactionProgram:
    """A :class:`DiscProgram` in z = S y, S the coefficients of y in two of the numbers of most nodes.

    In y the normal equations are a product of 3n rows, in z of n: z itself adds one 2 × 2 block per node.

    Attributes
    ----------
    program
        In y.
    reactions
        S⁻¹, and what else is known of z.
    dense : (R, r)
        Coefficients of z: in the first number of tied nodes, in all of the others, in the rows.
    """

    program: DiscProgram
    reactions: Reactions
    dense: FloatArray

    @property
    def cones(self) -> Cones:
        """The cones of the program."""
        return self.program.cones

    @property
    def limits(self) -> FloatArray:
        """The right-hand sides of the program."""
        return self.program.limits

    @property
    def costs(self) -> FloatArray:
        """The costs of the program: z has none."""
        return self.program.costs

    @property
    def left(self) -> float:
        """All of it: an orthogonal factor costs ten steps, and what does not finish is solved in y."""
        return np.inf

    def in_y(self, x: FloatArray) -> FloatArray:
        """(y, w) of (z, w)."""
        return np.append(self.reactions.to_y @ x[: self.program.rank], x[self.program.rank :])

    def in_z(self, x: FloatArray) -> FloatArray:
        """(z, w) of (y, w)."""
        of = self.program
        reactions = (of.blocks.reshape(-1, of.rank) @ x[: of.rank]).reshape(-1, CONE)[:, 1:]
        return np.append(reactions.ravel()[self.reactions.kept], x[of.rank :])

    def times(self, x: FloatArray) -> FloatArray:
        """Discs, rows and bound at x = (z, w)."""
        of = self.program
        z, w = x[: of.rank], x[of.rank :]
        numbers = np.empty((len(of.blocks), CONE))
        numbers[self.reactions.tied, 0], numbers[self.reactions.others], rows = self._parts(self.dense @ z)
        numbers[self.reactions.tied, 1:] = z[self.reactions.columns]
        tail = np.zeros(0) if of.norm is None else -np.append(of.norm @ w, self.reactions.to_y @ z)
        discs = numbers[of.node].ravel() + of.loads @ w
        return np.concatenate([discs, rows + of.rows_extra @ w, tail])

    def transposed(self, u: FloatArray) -> FloatArray:
        """What multipliers of discs, rows and bound add up to."""
        of, known = self.program, self.reactions
        discs, rows, tail = of.parts(u)
        sums = of.sums(discs)
        z = np.concatenate([sums[known.tied, 0], sums[known.others].ravel(), rows]) @ self.dense
        z[known.columns] += sums[known.tied, 1:]
        w = discs.ravel() @ of.loads + rows @ of.rows_extra
        if of.norm is not None:
            z, w = z - tail[1:] @ self.reactions.to_y, w - tail[0] * of.norm
        return np.append(z, w)

    def normal_equations(self, scaling: Scaling) -> Solve:
        """The solution of Mᵀ W⁻² M x = right, M all of the coefficients; raises ``LinAlgError``."""
        of, squares = self.program, scaling.inverse_squares()
        halves = np.asarray(np.linalg.qr(of.halves(squares), mode="r"))  # one row holds the first number
        normal = self._of_z(halves, scaling)
        own = halves[self.reactions.tied, 1:, 1:]
        at = self.reactions.columns
        normal[at[:, :, None], at[:, None, :]] += np.swapaxes(own, 1, 2) @ own
        self._add_loads(normal, squares, scaling)
        return by_cholesky(normal)

    def orthogonal_factor(self, scaling: Scaling) -> Solve:
        """The same equations solved in y, by a more accurate factor."""
        solve, r = self.program.orthogonal_factor(scaling), self.program.rank
        S = self.program.blocks[:, 1:].reshape(-1, r)[self.reactions.kept]

        def solved(right: FloatArray) -> FloatArray:
            found = solve(np.append(right[:r] @ S, right[r:]))
            return np.append(S @ found[:r], found[r:])

        return solved

    def _of_z(self, halves: FloatArray, scaling: Scaling) -> FloatArray:
        """What dense coefficients of z and the length of y make of it, in the lower triangle of all unknowns.

        On the cone of that length W⁻² = (2 w wᵀ + I − 2 e₀ e₀ᵀ) / factor².
        """
        of, t, bound = self.program, len(self.reactions.tied), self.program.norm is not None
        r, size, count = of.rank, of.rank + len(of.cost), len(self.dense)
        stacked = np.empty((count + bound, size))
        stacked[:, r:] = 0.0
        rows, others = self._parts(stacked[:count, :r]), self._parts(self.dense)[1]
        np.multiply(self.dense[:t], halves[self.reactions.tied, :1, 0], out=stacked[:t, :r])
        stacked[np.arange(t)[:, None], self.reactions.columns] += halves[self.reactions.tied, 0, 1:]
        rows[1][:] = halves[self.reactions.others] @ others
        rows[2][:] = self._parts(self.dense)[2] / scaling.of_numbers
        if not bound:
            return np.asarray(blas.dsyrk(1.0, stacked.T, lower=1))
        axis, factor = scaling.of_large
        stacked[-1, :r] = (np.sqrt(2.0) / factor * axis[1:]) @ self.reactions.to_y
        normal = np.empty((size, size), order="F")
        normal[r:], normal[:r, r:] = 0.0, 0.0
        np.multiply(self.reactions.gram.T, 1.0 / factor**2, out=normal[:r, :r])
        return np.asarray(blas.dsyrk(1.0, stacked.T, 1.0, normal, lower=1, overwrite_c=1))

    def _add_loads(self, normal: FloatArray, squares: FloatArray, scaling: Scaling) -> None:
        """What w has in discs, rows and the bound of the length of y."""
        of, r, p = self.program, self.program.rank, len(self.program.cost)
        pulled = squares @ of.extra
        of_loads = of.sums(pulled.reshape(-1, CONE * p)).reshape(-1, CONE, p)
        rows = of.rows_extra / scaling.of_numbers**2
        parts = [of_loads[self.reactions.tied, 0], of_loads[self.reactions.others].reshape(-1, p), rows]
        normal[r:, :r] = np.vstack(parts).T @ self.dense
        normal[r:, self.reactions.columns] += np.moveaxis(of_loads[self.reactions.tied, 1:], 2, 0)
        normal[r:, r:] = np.tensordot(of.extra, pulled, axes=((0, 1), (0, 1))) + rows.T @ of.rows_extra
        if of.norm is not None:
            axis, factor = scaling.of_large
            w = axis / factor
            normal[r:, :r] -= np.outer(2.0 * w[0] * of.norm, w[1:] @ self.reactions.to_y)
            normal[r:, r:] += (2.0 * w[0] ** 2 - 1.0 / factor**2) * np.outer(of.norm, of.norm)

    def _parts(self, rows: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Dense rows (R, …) in three parts, as views: tied nodes, the other nodes (o, 3, …), and rows."""
        t, end = len(self.reactions.tied), len(rows) - len(self.program.rows)
        return rows[:t], rows[t:end].reshape(-1, CONE, *rows.shape[1:]), rows[end:]


def in_reactions(program: DiscProgram) -> ReactionProgram | None:
    """A program in the last two numbers of its nodes; None where that is slower, or ill-conditioned."""
    if program.rank < MANY_ROWS:
        return None
    shared = program.shared or SharedBlocks(program.blocks)
    found = shared.reactions
    if found is not None and program.scale is not None:
        found = found.scaled(program.scale)
    if found is None:
        return None
    unknowns = program.blocks[:, 1:].reshape(-1, program.rank)[found.kept]
    if not np.linalg.norm(found.to_y, 1) * np.linalg.norm(unknowns, 1) < DISTORTED:
        return None
    return ReactionProgram(program, found, np.vstack([found.dense, program.rows @ found.to_y]))
