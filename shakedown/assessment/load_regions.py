"""The regions of the load factor, and the prediction that follows in each."""

import numpy as np

from shakedown.assessment.every_limit import JointLimits
from shakedown.ground.errors import Missing, sought
from shakedown.ground.shown_values import FEW_DIGITS
from shakedown.ground.status import Status

UNSAFE, BELOW, BETWEEN, ABOVE = "below λ_lo", "below λ_1", "between", "above λ_max"
PROVED = "below λ_U"  # for a load domain, where λ_1 predicts nothing, and in space, where it does not exist
NARROW = 10.0**-FEW_DIGITS  # relative width below which nothing is simulated in a region
IN_ZONE, OUTSIDE = "zone is safe", "zone is not safe"  # between λ_lo and λ_max of a zone, and elsewhere
NO_ZONE = "no zone is safe"  # all were tried


def predicted_below(limits: JointLimits) -> tuple[float, str]:
    """Up to where every closed state is predicted to shake down: λ_1; for a load domain and in space λ_U."""
    lower = limits.lower
    if isinstance(lower, Missing) or limits.problem.is_domain:
        return limits.universal.load_factor, PROVED
    return lower.load_factor, BELOW


def default_load_factors(limits: JointLimits) -> list[float]:
    """One load factor slightly inside every region that is wider than four digits resolve.

    Examples
    --------
    >>> import shakedown
    >>> limits = shakedown.assess(shakedown.example("two-node")).details
    >>> [round(x, 3) for x in default_load_factors(limits)]
    [0.625, 0.682, 0.776]
    """
    upper = limits.upper
    least, last = upper.least_load_factor, upper.load_factor
    first, _ = predicted_below(limits)
    if upper.status in (Status.INFEASIBLE, Status.UNDECIDED):
        return [1.0]
    if upper.open_nodes:
        below = [0.95 * first] if 0 < first < np.inf else []
        inside = [least + 0.5 * (last - least), least + 0.999 * (last - least)]
        return [*below, *inside, 1.05 * last or 1.0] if last < np.inf else [*below, 1.5 * least or 1.0]
    if least > 0:  # the mean load alone has no safe slip, and so there is no λ_1
        factors, first = [0.95 * least], least
    elif np.isinf(first):  # nothing ever collapses
        return [1.0, 10.0]
    else:
        factors = [0.95 * first] if first > 0 else []
    if np.isinf(last):
        return [*factors, 1.5 * first or 1.0]
    if not first and not limits.lower:  # from every state nothing is proved
        energy = sought(lambda: limits.energy)
        proved = 0.0 if isinstance(energy, Missing) else energy.load_factor
        first = proved if 0.0 < proved < last else 0.0
        factors = [0.95 * first] if first > 0 else []
    if last > first * (1 + NARROW):
        factors.append(first + 0.3 * (last - first))
    return [*factors, 1.05 * last or 1.0]


def region_of(load_factor: float, limits: JointLimits) -> str:
    """The region that a load factor lies in."""
    upper = limits.upper
    first, below = predicted_below(limits)
    if upper.open_nodes and not load_factor < first:
        return IN_ZONE if upper.least_load_factor <= load_factor <= upper.load_factor else OUTSIDE
    if upper.status == Status.UNDECIDED:
        return OUTSIDE
    if upper.status == Status.INFEASIBLE:
        return NO_ZONE if limits.zone == "auto" else ABOVE
    if load_factor < upper.least_load_factor:
        return UNSAFE
    if load_factor < first:  # even where round-off affects λ_max
        return below
    return ABOVE if load_factor > upper.load_factor else BETWEEN
