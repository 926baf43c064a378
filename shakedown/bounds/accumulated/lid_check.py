"""The conditions of the theorem, checked on a problem in the plane as it is stored, without round-off."""

from typing import NamedTuple

import numpy as np

from shakedown.bounds.accumulated.slip_arcs import MARGIN, Arcs, Flags, Lids, Numbers
from shakedown.bounds.row_programs import Exact, exact_numbers
from shakedown.ground.constants import ROUND_OFF, FloatArray
from shakedown.joint.law import Law
from shakedown.joint.loading import loading, transient_path
from shakedown.joint.problem import Problem


class Start(NamedTuple):
    """Where a motion begins: v₀ (dn,), and how far every node may be from there (n,) [length]."""

    slip: FloatArray
    error: FloatArray


def confirmed(problem: Problem, start: Start, load_factor: float, arcs: Arcs, lids: Lids) -> bool:
    """Whether the theorem holds from a start at all load factors up to one, with these arcs and lids.

    In the plane only. Of the arcs all is checked, of the lids a and N.
    """
    sign = arcs.first[:, 0]
    A, B, e = exact_numbers(problem.A), exact_numbers(problem.B), exact_numbers(np.array([1.0, -1.0]))
    v, error, law = exact_numbers(start.slip), exact_numbers(start.error), Law(exact_numbers(problem.f))
    q, p = problem.layout.split(_loads(problem, load_factor))
    first = p[: 1 if len(transient_path(problem)) else 2] + B @ v - np.abs(B) @ error
    if not (_slips_end(lids) and np.all(first > 0)):  # the load rises to the first one under these pressures
        return False
    fB = law.limit_rows(B)
    rows = fB + e[:, None, None] * A  # of the limits f p + e q in both directions e, (2, n, n)
    limit, shear = law.limit(p), e[:, None, None] * q
    terms = np.max(np.abs(limit) + np.abs(q), axis=0) + (np.abs(fB) + np.abs(A)) @ np.abs(v)
    slack = (
        (limit + shear).min(axis=1)
        + rows @ v
        - np.abs(rows) @ error
        - exact_numbers(np.array(MARGIN)) * terms
    )
    slopes = rows[:, :, arcs.node] * exact_numbers(sign)
    arc = np.full((2, problem.n), -1)
    arc[(sign < 0).astype(int), arcs.node] = np.arange(len(arcs))
    inside, sizes = arc >= 0, (np.abs(fB) + np.abs(A))[None, :, arcs.node].repeat(2, axis=0)
    below = _below_lids(lids, slack[inside], slopes[inside], arc[inside])
    return bool(below.all() and _away(lids, slack[~inside], slopes[~inside], sizes[~inside]).all())


def _loads(problem: Problem, load_factor: float) -> Exact:
    """The transient load steps, the mean load, and the loop at a load factor from its first step on."""
    loop, joined = loading(problem), problem.layout.joined
    mean, periodic = exact_numbers(joined(loop.q0, loop.p0)), exact_numbers(joined(loop.q1, loop.p1))
    reached = mean + exact_numbers(np.array(load_factor)) * periodic
    return np.concatenate([exact_numbers(transient_path(problem)), mean[None], reached])


def _slips_end(lids: Lids) -> bool:
    """a, N ≥ 0, ρ(N) < 1 and S ≥ a + N S."""
    a, N = exact_numbers(lids.a), exact_numbers(lids.N)
    x, total = exact_numbers(lids.inverse.sum(axis=1)), exact_numbers(lids.total)
    signs = np.all(lids.a >= 0.0) and np.all(lids.N >= 0.0) and not np.diagonal(lids.N).any()
    return bool(signs and np.all(x > 0) and np.all(x - N @ x > 0) and np.all(total >= a + N @ total))


def _below_lids(lids: Lids, slack: Exact, slopes: Exact, arc: Numbers) -> Flags:
    """In which directions of arcs nodes stay below their lids."""
    a, N, points = exact_numbers(lids.a), exact_numbers(lids.N), np.arange(len(arc))
    own = slopes[points, arc]
    hindered = own[:, None] * N[arc] + slopes >= 0
    hindered[points, arc] = True
    return np.asarray((own > 0) & (slack + own * a[arc] > 0) & hindered.all(axis=1))


def _away(lids: Lids, slack: Exact, slopes: Exact, sizes: Exact) -> Flags:
    """In which directions outside all arcs nodes stay clear of their limits."""
    y = lids.multipliers(slack.astype(float), slopes.astype(float))
    most = (y + sizes.astype(float)).max(axis=1, initial=0.0)
    Y = exact_numbers(y + 4.0 * ROUND_OFF * most[:, None] * lids.inverse.sum(axis=0))
    proved = Y - Y @ exact_numbers(lids.N) + slopes >= 0
    return np.asarray(proved.all(axis=1) & (slack - Y @ exact_numbers(lids.a) > 0))
