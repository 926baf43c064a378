"""Jumps: where the quasi-static evolution has no solution, a viscous system determines the next state.

Above a friction threshold the rate problem can lose its solution (chapter VI).
The state then moves at constant load, as a system D u̇ = −(out-of-balance) does
(thesis §6.3), until it is in equilibrium again. Implicit steps Δt of it are
static problems with the stiffness κ + D/Δt, and each of them is solved by
the exact evolution of that stiffer system, from the reactions of the step before to
those that the viscous system has at the end of the step. Steps adapt: they are
halved where the stiffer system is itself above a threshold (an implicit step
that long would step over the instability) and shortened where the path turns
(:class:`StepLengths`), and they grow without limit as the motion dies out. The end state is then solved for
exactly from its contact states; it depends on D only through nodes that come to
rest before the others.

A motion that has an end loses its velocity. One that has none tends to a *steady slide*, a velocity V that
changes no reaction, κ V = 0: all reactions are constant then, with those of damping they satisfy the law, and
so they do for ever. Whether there is such a slide next to a motion, and whether motions beside it approach
it, is solved for instead of waited for.

Of the implicit steps of a jump only its path counts, not how fast it is passed.
A jump leaves a state that is all but in equilibrium: slowly at first, then at speeds that grow like a power
of the way, or exponentially. An implicit step is accepted where it is straight enough, and aims at the
farthest of a fixed sequence of distances that the speeds so far let it reach. So it hardly matters where a
motion began, whether it was put out of balance by 1e-9 or by 2e-9: its steps soon end at the same places,
and a jump that comes again in every cycle repeats.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from functools import cached_property
from math import floor, inf, log, sqrt
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from shakedown.ground.constants import (
    CONVERGED,
    MINOR,
    NEGLIGIBLE,
    NEWTON_ROUNDS,
    ROUND_OFF,
    SIX_DIGITS,
    FloatArray,
)
from shakedown.ground.status import OPEN, STICK
from shakedown.ground.tolerances import DEFAULT
from shakedown.ground.work_limit import BY_BLAS, count_work, work_is_left
from shakedown.joint.law import Law
from shakedown.joint.result import Result
from shakedown.motion.checked_law import Scales, law_violation, reaction_round_off
from shakedown.motion.course import CALL_OPERATIONS, Course, LoopEnd, course
from shakedown.motion.plane.active_set import ActiveSet, active_set, factorize, rates, solve
from shakedown.motion.plane.event_loop import follow_straight
from shakedown.motion.plane.moving_state import PlaneRun, begin, empty_record, motion_at_rest

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


def steady_slide(
    joint: ViscousJoint, u: FloatArray, velocity: FloatArray, contact: NDArray[np.int64]
) -> tuple[FloatArray, FloatArray] | None:
    """The slide that a motion with this state tends to, u and V; None where there is none near.

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
    >>> steady_slide(joint, np.zeros(2), np.array([-1.499, 0.0]), np.array([-1]))[1]
    array([-1.5,  0. ])

    Nothing holds it for ever where a load pulls it away while it is open; one that presses it closes it, and
    none slides on under tension:

    >>> for p, contact in ((-1.0, 2), (1.0, 2), (-1.0, -1)):
    ...     pulled = joint._replace(kappa=np.zeros((2, 2)), load=np.array([2.0, p]))
    ...     gap, opening = (1.0, -p) if contact == 2 else (0.0, 0.0)
    ...     slide = steady_slide(pulled, np.array([0.0, gap]), np.array([-2.0, opening]), np.array([contact]))
    ...     print(slide is not None)
    True
    False
    False
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
    found = equations.velocity(speeds)
    near = np.abs(found - velocity).max() <= MINOR * np.abs(velocity).max()
    held = near and _holds(joint, u, found, contact) and equations.attracts(u, speeds)
    return (u, found) if held else None


