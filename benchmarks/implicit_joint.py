"""Load steps of a joint with two tangential directions, each solved at once (implicit Euler).

Newton's method on the projections of the law (Alart and Curnier 1991). With s the slip of a node from where
it touches, w its gap, ρ and c stiffnesses of the node alone, it obeys the law where

    q = Π(q − ρ s)  on the disc of radius f p⁺,    p = p⁺,    p⁺ = max(p − c w, 0).

It begins from sweeps of Gauss–Seidel (:mod:`shakedown.motion.fixed_steps`), and from more of them where it
fails.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import FOUR_DIGITS, NEWTON_ROUNDS, ROUND_OFF, SWEEPS, FloatArray
from shakedown.joint.law import Law, Layout
from shakedown.motion.fixed_steps import contact_nodes, load_steps, places_by_node

CLOSE = 20 * ROUND_OFF  # accepted departure from the law, relative to the force scale
FIRST_SWEEPS = 3  # before Newton's method; twice as many after every failure of it
TURNS = 9  # of sweeps and Newton's method: the last ones take as many sweeps as linear convergence needs
HALVINGS = 8  # of one step of Newton's method


class Steps(NamedTuple):
    """States after load steps.

    Attributes
    ----------
    solved
        How many were solved; one more is given where that is not all.
    residual
        Largest departure from the law, relative to the force scale; of the last step where that failed.
    v, w : (k, 2n), (k, n)
        Slips and gaps after every load step [length].
    slip : (k, 2n)
        Slip in contact in the last part of every load step [length].
    length, work : (k, n)
        Length of the way in contact, and what friction dissipates, in every load step.
    """

    solved: int
    residual: float
    v: FloatArray
    w: FloatArray
    slip: FloatArray
    length: FloatArray
    work: FloatArray


class _Trial(NamedTuple):
    """Displacements that may end a step, and how far they depart from the law.

    Attributes
    ----------
    u, r : (3n,)
        Slips and gaps; reactions.
    touch : (n, 2)
        Where nodes touch.
    x : (n, 2)
        q − ρ s, which a slipping node is against.
    pressed : (n,)
        p − c w; where nodes cannot open, p.
    missed : (3n,)
        What departs from the law, but for the tension of nodes that cannot open [force].
    tension
        The largest of these.
    """

    u: FloatArray
    r: FloatArray
    touch: FloatArray
    x: FloatArray
    pressed: FloatArray
    missed: FloatArray
    tension: float

    @property
    def largest(self) -> float:
        """The largest departure; infinite where it is no number."""
        largest = max(float(np.abs(self.missed).max()), self.tension)
        return largest if np.isfinite(largest) else np.inf


class ImplicitJoint:
    """A joint of n nodes with two tangential directions, ready to be carried through load steps.

    Of each step the state (v, w) after it satisfies, at every node, w ≥ 0, p ≥ 0, w p = 0, |q| ≤ f p and
    q = −f p s/|s| where it slips by s in contact; s counts from the slip before the step, and where the
    node was open from where it touches. Of several such states it is the one that the sweeps reach
    from the state before.

    Parameters
    ----------
    A, B, C : (2n, 2n), (n, 2n), (n, n)
        Contact stiffness, node by node [force/length]. C None: nodes cannot open.
    f : (n,)
        Friction coefficients.
    force
        What "small" is measured against [force]: the largest welded reaction of the scene.

    Attributes
    ----------
    turns
        How often sweeps and Newton's method are tried in a step.

    Examples
    --------
    >>> import numpy as np
    >>> joint = ImplicitJoint(np.eye(2), np.zeros((1, 2)), np.eye(1), np.array([0.5]), 1.0)
    >>> joint.step(np.array([0.6, 0.8]), np.array([1.0])).v
    array([[-0.3, -0.4]])
    """

    def __init__(
        self, A: FloatArray, B: FloatArray, C: FloatArray | None, f: FloatArray, force: float
    ) -> None:
        n = len(B)
        self.layout, self.law = Layout(n, 2), Law(np.array(f, dtype=float), 2)
        self.force, self.turns, self.separable = float(force), TURNS, C is not None
        self.kappa = self.layout.of_blocks(A, B, np.zeros((n, n)) if C is None else C)
        self._at, self._close = places_by_node(self.layout), CLOSE * self.force
        self._nodes = contact_nodes(self.layout, self.kappa, self.law.f, self.separable, force)
        diagonal = np.diag(self.kappa)
        self._rho = _weights(self.layout.by_node(diagonal[self.layout.slips]).mean(axis=1))
        self._c = _weights(diagonal[self.layout.gaps]) if self.separable else self._rho
        nothing = np.zeros(2 * n), np.zeros(n)
        self.begin(*nothing, *nothing)

    @property
    def v(self) -> FloatArray:
        """Present slips (2n,) [length]."""
        return self._u[self.layout.slips].copy()

    @property
    def w(self) -> FloatArray:
        """Present gaps (n,) [length]."""
        return self._u[self.layout.gaps].copy()

    def begin(self, v: FloatArray, w: FloatArray, q_w: FloatArray, p_w: FloatArray) -> None:
        """Put the joint into a state (v, w) under welded reactions (q_w, p_w): where the next step begins."""
        self._u, self._load = self.layout.joined(v, w).astype(float), self.layout.joined(q_w, p_w)
        self._ahead = self.layout.zeros()  # displacement that the next step is expected to add

    def forget(self) -> None:
        """Count the slip of the next step from v = 0, all nodes closed; it is still expected to end here."""
        self._ahead, self._u = self._u, self.layout.zeros()

    def step(self, q_w: FloatArray, p_w: FloatArray) -> Steps:
        """Carry the joint through one load step (2n,), (n,)."""
        return self.follow(q_w[None], p_w[None])

    def follow(self, q_w: FloatArray, p_w: FloatArray, parts: int = 1) -> Steps:
        """Carry the joint through load steps (k, 2n), (k, n), each in equal parts, up to one not solved."""
        layout, loads, worst, solved = self.layout, self.layout.joined(q_w, p_w), 0.0, 0
        v, w, slips, lengths, works = (np.zeros((len(loads), size * layout.n)) for size in (2, 1, 2, 1, 1))
        for k, load in enumerate(loads):
            before, worst = self._load, worst if worst <= self._close else 0.0
            for part in range(1, parts + 1):
                end = self._solved(load if part == parts else before + part / parts * (load - before))
                (v[k], w[k]), slips[k] = layout.split(end.u), self._slip(end)
                lengths[k] += self.law.size(slips[k])
                works[k] -= (layout.by_node(end.r[layout.slips]) * layout.by_node(slips[k])).sum(axis=1)
                self._u, self._ahead = end.u, layout.joined(slips[k], np.zeros(layout.n))
                if not end.largest <= self._close:
                    rows = slice(k + 1)
                    return Steps(
                        k, end.largest / self.force, v[rows], w[rows], slips[rows], lengths[rows], works[rows]
                    )
                worst = max(worst, end.largest)
            self._load, solved = load, k + 1
        return Steps(solved, worst / self.force, v, w, slips, lengths, works)

    def _solved(self, load: FloatArray) -> _Trial:
        """The end of a step to a load, or what is nearest to one where it is not solved."""
        start, sweeps = self._u, FIRST_SWEEPS
        if self._ahead.any():
            found = self._newton(start + self._ahead, start, load)
            if found.largest <= self._close:
                return found
        for _ in range(self.turns):
            found = self._newton(self._swept(start, load, sweeps), start, load)
            if found.largest <= self._close:
                break
            sweeps = min(2 * sweeps, SWEEPS)
        return found

    def _swept(self, start: FloatArray, load: FloatArray, sweeps: int) -> FloatArray:
        """Where some sweeps lead."""
        u, loads, slips = start[self._at], load[self._at][None], np.empty((1, self.layout.slip_size))
        load_steps(self._nodes, loads, u, 0.0, sweeps, np.empty_like(loads), slips)
        after = np.empty_like(start)
        after[self._at] = u
        return after

    def _newton(self, u: FloatArray, start: FloatArray, load: FloatArray) -> _Trial:
        """Newton's method from displacements, with a line search, until the law holds or it fails."""
        now = self._trial(u, start, load)
        for _ in range(NEWTON_ROUNDS):
            if now.largest <= self._close:
                break
            try:
                change = self._change(now, start)
            except np.linalg.LinAlgError:
                break
            before, share = now, 1.0
            for _ in range(HALVINGS):
                now = self._trial(before.u + share * change, start, load)
                if now.missed @ now.missed <= (1.0 - FOUR_DIGITS * share) * (before.missed @ before.missed):
                    break
                share *= 0.5
            else:
                return before
        return now

    def _trial(self, u: FloatArray, start: FloatArray, load: FloatArray) -> _Trial:
        """What departs from the law at displacements, after a step from a start."""
        layout, r = self.layout, load + self.kappa @ u
        (q, p), (v, w) = layout.split(r), layout.split(u)
        touch, landing = layout.by_node(start[layout.slips].copy()), np.flatnonzero(start[layout.gaps] > 0.0)
        if landing.size:
            touch[landing] = self._touch(landing, u, r, start)[0]
        x = layout.by_node(q) - self._rho[:, None] * (layout.by_node(v) - touch)
        pressed = p - self._c * w if self.separable else p
        missed_q = q - self.law.projection(x.ravel(), np.maximum(pressed, 0.0))
        missed_p = p - np.maximum(pressed, 0.0) if self.separable else np.zeros_like(p)
        tension = 0.0 if self.separable else -float(p.min())
        return _Trial(u, r, touch, x, pressed, layout.joined(missed_q, missed_p), tension)

    def _slip(self, end: _Trial) -> FloatArray:
        """Slip in contact at the end of a step, (2n,)."""
        slips = self.law.size(end.x.ravel()) > self.law.f * np.maximum(end.pressed, 0.0)
        moves = slips & (end.u[self.layout.gaps] <= 0.0)
        slip = self.layout.by_node(end.u[self.layout.slips]) - end.touch
        return np.where(moves[:, None], slip, 0.0).ravel()

    def _touch(
        self, nodes: NDArray[np.intp], u: FloatArray, r: FloatArray, start: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Where nodes that were open touch (m, 2), and how that follows all displacements (m, 2, 3n).

        As in :func:`shakedown.motion.fixed_steps.find_contact`: on the way to where they would be free of
        reactions, at the share of it at which the gap closes.
        """
        places = np.column_stack([self.layout.slips_of(nodes).reshape(-1, 2), self.layout.gaps_of(nodes)])
        P, old = self._nodes.flexibility[nodes], start[places]
        free = u[places] - np.einsum("mab,mb->ma", P, r[places])
        follows = np.eye(len(u))[places] - P @ self.kappa[places]
        gap, way = free[:, 2], free[:, :2] - old[:, :2]
        share = old[:, 2] / (old[:, 2] - np.minimum(gap, 0.0))
        grows = np.where(gap < 0.0, share**2 / old[:, 2], 0.0)
        of_gap = (grows[:, None] * way)[:, :, None] * follows[:, 2:]
        return old[:, :2] + share[:, None] * way, share[:, None, None] * follows[:, :2] + of_gap

    def _change(self, now: _Trial, start: FloatArray) -> FloatArray:
        """The step of Newton's method: nodes that stick go where they touch, the others solve equations."""
        layout, landing = self.layout, start[self.layout.gaps] > 0.0
        size = self.law.size(now.x.ravel())
        limit, closed = self.law.f * np.maximum(now.pressed, 0.0), (now.pressed > 0.0) | (not self.separable)
        slips = size > limit
        change = -now.missed / layout.joined(np.repeat(self._rho, 2), self._c)
        nodes = np.flatnonzero(slips | ~closed | landing)
        if not nodes.size:
            return change
        m, places = len(nodes), layout.of_nodes(nodes)
        of_slips, of_gaps = places[: 2 * m].reshape(m, 2), places[2 * m :]
        stick = np.eye(layout.size)[of_slips]
        if landing.any():
            at = np.flatnonzero(landing)
            stick[np.searchsorted(nodes, at)] -= self._touch(at, now.u, now.r, start)[1]
        stick *= self._rho[nodes][:, None, None]
        close = self._c[nodes][:, None] * np.eye(layout.size)[of_gaps]
        dq, dp = self.kappa[of_slips], self.kappa[of_gaps]
        reach = np.where(size > 0.0, size, 1.0)[nodes]
        unit, turns = now.x[nodes] / reach[:, None], (limit[nodes] / reach)[:, None, None]
        presses = (dp - close) if self.separable else dp
        narrows = np.where(now.pressed > 0.0, self.law.f, 0.0)[nodes][:, None] * presses
        across = turns * (np.eye(2) - unit[:, :, None] * unit[:, None, :])
        slide = dq - across @ (dq - stick) - unit[:, :, None] * narrows[:, None, :]
        of_q = np.where(slips[nodes][:, None, None], slide, stick).reshape(2 * m, -1)
        rows = np.concatenate([of_q, np.where(closed[nodes][:, None], close, dp)])
        rest = np.setdiff1d(np.arange(layout.size), places)
        missing = -now.missed[places] - rows[:, rest] @ change[rest]
        change[places] = np.linalg.solve(rows[:, places], missing)
        change[layout.gaps] = np.where(closed, -now.u[layout.gaps], change[layout.gaps])  # closed exactly
        return change


def _weights(diagonal: FloatArray) -> FloatArray:
    """Stiffnesses of the nodes, and where one has none the largest of all."""
    largest = float(diagonal.max())
    return np.where(diagonal > 1e-12 * largest, diagonal, largest if largest > 0 else 1.0)
