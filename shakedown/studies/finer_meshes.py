"""One joint on finer and finer meshes: which of its numbers converge."""

import logging
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from importlib.metadata import version
from math import nan
from os import PathLike
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from shakedown.assessment.assess import assess
from shakedown.assessment.slip_limit import slip_limit
from shakedown.campaign.pieces import Arrays, Progress, TextWork, as_text, function_stamp, run_pieces, text_of
from shakedown.files.table_file import check_table
from shakedown.ground.errors import SolverError, UsageError
from shakedown.ground.status import Outcome
from shakedown.ground.visible_text import shortened
from shakedown.joint.arguments import check_load_factor, checked, is_finite, real_array, require_problem
from shakedown.joint.contact_surface import element_count
from shakedown.joint.hat_functions import averaged
from shakedown.joint.problem import Problem
from shakedown.long_term.find_state import long_term_state
from shakedown.long_term.node_results import node_results
from shakedown.long_term.slip_criterion import check_slip_below
from shakedown.studies.refined import COLUMNS, LIMITS, Refinement

Make = Callable[[Any], Problem] | Mapping[Any, Problem]
LOGGER = logging.getLogger("shakedown")
KINDS = {  # what a row holds
    np.int64: ("nodes", "directions", "load steps"),
    float: ("elements", *COLUMNS),
    str: ("fingerprint", "units"),
    list: ("friction", "loads"),
}
ROW: dict[str, Any] = {name: kind for kind, names in KINDS.items() for name in names}


class Asked(NamedTuple):
    """The request for every mesh: a load factor, the averaging length, the limit on slips."""

    load_factor: float
    radius: float | None
    slip_below: float | None


@checked
def refine(
    make: Make,
    sizes: ArrayLike,
    *,
    radius: float | None = None,
    load_factor: float = 1.0,
    slip_below: float | None = None,
    executor: Executor | None = None,
    workers: int | None = 1,
    output: str | PathLike[str] | None = None,
    resume: bool = False,
    progress: Progress | None = None,
) -> Refinement:
    """Which numbers of a joint converge as its mesh is refined (docs/mesh.md).

    Three meshes or more tell, each with about twice as many elements along an edge as the one before.
    A number a + c h^p is fitted through the last three, h^(−d) the number of elements: it converges where p
    is 0.5 or more and the limit within a quarter of the last number; else it falls or grows, or three meshes
    do not tell. That is evidence, no proof. Where it is 0 on all three it is called zero, no more.

    Parameters
    ----------
    make
        The joint on the mesh of a size: a function of it, or joints by size.
    sizes
        Sizes of the meshes, the coarsest first.
    radius
        The length over which slips are averaged (:func:`averaged`), the same on every mesh [length].
    load_factor
        At which friction work and slips are found.
    slip_below
        Also up to which load factor the slip of every node stays below this length [length].
    executor
        Who works: any :class:`concurrent.futures.Executor`; it is not shut down.
    workers
        Without one the number of processes; a function that makes joints has to be one that can be imported,
        and a script to keep the call under ``if __name__ == "__main__":``.
    output
        Where to write the table (.csv or .parquet). Until then every mesh is kept, as soon as it is known, in
        a file of its own in ``OUTPUT.parts``.
    resume
        Whether to go on with the meshes that a stopped run has left there.
    progress
        Called with (meshes done, meshes in all).

    Raises
    ------
    UsageError
        If an argument is out of range, no joint is made, the meshes do not get finer, or their units differ.

    Examples
    --------
    >>> import shakedown
    >>> joints = {name: shakedown.example(name) for name in ("block-9", "block-33")}
    >>> found = refine({joint.n: joint for joint in joints.values()}, [9, 33])
    >>> found.nodes.tolist(), found.verdict["impossible_above"]
    ([9, 33], 'undecided')
    """
    check_load_factor(load_factor)
    if radius is not None and not (is_finite(radius) and radius > 0):
        raise UsageError(f"radius: expected a length above 0, found {radius!r}")
    if slip_below is not None:
        slip_below = check_slip_below(slip_below)
    real_array("sizes", sizes)
    wanted = tuple(np.ravel(np.asarray(sizes)).tolist())  # whole numbers stay such
    if not wanted or (isinstance(make, Mapping) and not set(wanted) <= set(make)):
        raise UsageError(f"sizes: expected sizes of joints, found {wanted}")
    work = _Meshes(make, wanted, Asked(float(load_factor), radius, slip_below))
    if output is not None:
        check_table(output)
    if isinstance(make, Mapping):  # for a function the joints are known only afterwards
        _check_one_joint([_about(make[size]) for size in wanted])
    run: dict[str, Any] = {"executor": executor, "workers": workers, "progress": progress}
    with run_pieces(work, len(wanted), output=output, resume=resume, **run) as pieces:
        rows = [work.told(number, pieces.read(number)) for number in range(len(wanted))]
        if not isinstance(make, Mapping):
            _check_one_joint(rows)
        found = _refinement(wanted, rows, work.asked)
        if output is not None:
            found.save(output)
    return found


