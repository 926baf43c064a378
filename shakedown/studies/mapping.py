"""Long-term states from many initial states: the public function."""

import logging
import os
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path
from typing import Any, overload

import numpy as np

from shakedown.campaign.pieces import remove_pieces, run_pieces
from shakedown.files.atomic_write import check_target, pieces_beside
from shakedown.ground.blas_threads import all_cores
from shakedown.ground.errors import UsageError
from shakedown.ground.size_limits import CYCLES
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.ground.visible_text import visible
from shakedown.joint.arguments import check_load_factor, checked
from shakedown.joint.problem import Problem
from shakedown.long_term.limit_search import LONGEST_PERIOD
from shakedown.long_term.slip_criterion import check_slip_below
from shakedown.studies.basin_map import InitialStateMap, InitialStateMaps, MissingMap, basin_map
from shakedown.studies.map_file import Columns, finished_map, mapped_columns, write_map
from shakedown.studies.map_pieces import MapPieces, MapSearch
from shakedown.studies.samplers import Sampler, require_ball, sampling

LOGGER = logging.getLogger("shakedown")


@overload
def initial_state_map(
    problem: Problem,
    load_factor: float,
    *,
    states: int = ...,
    sampler: str = ...,
    seed: int = ...,
    coordinates: tuple[int, int] | None = ...,
    reach: float = ...,
    path: str | os.PathLike[str] | None = ...,
    resume: bool = ...,
    executor: Executor | None = ...,
    workers: int | None = ...,
    max_cycles: int = ...,
    longest_period: int = ...,
    slip_below: float | None = ...,
    progress: Callable[[int, int], None] | None = ...,
    tolerances: Tolerances = ...,
) -> InitialStateMap: ...


@overload
def initial_state_map(
    problem: Problem,
    load_factor: Sequence[float],
    *,
    states: int = ...,
    sampler: str = ...,
    seed: int = ...,
    coordinates: tuple[int, int] | None = ...,
    reach: float = ...,
    path: str | os.PathLike[str] | None = ...,
    resume: bool = ...,
    executor: Executor | None = ...,
    workers: int | None = ...,
    max_cycles: int = ...,
    longest_period: int = ...,
    slip_below: float | None = ...,
    progress: Callable[[int, int], None] | None = ...,
    tolerances: Tolerances = ...,
) -> InitialStateMaps: ...


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
        ``"latin"``, ``"ball"`` or ``"transients"``. The box of the first three has the
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
        each whole after a kill at any instant. The result's arrays
        then stay on the disk; while statistics are taken, memory holds some 25
        bytes of each state, and no slips.
    resume
        Whether to go on with the pieces that are there; a map that is whole already is read.
    executor
        Who works: any :class:`concurrent.futures.Executor`, as of threads, loky, MPI or
        ``dask.distributed.Client(…).get_executor()``. It is not shut down.
    workers
        Without an executor the number of processes. None is one for a little work, in the plane with threads
        for half a minute's, else one for each core. A script has to keep the call under
        ``if __name__ == "__main__":`` where it is more than one.
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
    wanted = [
        sampling(
            problem,
            factor,
            sampler,
            states=states,
            seed=seed,
            coordinates=coordinates,
            reach=reach,
            tolerances=tolerances,
        )
        for factor in factors
    ]
    missing = tuple(
        MissingMap(place, one.load_factor, one.missing_ball)
        for place, one in enumerate(wanted)
        if one.missing_ball
    )
    chosen = tuple(one for one in wanted if not one.missing_ball) or (require_ball(wanted[0]),)
    work = MapPieces(
        chosen, MapSearch(max_cycles, longest_period, tolerances), slip_ranges=slip_below is not None
    )
    if executor is None and workers is None and (work.little or work.for_threads):
        workers, work = 1, replace(work, threads=all_cores() if work.for_threads else 1)
    if executor is not None or workers != 1:
        work = work.for_other_processes()
    run = {"executor": executor, "workers": workers, "progress": progress}
    columns = _columns(work, target, resume, run)
    each = chosen[0].rows
    maps = tuple(
        basin_map(
            one,
            work.search,
            {key: c[k * each : (k + 1) * each] for key, c in columns.items() if c.ndim},
            slip_below,
        )
        for k, one in enumerate(chosen)
    )
    return InitialStateMaps(maps, missing) if several else maps[0]


def _columns(work: MapPieces, target: Path | None, resume: bool, run: dict[str, Any]) -> Columns:
    """All states of all load factors, done now or before; on the disk where they have a file."""
    settings, kinds = work.of_the_map(), work.kinds(len(work.samplings) * work.samplings[0].rows)
    if len(work.samplings) == 1:
        kinds["load_factor"] = (kinds["load_factor"][0], ())
    if resume and target is not None and target.exists():
        found = finished_map(target, settings, kinds)
        if found is not None:
            remove_pieces(Path(pieces_beside(target)))
            return found
        LOGGER.warning("%s: not this map, or altered since; made again", visible(str(target)))
    with run_pieces(work, work.count, output=target, resume=resume, **run) as pieces:
        if target is None:
            whole = [pieces.read(number) for number in range(work.count)]
            return {key: np.concatenate([piece[key] for piece in whole]) for key in whole[0]}
        write_map(target, pieces, work.count, kinds, settings)
    return mapped_columns(target)
