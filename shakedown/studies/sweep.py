"""Limits of the load factor over the whole grid of parameters."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from os import PathLike
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from shakedown.bounds.plane_or_space import methods_of
from shakedown.campaign.crew import Crew
from shakedown.campaign.journal import journal_at
from shakedown.campaign.pieces import function_stamp, run_campaign
from shakedown.campaign.stored_result import restored, stored
from shakedown.files.atomic_write import record_beside
from shakedown.files.table_file import check_table
from shakedown.ground.errors import ProblemError, ShakedownError, UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import check_load_factor, checked, real_array
from shakedown.joint.problem import Problem
from shakedown.long_term.slip_criterion import check_slip_below
from shakedown.models.importing.import_model import Import
from shakedown.studies.design_point import LIMITS, DesignPoint, Question, design_point
from shakedown.studies.diagram import Sweep
from shakedown.studies.variation import Configured, ProblemOf, Variation, checked_variation

Progress = Callable[[int, int], None]


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
    workers: int = 1,
    scheduler: str | None = None,
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
    workers
        Number of processes; of a function that makes joints it has to be one that can be
        imported, and the script has to keep the call under ``if __name__ == "__main__"``.
    scheduler
        Address of a dask scheduler, whose workers take over.
    output
        Where to write the table (:meth:`Sweep.save`). Until it is written every point is
        recorded, as soon as it is known, in a file of that name with ``.partial`` after it.
    resume
        Whether to go on with what a killed run has recorded there, if one has.
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
        If worker processes die again and again.

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
    crew, partial = Crew(workers, scheduler), None if output is None else record_beside(output)
    if output is not None:
        check_table(output)
    header = {} if partial is None else work.header()
    with journal_at(partial, header, resume=resume) as journal:
        run_campaign(work, int(np.prod(work.shape)), journal, crew, progress, work.fits)
        points = tuple(restored(piece) for piece in journal.pieces())
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
        journal.remove()
    return found


def _checked_bounds(bounds: Sequence[str] | None, base: Problem | None) -> tuple[str, ...]:
    absent = () if base is None else methods_of(base).ABSENT
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
class _Points:
    """The work of a sweep: from the number of a point to the point, as bytes."""

    variation: Variation
    values: tuple[FloatArray, ...]
    question: Question
    tolerances: Tolerances

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each parameter."""
        return tuple(len(array) for array in self.values)

    def __call__(self, number: int) -> bytes:
        return stored(point_at(self.variation, self._at(number), self.question, self.tolerances))

    def fits(self, number: int, piece: bytes) -> bool:
        """Whether a recorded piece is a point of these values that answers this question."""
        try:
            point = restored(piece)
        except ProblemError:
            return False
        if not isinstance(point, DesignPoint):
            return False
        simulated = len(self.question.load_factors) if point.exists else 0
        limits = self.question.bounds if point.exists else ()
        return (
            point.values == self._at(number)
            and set(point.limits) == set(limits)
            and len(point.outcomes) == simulated
            and _asked(point) == (self.question.slip_below if point.exists else None)
        )

    def _at(self, number: int) -> tuple[float, ...]:
        """The values of the parameters at a point."""
        places = np.unravel_index(number, self.shape)  # the last parameter runs fastest
        return tuple(float(array[k]) for array, k in zip(self.values, places, strict=True))

    def header(self) -> dict[str, str]:
        """All that the points depend on."""
        joint, base, initial = self.variation.joint, self.variation.base, self.question.initial_slip
        return {
            "joint": function_stamp(joint, *self._at(0)) if base is None else base.fingerprint,  # type: ignore[arg-type]
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
