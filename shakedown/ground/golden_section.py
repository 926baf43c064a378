"""The least point of a convex function of one number."""

from collections.abc import Callable

STEPS = 24  # of a golden section: the place to 1e-5 of the range


def least_point(convex: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    """Where a convex function is least, as a golden section finds it, and its value: one value a step.

    By hand, because to load scipy.optimize takes longer than what it is used for here.

    Examples
    --------
    >>> [round(number, 3) for number in least_point(lambda x: (x - 1.0) ** 2 + 3.0, -5.0, 5.0)]
    [1.0, 3.0]
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
    return (a, at_a) if at_a < at_b else (b, at_b)
