"""The work of a map, cut into pieces: the long-term states of some initial states."""

from dataclasses import asdict, dataclass, replace
from importlib.metadata import version
from math import prod
from typing import Any

import numpy as np

from shakedown.campaign.pieces import Arrays
from shakedown.ground.argument_kinds import check_count, check_fields
from shakedown.ground.float_array import FloatArray
from shakedown.ground.size_limits import CYCLES, MANY
from shakedown.ground.status import Outcome
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.problem import Problem
from shakedown.long_term.find_state import long_term_state
from shakedown.long_term.limit_search import LONGEST_PERIOD
from shakedown.long_term.many_states import NAMES, LongTermStates, long_term_states
from shakedown.long_term.node_results import slip_ranges
from shakedown.studies.map_file import Kinds, kinds_of
from shakedown.studies.samplers import BLOCK, Sampling

LITTLE = 1 << 17  # states times nodes squared: a few seconds at most
MUCH = 1 << 22  # the same: half a minute or more
LARGEST_HEADERS = 1 << 13  # bytes of an archive beside its columns
IN_SPACE = 16  # times the work of a state in the plane, with correspondingly fewer states in a piece
COLUMNS = (  # columns kept for every state in any case
    "initial_slip",
    "final_slip",
    "outcome",
    "period",
    "dissipation",
    "slip_per_cycle",
    "contraction",
    "signature",
)
SLIPS = ("initial_slip", "final_slip")  # of every node in all directions
FLOAT = np.dtype(np.float64)
DTYPES = {
    "outcome": NAMES.dtype,
    "period": np.dtype(np.int64),
    "signature": np.dtype(np.uint64),
}  # else FLOAT


@dataclass(frozen=True)
class MapSearch:
    """How long the long-term state of one initial state is searched for (:func:`long_term_state`)."""

    max_cycles: int = CYCLES
    longest_period: int = LONGEST_PERIOD
    tolerances: Tolerances = DEFAULT

    def __post_init__(self) -> None:
        check_fields(self)
        check_count("max_cycles", self.max_cycles)
        check_count("longest_period", self.longest_period, MANY)


