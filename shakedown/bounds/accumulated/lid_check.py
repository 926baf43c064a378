"""The conditions of the theorem, checked on the problem as stored, in floats or without round-off."""

from collections.abc import Callable
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from shakedown.bounds.accumulated.slip_arcs import MARGIN, Arcs, Flags, Lids, Numbers, by_node, crossed
from shakedown.bounds.row_programs import exact_numbers
from shakedown.ground.constants import ROUND_OFF, FloatArray
from shakedown.joint.law import Law
from shakedown.joint.loading import loading, transient_path
from shakedown.joint.problem import Problem

WIDTH = np.pi / 48  # initial width of the pieces of a circle
HALVED = 10  # largest number of bisections where a condition fails at the corners of a piece


class Start(NamedTuple):
    """Where a motion begins: v₀ (dn,), and how far every node may be from there (n,) [length]."""

    slip: FloatArray
    error: FloatArray


def confirmed(
    problem: Problem, start: Start, load_factor: float, arcs: Arcs, lids: Lids, *, exact: bool
) -> bool:
    """Whether the theorem holds from a start at all load factors up to one, with these arcs and lids.

    Of the arcs all is checked, of the lids a and N; ``exact`` in the plane only.
    """
    claim = _Claim(problem, start, load_factor, arcs, lids, exact)
    pieces = _signs(problem.n, arcs) if problem.directions == 1 else _sectors(problem.n, arcs)
    if pieces is None or not claim.slips_end() or not claim.pressed():
        return False
    for _ in range(HALVED):
        pieces = pieces.part(~claim.holds(pieces))
        if not (pieces.high > pieces.low).any():  # no piece is left, or none can be halved
            break
        pieces = pieces.halved()
    return not len(pieces.node)


class _Pieces(NamedTuple):
    """Directions of nodes from one angle to another, in an arc or (−1) in none."""

    node: Numbers
    low: FloatArray
    high: FloatArray
    arc: Numbers

    def corners(self, d: int) -> FloatArray:
        """Whose convex hull holds a piece, (c, 1 or 3, d)."""
        middle, half = 0.5 * (self.low + self.high), 0.5 * (self.high - self.low)
        angles = np.stack([self.low, self.high, middle], axis=1)[:, : 2 * d - 1]
        found = np.stack([np.cos(angles), np.sin(angles)], axis=2)[..., :d]
        found[:, 2:] /= np.cos(half)[:, None, None]
        return found

    def part(self, which: Flags) -> "_Pieces":
        return _Pieces(self.node[which], self.low[which], self.high[which], self.arc[which])

    def halved(self) -> "_Pieces":
        middle = 0.5 * (self.low + self.high)
        low, high = np.append(self.low, middle), np.append(middle, self.high)
        return _Pieces(np.tile(self.node, 2), low, high, np.tile(self.arc, 2))


def _signs(n: int, arcs: Arcs) -> _Pieces:
    """Both directions of every node in the plane."""
    arc = np.full((n, 2), -1)
    arc[arcs.node, (arcs.first[:, 0] < 0).astype(int)] = np.arange(len(arcs))
    angle = np.tile([0.0, np.pi], n)
    return _Pieces(np.repeat(np.arange(n), 2), angle, angle, arc.ravel())


