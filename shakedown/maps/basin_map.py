"""A map of initial states: how many shake down, what the others dissipate, and in which limit cycles."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binomtest

from shakedown.long_term.outcome import Outcome
from shakedown.maps.limit_cycles import BORDER, STABLE, UNSTABLE, LimitCycle, limit_cycles
from shakedown.maps.map_file import Columns
from shakedown.maps.map_pieces import Search
from shakedown.maps.samplers import Sampler, Sampling
from shakedown.maps.slip_plane import SlipPlane, admissible, slip_plane
from shakedown.model.problem import FloatArray, Problem
from shakedown.model.result import Result
from shakedown.shown_values import plain
from shakedown.tolerances import Tolerances

CONFIDENCE = 0.95


@dataclass(frozen=True, eq=False, repr=False)
class InitialStateMap(Result):
    """What becomes of a joint from many initial states at one load factor.

    Attributes
    ----------
    sampling
        Which initial states: ``sampling.slips(k, k + 1)`` gives number k again.
    search
        How long-term states were searched for.
    initial_slip, final_slip : (s, n)
        Slips at the start, and at the end of a period of the long-term state [length].
    outcome : (s,)
        Values of :class:`Outcome`.
    period : (s,)
        Cycles after which the long-term state repeats; 0 where there is none.
    dissipation : (s,)
        Per cycle of the long-term state [force × length]; NaN where undecided.
    slip_per_cycle : (s, n)
        Σ|Δv| in contact over one period [length].
    contraction : (s,)
        Factor per cycle by which the distance to the long-term state shrinks in the end.
    signature : (s,)
        Identifies the sequence of contact states of the long-term state.
    limit_cycles
        The distinct limit cycles, the most frequent first.
    """

    sampling: Sampling
    search: Search
    initial_slip: FloatArray
    final_slip: FloatArray
    outcome: NDArray[np.str_]
    period: NDArray[np.int64]
    dissipation: FloatArray
    slip_per_cycle: FloatArray
    contraction: FloatArray
    signature: NDArray[np.uint64]
    limit_cycles: tuple[LimitCycle, ...] = field(default=())

    def __repr__(self) -> str:
        return (
            f"InitialStateMap(load_factor={self.load_factor:.6g}, states={len(self)}, "
            f"shakedown_fraction={self.shakedown_fraction:.4g}, limit_cycles={len(self.limit_cycles)})"
        )

    def __len__(self) -> int:
        return len(self.outcome)

    @property
    def problem(self) -> Problem:
        """The joint."""
        return self.sampling.problem

    @property
    def load_factor(self) -> float:
        """λ."""
        return self.sampling.load_factor

    @cached_property
    def outcomes(self) -> dict[str, int]:
        """How many states have each outcome, every outcome that occurs."""
        counts = {str(word): int(np.count_nonzero(self.outcome == word)) for word in Outcome}
        return {word: count for word, count in counts.items() if count}

    @property
    def undecided(self) -> int:
        """How many states have no long-term state within the cycles allowed."""
        return self.outcomes.get(Outcome.UNDECIDED, 0)

    @property
    def shakedown_fraction(self) -> float:
        """Share of the states that shake down, among all."""
        return self.outcomes.get(Outcome.SHAKEDOWN, 0) / len(self)

    @cached_property
    def interval(self) -> tuple[float, float]:
        """95 % confidence interval of that share (Wilson's); NaN for a grid, which is no random sample.

        It holds for independent states; more evenly spread ones (Sobol, Latin hypercube)
        know the share better. Undecided states count against both of its ends.
        """
        if self.sampling.sampler == Sampler.GRID:
            return np.nan, np.nan
        shaken, states = self.outcomes.get(Outcome.SHAKEDOWN, 0), len(self)
        low, high = (
            binomtest(count, states).proportion_ci(CONFIDENCE, method="wilson")
            for count in (shaken, shaken + self.undecided)
        )
        return float(low.low), float(high.high)

    @cached_property
    def dissipation_quartiles(self) -> FloatArray:
        """Minimum, quartiles and maximum of the dissipation per cycle over all decided states, (5,)."""
        known = self.dissipation[~np.isnan(self.dissipation)]
        return np.quantile(known, [0.0, 0.25, 0.5, 0.75, 1.0]) if len(known) else np.full(5, np.nan)

    @property
    def admissible(self) -> NDArray[np.bool_]:
        """Which initial slips keep all nodes closed and within their limits at the first load, (s,)."""
        return admissible(self.problem, self.load_factor, self.initial_slip, self.search.tolerances)

    @cached_property
    def plane(self) -> SlipPlane:
        """Safe region, admissible slips, energy ball in the plane of the two coordinates."""
        return slip_plane(self.sampling)

    @property
    def unique(self) -> bool | None:
        """Whether all states end in one and the same motion; None where that is not known.

        Slips that stay locked in may differ, as long as the dissipation does not: by the
        tolerance ``same_cycle``, relative to itself. All shaking down counts as one motion.
        """
        return uniqueness(self)[0]

    @property
    def evidence(self) -> str:
        """What that rests on, in words."""
        return uniqueness(self)[1]

    def to_dict(self) -> dict[str, Any]:
        """Everything but the states themselves, for JSON."""
        document = {
            "load_factor": self.load_factor,
            "states": len(self),
            "sampler": str(self.sampling.sampler),
            "seed": self.sampling.seed,
            "shakedown_fraction": self.shakedown_fraction,
            "interval": list(self.interval),
            "outcomes": self.outcomes,
            "dissipation": self.dissipation_quartiles,
            "limit_cycles": [_cycle_document(cycle) for cycle in self.limit_cycles],
            "unique": self.unique,
            "evidence": self.evidence,
        }
        return {word: plain(value) for word, value in document.items()}


@dataclass(frozen=True, eq=False, repr=False)
class InitialStateMaps(Result):
    """Maps of initial states over a range of load factors.

    Attributes
    ----------
    maps
        One for each load factor, in the order asked for.
    """

    TABLE: ClassVar[str] = "load_factors shakedown_fraction interval"

    maps: tuple[InitialStateMap, ...]

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
        return {"maps": [one.to_dict() for one in self.maps]}


def basin_map(chosen: Sampling, search: Search, columns: Columns) -> InitialStateMap:
    """The map that the long-term states of all states of a sampling make."""
    own = {key: columns[key] for key in InitialStateMap.__dataclass_fields__ if key in columns}
    cycles = limit_cycles(chosen.problem, chosen.load_factor, columns, search)
    return InitialStateMap(sampling=chosen, search=search, limit_cycles=cycles, **own)


def uniqueness(found: InitialStateMap) -> tuple[bool | None, str]:
    """Whether the final state of motion is one and the same, and the evidence in words."""
    cycles, shaken = found.limit_cycles, found.outcomes.get(Outcome.SHAKEDOWN, 0)
    differences = _differences(found.outcomes, cycles, found.search.tolerances)
    if differences:
        return False, "; ".join(differences)
    if found.undecided:
        return None, f"{found.undecided} of {len(found)} states are undecided, the others agree"
    if not cycles and shaken == len(found):
        return True, f"all {len(found)} states shake down"
    if len(cycles) == 1:
        if cycles[0].stability == BORDER:
            return True, f"all {len(found)} states end in a continuum of limit cycles that dissipate the same"
        return True, f"all {len(found)} states end in the same limit cycle, which is {cycles[0].stability}"
    return None, "the body leaves the contact from every state"


def _differences(
    outcomes: Mapping[str, int], cycles: tuple[LimitCycle, ...], tolerances: Tolerances
) -> list[str]:
    """What tells final states apart, in words."""
    words = []
    moving = sum(count for name, count in outcomes.items() if name not in ("shakedown", "undecided"))
    if outcomes.get(Outcome.SHAKEDOWN, 0) and moving:
        words.append("some states shake down and others do not")
    if len(cycles) > 1:
        words.append(f"{len(cycles)} different limit cycles")
        sets = len({cycle.slipping_nodes for cycle in cycles})
        words += [f"{sets} different sets of slipping nodes"] * (sets > 1)
    for cycle in cycles:
        low, high = cycle.dissipation
        if cycle.stability != STABLE and high - low > tolerances.same_cycle * high:
            words.append(
                f"the slip locked in selects one of a continuum (dissipation {low:.6g} to {high:.6g})"
            )
            break
    words += ["one of them is unstable"] * any(cycle.stability == UNSTABLE for cycle in cycles)
    return words


def _cycle_document(cycle: LimitCycle) -> dict[str, Any]:
    multipliers = [[float(value.real), float(value.imag)] for value in cycle.multipliers]
    return {
        "count": cycle.count,
        "outcome": cycle.outcome,
        "period": cycle.period,
        "dissipation": list(cycle.dissipation),
        "slipping_nodes": list(cycle.slipping_nodes),
        "stability": cycle.stability,
        "multipliers": multipliers,
        "contact_sequences": cycle.contact_sequences,
        "example": cycle.example,
    }
