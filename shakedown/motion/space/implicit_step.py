"""Load steps of a joint with two tangential directions, each solved at once (implicit Euler)."""

from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import ROUND_OFF
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.layout import Layout
from shakedown.motion.space.dense_solver import no_factors
from shakedown.motion.space.load_steps import follow_load_steps
from shakedown.motion.space.swept_stiffness import Body, Tableau

CLOSE = 20 * ROUND_OFF  # residual of Newton's method, relative to the force scale
TENSION = 16 * np.finfo(float).eps  # a closed node's p may be negative by that, relative to the force scale
MOST_SWEEPS = 10_000
TURNS = 60  # alternations of sweeps and Newton's method in a step
WANDERING = 50  # sweeps that show whether a body that found no rest keeps moving


class StepStatus(IntEnum):
    """How a load step ended."""

    SOLVED = 0
    UNSOLVED = 1
    LIFTS_OFF = 2
    SLIDES_AWAY = 3


class Steps(NamedTuple):
    """States after load steps.

    Attributes
    ----------
    status
        Of the last of them: the others are solved.
    solved
        How many were solved.
    node
        A node that found no state, where one was not solved; −1 where it is none alone.
    residual
        Largest departure from the law, relative to the force scale; of the last step where that failed.
    v, w : (k, 2n), (k, n)
        Slips and gaps after every load step [length].
    slip : (k, 2n)
        Slip in contact in the last part of every load step [length].
    length, work : (k, n)
        Length of the way in contact, and what friction dissipates, in every load step.
    sweeps, newton_steps
        Work in all.
    """

    status: StepStatus
    solved: int
    node: int
    residual: float
    v: FloatArray
    w: FloatArray
    slip: FloatArray
    length: FloatArray
    work: FloatArray
    sweeps: int
    newton_steps: int

    @classmethod
    def none(cls, layout: Layout) -> "Steps":
        """No load steps of these nodes."""
        slips, nodes = np.zeros((0, layout.slip_size)), np.zeros((0, layout.n))
        return cls(StepStatus.SOLVED, 0, -1, 0.0, slips, nodes, slips, nodes, nodes, 0, 0)

    @classmethod
    def joined(cls, pieces: "Sequence[Steps]") -> "Steps":
        """One after the other; all but the last are solved."""
        *_, last = pieces
        v, w, slip, length, work = (np.concatenate([piece[at] for piece in pieces]) for at in range(4, 9))
        return cls(
            last.status, sum(piece.solved for piece in pieces), last.node,
            max(piece.residual for piece in pieces), v, w, slip, length, work,
            sum(piece.sweeps for piece in pieces), sum(piece.newton_steps for piece in pieces),
        )  # fmt: skip