def _sectors(n: int, arcs: Arcs) -> _Pieces | None:
    """The circle of every node, cut at the ends of its arcs; None where these overlap or are half circles."""
    begin = np.arctan2(arcs.first[:, 1], arcs.first[:, 0])
    wide = np.arctan2(crossed(arcs.first, arcs.last), np.sum(arcs.first * arcs.last, axis=1))
    pieces: list[tuple[int, float, float, int]] = []
    for node in range(n):
        mine = np.flatnonzero(arcs.node == node)
        mine = mine[np.argsort(begin[mine])]
        ends = [(begin[k], begin[k] + wide[k], int(k)) for k in mine]
        if not ends:
            ends = [(-np.pi, np.pi, -1)]
        following = [*(low for low, _, _ in ends[1:]), ends[0][0] + 2.0 * np.pi]
        gaps = [(high, low, -1) for (_, high, _), low in zip(ends, following, strict=True)]
        if np.any(wide <= 0.0) or min(low - high for high, low, _ in gaps) < -MARGIN:
            return None
        for low, high, arc in [*ends, *(gap for gap in gaps if gap[1] - gap[0] > MARGIN)]:
            cuts = np.linspace(low, high, int(np.ceil((high - low) / WIDTH)) + 1).tolist()
            pieces += [(node, *cut, arc) for cut in pairwise(cuts)]
    columns = np.array(pieces)
    return _Pieces(columns[:, 0].astype(int), columns[:, 1], columns[:, 2], columns[:, 3].astype(int))


