"""Jumps with two tangential directions: where there are no rates, a viscous system finds the next state.

As in the plane (:mod:`shakedown.motion.viscous_jump`): implicit steps of D u̇ = −(out-of-balance) are
static problems with the stiffness κ + D/Δt, and each of them is solved by following the motion of that
stiffer system; where a node next to its apex would make that endless, all at once. The end state is then
put into equilibrium exactly, nodes that still slip at the limit in their last direction.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.joint.law import Law
from shakedown.joint.layout import Layout
from shakedown.motion.contact_law import Scales, law_violation
from shakedown.motion.cycle_record import State
from shakedown.motion.directed import curved_loop as kernel
from shakedown.motion.directed.sliding import (
    SLIP,
    Measures,
    curve_room,
    reached,
    sliding,
)
from shakedown.motion.implicit.implicit_step import ImplicitJoint, StepStatus
from shakedown.motion.kernels.contact_status import OPEN, STICK
from shakedown.motion.viscous_jump import ACCURACY, Jump, Relaxation, Rest, potential_energy

OF_THE_WAY = 1e-6  # error of an implicit step, relative to the length scale: the end state is exact
NEWTON_STEPS = 20
SETTLED = 1e-12  # violation of the law at the end, relative
LABOUR = 10_000_000  # multiplications and additions after which the steps of integration are counted
MOST_TAKEN = 5_000  # of them in an implicit step: beyond that it is solved at once


class StepEnd(NamedTuple):
    """Where an implicit step ends: displacements, contact states, and friction work and ways."""

    u: FloatArray
    contact: NDArray[np.int64]
    work: FloatArray
    slip: FloatArray


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
    """The viscous system at constant load, from a state that a small change of load has put out of balance.

    Parameters
    ----------
    kappa, f
        Contact stiffness (3n, 3n) and friction coefficients (n,).
    start, reaction
        State before, and reactions (3n,) that satisfy the law in it.
    load : (3n,)
        Welded reactions from now on.
    damping : (3n,)
        Diagonal of D; only ratios matter.
    measures, scale
        What counts as zero, and the scene's force and length.
    """

    def __init__(
        self,
        kappa: FloatArray,
        f: FloatArray,
        start: State,
        reaction: FloatArray,
        load: FloatArray,
        damping: FloatArray,
        measures: Measures,
        scale: Scales,
    ) -> None:
        self.kappa, self.law, self.load, self.damping = kappa, Law(f, 2), load, damping
        self.measures = measures._replace(accuracy=max(measures.accuracy, OF_THE_WAY))
        self.scale = scale
        self.start, self.u, self.contact = start.u.copy(), start.u.copy(), start.contact.copy()
        self.reaction, self.velocity = reaction.copy(), np.zeros_like(start.u)
        self.work, self.slip = np.zeros(len(f)), np.zeros(len(f))
        self.at_once = False  # whether a path was too long to follow

    @property
    def layout(self) -> Layout:
        """Where slips and gaps stand."""
        return self.law.layout

    def _step(self, dt: float) -> bool:
        """One implicit step; False, and nothing changed, where it is too long."""
        stiffer = self.kappa + np.diag(self.damping / dt)
        path = np.stack([self.reaction - stiffer @ self.u, self.load - self.damping / dt * self.u])
        end = None if self.at_once else self._followed(stiffer, path)
        if self.at_once:
            end = self._solved(stiffer, path)
        if end is None:
            return False
        velocity = (end.u - self.u) / dt
        motion = max(float(np.abs(end.u - self.start).max()), 1e-9 * self.scale.length)
        if np.abs(velocity - self.velocity).max() * dt > ACCURACY * motion and self.steps > 0:
            return False
        self.u, self.velocity, self.contact = end.u, velocity, end.contact
        self.reaction = path[1] + stiffer @ end.u
        self.work += end.work
        self.slip += end.slip
        return True

    def _followed(self, stiffer: FloatArray, path: FloatArray) -> StepEnd | None:
        """The end of an implicit step along the path of its static problem; None where there is none."""
        mo, room = sliding(stiffer, self.law.f, path, 0, True), curve_room(0, len(self.law.f))
        mo.set(**self.measures._asdict())
        mo.u[:], mo.contact[:] = self.u, self.contact
        status = kernel.PAUSED
        while status == kernel.PAUSED:
            status = kernel.follow_curve(mo, room, 1, LABOUR)
            self.at_once = status == kernel.PAUSED and reached(mo, room).taken > MOST_TAKEN
            if self.at_once:
                return None
        if status != kernel.DONE or not np.isfinite(mo.u).all() or reached(mo, room).passes < 1:
            return None
        return StepEnd(mo.u.copy(), mo.contact.copy(), mo.work, mo.slipped)

    def _solved(self, stiffer: FloatArray, path: FloatArray) -> StepEnd | None:
        """The end of an implicit step, solved for; None where there is none."""
        joint = ImplicitJoint(*self.layout.blocks(stiffer), self.law.f, self.scale.force)
        return end_at_once(joint, self.layout, self.u, path)

    def _rest(self) -> Rest | None:
        """The equilibrium of the present contact states, if the motion has come near it and it is one."""
        u = self._equilibrium()
        if u is None:
            return None
        if np.abs(u - self.u).max() > 1e-3 * np.abs(u - self.start).max() + 1e-12 * self.scale.length:
            return None
        (v, w), (q, p) = self.layout.split(u), self.layout.split(self.load + self.kappa @ u)
        if law_violation(self.law.f, q, p, w, np.zeros_like(v), self.scale).max() > SETTLED:
            return None
        last = self.layout.by_node(v - self.u[self.layout.slips])
        last = np.where((self.contact == OPEN)[:, None], 0.0, last)
        mean = self.layout.by_node(0.5 * (self.reaction[self.layout.slips] + q))
        work = self.work - (last * mean).sum(axis=1)
        slip = self.slip + np.hypot(*last.T)
        return Rest(u, self.contact.copy(), float(work.sum()), work, slip, self.steps)

    def _equilibrium(self) -> FloatArray | None:
        """Displacements with slipping nodes at their limits and nothing on open ones, by Newton's method.

        None where there are none near, or what moves is not held.
        """
        u, layout, f = self.u.copy(), self.layout, self.law.f
        open_places = layout.of_nodes(np.flatnonzero(self.contact == OPEN))
        loose = np.flatnonzero((self.contact == SLIP) & (f == 0.0))
        free = np.concatenate([open_places, layout.slips_of(loose)])
        nodes = np.flatnonzero((self.contact == SLIP) & (f > 0.0))
        for _ in range(NEWTON_STEPS):
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


def jump_of(cycle: float, kappa: FloatArray, load: FloatArray, before: State, rest: Rest) -> Jump:
    """What is told of a jump from one state to another at this load."""
    layout = Layout(len(rest.contact), 2)
    (v, w), (v_rest, w_rest) = layout.split(before.u), layout.split(rest.u)
    released = potential_energy(kappa, load, before.u) - potential_energy(kappa, load, rest.u)
    return Jump(
        cycle,
        v,
        w,
        v_rest,
        w_rest,
        rest.contact,
        released,
        rest.friction_work,
        rest.work,
        rest.slip,
        rest.steps,
    )
