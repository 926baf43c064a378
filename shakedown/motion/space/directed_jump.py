"""Jumps with two tangential directions: where there are no rates, a viscous system finds the next state.

As in the plane (:mod:`shakedown.motion.viscous_jump`): implicit steps of D u̇ = −(out-of-balance) are
static problems with the stiffness κ + D/Δt, and each of them is solved by following the motion of that
stiffer system; where a node next to its apex would make that endless, all at once. The end state is then
put into equilibrium exactly, nodes that still slip at the limit in their last direction.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cho_factor, cho_solve, lapack
from scipy.sparse import csc_array

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEWTON_ROUNDS, SIX_DIGITS
from shakedown.ground.size_limits import BLOCK
from shakedown.ground.status import OPEN, SLIP, STICK
from shakedown.ground.work_limit import BY_BLAS, count_work
from shakedown.joint.law import Law
from shakedown.joint.layout import Layout
from shakedown.motion.course import DONE, PAUSED, course
from shakedown.motion.space.curved_loop import follow_curve
from shakedown.motion.space.exchange import MOST_EXCHANGES
from shakedown.motion.space.implicit_step import ImplicitJoint, StepStatus
from shakedown.motion.space.moving_state import CompiledJoint, empty_curve_record
from shakedown.motion.space.space_run import Measures, begin, run_in_space
from shakedown.motion.viscous_jump import Relaxation, StepEnd

LABOUR = 1_000_000  # operations after which the steps of integration are counted
MOST_TAKEN = 1_000  # largest number of these in an implicit step; beyond that it is solved as a whole
FEW_TURNS = 4  # of sweeps and Newton's method in such a solution: one that takes more is of a step too long


def end_at_once(joint: ImplicitJoint, layout: Layout, u: FloatArray, path: FloatArray) -> StepEnd | None:
    """The end of an implicit step between two welded reactions (2, 3n); None where none is found."""
    count_work(BY_BLAS * layout.size**3)
    joint.begin(*layout.split(u), *layout.split(path[0]))
    found = joint.step(*layout.split(path[1]))
    if found.status != StepStatus.SOLVED:
        return None
    w, length = found.w[-1], found.length[-1]
    contact = np.where(w > 0.0, OPEN, np.where((length > 0.0) | joint.without_friction, SLIP, STICK))
    return StepEnd(layout.joined(found.v[-1], w), contact, found.work[-1], length)


def stable_solution(matrix: FloatArray, right: FloatArray) -> FloatArray | None:
    """The solution of linear equations; None where their determinant is not positive."""
    if not len(right):
        return right
    factors, pivots, singular = lapack.dgetrf(matrix)
    swaps = np.count_nonzero(pivots != np.arange(len(right)))
    if singular or np.prod(np.sign(np.diagonal(factors))) * (-1.0) ** swaps < 0.0:
        return None
    return np.asarray(lapack.dgetrs(factors, pivots, right)[0])


class DirectedJump(Relaxation):
    """The viscous system of a joint in space: implicit steps are followed, or solved at once.

    Parameters
    ----------
    kappa, f
        Contact stiffness (3n, 3n) and friction coefficients (n,).
    u, contact, reaction, load, damping
        As for :class:`Relaxation`.
    measures
        What counts as zero, and the scale of the scene.
    """

    def __init__(
        self,
        kappa: FloatArray,
        f: FloatArray,
        u: FloatArray,
        contact: NDArray[np.int64],
        reaction: FloatArray,
        load: FloatArray,
        damping: FloatArray,
        measures: Measures,
    ) -> None:
        super().__init__(kappa, Law(f, 2), u, contact, reaction, load, damping, measures.scale)
        self.measures = measures._replace(accuracy=max(measures.accuracy, SIX_DIGITS))  # its end is exact
        self.at_once = False  # whether a path was too long to follow
        path = course(np.stack([load, load]), 0, True, self.measures.precision)
        self.run = run_in_space(
            kappa, self.law.f, self.measures, path, empty_curve_record(0, len(self.law.f))
        )

    def _end(self, stiffer: FloatArray, path: FloatArray) -> StepEnd | None:
        end = None if self.at_once else self._followed(stiffer, path)
        return self._solved(stiffer, path) if self.at_once else end

    def _followed(self, stiffer: FloatArray, path: FloatArray) -> StepEnd | None:
        """The end of an implicit step along the path of its static problem; None where there is none."""
        run = self.run
        run.course.path[:] = path
        run.joint.kappa[:] = stiffer
        run.joint.set(known=False, keeps=False, exchanges=MOST_EXCHANGES + 1)  # all is worked out anew
        begin(run)
        mo = run.motion
        mo.u[:], mo.contact[:], mo.direction[:] = self.u, self.contact, 0.0
        self._exchange_free(run.joint, stiffer)
        status = PAUSED
        while status == PAUSED:
            status = follow_curve(run, LABOUR)
            count_work(run.control.effort)
            self.at_once = status == PAUSED and run.control.taken > MOST_TAKEN
            if self.at_once:
                return None
        if status != DONE or not np.isfinite(mo.u).all():
            return None
        return StepEnd(mo.u.copy(), mo.contact.copy(), mo.work.copy(), mo.slip.copy())

    def _free(self) -> NDArray[np.intp]:
        """The places without a reaction: those of open nodes, and slips without friction."""
        of_slips = np.repeat((self.contact == OPEN) | (self.law.f == 0.0), 2)
        return np.flatnonzero(np.concatenate([of_slips, self.contact == OPEN]))

    def _exchange_free(self, joint: CompiledJoint, stiffer: FloatArray) -> None:
        """Exchange all free places at once: one after the other takes seconds where hundreds are open.

        Where nothing holds them it is left to the loop, which says so.
        """
        free = self._free()
        if len(free) <= MOST_EXCHANGES:
            return
        held = np.setdiff1d(np.arange(self.layout.size), free)
        try:
            factor = cho_factor(stiffer[np.ix_(free, free)])
        except LinAlgError:
            return
        from_held = cho_solve(factor, stiffer[np.ix_(free, held)])
        S = joint.exchanged.reshape(stiffer.shape)
        S[np.ix_(free, free)] = cho_solve(factor, np.eye(len(free)))
        S[np.ix_(free, held)], S[np.ix_(held, free)] = -from_held, from_held.T
        S[np.ix_(held, held)] = stiffer[np.ix_(held, held)] - stiffer[np.ix_(held, free)] @ from_held
        joint.free[:] = 0
        joint.free[free] = 1
        joint.set(exchanges=0)

    def _solved(self, stiffer: FloatArray, path: FloatArray) -> StepEnd | None:
        """The end of an implicit step, solved for; None where there is none."""
        joint = ImplicitJoint(*self.layout.blocks(stiffer), self.law.f, self.scale.force)
        joint.turns = FEW_TURNS
        return end_at_once(joint, self.layout, self.u, path)

    def _equilibrium(self) -> FloatArray | None:
        """Displacements with slipping nodes at their limits and nothing on open ones, by Newton's method.

        None where there are none near, as where the motion does not slow down, or what moves is not held.
        """
        if not self.slows_down:
            return None
        u, layout, f = self.u.copy(), self.layout, self.law.f
        nodes, free = np.flatnonzero((self.contact == SLIP) & (f > 0.0)), self._free()
        places = np.concatenate([layout.slips_of(nodes), free, layout.gaps_of(nodes)])
        of_slips, of_free = np.repeat(np.arange(len(nodes)), 2), len(nodes) + np.arange(len(free))
        columns = np.concatenate([of_slips, of_free, np.arange(len(nodes))])
        size, moves = (layout.size, len(nodes) + len(of_free)), len(of_slips) + len(of_free)
        for _ in range(NEWTON_ROUNDS):
            reaction = self.load + self.kappa @ u
            unit = layout.by_node(self.law.direction(reaction[layout.slips]))[nodes].ravel()
            parts = np.concatenate([unit, np.ones(len(of_free)), f[nodes]])
            limits = _entered(parts, places, columns, size)
            ways = _entered(parts[:moves], places[:moves], columns[:moves], size)
            residual = limits.T @ reaction
            if np.abs(residual).max(initial=0.0) <= 1e-15 * self.scale.force:
                break
            change = stable_solution(limits.T @ (self.kappa @ ways), residual)
            if change is None:
                return None
            u -= ways @ change
            if not self._is_near(u):
                return None
        u[layout.gaps][self.contact != OPEN] = 0.0
        return u


def _entered(
    entries: FloatArray, rows: NDArray[np.intp], columns: NDArray[np.intp], size: tuple[int, int]
) -> FloatArray | csc_array:
    """A matrix of these entries, each in a place of its own; sparse where it is large."""
    if size[0] * size[1] > BLOCK:
        return csc_array((entries, (rows, columns)), size)
    matrix = np.zeros(size)
    matrix[rows, columns] = entries
    return matrix
