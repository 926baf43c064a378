"""Jumps: where the quasi-static evolution has no solution, a viscous system determines the next state.

Above a friction threshold the rate problem can lose its solution (chapter VI).
The state then moves at constant load, as a system D u̇ = −(out-of-balance) does
(thesis §6.3), until it is in equilibrium again. Implicit steps Δt of it are
static problems with the stiffness κ + D/Δt, and each of them is solved by
the exact evolution of that stiffer system, from the reactions of the step before to
those that the viscous system has at the end of the step. Steps adapt: they are
halved where the stiffer system is itself above a threshold (an implicit step
that long would step over the instability) and shortened where the path turns
(:mod:`.jump_steps`), and they grow without limit as the motion dies out. The end state is then solved for
exactly from its contact states; it depends on D only through nodes that come to
rest before the others. A motion without an end tends to a rigid one, which
is solved for as well (:mod:`.steady_slide`).
"""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE, PER_CENT, ROUND_OFF, SIX_DIGITS
from shakedown.ground.status import OPEN
from shakedown.ground.work_limit import BY_BLAS, count_work, work_is_left
from shakedown.joint.law import Law
from shakedown.joint.layout import Layout
from shakedown.joint.result import Result
from shakedown.motion.checked_law import Scales, law_violation, reaction_round_off
from shakedown.motion.course import DONE, EFFORT, NO_RATES, PAUSED, Precision, course
from shakedown.motion.jump_steps import StepLengths, Stride
from shakedown.motion.plane.active_set import ActiveSet, active_set, factorize, solve
from shakedown.motion.plane.event_loop import follow_straight
from shakedown.motion.plane.moving_state import begin, empty_record, motion_at_rest
from shakedown.motion.plane.rate_problem import rates
from shakedown.motion.plane.rate_search import enumerate_states
from shakedown.motion.plane.run import run_along
from shakedown.motion.steady_slide import ViscousJoint, steady_slide

MAX_STEPS = 2000
MOST_IDLE = 16  # of these within round-off of where they begin: it stands between states that do not last
FAR = (
    1 / SIX_DIGITS
)  # motion, relative to the length scale and earlier slips, beyond which a body slides away
SETTLED = 10 * ROUND_OFF  # violation of the law at the end, relative


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
        The part dissipated by friction along the path of the implicit steps [force × length].
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
        """The part of the released energy that damping dissipates [force × length]."""
        return self.energy_released - self.friction_work


@dataclass(frozen=True)
class Rest:
    """The state at rest of a viscous motion, with the work and slip on the way there.

    Displacements u = (v, w), contact states, friction work in all and of each node (n,)
    [force × length], slip in contact (n,) [length] and steps taken.
    """

    u: FloatArray
    contact: NDArray[np.int64]
    friction_work: float
    work: FloatArray
    slip: FloatArray
    steps: int


class StepEnd(NamedTuple):
    """Where an implicit step ends: displacements, contact states, and friction work and ways of the nodes.

    ``friction`` is the work in all, where it is counted apart.
    """

    u: FloatArray
    contact: NDArray[np.int64]
    work: FloatArray
    slip: FloatArray
    friction: float = 0.0