def _about(problem: Problem) -> dict[str, Any]:
    """What a mesh is, and what of the joint it does not change."""
    require_problem(problem)
    return {
        "nodes": problem.n,
        "elements": element_count(problem),
        "directions": problem.directions,
        "fingerprint": problem.fingerprint,
        "units": problem.units,
        "friction": [float(problem.f.min()), float(problem.f.max())],
        "load steps": problem.m,
        "loads": list(problem.load_names or ()),
    }


def _check_one_joint(meshes: Sequence[Mapping[str, Any]]) -> None:
    """Refuse meshes that do not get finer, and other units; say what else differs, which no mesh changes."""
    nodes = [mesh["nodes"] for mesh in meshes]
    spaces, units = (list(dict.fromkeys(mesh[name] for mesh in meshes)) for name in ("directions", "units"))
    if (np.diff(nodes) <= 0).any() or len(spaces) > 1:
        found = f"{shortened(str(nodes))} contact nodes" + " in the plane and in space" * (len(spaces) > 1)
        raise UsageError(f"meshes: expected one joint, the coarsest first, found {found}")
    if len(units) > 1:
        raise UsageError(f"meshes: expected one joint in the same units, found {shortened(repr(units))}")
    kept = ("friction", "load steps", "loads")
    differ = [name for name in kept if any(mesh[name] != meshes[0][name] for mesh in meshes)]
    if differ:
        LOGGER.warning("the meshes differ in %s: are they one joint?", " and ".join(differ))


def _refinement(sizes: tuple[float, ...], rows: Sequence[dict[str, Any]], asked: Asked) -> Refinement:
    return Refinement(
        *asked,
        np.array(sizes, dtype=float),
        np.array([row["nodes"] for row in rows]),
        rows[0]["directions"],
        {name: np.array([row[name] for row in rows], dtype=float) for name in COLUMNS},
        tuple(row["fingerprint"] for row in rows),
        np.array([row["elements"] for row in rows]),
    )


@dataclass(frozen=True)
class _Meshes(TextWork):
    """The work of a refinement: from the number of a mesh to its row, as text."""

    make: Make
    sizes: tuple[float, ...]
    asked: Asked

    def __call__(self, number: int) -> Arrays:
        size = self.sizes[number]
        problem = self.make[size] if isinstance(self.make, Mapping) else self.make(size)
        return as_text(_about(problem) | mesh_row(problem, *self.asked))

    def told(self, number: int, arrays: Arrays) -> dict[str, Any]:
        """The row of a mesh."""
        said = text_of(arrays)
        return {name: kind(said[name]) for name, kind in ROW.items()}

    def settings(self) -> dict[str, str]:
        """All that the rows depend on."""
        if isinstance(self.make, Mapping):
            joints = [self.make[size].fingerprint for size in self.sizes]
        else:
            joints = [function_stamp(self.make, self.sizes[0])]
        return {
            "refine": repr(joints),
            "sizes": repr(self.sizes),
            "question": repr(self.asked),
            "version": version("shakedown-bounds"),
        }


def mesh_row(
    problem: Problem, load_factor: float, radius: float | None, slip_below: float | None
) -> dict[str, Any]:
    """The numbers of one mesh, by ``COLUMNS``."""
    row: dict[str, Any] = {}
    limits = assess(problem)
    for name in LIMITS[:3]:
        row[name] = _number(limits, name)
    coarse = None if radius is None else assess(averaged(problem, radius))
    row[LIMITS[3]] = nan if coarse is None else _number(coarse, LIMITS[0])
    state = long_term_state(problem, load_factor)
    nodes, slips = node_results(state), state.outcome != Outcome.SHAKEDOWN  # else what is left is round-off
    known = nodes.period > 0
    row["work"] = float(slips * nodes.work.sum()) if known else nan
    row["largest_slip"] = float(slips * nodes.slip_range.max()) if known else nan
    row["slip_limit"] = nan if slip_below is None else slip_limit(problem, slip_below).load_factor
    return row


def _number(found: Any, name: str) -> float:
    """A limit; NaN where its program did not finish."""
    try:
        return float(getattr(found, name))
    except SolverError:
        return nan
