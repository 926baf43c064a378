"""What a computation leaves open: answers without a number, and numbers that exact arithmetic disputes."""

from collections.abc import Iterator

from shakedown.bounds.collapse.lower import LowerBound
from shakedown.bounds.energy.energy_bound import EnergyBound
from shakedown.bounds.every_state.universal_bound import UniversalBound
from shakedown.bounds.results import UpperBound
from shakedown.ground.evidence import Missing
from shakedown.ground.status import Status


def open_ends(
    *results: LowerBound | UpperBound | EnergyBound | UniversalBound | Missing,
) -> Iterator[str]:
    """One sentence for each result without an answer, or whose answer is disputed.

    What a joint has not, as λ_1 with two tangential directions, is not open.

    Examples
    --------
    >>> import shakedown
    >>> list(open_ends(shakedown.upper_bound(shakedown.example("two-node"))))
    []
    """
    names = {LowerBound: "λ_1", UpperBound: "λ_max", EnergyBound: "λ_E", UniversalBound: "λ_U"}
    for result in results:
        if isinstance(result, Missing):
            continue
        name = names[type(result)]
        if result.status == Status.UNDECIDED:
            yield f"{name} is open: {result.reason}"
        elif isinstance(result, LowerBound | UpperBound) and result.disputed:
            yield f"{name} is disputed: {result.uncertified}"