class Relaxation:
    """The viscous system at constant load, from a state put out of balance by a small change of load.

    It is carried to rest by implicit steps of increasing length.

    Parameters
    ----------
    kappa, law
        Contact stiffness ((d + 1) n, (d + 1) n), and Coulomb's law of the nodes.
    u, contact, reaction
        State before: displacements, contact states (n,), reactions that satisfy the law.
    load
        Welded reactions from now on.
    damping
        Diagonal of D; only ratios matter.
    scale
        The scene's force and length.
    """

    endless = False

    def __init__(
        self,
        kappa: FloatArray,
        law: Law,
        u: FloatArray,
        contact: NDArray[np.int64],
        reaction: FloatArray,
        load: FloatArray,
        damping: FloatArray,
        scale: Scales,
    ) -> None:
        self.kappa, self.law, self.load, self.damping, self.scale = kappa, law, load, damping, scale
        self.start, self.u, self.contact, self.reaction = u.copy(), u.copy(), contact.copy(), reaction.copy()
        self.velocity, self.steps, self.friction_work = np.zeros_like(u), 0, 0.0
        self.work, self.slip = np.zeros(len(law.f)), np.zeros(len(law.f))
        self.turned = np.inf  # change of the velocity in the last step, relative
        self.slows_down = True  # in the last step
        self.asked_at = scale.length  # how far it has moved beyond which a slide for ever is looked for

    @property
    def layout(self) -> Layout:
        """Where slips and gaps stand."""
        return self.law.layout

    def to_rest(self) -> Rest | None:
        """Follow the motion to its end; None where it has none, ``endless`` where it goes on for ever."""
        fastest = float(np.max(np.diag(self.kappa) / self.damping))
        dt = 0.05 / fastest if fastest > 0 else 1.0  # without stiffness there is no time scale
        shortest = 1e-9 * dt
        far = FAR * self.scale.length + FAR * np.abs(self.start).max()
        longest = FAR * FAR * dt
        size = max(self.scale.length, float(np.abs(self.start).max()))
        lengths = StepLengths(self.scale.length, dt, size)
        while (
            self.steps < MAX_STEPS
            and lengths.idle < MOST_IDLE
            and shortest < dt < longest
            and self.moved < far
        ):
            if not work_is_left():
                return None
            count_work(BY_BLAS * len(self.u) ** 3)
            if self._step(lengths):
                self.steps += 1
                rest = self._rest()
                if rest is not None:
                    return rest
                self.endless = self._slides_for_ever()
                if self.endless:
                    return None
            dt = lengths.duration
        self.endless = bool(dt >= longest or self.moved >= far)
        return None

    @property
    def moved(self) -> float:
        """How far it has come [length]."""
        return float(np.abs(self.u - self.start).max())

    def _slides_for_ever(self) -> bool:
        """Whether the motion tends to a rigid one that nothing ends; asked when its way has doubled."""
        if self.moved <= self.asked_at or self.turned > PER_CENT:
            return False
        self.asked_at = 2.0 * self.moved
        joint = ViscousJoint(self.kappa, self.law, self.load, self.damping, self.scale)
        return steady_slide(joint, self.u, self.velocity, self.contact) is not None

    def _step(self, lengths: StepLengths) -> bool:
        """One implicit step; False, and nothing changed, where it is too long: the next one is shorter."""
        dt = lengths.duration
        stiffer = self.kappa + np.diag(self.damping / dt)
        path = np.stack([self.reaction - stiffer @ self.u, self.load - self.damping / dt * self.u])
        end = self._end(stiffer, path)
        if end is None:
            lengths.shorten()
            return False
        velocity = (end.u - self.u) / dt
        before, fastest = float(np.abs(self.velocity).max()), float(np.abs(velocity).max())
        motion = max(float(np.abs(end.u - self.start).max()), NEGLIGIBLE * self.scale.length)
        goes_on = before > 0.0 and fastest > 0.0
        turn = float(np.abs(velocity / fastest - self.velocity / before).max()) if goes_on else 0.0
        changes = bool((end.contact != self.contact).any())
        if not lengths.accepts(Stride(fastest * dt, fastest, motion, turn, changes)):
            return False
        change = float(np.abs(velocity - self.velocity).max())
        self.slows_down = self.steps == 0 or fastest <= (1.0 - PER_CENT) * before or fastest == 0.0
        self.turned = change / fastest if fastest > 0.0 else np.inf
        self.u, self.velocity, self.contact = end.u, velocity, end.contact
        self.reaction = path[1] + stiffer @ end.u
        self.friction_work += end.friction
        self.work += end.work
        self.slip += end.slip
        return True

    def _end(self, stiffer: FloatArray, path: FloatArray) -> StepEnd | None:
        """The end of the static problem with this stiffness between two welded reactions, if there is one."""
        raise NotImplementedError

    def _rest(self) -> Rest | None:
        """The equilibrium of the present contact states, if it is admissible and the motion is near it."""
        u = self._equilibrium()
        if u is None or not self._is_near(u):
            return None
        layout, slips = self.layout, self.layout.slips
        (v, w), (q, p) = layout.split(u), layout.split(self.load + self.kappa @ u)
        violation = law_violation(self.law.f, q, p, w, np.zeros_like(v), self.scale).max()
        if violation > max(SETTLED, reaction_round_off(self.kappa, u, self.scale)):
            return None
        last = layout.by_node(v - self.u[slips])
        last = np.where((self.contact == OPEN)[:, None], 0.0, last)
        twice = layout.by_node(self.reaction[slips] + q)
        work = self.work - (last * (0.5 * twice)).sum(axis=1)
        slip = self.slip + self.law.size(last.ravel())
        return Rest(u, self.contact.copy(), self._friction(work, last, twice), work, slip, self.steps)

    def _is_near(self, u: FloatArray) -> bool:
        """Whether the motion is near displacements, so that these may be its end."""
        way = float(np.abs(u - self.start).max())
        return bool(np.abs(u - self.u).max() <= 1e-3 * way + 1e-12 * self.scale.length)

    def _equilibrium(self) -> FloatArray | None:
        """Displacements in which the present contact states are in equilibrium; None where there are none."""
        raise NotImplementedError

    def _friction(self, work: FloatArray, last: FloatArray, twice: FloatArray) -> float:
        """Friction work in all, of each node, with a last path against a share of twice the reactions."""
        return float(work.sum())


