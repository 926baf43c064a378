"""Jumps with two tangential directions: where there are no rates, a viscous system finds the next state.

As in the plane (:mod:`shakedown.motion.viscous_jump`): implicit steps of D u̇ = −(out-of-balance) are
static problems with the stiffness κ + D/Δt, and each of them is solved by following the motion of that
stiffer system; where a node next to its apex would make that endless, all at once. The end state is then
put into equilibrium exactly, nodes that still slip at the limit in their last direction.
"""

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEWTON_ROUNDS, SIX_DIGITS
from shakedown.ground.status import OPEN, SLIP, STICK
from shakedown.joint.law import Law
from shakedown.joint.layout import Layout
from shakedown.motion.course import DONE, PAUSED, course
from shakedown.motion.space.curved_loop import follow_curve
from shakedown.motion.space.implicit_step import ImplicitJoint, StepStatus
from shakedown.motion.space.moving_state import empty_curve_record
from shakedown.motion.space.space_run import Measures, run_in_space
from shakedown.motion.viscous_jump import Relaxation, StepEnd

LABOUR = 10_000_000  # operations after which the steps of integration are counted
MOST_TAKEN = 5_000  # largest number of these in an implicit step; beyond that it is solved as a whole


def end_at_once(joint: ImplicitJoint, layout: Layout, u: FloatArray, path: FloatArray) -> StepEnd | None:
    """The end of an implicit step between two welded reactions (2, 3n); None where none is found."""
    joint.begin(*layout.split(u), *layout.split(path[0]))
    found = joint.step(*layout.split(path[1]))
    if found.status != StepStatus.SOLVED:
        return None
    w, length = found.w[-1], found.length[-1]
    contact = np.where(w > 0.0, OPEN, np.where(length > 0.0, SLIP, STICK))
    return StepEnd(layout.joined(found.v[-1], w), contact, found.work[-1], length)


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

    def _end(self, stiffer: FloatArray, path: FloatArray) -> StepEnd | None:
        end = None if self.at_once else self._followed(stiffer, path)
        return self._solved(stiffer, path) if self.at_once else end

    def _followed(self, stiffer: FloatArray, path: FloatArray) -> StepEnd | None:
        """The end of an implicit step along the path of its static problem; None where there is none."""
        way = course(path, 0, True, self.measures.precision)
        run = run_in_space(stiffer, self.law.f, self.measures, way, empty_curve_record(0, len(self.law.f)))
        mo = run.motion
        mo.u[:], mo.contact[:] = self.u, self.contact
        status = PAUSED
        while status == PAUSED:
            status = follow_curve(run, LABOUR)
            self.at_once = status == PAUSED and run.control.taken > MOST_TAKEN
            if self.at_once:
                return None
        if status != DONE or not np.isfinite(mo.u).all():
            return None
        return StepEnd(mo.u.copy(), mo.contact.copy(), mo.work, mo.slip)

    def _solved(self, stiffer: FloatArray, path: FloatArray) -> StepEnd | None:
        """The end of an implicit step, solved for; None where there is none."""
        joint = ImplicitJoint(*self.layout.blocks(stiffer), self.law.f, self.scale.force)
        return end_at_once(joint, self.layout, self.u, path)

    def _equilibrium(self) -> FloatArray | None:
        """Displacements with slipping nodes at their limits and nothing on open ones, by Newton's method.

        None where there are none near, or what moves is not held.
        """
        u, layout, f = self.u.copy(), self.layout, self.law.f
        open_places = layout.of_nodes(np.flatnonzero(self.contact == OPEN))
        loose = np.flatnonzero((self.contact == SLIP) & (f == 0.0))
        free = np.concatenate([open_places, layout.slips_of(loose)])
        nodes = np.flatnonzero((self.contact == SLIP) & (f > 0.0))
        for _ in range(NEWTON_ROUNDS):
            reaction = self.load + self.kappa @ u
            unit = layout.by_node(self.law.direction(reaction[layout.slips]))[nodes]
            ways = np.zeros((layout.size, len(nodes) + len(free)))
            for c in range(2):
                ways[2 * nodes + c, np.arange(len(nodes))] = unit[:, c]
            ways[free, len(nodes) + np.arange(len(free))] = 1.0
            limits = ways.copy()
            limits[layout.gaps_of(nodes), np.arange(len(nodes))] = f[nodes]
            residual = limits.T @ reaction
            if np.abs(residual).max(initial=0.0) <= 1e-15 * self.scale.force:
                break
            matrix = limits.T @ self.kappa @ ways
            if np.linalg.slogdet(matrix)[0] <= 0:
                return None
            u -= ways @ np.linalg.solve(matrix, residual)
        u[layout.gaps][self.contact != OPEN] = 0.0
        return u