def _holds(joint: ViscousJoint, u: FloatArray, velocity: FloatArray, contact: NDArray[np.int64]) -> bool:
    """Whether the law is satisfied at every node, now and for ever."""
    layout, way = joint.law.layout, velocity / np.abs(velocity).max()
    q, p = layout.split(joint.load + joint.kappa @ u + joint.damping * velocity)
    slip, opening = layout.split(way)
    slip = np.where(np.repeat(contact == OPEN, layout.d), 0.0, slip) * joint.scale.length / SIX_DIGITS
    violation = law_violation(joint.law.f, q, p, u[layout.gaps], slip, joint.scale)
    most = max(HOLDS, reaction_round_off(joint.kappa, u, joint.scale))
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


ACCURACY = 0.01  # accepted departure of a step from a straight path, relative to the motion so far
DISTANCE_RATIO = 1.5  # of successive distances: one step each where speeds grow with the cube of the distance
LARGEST_GROWTH = 5.0  # how much longer a step lasts than the one before, at most
SAFETY = 0.8  # of the length at which a step would be just straight enough


@dataclass
class StepLengths:
    """The duration of the next step of a motion.

    Attributes
    ----------
    length
        Scale of the scene [length].
    duration
        Of the next step.
    size
        Of displacements [length].
    idle
        How many steps have moved no more than their round-off.
    passed
        Ways at the ends of the last steps, three at most, with the speeds there.
    """

    length: float
    duration: float
    size: float
    idle: int = 0
    passed: list[tuple[float, float]] = field(default_factory=list)

    def shorten(self, factor: float = inf) -> None:
        """Try the step again, shorter: at most half as long."""
        self.duration *= min(max(0.1, factor), 0.5)

    def accepts(self, way: float, speed: float, motion: float, turn: float, changes: bool) -> bool:
        """Whether a step is straight enough; sets the duration of the next, or of a shorter one instead.

        Parameters
        ----------
        way, speed
            Its length [length], and that per duration.
        motion
            How far it ends from the beginning of the motion [length].
        turn
            By how much its direction differs from that of the step before.
        changes
            Whether a node has changed its contact state.
        """
        bend = turn * way / (ACCURACY * motion)  # how far from straight, relative to what is accepted
        if self.passed and bend > 1.0:
            self.shorten(SAFETY / sqrt(bend))
            return False
        # length of a step in which nodes change their contact states, relative to the motion so far
        if self.passed and changes and way > 0.4 * motion:
            self.shorten()
            return False
        before = self.passed[-1][0] if self.passed else 0.0
        self.passed = [*self.passed[-2:], (before + way, speed)]
        self.duration = self._next(way, motion, SAFETY * way / sqrt(bend) if bend > 0.0 else inf)
        return True

    def _next(self, last: float, motion: float, straight: float) -> float:
        """The duration in which the next step will end where it is to end; longer where none is seen."""
        if last <= CONVERGED * self.size:  # speeds are round-off
            self.idle += 1
            return LARGEST_GROWTH * self.duration
        longest, way = LARGEST_GROWTH * self.duration, 0.0
        level = floor(log(motion / self.length) / log(DISTANCE_RATIO) + 0.5)
        while True:
            level += 1
            further = self.length * DISTANCE_RATIO**level - motion
            speed = self._speed_after(further)
            # how much faster the motion is expected to be at the end of a step, at most
            reached = 0.0 < speed <= 4.0 * self.passed[-1][1] and further <= longest * speed
            if way and not (reached and further <= straight):
                break
            way = further
            if not reached:
                break
        way = min(way, straight)
        speed = self._speed_after(way)
        return min(way / speed, longest) if speed > 0.0 else longest

    def _speed_after(self, further: float) -> float:
        """The speed to expect after a further distance, on a parabola where speeds grow faster and faster."""
        distances, speeds = np.transpose(self.passed)
        if len(distances) == 1 or not np.diff(distances).all():
            return float(speeds[-1])
        slopes = np.diff(speeds) / np.diff(distances)
        curve = max(slopes[-1] - slopes[0], 0.0) / (distances[-1] - distances[0]) if slopes[-1] > 0.0 else 0.0
        return float(speeds[-1] + further * (slopes[-1] + curve * (further + distances[-1] - distances[-2])))


