"""Steady slides: rigid motions at constant velocity that no stiffness, no friction and no contact ends.

A viscous motion D u̇ = −(out-of-balance) at constant load that has an end loses its velocity. One that has
none tends to a velocity V that changes no reaction, κ V = 0: all reactions are constant then, with those of
damping they satisfy the law, and so they do for ever. Whether there is such a slide next to a motion, and
whether motions beside it approach it, is solved for instead of waited for.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from shakedown.ground.constants import NEGLIGIBLE, NEWTON_ROUNDS, PER_CENT, ROUND_OFF, SIX_DIGITS, FloatArray
from shakedown.ground.status import OPEN, STICK
from shakedown.ground.tolerances import DEFAULT
from shakedown.joint.law import Law
from shakedown.motion.checked_law import Scales, law_violation, reaction_round_off

HOLDS = 10 * ROUND_OFF  # violation of the law at rest and in a slide, relative


class ViscousJoint(NamedTuple):
    """A joint under a constant load, and the damping of its nodes.

    Attributes
    ----------
    kappa, law
        Contact stiffness ((d + 1) n, (d + 1) n) [force/length], and Coulomb's law of the nodes.
    load
        Welded reactions [force].
    damping
        Diagonal of D; only ratios matter.
    scale
        The scene's force and length.
    """

    kappa: FloatArray
    law: Law
    load: FloatArray
    damping: FloatArray
    scale: Scales


class SteadySlide(NamedTuple):
    """Displacements u and the velocity V with which they grow for ever, ((d + 1) n,)."""

    u: FloatArray
    velocity: FloatArray


def steady_slide(
    joint: ViscousJoint, u: FloatArray, velocity: FloatArray, contact: NDArray[np.int64]
) -> SteadySlide | None:
    """The slide that a motion with this state tends to; None where there is none near.

    Solved are, for the nodes that slip and those that are open,

        r_w + κ u + D V = −f p V/|V|  (0 where a node is open),   κ V = 0,

    by Newton's method from the present state. What is found is checked: the law at every node, a node
    that comes back to contact, and that small deviations, M u̇ = −J u with the derivatives of the equations,
    do not grow.

    Parameters
    ----------
    joint
        The viscous joint.
    u, velocity
        Present displacements [length] and their rates, by whatever clock.
    contact : (n,)
        Contact states.

    Examples
    --------
    A node without stiffness, pulled by 2 against friction of 0.5 · 1:

    >>> no_stiffness, load = np.diag([0.0, 1.0]), np.array([2.0, 1.0])
    >>> joint = ViscousJoint(no_stiffness, Law(np.array([0.5])), load, np.ones(2), Scales(2.0, 2.0))
    >>> steady_slide(joint, np.zeros(2), np.array([-1.499, 0.0]), np.array([-1])).velocity
    array([-1.5,  0. ])
    """
    equations = _SlideEquations(joint, contact)
    if not equations.rigid.shape[1]:
        return None
    speeds = equations.rigid.T @ (velocity[equations.at] / equations.unit)
    enough = ROUND_OFF * joint.scale.force * equations.unit
    for _ in range(NEWTON_ROUNDS):
        missing = equations.missing(u, speeds)
        if not np.isfinite(missing).all():
            return None
        if (np.abs(missing) <= enough).all():
            break
        change, faster = equations.newton_step(u, speeds, missing)
        u, speeds = u + change, speeds + faster
    found = SteadySlide(u, equations.velocity(speeds))
    near = np.abs(found.velocity - velocity).max() <= PER_CENT * np.abs(velocity).max()
    return found if near and _holds(joint, found, contact) and equations.attracts(u, speeds) else None


def _holds(joint: ViscousJoint, slide: SteadySlide, contact: NDArray[np.int64]) -> bool:
    """Whether the law is satisfied at every node, now and for ever."""
    layout, way = joint.law.layout, slide.velocity / np.abs(slide.velocity).max()
    q, p = layout.split(joint.load + joint.kappa @ slide.u + joint.damping * slide.velocity)
    slip, opening = layout.split(way)
    slip = np.where(np.repeat(contact == OPEN, layout.d), 0.0, slip) * joint.scale.length / SIX_DIGITS
    violation = law_violation(joint.law.f, q, p, slide.u[layout.gaps], slip, joint.scale)
    most = max(HOLDS, reaction_round_off(joint.kappa, slide.u, joint.scale))
    return bool(violation.max() <= most and (opening >= -NEGLIGIBLE).all())


class _SlideEquations:
    """The equations of a steady slide, in units in which the damping is 1.

    Attributes
    ----------
    at
        The places that move: the slips of nodes that slip, slips and gaps of open ones.
    unit
        1/√D there.
    rigid
        The motions of these places that change no reaction, in columns: V = unit · rigid @ speeds.
    """

    def __init__(self, joint: ViscousJoint, contact: NDArray[np.int64]) -> None:
        layout = joint.law.layout
        self.joint, self.is_closed = joint, contact != OPEN
        moves = np.concatenate([np.repeat(contact != STICK, layout.d), contact == OPEN])
        self.at = np.flatnonzero(moves)
        self.unit = 1.0 / np.sqrt(joint.damping[self.at])
        values, modes = np.linalg.eigh(self._scaled(joint.kappa[self.at]))
        self.rigid = modes[:, values <= DEFAULT.zero_mode * np.abs(values).max(initial=0.0)]

    def _scaled(self, rows: FloatArray) -> FloatArray:
        """Rows (m, (d + 1) n) of a stiffness at the places that move, (m, m)."""
        return np.asarray(rows[:, self.at] * self.unit * self.unit[:, None])

    def velocity(self, speeds: FloatArray) -> FloatArray:
        """V, ((d + 1) n,)."""
        V = np.zeros(len(self.joint.load))
        V[self.at] = self.unit * (self.rigid @ speeds)
        return V

    def _friction(self, u: FloatArray, V: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Limits f p of closed nodes (n,), and directions of slip (dn,)."""
        law, layout = self.joint.law, self.joint.law.layout
        pressure = self.joint.load[layout.gaps] + self.joint.kappa[layout.gaps] @ u
        return np.where(self.is_closed, law.limit(pressure), 0.0), law.direction(-V[layout.slips])

    def missing(self, u: FloatArray, speeds: FloatArray) -> FloatArray:
        """What is not in equilibrium, times ``unit``."""
        joint, V = self.joint, self.velocity(speeds)
        (limit, along), slips = self._friction(u, V), joint.law.layout.slips
        force = joint.load + joint.kappa @ u + joint.damping * V
        force[slips] += np.repeat(limit, joint.law.d) * along
        return np.asarray(self.unit * force[self.at])

    def _derivatives(self, u: FloatArray, V: FloatArray) -> tuple[FloatArray, FloatArray]:
        """J and M: of the equations with respect to displacements and velocities, (m, m)."""
        law, layout = self.joint.law, self.joint.law.layout
        (limit, along), d = self._friction(u, V), law.d
        stiffness = self.joint.kappa.copy()
        pressed = np.where(self.is_closed, law.f, 0.0)[:, None] * self.joint.kappa[layout.gaps]
        stiffness[layout.slips] += along[:, None] * np.repeat(pressed, d, axis=0)
        speed, unit = law.size(V[layout.slips]), layout.by_node(along)
        turned = np.divide(limit, speed, out=np.zeros_like(speed), where=speed > 0)[:, None, None]
        blocks = turned * (np.eye(d) - unit[:, :, None] * unit[:, None, :])
        drag = np.zeros_like(stiffness)
        drag[layout.slips, layout.slips] = block_diag(*blocks)
        return self._scaled(stiffness[self.at]), np.eye(len(self.at)) + self._scaled(drag[self.at])

    def newton_step(
        self, u: FloatArray, speeds: FloatArray, missing: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Changes of displacements, which contain no rigid motion, and speeds; NaN where there are none."""
        J, M = self._derivatives(u, self.velocity(speeds))
        m, r = self.rigid.shape
        matrix = np.block([[J, M @ self.rigid], [self.rigid.T, np.zeros((r, r))]])
        try:
            change = np.linalg.solve(matrix, np.append(-missing, np.zeros(r)))
        except np.linalg.LinAlgError:
            change = np.full(m + r, np.nan)
        moved = np.zeros_like(u)
        moved[self.at] = self.unit * change[:m]
        return moved, change[m:]

    def attracts(self, u: FloatArray, speeds: FloatArray) -> bool:
        """Whether no small deviation grows."""
        J, M = self._derivatives(u, self.velocity(speeds))
        rates = np.linalg.eigvals(np.linalg.solve(M, J))
        return bool(rates.real.min() >= -NEGLIGIBLE * np.abs(rates).max())
