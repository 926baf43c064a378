"""One joint on finer and finer meshes: which of its numbers converge."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from math import nan
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from shakedown.assessment.assess import assess
from shakedown.campaign.crew import Crew
from shakedown.campaign.journal import journal_at
from shakedown.campaign.pieces import run_campaign
from shakedown.files.atomic_write import record_beside
from shakedown.files.table_file import check_table
from shakedown.ground.errors import SolverError, UsageError
from shakedown.joint.arguments import check_load_factor, checked, is_finite, real_array, require_problem
from shakedown.joint.hat_functions import averaged
from shakedown.joint.problem import Problem
from shakedown.long_term.find_state import long_term_state
from shakedown.long_term.node_results import node_results
from shakedown.studies.meshes.refined import COLUMNS, LIMITS, Refinement

Progress = Callable[[int, int], None]
Make = Callable[[Any], Problem] | Mapping[Any, Problem]


@checked
def refine(
    make: Make,
    sizes: ArrayLike,
    *,
    radius: float | None = None,
    load_factor: float = 1.0,
    workers: int = 1,
    output: str | PathLike[str] | None = None,
    resume: bool = False,
    progress: Progress | None = None,
) -> Refinement:
    """What of a joint converges as its mesh is refined (docs/mesh.md).

    Three meshes or more tell, each with about twice as many elements along an edge as the one before.
    A number a + c h^p is fitted through the last three: it converges where p is 0.5 or more and the limit
    within a quarter of the last number; else it falls or grows, or three meshes do not tell. That is
    evidence, no proof.

    Parameters
    ----------
    make
        From a size to a joint on that mesh: a function, or joints by size.
    sizes
        Of the meshes, the coarsest first.
    radius
        The length over which slips are averaged (:func:`averaged`), the same on every mesh [length].
    load_factor
        At which friction work and slips are found.
    workers
        Number of processes; a function that makes joints has to be one that can be imported then.
    output
        Where to write the table (.csv or .parquet). Every mesh is recorded as soon as it is known, in a
        file of that name with ``.partial`` after it.
    resume
        Whether to go on with what a killed run has recorded there, if one has.
    progress
        Called with (meshes done, meshes in all).

    Raises
    ------
    UsageError
        If an argument is out of range, no joint is made, or the meshes do not get finer.

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
    real_array("sizes", sizes)
    wanted = tuple(np.ravel(np.asarray(sizes)).tolist())  # whole numbers stay such
    if not wanted or (isinstance(make, Mapping) and not set(wanted) <= set(make)):
        raise UsageError(f"sizes: expected sizes of joints, found {wanted}")
    work = _Meshes(make, wanted, radius, float(load_factor))
    partial = None if output is None else record_beside(output)
    if output is not None:
        check_table(output)
    with journal_at(partial, work.header(), resume=resume) as journal:
        run_campaign(work, len(wanted), journal, Crew(workers), progress)
        rows = [json.loads(piece) for piece in journal.pieces()]
        found = _refinement(wanted, rows, radius, float(load_factor))
        if output is not None:
            found.save(output)
        journal.remove()
    return found


def _refinement(
    sizes: tuple[float, ...], rows: Sequence[dict[str, Any]], radius: float | None, load_factor: float
) -> Refinement:
    nodes = np.array([row["nodes"] for row in rows])
    directions = {row["directions"] for row in rows}
    if (np.diff(nodes) <= 0).any() or len(directions) > 1:
        raise UsageError(
            f"sizes: expected meshes of one joint, the coarsest first, found {nodes.tolist()} contact nodes"
            + " in the plane and in space" * (len(directions) > 1)
        )
    numbers = {name: np.array([row[name] for row in rows], dtype=float) for name in COLUMNS}
    return Refinement(load_factor, radius, np.array(sizes, dtype=float), nodes, directions.pop(), numbers)


@dataclass(frozen=True)
class _Meshes:
    """The work of a refinement: from the number of a mesh to its row, as bytes."""

    make: Make
    sizes: tuple[float, ...]
    radius: float | None
    load_factor: float

    def __call__(self, number: int) -> bytes:
        size = self.sizes[number]
        problem = self.make[size] if isinstance(self.make, Mapping) else self.make(size)
        require_problem(problem)
        return json.dumps(mesh_row(problem, self.radius, self.load_factor)).encode()

    def header(self) -> dict[str, str]:
        """All that the rows depend on."""
        if isinstance(self.make, Mapping):
            for size in self.sizes:
                require_problem(self.make[size])
            joints = [self.make[size].fingerprint for size in self.sizes]
        else:
            name = getattr(self.make, "__qualname__", repr(self.make))
            coarsest = self.make(self.sizes[0])  # a function of the same name may have been changed
            require_problem(coarsest)
            joints = [f"{getattr(self.make, '__module__', '')}.{name}", coarsest.fingerprint]
        asked = self.sizes, self.radius, self.load_factor
        return {"joints": repr(joints), "question": repr(asked), "version": version("shakedown-bounds")}


def mesh_row(problem: Problem, radius: float | None, load_factor: float) -> dict[str, Any]:
    """One mesh: its nodes, and the numbers of ``COLUMNS``."""
    row: dict[str, Any] = {"nodes": problem.n, "directions": problem.directions}
    limits = assess(problem)
    for name in LIMITS[:3]:
        row[name] = _number(limits, name)
    coarse = None if radius is None else assess(averaged(problem, radius))
    row[LIMITS[3]] = nan if coarse is None else _number(coarse, LIMITS[0])
    nodes = node_results(long_term_state(problem, load_factor))
    known = nodes.period > 0
    row["work"] = float(nodes.work.sum()) if known else nan
    row["largest_slip"] = float(nodes.slip_range.max()) if known else nan
    return row


def _number(found: Any, name: str) -> float:
    """A limit; NaN where its program came to no end."""
    try:
        return float(getattr(found, name))
    except SolverError:
        return nan