FAR = 1 / SIX_DIGITS  # motion beyond which a body slides away, relative to its scale and earlier slips


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
    work : (n,)
        What friction dissipates along the path of the implicit steps [force × length].
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
    work: FloatArray
    slip: FloatArray
    steps: int

    @property
    def friction_work(self) -> float:
        """The part of the released energy that friction dissipates [force × length]."""
        return float(self.work.sum())

    @property
    def damping_work(self) -> float:
        """The part of the released energy that damping dissipates [force × length]."""
        return self.energy_released - self.friction_work


class StepEnd(NamedTuple):
    """Where an implicit step ends, or the whole motion.

    Displacements u = (v, w), contact states, and from its beginning on the friction work of each node (n,)
    [force × length] and its slip in contact (n,) [length].
    """

    u: FloatArray
    contact: NDArray[np.int64]
    work: FloatArray
    slip: FloatArray


class Relaxation(ABC):
    """The viscous system at constant load, from a state put out of balance by a small change of load.

    It is carried to rest by implicit steps of increasing length.

    Parameters
    ----------
    joint
        The joint, its damping, and the welded reactions from now on.
    u, contact, reaction
        State before: displacements, contact states (n,), reactions that satisfy the law.
    precise
        A course that says what counts as zero.
    """

    endless = False

    def __init__(
        self,
        joint: ViscousJoint,
        u: FloatArray,
        contact: NDArray[np.int64],
        reaction: FloatArray,
        precise: Course,
    ) -> None:
        self.joint = joint
        self.kappa, self.law, self.load, self.damping, scale = joint
        self.scale, self.layout = scale, self.law.layout
        self.course = course(np.stack([self.load, self.load]), 0, True, precise.with_parts())
        self.start, self.u, self.contact, self.reaction = u.copy(), u.copy(), contact.copy(), reaction.copy()
        self.velocity, self.steps = np.zeros_like(u), 0
        self.work, self.slip = np.zeros(self.layout.n), np.zeros(self.layout.n)
        self.turned = np.inf  # change of the velocity in the last step, relative
        self.slows_down = True  # in the last step
        self.asked_at = scale.length  # how far it has moved beyond which a slide for ever is looked for

    def to_rest(self) -> StepEnd | None:
        """Follow the motion to its end; None where it has none, ``endless`` where it goes on for ever."""
        fastest = float(np.max(np.diag(self.kappa) / self.damping))
        dt = 0.05 / fastest if fastest > 0 else 1.0  # without stiffness there is no time scale
        shortest = 1e-9 * dt
        far = FAR * self.scale.length + FAR * np.abs(self.start).max()
        longest = FAR * FAR * dt
        size = max(self.scale.length, float(np.abs(self.start).max()))
        lengths = StepLengths(self.scale.length, dt, size)
        # idle ones end within round-off of where they begin: it stands between states that do not last
        while self.steps < 2000 and lengths.idle < 16 and shortest < dt < longest and self.moved < far:
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
        if self.moved <= self.asked_at or self.turned > MINOR:
            return False
        self.asked_at = 2.0 * self.moved
        return steady_slide(self.joint, self.u, self.velocity, self.contact) is not None

    def _step(self, lengths: StepLengths) -> bool:
        """One implicit step; False, and nothing changed, where it is too long: the next one is shorter."""
        dt = lengths.duration
        stiffer = self.kappa + np.diag(self.damping / dt)
        path = np.stack([self.reaction - stiffer @ self.u, self.load - self.damping / dt * self.u])
        end = self._step_end(stiffer, path)
        if end is None:
            lengths.shorten()
            return False
        velocity = (end.u - self.u) / dt
        before, fastest = float(np.abs(self.velocity).max()), float(np.abs(velocity).max())
        motion = max(float(np.abs(end.u - self.start).max()), NEGLIGIBLE * self.scale.length)
        goes_on = before > 0.0 and fastest > 0.0
        turn = float(np.abs(velocity / fastest - self.velocity / before).max()) if goes_on else 0.0
        changes = bool((end.contact != self.contact).any())
        if not lengths.accepts(fastest * dt, fastest, motion, turn, changes):
            return False
        change = float(np.abs(velocity - self.velocity).max())
        self.slows_down = self.steps == 0 or fastest <= (1.0 - MINOR) * before or fastest == 0.0
        self.turned = change / fastest if fastest > 0.0 else np.inf
        self.u, self.velocity, self.contact = end.u, velocity, end.contact
        self.reaction = path[1] + stiffer @ end.u
        self.work += end.work
        self.slip += end.slip
        return True

    @abstractmethod
    def _step_end(self, stiffer: FloatArray, path: FloatArray) -> StepEnd | None:
        """The end of the static problem with this stiffness between two welded reactions, if there is one."""

    def _rest(self) -> StepEnd | None:
        """The equilibrium of the present contact states, if it is admissible and the motion is near it."""
        u = self._equilibrium()
        if u is None or not self._is_near(u):
            return None
        layout, slips = self.layout, self.layout.slips
        (v, w), (q, p) = layout.split(u), layout.split(self.load + self.kappa @ u)
        violation = law_violation(self.law.f, q, p, w, np.zeros_like(v), self.scale).max()
        if violation > max(HOLDS, reaction_round_off(self.kappa, u, self.scale)):
            return None
        last = layout.by_node(v - self.u[slips])
        last = np.where((self.contact == OPEN)[:, None], 0.0, last)
        twice = layout.by_node(self.reaction[slips] + q)
        work = self.work - (last * (0.5 * twice)).sum(axis=1)
        slip = self.slip + self.law.size(last.ravel())
        return StepEnd(u, self.contact.copy(), work, slip)

    def _is_near(self, u: FloatArray) -> bool:
        """Whether the motion is near displacements, so that these may be its end."""
        way = float(np.abs(u - self.start).max())
        return bool(np.abs(u - self.u).max() <= 1e-3 * way + 1e-12 * self.scale.length)

    def jump_to(self, rest: StepEnd, cycle: float) -> Jump:
        """The record of the jump that has come to this state of rest."""
        before, after = self.layout.split(self.start), self.layout.split(rest.u)
        middle = self.load + 0.5 * (self.kappa @ (self.start + rest.u))
        released = float(middle @ (self.start - rest.u))
        return Jump(cycle, *before, *after, rest.contact, released, rest.work, rest.slip, self.steps)

    @abstractmethod
    def _equilibrium(self) -> FloatArray | None:
        """Displacements in which the present contact states are in equilibrium; None where there are none."""


