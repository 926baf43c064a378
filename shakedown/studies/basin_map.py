"""Maps of initial states: how many shake down, what the others dissipate, and in which limit cycles."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import FloatArray
from shakedown.ground.shown_values import plain
from shakedown.ground.status import Outcome
from shakedown.joint.constraints import constraints
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.long_term.find_state import LongTermStates
from shakedown.programs.polygon import corners
from shakedown.studies.limit_cycles import (
    LimitCycle,
    Scatter,
    UndecidedReason,
    final_states,
    slip_scatter,
    undecided_reasons,
)
from shakedown.studies.samplers import NAMED, Sampler, Sampling


@dataclass(frozen=True, eq=False, repr=False)
class InitialStateMap(LongTermStates):
    """What becomes of a joint from many initial states at one load factor.

    Attributes
    ----------
    sampling
        Which initial states. The first rows, as many as ``sampling.named`` has, are slip zero, the given
        and the critical state; the others are sampled: ``sampling.slips(k, k + 1)`` gives number k of
        them again. Shares and what is said over all states are those of the sampled ones.
    limit_cycles
        The distinct limit cycles, the most frequent first.
    slip_range : (s,) or None
        The largest slip range of a node in the long-term state [length], where that was asked for; infinite
        where slips grow for ever or contact is lost for good, NaN where undecided.
    slip_below
        The length that it is to stay below, where that was asked for.
    """

    sampling: Sampling
    limit_cycles: tuple[LimitCycle, ...] = field(default=())
    slip_range: FloatArray | None = None
    slip_below: float | None = None

    def __repr__(self) -> str:
        return (
            f"InitialStateMap(load_factor={self.load_factor:.6g}, states={self.sampling.states}, "
            f"shakedown_fraction={self.shakedown_fraction:.4g}, limit_cycles={len(self.limit_cycles)})"
        )

    @property
    def sampled(self) -> slice:
        """The rows of the states that are sampled; those before them have a name."""
        return slice(len(self.sampling.named), None)

    @property
    def named(self) -> dict[str, str | None]:
        """What becomes of slip zero, the given and the critical state; None of one that does not exist."""
        found = dict(zip(self.sampling.named, map(str, self.outcome), strict=False))
        return {name: found.get(name) for name in NAMED}

    @property
    def problem(self) -> Problem:
        """The joint."""
        return self.sampling.problem

    @cached_property
    def outcomes(self) -> dict[str, int]:
        """The number of sampled states per outcome, for every outcome that occurs."""
        return _counts(self.outcome[self.sampled])

    @property
    def undecided(self) -> int:
        """How many sampled states have no long-term state within the cycles allowed."""
        return self.outcomes.get(Outcome.UNDECIDED, 0)

    @property
    def shakedown_fraction(self) -> float:
        """Share of the sampled states that shake down."""
        return self.outcomes.get(Outcome.SHAKEDOWN, 0) / self.sampling.states

    @cached_property
    def interval(self) -> tuple[float, float]:
        """95 % confidence interval of that share (Wilson's); NaN for a grid, which is no random sample.

        It holds for independent states; Sobol points, which are more evenly spread,
        know the share better. Undecided states count against both of its ends.
        """
        if self.sampling.sampler == Sampler.GRID:
            return np.nan, np.nan
        from scipy.stats import binomtest  # a slow import, not needed in every worker

        shaken, states = self.outcomes.get(Outcome.SHAKEDOWN, 0), self.sampling.states
        low, high = (
            binomtest(count, states).proportion_ci(confidence_level=0.95, method="wilson")
            for count in (shaken, shaken + self.undecided)
        )
        return float(low.low), float(high.high)

    @cached_property
    def dissipation_quartiles(self) -> FloatArray:
        """Minimum, quartiles and maximum of the dissipation per cycle over decided sampled states, (5,)."""
        return _quartiles(self.dissipation[self.sampled])

    @cached_property
    def dissipation_of(self) -> dict[str, FloatArray]:
        """Minimum, quartiles and maximum of the dissipation over the states of each outcome, (5,) each."""
        outcome, dissipation = self.outcome[self.sampled], self.dissipation[self.sampled]
        return {word: _quartiles(dissipation[outcome == word]) for word in self.outcomes}

    @cached_property
    def scatter(self) -> Scatter:
        """The scatter of the slips locked in where it shakes down; NaN where it does not."""
        shaken = np.flatnonzero(self.outcome == Outcome.SHAKEDOWN)
        return slip_scatter(self.final_slip, shaken, np.asarray(self.final_slip[shaken[:1]]))

    @cached_property
    def slip_criterion(self) -> dict[str, Any] | None:
        """From how many states every slip range stays below the length; None where none was given.

        ``below``: the length [length]. ``met``: whether it does from all of them; None where it does from all
        that are decided. ``largest``: the largest slip range [length], infinite where slips grow for ever or
        contact is lost for good. ``met_fraction``: from which share of the sampled states it does.
        """
        if self.slip_below is None or self.slip_range is None:
            return None
        met, unknown = self.slip_range < self.slip_below, np.isnan(self.slip_range)
        return {
            "below": self.slip_below,
            "met": None if (met | unknown).all() and unknown.any() else bool(met.all()),
            "largest": float(np.nanmax(self.slip_range)) if not unknown.all() else np.nan,
            "met_fraction": float(met[self.sampled].mean()),
        }

    @cached_property
    def undecided_reasons(self) -> tuple[UndecidedReason, ...]:
        """Why states are undecided, the most frequent reason first.

        A few of them, spread evenly over their numbers, are followed once more.
        """
        undecided = self.sampled.start + np.flatnonzero(self.outcome[self.sampled] == Outcome.UNDECIDED)
        return undecided_reasons(self.sampling, self.initial_slip, undecided)

    @cached_property
    def region_type(self) -> str:
        """The regions in the plane of the slips of two nodes, (i) to (iv) of thesis §4.4; else empty.

        ``"i"``: a safe region and no complementary one, ``"ii"``: both, ``"iii"``: a complementary one only,
        ``"iv"``: neither. In a complementary region both rows of a node are violated and those of the other
        one hold: there it slips to and fro for ever (figs 4.11–4.15).
        """
        if self.problem.n != 2 or self.problem.directions > 1:
            return ""
        rows = constraints(self.problem)
        limits = rows.g - self.load_factor * rows.d
        safe = len(corners(rows.G, limits))
        signs = (np.where(rows.limits_of(node), -1.0, 1.0) for node in (0, 1))
        beyond = any(len(corners(sign[:, None] * rows.G, sign * limits)) for sign in signs)
        return ("ii" if beyond else "i") if safe else ("iii" if beyond else "iv")

    @cached_property
    def _ends(self) -> tuple[bool | None, bool | None, str]:
        return final_states(self.sampling, _counts(self.outcome), self.limit_cycles, self.scatter)

    @property
    def same_outcome(self) -> bool | None:
        """Whether the outcome is the same from all states; None where that is not known."""
        return self._ends[0]

    @property
    def unique(self) -> bool | None:
        """Whether all states end in the same state; None where that is not known.

        The slips at the end of a period agree too, those that stay locked in among them, to
        the tolerance ``same_cycle``.
        """
        return self._ends[1]

    @property
    def evidence(self) -> str:
        """The evidence for that, in words."""
        return self._ends[2]

    def to_dict(self) -> dict[str, Any]:
        """Everything but the states themselves, for JSON."""
        document = {
            "load_factor": self.load_factor,
            "named": self.named,
            "states": self.sampling.states,
            "sampler": str(self.sampling.sampler),
            "seed": self.sampling.seed,
            "shakedown_fraction": self.shakedown_fraction,
            "interval": list(self.interval),
            "outcomes": self.outcomes,
            "fractions": {word: count / self.sampling.states for word, count in self.outcomes.items()},
            "dissipation": self.dissipation_quartiles,
            "dissipation_of": self.dissipation_of,
            "limit_cycles": [
                {word: value for word, value in cycle.to_dict().items() if word != "final_slip"}
                for cycle in self.limit_cycles
            ],
            "same_outcome": self.same_outcome,
            "slip_spread": self.scatter.spread,
            "largest_slip": self.scatter.largest,
            "unique": self.unique,
            "evidence": self.evidence,
            "undecided_reasons": self.undecided_reasons,
        }
        if self.slip_criterion is not None:
            document["slip_criterion"] = self.slip_criterion
        return {word: plain(value) for word, value in document.items()}


def _counts(outcome: NDArray[np.str_]) -> dict[str, int]:
    """The number of states per outcome that occurs."""
    return {str(word): count for word in Outcome if (count := int(np.count_nonzero(outcome == word)))}


def _quartiles(values: FloatArray) -> FloatArray:
    """Minimum, quartiles and maximum of what is known, (5,)."""
    known = values[~np.isnan(values)]
    return np.quantile(known, [0.0, 0.25, 0.5, 0.75, 1.0]) if len(known) else np.full(5, np.nan)


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
