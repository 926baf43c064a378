"""Jumps: where the quasi-static evolution has no solution, a viscous system finds the state that it goes to.

Above a friction threshold the rate problem can lose its solution (chapter VI).
The state then moves at constant load, as a system D u̇ = −(out-of-balance) does
(thesis §6.3), until it is in equilibrium again. Implicit steps Δt of it are
static problems with the stiffness κ + D/Δt, and each of them is solved by
the exact evolution of that stiffer system, from the reactions of the step before to
those that the viscous system has at the end of the step. Steps adapt: they are
halved where the stiffer system is itself above a threshold (an implicit step
that long would step over the instability) or where the rates change much, and
they grow without limit as the motion dies out. The end state is then solved for
exactly from its contact states; it depends on D only through nodes that come to
rest before the others.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.joint.layout import Layout
from shakedown.joint.result import Result
from shakedown.motion.contact_law import Scales, law_violation
from shakedown.motion.kernels import event_loop as kernel
from shakedown.motion.kernels.active_set import ActiveSet, active_set, factorize, solve
from shakedown.motion.kernels.contact_status import OPEN
from shakedown.motion.kernels.moving_state import Precision, begin, course, motion_at_rest, room_for
from shakedown.motion.kernels.rate_problem import rates
from shakedown.motion.kernels.rate_search import enumerate_states
from shakedown.motion.kernels.run import run_along

MAX_STEPS = 2000
FAR = 1e6  # motion, relative to the length scale and the slips before, from which on there is no end to it
ACCURACY = 0.05  # change of the rates over a step, relative to the motion so far, that is accepted


@dataclass(frozen=True, eq=False, repr=False)
class Jump(Result):
    """A jump of the state at constant load.

    Attributes
    ----------
    cycle
        Time in cycles.
    v_before, w_before, v_after, w_after : (n,)
        Slips and gaps [length].
    contact : (n,)
        Contact states after it: 0 stick, +1 backward, −1 forward slip, 2 open.
    energy_released
        Loss of potential energy ½ uᵀκu + r_wᵀu [force × length], independent of the damping.
    friction_work
        The part that friction takes, on the way that the implicit steps find [force × length].
    work : (n,)
        The same node by node.
    slip : (n,)
        Σ|Δv| in contact on that way [length].
    steps
        Implicit steps taken.
    """

    DOCUMENT: ClassVar[str] = "cycle energy_released friction_work damping_work"
    TABLE: ClassVar[str] = "v_before w_before v_after w_after contact slip"

    cycle: float
    v_before: FloatArray
    w_before: FloatArray
    v_after: FloatArray
    w_after: FloatArray
    contact: NDArray[np.int64]
    energy_released: float
    friction_work: float
    work: FloatArray
    slip: FloatArray
    steps: int

    @property
    def damping_work(self) -> float:
        """The part of the energy released that the damping takes [force × length]."""
        return self.energy_released - self.friction_work


@dataclass(frozen=True)
class Rest:
    """Where a viscous motion has come to rest, and what it took to get there.

    Displacements u = (v, w), contact states, friction work in all and of each node (n,)
    [force × length], slip in contact (n,) [length] and steps taken.
    """

    u: FloatArray
    contact: NDArray[np.int64]
    friction_work: float
    work: FloatArray
    slip: FloatArray
    steps: int


class Relaxation:
    """A viscous system that is carried to rest by implicit steps, longer and longer ones.

    What a step is and what rest is, the kinds of it say.
    """

    kappa: FloatArray
    damping: FloatArray
    scale: Scales
    start: FloatArray
    u: FloatArray
    steps = 0
    endless = False

    def to_rest(self) -> Rest | None:
        """Follow the motion to its end; None where it has none, ``endless`` where it goes on for ever."""
        fastest = float(np.max(np.diag(self.kappa) / self.damping))
        dt = 0.05 / fastest if fastest > 0 else 1.0  # without any stiffness there is no time to compare with
        shortest = 1e-9 * dt
        far = FAR * self.scale.length + FAR * np.abs(self.start).max()
        longest = FAR * FAR * dt
        while self.steps < MAX_STEPS and shortest < dt < longest and np.abs(self.u - self.start).max() < far:
            if not self._step(dt):
                dt *= 0.5
                continue
            self.steps += 1
            rest = self._rest()
            if rest is not None:
                return rest
            dt *= 1.5
        self.endless = bool(dt >= longest or np.abs(self.u - self.start).max() >= far)
        return None

    def _step(self, dt: float) -> bool:
        """One implicit step; False, and nothing changed, where it is too long."""
        raise NotImplementedError

    def _rest(self) -> Rest | None:
        """The state in equilibrium that the motion has come next to, if it has."""
        raise NotImplementedError


class ViscousMotion(Relaxation):
    """The viscous system at constant load, from a state that a small change of load has put out of balance.

    Parameters
    ----------
    kappa, f
        Contact stiffness (2n, 2n) and friction coefficients (n,).
    u, contact, reaction
        State before: displacements (2n,), contact states (n,), reactions (2n,) that satisfy the law.
    load : (2n,)
        Welded reactions from now on.
    damping : (2n,)
        Diagonal of D; only ratios matter.
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
        precision: Precision,
        scale: Scales,
    ) -> None:
        self.kappa, self.f, self.load, self.damping = kappa, f, load, damping
        self.precision, self.scale = precision, scale
        self.start, self.u, self.contact, self.reaction = u.copy(), u.copy(), contact.copy(), reaction.copy()
        self.velocity = np.zeros_like(u)
        self.friction_work = 0.0
        self.work, self.slip = np.zeros(len(f)), np.zeros(len(f))
        self.at_rest = active_set(kappa, f)
        parts = active_set(kappa.copy(), f), rates(len(f)), motion_at_rest(len(f)), room_for(0, len(f))
        self.run = run_along(*parts, course(np.stack([load, load]), 0, True, precision))

    def _step(self, dt: float) -> bool:
        """One implicit step; False, and nothing changed, where it is too long."""
        stiffer = self.kappa + np.diag(self.damping / dt)
        run, act, mo, path = self.run, self.run.active, self.run.motion, self.run.course.path
        act.kappa[:], act.state[:], mo.u[:] = stiffer, self.contact, self.u
        if factorize(act) <= 0:
            return False
        path[:] = self.reaction - stiffer @ self.u, self.load - self.damping / dt * self.u
        begin(mo)
        status = kernel.follow(run, 1, kernel.EFFORT)
        while status == kernel.PAUSED or (
            status == kernel.NO_RATES and enumerate_states(act, run.rates, self.precision.rate)
        ):
            status = kernel.follow(run, 1, kernel.EFFORT)
        if status != kernel.DONE:
            return False
        if not np.isfinite(mo.u).all():
            return False
        velocity = (mo.u - self.u) / dt
        motion = max(float(np.abs(mo.u - self.start).max()), 1e-9 * self.scale.length)
        if np.abs(velocity - self.velocity).max() * dt > ACCURACY * motion and self.steps > 0:
            return False
        self.u, self.velocity, self.contact = mo.u.copy(), velocity, act.state.copy()
        self.reaction = path[1] + stiffer @ mo.u
        self.friction_work += mo.dissipation
        self.work += mo.work
        self.slip += mo.slip
        return True

    def _rest(self) -> Rest | None:
        """The equilibrium of the present contact states, if the motion has come near it and it is one."""
        self.at_rest.state[:] = self.contact
        if factorize(self.at_rest) <= 0:
            return None
        u = equilibrium(self.at_rest, self.u, self.load)
        if np.abs(u - self.u).max() > 1e-3 * np.abs(u - self.start).max() + 1e-12 * self.scale.length:
            return None
        layout = Layout(len(self.f))
        (v, w), (q, p) = layout.split(u), layout.split(self.load + self.kappa @ u)
        if law_violation(self.f, q, p, w, np.zeros_like(v), self.scale).max() > 1e-12:
            return None
        last = np.where(self.contact == OPEN, 0.0, v - self.u[layout.slips])
        friction_work = self.friction_work - float(last @ (self.reaction[layout.slips] + q)) / 2
        work = self.work - 0.5 * last * (self.reaction[layout.slips] + q)
        return Rest(u, self.contact.copy(), friction_work, work, self.slip + np.abs(last), self.steps)


def equilibrium(act: ActiveSet, u: FloatArray, load: FloatArray) -> FloatArray:
    """Displacements (2n,) that satisfy the equations of the moving nodes, the others where they are."""
    u, change = u.copy(), np.empty_like(u)
    for _ in range(3):
        solve(act, load + act.kappa @ u, change)
        u += change
    u[Layout(len(act.f)).gaps][act.state != OPEN] = 0.0
    return u


def potential_energy(kappa: FloatArray, load: FloatArray, u: FloatArray) -> float:
    """½ uᵀκu + r_wᵀu [force × length]."""
    return float(u @ (0.5 * (kappa @ u) + load))


def default_damping(kappa: FloatArray) -> FloatArray:
    """Damping in proportion to the diagonal of κ, (2n,)."""
    diagonal = np.diag(kappa).copy()
    diagonal[diagonal <= 0] = diagonal.max() or 1.0
    return diagonal