@dataclass(frozen=True)
class MapPieces:
    """A function from the number of a piece to its long-term states, by load factor and state."""

    samplings: tuple[Sampling, ...]
    search: MapSearch
    slips: tuple[FloatArray, ...] = ()  # of all states at each load factor, where they are drawn already
    slip_ranges: bool = False  # whether to follow every state that does not come to rest once more for them
    threads: int = 1  # that share a piece

    @property
    def columns(self) -> tuple[str, ...]:
        """What is kept of every state."""
        return (*COLUMNS, "slip_range") if self.slip_ranges else COLUMNS

    def for_other_processes(self) -> "MapPieces":
        """The same work with few states drawn here, so that a worker need not load what draws them."""
        first = self.samplings[0]
        if first.states * first.problem.layout.slip_size > MANY:  # too large to send to other processes
            return self
        return replace(self, slips=tuple(chosen.slips(0, chosen.states) for chosen in self.samplings))

    @property
    def size(self) -> int:
        """States in one piece: about a second of work."""
        return BLOCK * max(1, 256 // (self._of_a_state * self.samplings[0].problem.n))

    @property
    def count(self) -> int:
        """Number of pieces."""
        return len(self.samplings) * self._per_load_factor

    @property
    def little(self) -> bool:
        """Whether starting other processes would take longer than the work."""
        return self._work < LITTLE

    @property
    def for_threads(self) -> bool:
        """Whether threads of this process are faster than new processes, as in the plane."""
        return self._of_a_state == 1 and LITTLE <= self._work < MUCH

    @property
    def _work(self) -> int:
        first = self.samplings[0]
        return len(self.samplings) * first.states * self._of_a_state * first.problem.n**2

    @property
    def _of_a_state(self) -> int:
        """The work of a state relative to one in the plane."""
        return 1 if self.samplings[0].problem.directions == 1 else IN_SPACE

    @property
    def _per_load_factor(self) -> int:
        return 1 + -(-self.samplings[0].states // self.size)

    def _part(self, number: int) -> tuple[Sampling, FloatArray]:
        """The sampling that a piece belongs to, and its initial slips; the first has those with a name."""
        which, part = divmod(number, self._per_load_factor)
        chosen, rows = self.samplings[which], slice((part - 1) * self.size, part * self.size)
        if part == 0:
            return chosen, np.array(list(chosen.named.values()))
        return chosen, self.slips[which][rows] if self.slips else chosen.slips(rows.start, rows.stop)

    @property
    def most_bytes(self) -> int:
        """The largest size of the file of a piece [bytes]."""
        rows = max(self.size, len(self.samplings[0].named))
        return LARGEST_HEADERS + sum(kind.itemsize * prod(shape) for kind, shape in self.kinds(rows).values())

    def fits(self, number: int, arrays: Arrays) -> bool:
        """Whether a piece holds the columns of as many states, at the load factor of its number."""
        which, part = divmod(number, self._per_load_factor)
        chosen = self.samplings[which]
        rows = min(self.size, chosen.states - (part - 1) * self.size) if part else len(chosen.named)
        there = kinds_of(arrays) == self.kinds(rows)
        return there and bool((arrays["load_factor"] == chosen.load_factor).all())

    def settings(self) -> dict[str, Any]:
        """Everything that the pieces depend on."""
        return {"map": self.of_the_map(), "piece": self.size}

    def of_the_map(self) -> dict[str, Any]:
        """Everything that the states depend on, to repeat them and to distinguish maps."""
        first = self.samplings[0]
        asked = {"slip_ranges": True} if self.slip_ranges else {}
        return asked | {
            "problem_sha256": first.problem.fingerprint,
            "load_factors": [chosen.load_factor for chosen in self.samplings],
            "sampler": str(first.sampler),
            "seed": first.seed,
            "states": first.states,
            "named": list(first.named),
            "coordinates": list(first.coordinates),
            "reach": first.reach,
            "max_cycles": self.search.max_cycles,
            "longest_period": self.search.longest_period,
            "tolerances": asdict(self.search.tolerances),
            "version": version("shakedown-bounds"),
        }

    def kinds(self, rows: int) -> Kinds:
        """Type and shape of the columns of some states."""
        layout = self.samplings[0].problem.layout
        wide = dict.fromkeys(SLIPS, layout.slip_size) | {"slip_per_cycle": layout.n}
        return {
            key: (DTYPES.get(key, FLOAT), (rows, wide[key]) if key in wide else (rows,))
            for key in (*self.columns, "load_factor")
        }

    def __call__(self, number: int) -> Arrays:
        chosen, slips = self._part(number)
        found = long_term_states(
            chosen.problem,
            chosen.load_factor,
            slips,
            max_cycles=self.search.max_cycles,
            longest_period=self.search.longest_period,
            tolerances=self.search.tolerances,
            threads=self.threads,
        )
        columns = {key: getattr(found, key) for key in COLUMNS}
        if self.slip_ranges:
            columns["slip_range"] = self._slip_ranges(chosen.problem, found)
        return columns | {"load_factor": np.full(len(found), chosen.load_factor)}

    def _slip_ranges(self, problem: Problem, found: LongTermStates) -> FloatArray:
        """The largest slip range of a node in each long-term state, (s,), as in :class:`SlipCriterion`."""
        ranges = np.full(len(found), np.nan)
        for k, (outcome, period) in enumerate(zip(found.outcome, found.period, strict=True)):
            if outcome == Outcome.SHAKEDOWN:
                ranges[k] = 0.0
            elif outcome == Outcome.RATCHETTING or (outcome == Outcome.SEPARATION and not period):
                ranges[k] = np.inf
            elif outcome != Outcome.UNDECIDED:
                ranges[k] = self._slip_range(problem, found, k)
        return ranges

    def _slip_range(self, problem: Problem, found: LongTermStates, k: int) -> float:
        """The slip range of one state, which is followed once more."""
        state = long_term_state(
            problem,
            found.load_factor,
            found.initial_slip[k],
            max_cycles=self.search.max_cycles,
            longest_period=self.search.longest_period,
            tolerances=self.search.tolerances,
        )
        return float(slip_ranges(state, self.search.tolerances).max())
