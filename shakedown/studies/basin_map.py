"""Maps of initial states: how many shake down, what the others dissipate, and in which limit cycles."""

import json
import os
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, field, fields
from functools import cached_property, partial
from importlib.metadata import version
from math import inf, nan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shakedown.files.atomic_write import atomic_write, check_target
from shakedown.files.pieces import Arrays, run_pieces
from shakedown.ground.constants import CYCLES, FloatArray
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import plain
from shakedown.ground.status import Outcome
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.ground.work_limit import all_cores
from shakedown.joint.arguments import check_load_factor, checked
from shakedown.joint.constraints import constraints
from shakedown.joint.problem import Problem
from shakedown.long_term.find_state import LongTermStates, long_term_states
from shakedown.long_term.limit_search import LONGEST_PERIOD
from shakedown.long_term.simulation import check_slip_below, slip_criterion
from shakedown.programs.simplex import corners
from shakedown.studies.limit_cycles import LimitCycle, Scatter, final_states, limit_cycles, slip_scatter
from shakedown.studies.samplers import BLOCK, FIRST_TWO, NAMED, Sampler, Sampling


@dataclass(frozen=True, eq=False, repr=False)
class InitialStateMap(LongTermStates):
    """Long-term states of a joint from many initial states at one load factor.

    Attributes
    ----------
    sampling
        Which initial states. The first rows, as many as ``sampling.named`` has, are slip zero, the given
        and the critical state; the others are sampled: ``sampling.slips(k, k + 1)`` gives number k of
        them again. Shares and statistics are those of the sampled states.
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
    def _ends(self) -> tuple[bool | None, bool | None]:
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


RANGES: dict[str, float] = {  # slip ranges of states that need not be followed once more for them
    Outcome.SHAKEDOWN: 0.0,
    Outcome.RATCHETTING: inf,
    Outcome.UNDECIDED: nan,
}


@checked
def initial_state_map(
    problem: Problem,
    load_factor: float,
    *,
    states: int = 1024,
    sampler: str = Sampler.SOBOL,
    seed: int = 0,
    coordinates: tuple[int, int] | None = None,
    reach: float = 1.0,
    path: str | os.PathLike[str] | None = None,
    resume: bool = False,
    executor: Executor | None = None,
    workers: int | None = 1,
    max_cycles: int = CYCLES,
    longest_period: int = LONGEST_PERIOD,
    slip_below: float | None = None,
    progress: Callable[[int, int], None] | None = None,
    tolerances: Tolerances = DEFAULT,
) -> InitialStateMap:
    """Find the long-term states of a joint from many initial states (thesis §7.2.1, §7.2.2).

    Parameters
    ----------
    problem
        The joint and its loading.
    load_factor
        λ ≥ 0.
    states
        Number of initial states beside slip zero, the given and the critical state,
        which every map begins with. A grid has the largest square number up to it.
    sampler
        How they are chosen, as described at :class:`Sampler`: ``"grid"``, ``"sobol"``,
        ``"ball"`` or ``"transients"``. The box of the first two has the
        safe slip in its middle, and as half-width the slips that one load step could
        cause, (|q_w| + f |p_w|) / A_jj, or as much more as it takes to contain slip zero, the given
        and the critical state, and what 16 random transients leave.
    seed
        Seed of what is random. State number k follows from the seed and k alone.
    coordinates
        The two nodes whose slips a grid runs over and a picture shows; 0 and 1 by default. With two
        tangential directions the places of two slips among x0, y0, x1, y1, …
    reach
        Size of the box, or of the ball, relative to that above.
    path
        Where to write all states (NPZ: ``initial_slip``, ``final_slip``, ``outcome``,
        ``period``, ``dissipation``, ``load_factor``, ``named``, the names of the first states, and what
        the limit cycles follow from). Until the map is whole its pieces are files in ``PATH.parts``,
        each whole after a kill at any instant.
    resume
        Whether to go on with the pieces that a stopped run has left there.
    executor
        Who works: any :class:`concurrent.futures.Executor`, as of threads, loky, MPI or
        ``dask.distributed.Client(…).get_executor()``. It is not shut down.
    workers
        Without an executor the number of processes. None: in the plane this one with a thread for each core,
        with two tangential directions one for each core, but for a few seconds' work. A script has to keep
        the call under ``if __name__ == "__main__":`` where it is more than one.
    max_cycles, longest_period
        As for :func:`long_term_state`.
    slip_below
        A limit on the slip range of every node in the long run [length]. The share of states from which it
        holds is found as well; a state that does not come to rest is followed twice for that.
    progress
        Called as ``progress(done, total)`` from time to time.
    tolerances
        What counts as zero, as reached, as periodic and as one limit cycle.

    Raises
    ------
    UsageError
        If an argument is out of range, a ball is asked for and there is none, the file cannot
        be written, an unfinished run is kept there and not resumed, or processes cannot begin to work.
    SolverError
        If a worker dies.

    Examples
    --------
    >>> import shakedown
    >>> found = initial_state_map(shakedown.example("two-node"), 0.7, states=64)
    >>> found
    InitialStateMap(load_factor=0.7, states=64, shakedown_fraction=0.8438, limit_cycles=1)
    >>> cycle = found.limit_cycles[0]
    >>> cycle.slipping_nodes, cycle.period, cycle.coincide
    ((1,), 1, False)
    """
    check_load_factor(load_factor, problem)
    if slip_below is not None:
        check_slip_below(slip_below)
    target = None if path is None else check_target(path)
    pair = FIRST_TWO if coordinates is None else coordinates
    search_limits = max_cycles, longest_period, tolerances
    chosen = Sampling(problem, load_factor, sampler, states, seed, pair, reach, *search_limits)
    if found := chosen.missing_ball:
        at = f"at load factor {load_factor:g}"
        raise UsageError(f"sampler ball: expected a finite energy ball {at}, found {found}")
    threads = 1
    if executor is None and workers is None:
        if problem.directions == 1:  # processes take several times as much of the processor
            threads, workers = all_cores(), 1
        # states times nodes squared in space: a few seconds, as long as processes take to start
        elif chosen.states * problem.n**2 < 1 << 13:
            workers = 1
    size, settings = piece_size(problem), _settings(chosen, slip_below is not None)
    work = partial(_piece, chosen, size, slip_below is not None, threads)
    run: dict[str, Any] = {"executor": executor, "workers": workers, "progress": progress}
    run |= {"settings": (settings, size), "output": target, "resume": resume}
    with run_pieces(work, 1 + -(-chosen.states // size), **run) as pieces:
        columns: dict[str, Any] = {key: np.concatenate([piece[key] for piece in pieces]) for key in pieces[0]}
        if target is not None:
            about = {"load_factor": chosen.load_factor, "named": settings["named"]}
            about["settings"] = json.dumps(settings, ensure_ascii=False)
            with atomic_write(target) as file:
                np.savez(file, allow_pickle=False, **columns, **about)
    return InitialStateMap(
        load_factor=chosen.load_factor,
        **columns,
        sampling=chosen,
        slip_below=slip_below,
        limit_cycles=limit_cycles(chosen, columns),
    )


def piece_size(problem: Problem) -> int:
    """States in one piece of a map: about a second of work."""
    # times the work of a state in the plane, with correspondingly fewer states in a piece
    return BLOCK * max(1, 256 // (problem.n if problem.directions == 1 else 16 * problem.n))


def _piece(chosen: Sampling, size: int, slip_ranges: bool, threads: int, number: int) -> Arrays:
    """The long-term states of a piece: the first has the states with a name, each other one so many more.

    With ``slip_ranges`` every state that does not come to rest is followed once more for them. ``threads``
    share the piece.
    """
    slips = np.array(list(chosen.named.values()))
    if number:
        slips = chosen.slips((number - 1) * size, number * size)
    found = long_term_states(
        chosen.problem, chosen.load_factor, slips, **chosen.search_limits, threads=threads
    )
    columns: Arrays = {key: value for key, value in vars(found).items() if key != "load_factor"}
    if slip_ranges:
        ends = zip(found.outcome, slips, strict=True)
        columns["slip_range"] = np.array([_slip_range(chosen, *end) for end in ends], dtype=float)
    return columns


def _settings(chosen: Sampling, slip_ranges: bool) -> dict[str, Any]:
    """Everything that the states depend on, to repeat them and to distinguish maps."""
    rest = "problem", "tolerances"
    return {
        "problem_sha256": chosen.problem.fingerprint,
        **{each.name: getattr(chosen, each.name) for each in fields(chosen) if each.name not in rest},
        "tolerances": asdict(chosen.tolerances),
        "named": list(chosen.named),
        "slip_ranges": slip_ranges,
        "version": version("shakedown-bounds"),
    }


def _slip_range(chosen: Sampling, outcome: str, slip: FloatArray) -> float:
    """The largest slip range of a node in a long-term state, as in :class:`SlipCriterion`."""
    if outcome in RANGES:
        return RANGES[outcome]
    return slip_criterion(chosen.state(slip), inf, chosen.tolerances).largest
