"""Long-term states from many initial states: the public function, and its work in pieces."""

import json
import os
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, fields
from importlib.metadata import version
from math import inf, nan
from pathlib import Path
from typing import Any

import numpy as np

from shakedown.campaign.pieces import Arrays, run_pieces
from shakedown.files.atomic_write import atomic_write, check_target
from shakedown.ground.constants import CYCLES, FloatArray
from shakedown.ground.errors import UsageError
from shakedown.ground.status import Outcome
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.ground.work_limit import all_cores
from shakedown.joint.arguments import check_load_factor, checked
from shakedown.joint.problem import Problem
from shakedown.long_term.find_state import long_term_states
from shakedown.long_term.limit_search import LONGEST_PERIOD
from shakedown.long_term.simulation import check_slip_below, slip_criterion
from shakedown.studies.basin_map import InitialStateMap, InitialStateMaps, MissingMap
from shakedown.studies.limit_cycles import limit_cycles
from shakedown.studies.samplers import BLOCK, FIRST_TWO, Sampler, Sampling

RANGES: dict[str, float] = {  # slip ranges of states that need not be followed once more for them
    Outcome.SHAKEDOWN: 0.0,
    Outcome.RATCHETTING: inf,
    Outcome.UNDECIDED: nan,
}


@checked
def initial_state_map(
    problem: Problem,
    load_factor: float | Sequence[float],
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
) -> InitialStateMap | InitialStateMaps:
    """What becomes of a joint from many initial states (thesis §7.2.1, §7.2.2).

    Parameters
    ----------
    problem
        The joint and its loading.
    load_factor
        λ ≥ 0, or several: then a map is made at each of them where the sampler has states.
    states
        Number of initial states at each load factor, beside slip zero, the given and the critical state,
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
        A limit on the slip range of every node in the long run [length]; from how many states it holds is
        said beside the outcomes. A state that does not come to rest is followed twice for that.
    progress
        Called as ``progress(done, total)`` from time to time.
    tolerances
        What counts as zero, as reached, as periodic and as one limit cycle.

    Raises
    ------
    UsageError
        If an argument is out of range, a ball is asked for and none of the load factors has
        one, the file cannot be written, an unfinished run is kept there and not resumed, or
        processes cannot begin to work.
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
    several = isinstance(load_factor, Sequence | np.ndarray)
    factors: list[float] = [*load_factor] if several else [load_factor]  # type: ignore[misc, list-item]
    if not factors:
        raise UsageError("load factor: expected at least one, found none")
    for factor in factors:
        check_load_factor(factor, problem)
    if slip_below is not None:
        check_slip_below(slip_below)
    target = None if path is None else check_target(path)
    pair = FIRST_TWO if coordinates is None else coordinates
    patience = max_cycles, longest_period, tolerances
    wanted = [Sampling(problem, x, sampler, states, seed, pair, reach, *patience) for x in factors]
    chosen = tuple(one for one in wanted if not one.missing_ball)
    if not chosen:
        at, found = wanted[0].load_factor, wanted[0].missing_ball
        raise UsageError(f"sampler ball: expected a finite energy ball at load factor {at:g}, found {found}")
    threads = 1
    if executor is None and workers is None:
        if problem.directions == 1:  # processes take several times as much of the processor
            threads, workers = all_cores(), 1
        # states times nodes squared in space: a few seconds, as long as processes take to start
        elif len(chosen) * chosen[0].states * problem.n**2 < 1 << 13:
            workers = 1
    work = MapPieces(chosen, slip_below is not None, threads)
    run: dict[str, Any] = {"executor": executor, "workers": workers, "progress": progress}
    run |= {"settings": (work.settings(), work.size), "output": target, "resume": resume}
    with run_pieces(work, work.count, **run) as pieces:
        columns = {key: np.concatenate([piece[key] for piece in pieces]) for key in pieces[0]}
        if target is not None:
            _write(target, work, columns)
    maps, each = [], chosen[0].rows
    for k, one in enumerate(chosen):
        own: dict[str, Any] = {key: column[k * each : (k + 1) * each] for key, column in columns.items()}
        cycles = limit_cycles(one, own)
        own |= {"load_factor": one.load_factor, "sampling": one, "slip_below": slip_below}
        maps.append(InitialStateMap(**own, limit_cycles=cycles))
    missing = (MissingMap(k, one.load_factor, one.missing_ball) for k, one in enumerate(wanted))
    return InitialStateMaps(tuple(maps), tuple(one for one in missing if one.reason)) if several else maps[0]


@dataclass(frozen=True)
class MapPieces:
    """A function from the number of a piece to its long-term states, by load factor and state."""

    samplings: tuple[Sampling, ...]
    slip_ranges: bool = False  # whether to follow every state that does not come to rest once more for them
    threads: int = 1  # that share a piece

    @property
    def size(self) -> int:
        """States in one piece: about a second of work."""
        problem = self.samplings[0].problem
        # times the work of a state in the plane, with correspondingly fewer states in a piece
        return BLOCK * max(1, 256 // (problem.n if problem.directions == 1 else 16 * problem.n))

    @property
    def of_each(self) -> int:
        """Pieces of each load factor: one for the states with a name, then the others."""
        return 1 + -(-self.samplings[0].states // self.size)

    @property
    def count(self) -> int:
        """Number of pieces."""
        return len(self.samplings) * self.of_each

    def __call__(self, number: int) -> Arrays:
        which, part = divmod(number, self.of_each)
        chosen = self.samplings[which]
        slips = np.array(list(chosen.named.values()))
        if part:
            slips = chosen.slips((part - 1) * self.size, part * self.size)
        found = long_term_states(
            chosen.problem, chosen.load_factor, slips, **chosen.patience, threads=self.threads
        )
        columns: Arrays = {key: value for key, value in vars(found).items() if key != "load_factor"}
        if self.slip_ranges:
            ends = zip(found.outcome, slips, strict=True)
            columns["slip_range"] = np.array([_slip_range(chosen, *end) for end in ends], dtype=float)
        return columns

    def settings(self) -> dict[str, Any]:
        """Everything that the states depend on, to repeat them and to distinguish maps."""
        first, rest = self.samplings[0], ("problem", "load_factor", "tolerances")
        return {
            "problem_sha256": first.problem.fingerprint,
            "load_factors": [chosen.load_factor for chosen in self.samplings],
            **{each.name: getattr(first, each.name) for each in fields(first) if each.name not in rest},
            "tolerances": asdict(first.tolerances),
            "named": list(first.named),
            "slip_ranges": self.slip_ranges,
            "version": version("shakedown-bounds"),
        }


def _slip_range(chosen: Sampling, outcome: str, slip: FloatArray) -> float:
    """The largest slip range of a node in a long-term state, as in :class:`SlipCriterion`."""
    if outcome in RANGES:
        return RANGES[outcome]
    return slip_criterion(chosen.state(slip), inf, chosen.tolerances).largest


def _write(path: Path, work: MapPieces, columns: Arrays) -> None:
    """Write a map; equal ones are equal files."""
    settings = work.settings()
    factors, rows = settings["load_factors"], work.samplings[0].rows
    about = {
        "load_factor": factors[0] if len(factors) == 1 else np.repeat(factors, rows),
        "named": settings["named"],
        "settings": json.dumps(settings, ensure_ascii=False),
    }
    with atomic_write(path) as file:
        np.savez(file, allow_pickle=False, **columns, **about)
