"""Whether numbers of finer and finer meshes converge: a + c h^p through the last three of them."""

from enum import StrEnum
from math import inf, isfinite, nan
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from shakedown.ground.float_array import FloatArray

STILL = 1e-3  # of a number: changes up to that are none; ten times that ends a sequence that turns
SLOWEST = 0.5  # order of convergence: below it what is left is too uncertain for a limit
SLOW = 0.25  # order below which there is none: what is left cannot be told from a power of h, or log h
LEVEL = 0.03  # power of h below which nothing is said to fall or grow
FASTEST = 8.0  # order, above which the last change tells nothing
NEAR = 0.25  # of a number: as far as that its limit may be; twice as far leaves it open


class Tendency(StrEnum):
    """What a number does as the mesh is refined."""

    CONVERGES = "converges"
    FALLS = "falls"
    GROWS = "grows"
    UNDECIDED = "undecided"


class Trend(NamedTuple):
    """What a sequence of numbers does.

    Attributes
    ----------
    verdict
        Whether it converges, falls or grows; undecided where three numbers do not tell.
    limit
        Where it converges to, extrapolated; NaN where it does not.
    order
        Of convergence, p of a + c h^p, NaN where the last changes are too small or change sign. Where it
        falls or grows: the exponent s of h^s between the last two meshes. Else NaN.
    """

    verdict: Tendency
    limit: float = nan
    order: float = nan


def trend(size: FloatArray, values: FloatArray) -> Trend:
    """What numbers do as the element size falls, (k,) both; the last three are looked at.

    Examples
    --------
    >>> h = np.array([0.25, 0.125, 0.0625])
    >>> found = trend(h, 3.0 + 2.0 * h**1.5)
    >>> found.verdict.value, round(found.limit, 6), round(found.order, 6)
    ('converges', 3.0, 1.5)
    >>> trend(h, h**0.1).verdict.value, trend(h, 1.0 - np.log(h)).verdict.value
    ('falls', 'grows')
    """
    if len(values) < 3 or not all(map(isfinite, values[-3:])):
        return Trend(Tendency.UNDECIDED)
    h, (first, second, last) = size[-3:].tolist(), map(float, values[-3:])
    before, now = second - first, last - second
    if max(abs(before), abs(now)) <= STILL * abs(last):
        return Trend(Tendency.CONVERGES, last)
    if second == last == 0.0:
        return Trend(Tendency.FALLS if first > 0.0 else Tendency.UNDECIDED)
    if before * now <= 0.0:
        ends = abs(now) <= min(0.5 * abs(before), 10.0 * STILL * abs(last))
        return Trend(Tendency.CONVERGES, last) if ends else Trend(Tendency.UNDECIDED)
    order = _order(h, before / now)
    left = now / ((h[1] / h[2]) ** order - 1.0) if order > 0.0 else inf * now
    near, power = abs(left) <= NEAR * abs(last), nan
    if near and order >= SLOWEST:
        return Trend(Tendency.CONVERGES, last + left, order)
    if second * last > 0:
        power = float(np.log(second / last) / np.log(h[1] / h[2]))
    slow, far = near and order >= SLOW, order >= SLOWEST and abs(left) <= 2.0 * NEAR * abs(last)
    if slow or far or abs(power) < LEVEL:
        return Trend(Tendency.UNDECIDED)
    return Trend(Tendency.FALLS if now * last < 0 or last == 0.0 else Tendency.GROWS, order=power)


def _order(h: list[float], ratio: float) -> float:
    """p of a + c h^p, of which the ratio of two changes is known; 0 where no p > 0 has it."""

    def excess(p: float) -> float:
        # (h0^p − h1^p) / (h1^p − h2^p), by expm1 good near p = 0 as well
        return float(np.expm1(p * np.log(h[0] / h[1])) / -np.expm1(p * np.log(h[2] / h[1]))) - ratio

    if excess(1e-6) >= 0.0:
        return 0.0
    return FASTEST if excess(FASTEST) <= 0.0 else float(brentq(excess, 1e-6, FASTEST, xtol=1e-12))