class ImplicitJoint:
    """A joint of n nodes with two tangential directions, ready to be carried through load steps.

    Of each step the state (v, w) after it satisfies, at every node, w ≥ 0, p ≥ 0, w p = 0, |q| ≤ f p and
    q = −f p s/|s| where it slips by s in contact; s counts from the slip before the step, and where the
    node was open from where it touches. Of several such states it is the one that the sweeps reach
    from the state before. What is open stays eliminated from step to step.

    Parameters
    ----------
    A, B, C : (2n, 2n), (n, 2n), (n, n)
        Contact stiffness, node by node [force/length]. C None: nodes cannot open.
    f : (n,)
        Friction coefficients.
    force
        What "small" is measured against [force]: the largest welded reaction of the scene.
    tolerances
        ``zero_mode`` says which motion meets no resistance.

    Examples
    --------
    >>> import numpy as np
    >>> joint = ImplicitJoint(np.eye(2), np.zeros((1, 2)), np.eye(1), np.array([0.5]), 1.0)
    >>> joint.step(np.array([0.6, 0.8]), np.array([1.0])).v
    array([[-0.3, -0.4]])
    """

    def __init__(
        self,
        A: FloatArray,
        B: FloatArray,
        C: FloatArray | None,
        f: FloatArray,
        force: float,
        tolerances: Tolerances = DEFAULT,
    ) -> None:
        n = len(B)
        self.n, self.force, self._tolerances = n, float(force), tolerances
        self.turns = TURNS
        self._places = np.column_stack([np.arange(0, 2 * n, 2), np.arange(1, 2 * n, 2), 2 * n + np.arange(n)])
        normal = np.zeros((n, n)) if C is None else C
        kappa = np.block([[A, B.T], [B, normal]])
        own = self._places.ravel()
        kappa = np.ascontiguousarray(kappa[np.ix_(own, own)])
        blocks = kappa.reshape(n, 3, n, 3)[np.arange(n), :, np.arange(n)]
        tangential = _weights(0.5 * (blocks[:, 0, 0] + blocks[:, 1, 1]))
        stiff = _weights(blocks[:, 2, 2]) if C is not None else tangential.copy()
        self._body = Body(
            kappa, np.array(f, dtype=float), tangential, stiff, _determinants(blocks), C is not None
        )
        self._tableau = Tableau(
            kappa.copy(), np.zeros(n, dtype=np.bool_), np.zeros(3 * n), np.zeros(3 * n), np.zeros(3 * n),
            np.zeros(2, dtype=np.int64),
        )  # fmt: skip
        self._factors = no_factors(n)
        self._state, self._slips = np.zeros(3 * n), np.zeros(2 * n)

    @property
    def without_friction(self) -> NDArray[np.bool_]:
        """Which nodes have no friction, (n,)."""
        return np.asarray(self._body.f == 0.0)

    @property
    def v(self) -> FloatArray:
        """Present slips (2n,) [length]."""
        return self._state.reshape(-1, 3)[:, :2].flatten()  # for one node ravel would be a view

    @property
    def w(self) -> FloatArray:
        """Present gaps (n,) [length]."""
        return self._state[2::3].copy()

    def begin(self, v: FloatArray, w: FloatArray, q_w: FloatArray, p_w: FloatArray) -> None:
        """Put the joint into a state (v, w) under welded reactions (q_w, p_w): where the next step begins."""
        tableau = self._tableau
        self._state[:] = self._by_node(v, w)
        tableau.N[:] = self._body.kappa
        tableau.is_open[:] = False
        tableau.updates[0], tableau.updates[1] = 0, tableau.updates[1] + 1
        tableau.given[:] = self._state
        np.dot(tableau.N, tableau.given, out=tableau.out)
        self._slips[:] = 0.0
        tableau.r_w[:] = self._by_node(q_w, p_w)

    def forget(self) -> None:
        """Count the slip of the next step from v = 0; its initial state is unchanged."""
        self._state[:] = 0.0

    def follow(self, q_w: FloatArray, p_w: FloatArray, parts: int = 1, *, sweeps_only: bool = False) -> Steps:
        """Carry the joint through load steps (k, 2n), (k, n), each in equal parts."""
        n, k = self.n, len(q_w)
        path, (failed, node, missed, sweeps, steps) = self._run(
            np.ascontiguousarray(self._by_node(q_w, p_w)), parts, MOST_SWEEPS if sweeps_only else 0
        )
        solved, status = k, StepStatus.SOLVED
        if failed >= 0:
            solved, status = failed, self._failure()
        u, slip, length, work = (part[: solved + (failed >= 0)] for part in path)
        return Steps(
            status, solved, node, missed / self.force, u.reshape(-1, n, 3)[:, :, :2].reshape(-1, 2 * n),
            u[:, 2::3], slip, length, work, sweeps, steps,
        )  # fmt: skip

    def step(self, q_w: FloatArray, p_w: FloatArray) -> Steps:
        """Carry the joint through one load step (2n,), (n,)."""
        return self.follow(q_w[None], p_w[None])

    def _run(
        self, loads: FloatArray, parts: int, sweeps_only: int
    ) -> tuple[tuple[FloatArray, ...], tuple[int, int, float, int, int]]:
        """Run the compiled loop over load steps (k, 3n), node by node; returns what it fills and returns."""
        n, k = self.n, len(loads)
        path = np.empty((k, 3 * n)), np.empty((k, 2 * n)), np.empty((k, n)), np.empty((k, n))
        settings = (CLOSE * self.force, TENSION * self.force, self.turns, self._factors)
        return path, follow_load_steps(
            self._body, self._tableau, self._state, self._slips, loads, parts, settings, sweeps_only, path
        )

    def _by_node(self, tangential: FloatArray, normal: FloatArray) -> FloatArray:
        both = np.concatenate([tangential, normal], axis=-1)
        return both[..., self._places.ravel()]

    def _failure(self) -> StepStatus:
        """Why a step was not solved: a node tends to open, the body keeps moving, or no state was found."""
        r = self._tableau.r_w + self._body.kappa @ self._state
        if not self._body.separable and r[2::3].min() < -TENSION * self.force:
            return StepStatus.LIFTS_OFF
        self._wander()
        way = self._wander()
        stiffest = np.abs(np.diag(self._body.kappa)).max()
        held = way @ self._body.kappa @ way > self._tolerances.zero_mode * stiffest * (way @ way)
        goes_on = stiffest * np.abs(way).max() > self.force
        return StepStatus.SLIDES_AWAY if goes_on and not held else StepStatus.UNSOLVED

    def _wander(self) -> FloatArray:
        """The displacement of some more sweeps, (3n,): it repeats where nothing holds the body."""
        load, start = self._tableau.r_w.copy()[None], self._state.copy()
        self._run(load, 1, WANDERING)
        return self._state - start


def _weights(diagonal: FloatArray) -> FloatArray:
    """Stiffnesses of the nodes, and where one has none the largest of all."""
    largest = float(diagonal.max())
    return np.where(diagonal > 1e-12 * largest, diagonal, largest if largest > 0 else 1.0)


def _determinants(blocks: FloatArray) -> FloatArray:
    """The upper limit of the determinant of a block: the product of its diagonal."""
    return np.asarray(np.diagonal(blocks, axis1=1, axis2=2).prod(axis=1))
