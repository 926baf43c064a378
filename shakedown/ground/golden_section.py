"""The least value of a convex function of one number."""

from collections.abc import Callable

STEPS = 24  # of a golden section: the place to 1e-5 of the range


def least_value(convex: Callable[[float], float], low: float, high: float) -> float:
    """The least value of a convex function that a golden section finds: one value a step.

    By hand, because to load scipy.optimize takes longer than what it is used for here.

    Examples
    --------
    >>> round(least_value(lambda x: (x - 1.0) ** 2 + 3.0, -5.0, 5.0), 6)
    3.0
    """
    ratio = 0.5 * (5**0.5 - 1)
    a, b = high - ratio * (high - low), low + ratio * (high - low)
    at_a, at_b = convex(a), convex(b)
    for _ in range(STEPS):
        if at_a < at_b:
            high, b, at_b = b, a, at_a
            a = high - ratio * (high - low)
            at_a = convex(a)
        else:
            low, a, at_a = a, b, at_b
            b = low + ratio * (high - low)
            at_b = convex(b)
    return min(at_a, at_b)