class ViscousMotion(Relaxation):
    """The viscous system of a joint in the plane: implicit steps are followed exactly."""

    @cached_property
    def at_rest(self) -> ActiveSet:
        """The equations of the nodes that move, at rest."""
        return active_set(self.kappa, self.law.f)

    @cached_property
    def run(self) -> PlaneRun:
        """What follows an implicit step, of a stiffness that it gets."""
        n = self.layout.n
        return PlaneRun(
            {},
            active=active_set(self.kappa.copy(), self.law.f),
            rates=rates(n),
            motion=motion_at_rest(n),
            record=empty_record(0, n),
            course=self.course,
        )

    def _step_end(self, stiffer: FloatArray, path: FloatArray) -> StepEnd | None:
        run, act, mo = self.run, self.run.active, self.run.motion
        act.kappa[:], act.state[:], mo.u[:], run.course.path[:] = stiffer, self.contact, self.u, path
        if factorize(act) <= 0:
            return None
        begin(mo)
        status = LoopEnd.PAUSED
        while status == LoopEnd.PAUSED:
            status = follow_straight(run, 1, CALL_OPERATIONS)
        if status != LoopEnd.DONE or not np.isfinite(mo.u).all():
            return None
        return StepEnd(mo.u.copy(), act.state.copy(), mo.work, mo.slip)

    def _equilibrium(self) -> FloatArray | None:
        self.at_rest.state[:] = self.contact
        if factorize(self.at_rest) <= 0:
            return None
        u, change = self.u.copy(), np.empty_like(self.u)
        for _ in range(3):
            solve(self.at_rest, self.load + self.kappa @ u, change)
            u += change
        u[self.layout.gaps][self.contact != OPEN] = 0.0
        return u


def default_damping(kappa: FloatArray) -> FloatArray:
    """Damping in proportion to the diagonal of κ, (2n,)."""
    diagonal = np.diag(kappa).copy()
    diagonal[diagonal <= 0] = diagonal.max() or 1.0
    return diagonal
