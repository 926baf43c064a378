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
rest before the others. A motion without an end tends to a rigid one, which
is solved for as well (:mod:`.steady_slide`).

Of the implicit steps of a jump only its path counts, not how fast it is passed.

A jump leaves a state that is all but in equilibrium: slowly at first, then at speeds that grow like a power
of the way, or exponentially. An implicit step is accepted where it is straight enough, and aims at the
farthest of a fixed sequence of distances that the speeds so far let it reach. So it hardly matters where a
motion began, whether it was put out of balance by 1e-9 or by 2e-9: its steps soon end at the same places,
and a jump that comes again in every cycle repeats.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from math import floor, inf, log, sqrt
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import NEGLIGIBLE, PER_CENT, SETTLED, SIX_DIGITS, FloatArray
from shakedown.ground.status import OPEN
from shakedown.ground.work_limit import BY_BLAS, count_work, work_is_left
from shakedown.joint.result import Result
from shakedown.motion.checked_law import law_violation, reaction_round_off
from shakedown.motion.course import DONE, EFFORT, PAUSED, Precision, course
from shakedown.motion.plane.active_set import active_set, factorize, rates, solve
from shakedown.motion.plane.event_loop import follow_straight
from shakedown.motion.plane.moving_state import PlaneRun, begin, empty_record, motion_at_rest
from shakedown.motion.steady_slide import HOLDS, ViscousJoint, steady_slide

ACCURACY = 0.01  # accepted departure of a step from a straight path, relative to the motion so far
CHANGING = 0.4  # length of a step in which nodes change their contact states, relative to the motion so far
RUNG = 1.5  # ratio of the distances aimed at; speeds like the third power of the way let a step reach that
FASTER = 4.0  # how much faster the motion is expected to be at the end of a step, at most
LONGER = 5.0  # how much longer a step lasts than the one before, at most
AIMED = 0.8  # of the length at which a step would be just straight enough


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

    def shorten(self, factor: float = 0.5) -> None:
        """Try the step again, shorter."""
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
            self.shorten(AIMED / sqrt(bend))
            return False
        if self.passed and changes and way > CHANGING * motion:
            self.shorten()
            return False
        before = self.passed[-1][0] if self.passed else 0.0
        self.passed = [*self.passed[-2:], (before + way, speed)]
        self.duration = self._next(way, motion, AIMED * way / sqrt(bend) if bend > 0.0 else inf)
        return True

    def _next(self, last: float, motion: float, straight: float) -> float:
        """The duration in which the next step will end where it is to end; longer where none is seen."""
        if last <= SETTLED * self.size:  # speeds are round-off
            self.idle += 1
            return LONGER * self.duration
        longest, way = LONGER * self.duration, 0.0
        rung = floor(log(motion / self.length) / log(RUNG) + 0.5)
        while True:
            rung += 1
            further = self.length * RUNG**rung - motion
            speed = self._speed_after(further)
            reached = 0.0 < speed <= FASTER * self.passed[-1][1] and further <= longest * speed
            if way and not (reached and further <= straight):
                break
            way = further
            if not reached:
                break
        way = min(way, straight)
        speed = self._speed_after(way)
        return min(way / speed, longest) if speed > 0.0 else longest

    def _speed_after(self, further: float) -> float:
        """The speed to expect after a further way, on a parabola where speeds grow faster and faster."""
        ways, speeds = np.transpose(self.passed)
        if len(ways) == 1 or not np.diff(ways).all():
            return float(speeds[-1])
        slopes = np.diff(speeds) / np.diff(ways)
        curve = max(slopes[-1] - slopes[0], 0.0) / (ways[-1] - ways[0]) if slopes[-1] > 0.0 else 0.0
        return float(speeds[-1] + further * (slopes[-1] + curve * (further + ways[-1] - ways[-2])))


MAX_STEPS = 2000
MOST_IDLE = 16  # of these within round-off of where they begin: it stands between states that do not last
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
    """

    endless = False

    def __init__(
        self, joint: ViscousJoint, u: FloatArray, contact: NDArray[np.int64], reaction: FloatArray
    ) -> None:
        self.joint = joint
        self.kappa, self.law, self.load, self.damping, scale = joint
        self.scale, self.layout = scale, self.law.layout
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
        return steady_slide(self.joint, self.u, self.velocity, self.contact) is not None

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
        if not lengths.accepts(fastest * dt, fastest, motion, turn, changes):
            return False
        change = float(np.abs(velocity - self.velocity).max())
        self.slows_down = self.steps == 0 or fastest <= (1.0 - PER_CENT) * before or fastest == 0.0
        self.turned = change / fastest if fastest > 0.0 else np.inf
        self.u, self.velocity, self.contact = end.u, velocity, end.contact
        self.reaction = path[1] + stiffer @ end.u
        self.work += end.work
        self.slip += end.slip
        return True

    @abstractmethod
    def _end(self, stiffer: FloatArray, path: FloatArray) -> StepEnd | None:
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
    """The viscous system of a joint in the plane: implicit steps are followed exactly.

    Parameters
    ----------
    joint, u, contact, reaction
        As for :class:`Relaxation`.
    precision
        What counts as zero.
    """

    def __init__(
        self,
        joint: ViscousJoint,
        u: FloatArray,
        contact: NDArray[np.int64],
        reaction: FloatArray,
        precision: Precision,
    ) -> None:
        super().__init__(joint, u, contact, reaction)
        kappa, f, n = self.kappa, self.law.f, self.layout.n
        self.at_rest = active_set(kappa, f)
        self.run = PlaneRun(
            {},
            active=active_set(kappa.copy(), f),
            rates=rates(n),
            motion=motion_at_rest(n),
            record=empty_record(0, n),
            course=course(np.stack([self.load, self.load]), 0, True, precision),
        )

    def _end(self, stiffer: FloatArray, path: FloatArray) -> StepEnd | None:
        run, act, mo = self.run, self.run.active, self.run.motion
        act.kappa[:], act.state[:], mo.u[:], run.course.path[:] = stiffer, self.contact, self.u, path
        if factorize(act) <= 0:
            return None
        begin(mo)
        status = PAUSED
        while status == PAUSED:
            status = follow_straight(run, 1, EFFORT)
        if status != DONE or not np.isfinite(mo.u).all():
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
