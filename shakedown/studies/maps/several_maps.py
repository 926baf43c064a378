"""Maps of initial states at several load factors."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.shown_values import plain
from shakedown.joint.result import Result
from shakedown.studies.maps.basin_map import InitialStateMap


@dataclass(frozen=True)
class MissingMap:
    """A load factor at which there is no map, since there is no energy ball to draw states from.

    Attributes
    ----------
    place
        Number of the load factor among those asked for.
    load_factor
        λ.
    reason
        What there is instead of the ball, in words.
    """

    place: int
    load_factor: float
    reason: str


@dataclass(frozen=True, eq=False, repr=False)
class InitialStateMaps(Result):
    """Maps of initial states over a range of load factors.

    Attributes
    ----------
    maps
        One for each load factor that has one, in the order asked for.
    missing
        The other load factors.
    """

    TABLE: ClassVar[str] = "load_factors shakedown_fraction interval"

    maps: tuple[InitialStateMap, ...]
    missing: tuple[MissingMap, ...] = ()

    @property
    def load_factors(self) -> FloatArray:
        """λ, (k,)."""
        return np.array([one.load_factor for one in self.maps])

    @property
    def shakedown_fraction(self) -> FloatArray:
        """Share of the states that shake down at each load factor, (k,)."""
        return np.array([one.shakedown_fraction for one in self.maps])

    @property
    def interval(self) -> FloatArray:
        """Its confidence interval at each load factor, (k, 2)."""
        return np.array([one.interval for one in self.maps])

    def to_dict(self) -> dict[str, Any]:
        """Everything but the states themselves, for JSON."""
        return {"maps": [one.to_dict() for one in self.maps], "missing": [plain(one) for one in self.missing]}