class ViscousMotion(Relaxation):
    """The viscous system of a joint in the plane: implicit steps are followed exactly.

    Parameters
    ----------
    kappa, f
        Contact stiffness (2n, 2n) and friction coefficients (n,).
    u, contact, reaction, load, damping, scale
        As for :class:`Relaxation`.
    precision
        What counts as zero.
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
        super().__init__(kappa, Law(f), u, contact, reaction, load, damping, scale)
        self.precision, self.at_rest = precision, active_set(kappa, f)
        parts = active_set(kappa.copy(), f), rates(len(f)), motion_at_rest(len(f)), empty_record(0, len(f))
        self.run = run_along(*parts, course(np.stack([load, load]), 0, True, precision))

    def _end(self, stiffer: FloatArray, path: FloatArray) -> StepEnd | None:
        run, act, mo = self.run, self.run.active, self.run.motion
        act.kappa[:], act.state[:], mo.u[:], run.course.path[:] = stiffer, self.contact, self.u, path
        if factorize(act) <= 0:
            return None
        begin(mo)
        status = follow_straight(run, 1, EFFORT)
        while status == PAUSED or (
            status == NO_RATES and enumerate_states(act, run.rates, self.precision.rate)
        ):
            status = follow_straight(run, 1, EFFORT)
        if status != DONE or not np.isfinite(mo.u).all():
            return None
        return StepEnd(mo.u.copy(), act.state.copy(), mo.work, mo.slip, mo.dissipation)

    def _equilibrium(self) -> FloatArray | None:
        self.at_rest.state[:] = self.contact
        if factorize(self.at_rest) <= 0:
            return None
        return equilibrium(self.at_rest, self.u, self.load)

    def _friction(self, work: FloatArray, last: FloatArray, twice: FloatArray) -> float:
        return self.friction_work - float(last.ravel() @ twice.ravel()) / 2


def jump_of(
    cycle: float, layout: Layout, kappa: FloatArray, load: FloatArray, before: FloatArray, rest: Rest
) -> Jump:
    """The record of a jump from displacements to a state of rest at this load."""
    (v, w), (v_rest, w_rest) = layout.split(before), layout.split(rest.u)
    released = potential_energy(kappa, load, before) - potential_energy(kappa, load, rest.u)
    took = rest.friction_work, rest.work, rest.slip, rest.steps
    return Jump(cycle, v, w, v_rest, w_rest, rest.contact, released, *took)


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