class _Claim:
    """The conditions in one kind of numbers, floats or fractions."""

    def __init__(
        self, problem: Problem, start: Start, load_factor: float, arcs: Arcs, lids: Lids, exact: bool
    ) -> None:
        n, d = problem.n, problem.directions
        numbers: Callable[[FloatArray], Any] = exact_numbers if exact else np.asarray
        self._numbers = numbers
        self._margin, self._round = numbers(np.array([MARGIN, 0.0 if exact else ROUND_OFF]))
        self._arcs = Arcs(arcs.node, numbers(arcs.first), numbers(arcs.last))
        self._lids, self._a, self._N = lids, numbers(lids.a), numbers(lids.N)
        A, B, law = numbers(problem.A), numbers(problem.B), Law(numbers(problem.f), d)
        self._A, self._B = A.reshape(n, d, n, d), B.reshape(n, n, d)
        self._fB = law.limit_rows(B).reshape(n, n, d)
        self._slip, self._error = self._numbers(start.slip).reshape(n, d), self._numbers(start.error)
        self._off = np.flatnonzero(start.error)
        self._locked = _of_slip(self._fB, self._A, self._slip)
        self._locked_terms = _of_slip(np.abs(self._fB), np.abs(self._A), np.abs(self._slip))
        before, loads = transient_path(problem), self._loads(problem, load_factor)
        self._first = problem.layout.split(loads[: 1 if len(before) else 2])[1]
        q, p = problem.layout.split(loads)
        self._limit, self._q = law.limit(p), problem.layout.by_node(q)

    def _loads(self, problem: Problem, load_factor: float) -> Any:
        """The transient load steps, the mean load, and the loop at a load factor from its first step on."""
        loop, joined, numbers = loading(problem), problem.layout.joined, self._numbers
        mean, periodic = numbers(joined(loop.q0, loop.p0)), numbers(joined(loop.q1, loop.p1))
        reached = mean + numbers(np.array([load_factor]))[0] * periodic
        return np.concatenate([numbers(transient_path(problem)), mean[None], reached])

    def slips_end(self) -> bool:
        """a, N ≥ 0, ρ(N) < 1 and S ≥ a + N S."""
        a, N = self._lids.a, self._lids.N
        x, total = (self._numbers(each) for each in (self._lids.inverse.sum(axis=1), self._lids.total))
        signs = np.all(a >= 0.0) and np.all(N >= 0.0) and not np.diagonal(N).any()
        ends = np.all(x > 0) and np.all(x - self._N @ x > self._round * x)
        return bool(signs and ends and np.all(total >= self._a + self._N @ total))

    def pressed(self) -> bool:
        """Whether the first load presses all nodes, at every load factor: the load rises to it so."""
        p = self._first + np.sum(self._B * self._slip, axis=(1, 2)) - _size(self._B) @ self._error
        return bool(np.all(p > 0))

    def holds(self, pieces: _Pieces) -> Flags:
        """In which pieces nodes stay below their lids, or outside all arcs clear of their limits, (c,)."""
        corners = pieces.corners(self._slip.shape[1])
        count = corners.shape[1]
        node, arc = pieces.node.repeat(count), pieces.arc.repeat(count)
        e = self._numbers(corners.reshape(len(node), -1))
        found, inside = np.zeros(len(node), dtype=bool), arc >= 0
        found[inside] = self._below_lids(node[inside], e[inside], arc[inside])
        found[~inside] = self._away(node[~inside], e[~inside])
        return np.asarray(found.reshape(-1, count).all(axis=1))

    def _below_lids(self, node: Numbers, e: Any, arc: Numbers) -> Flags:
        slopes, terms = self._slopes(node, e)
        points = np.arange(len(node))
        own = slopes[points, arc]
        hindered = own[:, None] * self._N[arc] + slopes - self._round * terms >= 0
        hindered[points, arc] = True
        relieved = (own > 0) & (self._slack(node, e) + own * self._a[arc] > 0)
        return np.asarray(relieved & hindered.all(axis=1))

    def _away(self, node: Numbers, e: Any) -> Flags:
        slack, (slopes, terms) = self._slack(node, e), self._slopes(node, e)
        y = self._lids.multipliers(slack.astype(float), slopes.astype(float))
        most = (y + terms.astype(float)).max(axis=1, initial=0.0)
        Y = self._numbers(y + 4.0 * ROUND_OFF * most[:, None] * self._lids.inverse.sum(axis=0))
        proved = Y - Y @ self._N + slopes - self._round * (Y + Y @ self._N + terms) >= 0
        return np.asarray(proved.all(axis=1) & (slack - Y @ self._a > 0))

    def _slack(self, node: Numbers, e: Any) -> Any:
        """The smallest slack (p,) of nodes (p,) in directions (p, d) at the start, less a margin."""
        (fBv, Av), (of_fB, of_A) = self._locked, self._locked_terms
        q = np.moveaxis(self._q[:, node], 0, 2)
        loads, load_terms = self._limit[:, node].T, np.abs(self._limit[:, node].T)
        loads, load_terms = loads + _along(e, q), load_terms + _along(np.abs(e), np.abs(q))
        locked = fBv[node] + _along(e, Av[node])
        terms = load_terms.max(axis=1) + of_fB[node] + _along(np.abs(e), of_A[node])
        off = self._off
        for i, mine in by_node(node) if off.size else ():
            rows = self._fB[i, off] + np.tensordot(e[mine], self._A[i][:, off], axes=1)
            locked[mine] = locked[mine] - _size(rows) @ self._error[off]
        return loads.min(axis=1) + locked - self._margin * terms

    def _slopes(self, node: Numbers, e: Any) -> tuple[Any, Any]:
        """What slip in the arcs at least adds to limits, (p, K), and the size of its terms."""
        fB, A = self._between(node, self._arcs.node)
        terms = np.abs(fB) + _along(np.abs(e), np.abs(A))
        return self._arcs.least(fB + _along(e, A)), terms.sum(axis=2)

    def _between(self, node: Numbers, others: Numbers) -> tuple[Any, Any]:
        """f B and A of nodes (p,) by slips of others (k,): (p, k, d) and (p, d, k, d)."""
        i = node[:, None]
        return self._fB[i, others], np.moveaxis(self._A[i, :, others], 2, 1)


def _of_slip(fB: Any, A: Any, slip: Any) -> tuple[Any, Any]:
    """What slip (n, d) changes: limits by pressures (n,), and reactions (n, d)."""
    return np.sum(fB * slip, axis=(1, 2)), np.sum(A * slip, axis=(2, 3))


def _along(e: Any, values: Any) -> Any:
    """Sums over the directions of e (p, d) of values (p, d, …)."""
    return sum(e[:, x].reshape(-1, *[1] * (values.ndim - 2)) * values[:, x] for x in range(e.shape[1]))


def _size(rows: Any) -> Any:
    """The lengths of vectors (…, d); with one direction of fractions, too."""
    return np.abs(rows[..., 0]) if rows.shape[-1] == 1 else np.hypot(rows[..., 0], rows[..., 1])
