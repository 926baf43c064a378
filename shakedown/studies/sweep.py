"""Limits of the load factor over the whole grid of parameters."""

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from importlib.metadata import version
from os import PathLike
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from shakedown.bounds.registry import BOUNDS
from shakedown.campaign.pieces import Arrays, Progress, TextWork, as_text, function_stamp, run_pieces, text_of
from shakedown.files.table_file import check_table
from shakedown.ground.errors import ShakedownError, UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import check_load_factor, checked, real_array
from shakedown.joint.problem import Problem
from shakedown.long_term.slip_criterion import check_slip_below
from shakedown.models.importing.import_model import Import
from shakedown.studies.design_point import LIMITS, DesignPoint, Question, design_point, point_of
from shakedown.studies.diagram import Sweep
from shakedown.studies.variation import Configured, ProblemOf, Variation, checked_variation


@checked
def sweep(
    joint: Problem | Import | ProblemOf,
    vary: Mapping[str, ArrayLike],
    *,
    bounds: Sequence[str] | None = None,
    load_factors: Sequence[float] = (),
    initial_slip: ArrayLike | None = None,
    open_nodes: Literal["auto", "none"] = "auto",
    quick: bool = False,
    slip_below: float | None = None,
    executor: Executor | None = None,
    workers: int | None = 1,
    output: str | PathLike[str] | None = None,
    resume: bool = False,
    progress: Progress | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Sweep:
    """How the limits of the load factor move with one or two parameters of a joint.

    Every point is checked for contradictions between its limits (λ_U ≤ λ_1 ≤ λ_max, λ_E and
    λ_S ≤ λ_max, no cycle below a proved limit). Where the parameters make no joint the point says why.

    Parameters
    ----------
    joint
        A joint, of which named parameters are varied (:func:`with_parameter`). One from
        :func:`import_model`: also the numbers of its configuration, by dotted keys, tables and
        entries of lists counted from 1 (``"load.2.history.harmonics.1.sin"``), and constant loads
        by their names, in their units (``"bolt preload"``); there the factor
        on the friction is ``"friction.factor"``, the coefficient ``"f"``. Or a function
        problem(parameter) or problem(parameter, parameter) that returns one, whose arguments
        may have any names in ``vary``.
    vary
        Name → rising values, for one or two parameters.
    bounds
        Which limits: ``"lower"`` (λ_1), ``"universal"`` (λ_U), ``"energy"`` (λ_E),
        ``"accumulated"`` (λ_S, the :func:`accumulated_bound`),
        ``"transient"`` (λ_T), ``"upper"`` (λ_max); by default all that the joint has: with two
        tangential directions λ_U, λ_E, λ_S, λ_T and λ_max.
    load_factors
        Where to simulate what becomes of the joint from the state asked about.
    initial_slip : (n,), optional
        The state that λ_E, λ_S, λ_T and simulations are about [length]; zero by default.
    open_nodes
        ``"auto"``: λ_max and λ_E of the best zone of open nodes found; ``"none"``: of all
        nodes in contact.
    quick
        λ_T to 0.1 %.
    slip_below
        A limit on the slip range of every node in the long run [length]; up to which load factor it holds
        from the state asked about is said beside (:class:`~shakedown.assessment.slip_limit.SlipLimit`).
    executor
        Who works: any :class:`concurrent.futures.Executor`, as of threads, loky, MPI or
        ``dask.distributed.Client(…).get_executor()``. It is not shut down.
    workers
        Without an executor the number of processes, None one for each core; a function that makes joints has
        to be one that can be imported, and a script to keep the call under ``if __name__ == "__main__":``.
    output
        Where to write the table (:meth:`Sweep.save`). Until it is written every point is kept, as soon as it
        is known, in a file of its own in ``OUTPUT.parts``.
    resume
        Whether to go on with the points that a stopped run has left there.
    progress
        Called with (points done, points in all).
    tolerances
        What decides (:class:`Tolerances`).

    Raises
    ------
    UsageError
        If an argument is out of range, a joint has no such limit, or a function returns no problem.
    BudgetExceeded
        If there are more than a million points.
    SolverError
        If a worker dies.

    Examples
    --------
    >>> import shakedown
    >>> found = sweep(shakedown.example("two-node"), {"f": [0.2, 0.35]}, bounds=["lower", "upper"])
    >>> found.lower.round(4), found.upper.round(4)
    (array([0.4044, 0.6574]), array([0.4262, 0.7391]))
    >>> found.regions(0.5).tolist()
    ['never', 'depends on the state']
    """
    variation, values = checked_variation(joint, vary)
    question = Question(
        bounds=_checked_bounds(bounds, variation.base),
        load_factors=_checked_load_factors(load_factors),
        initial_slip=None if initial_slip is None else real_array("initial slip", initial_slip),
        open_nodes=_checked_zone(open_nodes),
        quick=bool(quick),
        slip_below=None if slip_below is None else check_slip_below(slip_below),
    )
    work = _Points(variation, values, question, tolerances)
    if output is not None:
        check_table(output)
    count = int(np.prod(work.shape))
    run: dict[str, Any] = {"executor": executor, "workers": workers, "progress": progress}
    with run_pieces(work, count, output=output, resume=resume, **run) as pieces:
        points = tuple(work.told(number, pieces.read(number)) for number in range(count))
        found = Sweep(
            name=variation.name,
            parameters=variation.parameters,
            meanings=variation.meanings,
            units=variation.units,
            values=values,
            bounds=question.bounds,
            load_factors_simulated=question.load_factors,
            points=points,
        )
        if output is not None:
            found.save(output)
    return found


def _checked_bounds(bounds: Sequence[str] | None, base: Problem | None) -> tuple[str, ...]:
    absent = () if base is None else [n for n, kind in BOUNDS.items() if not kind.exists_for(base)]
    there = tuple(name for name in LIMITS if name not in absent)
    if bounds is None:
        return there
    names = (bounds,) if isinstance(bounds, str) else tuple(bounds)
    if not names or len(set(names)) < len(names) or not set(names) <= set(there):
        found, where = ", ".join(map(str, names)) or "none", " with two directions" * bool(absent)
        raise UsageError(f"bounds{where}: expected some of {', '.join(there)}, each once, found {found}")
    return names


def _checked_load_factors(load_factors: Sequence[float]) -> tuple[float, ...]:
    for load_factor in load_factors:
        check_load_factor(load_factor)
    return tuple(float(load_factor) for load_factor in load_factors)


def _checked_zone(open_nodes: str) -> Literal["auto"] | tuple[()]:
    if open_nodes not in ("auto", "none"):
        raise UsageError(f"open_nodes: expected 'auto' or 'none', found {open_nodes!r}")
    return "auto" if open_nodes == "auto" else ()


@dataclass(frozen=True)
class _Points(TextWork):
    """The work of a sweep: from the number of a point to the point, as text."""

    variation: Variation
    values: tuple[FloatArray, ...]
    question: Question
    tolerances: Tolerances

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each parameter."""
        return tuple(len(array) for array in self.values)

    def __call__(self, number: int) -> Arrays:
        return as_text(vars(point_at(self.variation, self._at(number), self.question, self.tolerances)))

    def told(self, number: int, arrays: Arrays) -> Any:
        """The point of these values, where it answers this question."""
        point = point_of(text_of(arrays))
        simulated = len(self.question.load_factors) if point.exists else 0
        limits = self.question.bounds if point.exists else ()
        answers = (
            point.values == self._at(number)
            and set(point.limits) == set(limits)
            and len(point.outcomes) == simulated
            and _asked(point) == (self.question.slip_below if point.exists else None)
        )
        return point if answers else None

    def _at(self, number: int) -> tuple[float, ...]:
        """The values of the parameters at a point."""
        places = np.unravel_index(number, self.shape)  # the last parameter runs fastest
        return tuple(float(array[k]) for array, k in zip(self.values, places, strict=True))

    def settings(self) -> dict[str, str]:
        """All that the points depend on."""
        joint, base, initial = self.variation.joint, self.variation.base, self.question.initial_slip
        return {
            "sweep": function_stamp(joint, *self._at(0)) if base is None else base.fingerprint,  # type: ignore[arg-type]
            "configuration": _sources(self.variation),
            "values": repr(
                dict(zip(self.variation.parameters, (v.tolist() for v in self.values), strict=True))
            ),
            "question": repr(self.question._replace(initial_slip=None)),
            "initial_slip": "zero" if initial is None else repr(initial.tolist()),
            "tolerances": repr(self.tolerances),
            "version": version("shakedown-bounds"),
        }


def _asked(point: DesignPoint) -> float | None:
    """The length that slips are to stay below, where that was asked about."""
    return None if point.slip_criterion is None else point.slip_criterion.below


def _sources(variation: Variation) -> str:
    """SHA-256 of what an imported joint was made from."""
    return repr(variation.joint.made.sources) if isinstance(variation.joint, Configured) else ""


def point_at(
    variation: Variation, values: tuple[float, ...], question: Question, tolerances: Tolerances
) -> DesignPoint:
    """One point; where there is no such joint, why."""
    try:
        problem = variation.at(values)
    except ShakedownError as error:
        return DesignPoint(values, reason=str(error))
    return design_point(problem, values, question, tolerances=tolerances)
