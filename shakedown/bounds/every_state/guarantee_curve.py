"""The first collapse for initial states near the safe slip: λ_1 against the radius of a box."""

from dataclasses import dataclass
from math import inf, nan
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.bounds.collapse.collapse_programs import collapse_in_box
from shakedown.bounds.row_programs import load_factor_program
from shakedown.bounds.safe_slip import safe_slip
from shakedown.bounds.uniqueness.coupling import coupling
from shakedown.bounds.upper import upper_bound
from shakedown.ground.errors import SolverError, UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.shown_values import short
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import NO_SIDES, checked, real_array, require_plane
from shakedown.joint.constraints import Constraints, constraints
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.programs.program import INF
from shakedown.programs.simplex import Simplex


@dataclass(frozen=True, eq=False, repr=False)
class GuaranteeCurve(Result):
    """λ_1(R): the first collapse with every other slip within R of the safe slip.

    Attributes
    ----------
    status
        Optimal, or infeasible where there is no safe slip to start from.
    radii : (k,)
        R, in multiples of ``unit``.
    load_factors : (k,)
        λ_1(R): falls from λ_max (R = 0) to λ_1 (R → ∞); inf where no node collapses.
    nodes : (k,)
        The node that collapses; −1 where none does.
    slips : (k, n)
        The critical slip states [length].
    centre : (n,)
        The safe slip ṽ in the middle of the boxes [length].
    weights : (n,)
        d: the box is |v_i − ṽ_i| ≤ R d_i unit.
    unit
        max |ṽ|, or where ṽ = 0 the largest distance g / ‖G‖ of a row [length].
    invariant
        Whether slip never leads out of a box while all nodes stay closed, at any load factor up to
        the largest λ_1(R) asked for: so it is for ρ* < 1, weights with N∓ d ≤ d and a centre that is safe at
        all of them, because every limit at a slip in the box differs from that at ṽ by at most
        N∓ (R d) ≤ R d. Then λ_1(R) is *proved* for every state in the box, closed and admissible, from
        which no node lifts off, of a loop (docs/guarantee.md, statement 7).
    pinned
        Where the joint can move as a whole: the nodes that slips, and so the boxes, are relative to.
    """

    DOCUMENT: ClassVar[str] = "status radii load_factors nodes unit weights invariant pinned"
    TABLE: ClassVar[str] = "radii load_factors nodes"

    status: Status
    radii: FloatArray
    load_factors: FloatArray
    nodes: NDArray[np.intp]
    slips: FloatArray
    centre: FloatArray
    weights: FloatArray
    unit: float
    invariant: bool
    pinned: tuple[int, ...] = ()


@checked
def guarantee_curve(
    problem: Problem,
    radii: ArrayLike,
    *,
    weights: ArrayLike | None = None,
    centre: ArrayLike | None = None,
    tolerances: Tolerances = DEFAULT,
) -> GuaranteeCurve:
    """The first collapse when initial states stay near the safe slip.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    radii : (k,)
        Half-widths of the box of slips, ≥ 0, in multiples of max |ṽ| (dimensionless).
    weights : (n,), optional
        Positive shape of the box; by default the Perron vector of the coupling where
        its ratio is below 1 (then the box is invariant), else 1 for every node.
    centre : (n,), optional
        The slip in the middle [length]; by default the safe slip at λ_max, or at load
        factor 1 where there is no λ_max.
    tolerances
        The tolerances that decide.

    Raises
    ------
    UsageError
        If a radius is negative or not a number, or a shape does not fit.
    SolverError
        If a linear program ends without an answer.

    Examples
    --------
    >>> import shakedown
    >>> curve = shakedown.guarantee_curve(shakedown.example("two-node"), [0.0, 0.5, 100.0])
    >>> curve.load_factors.round(4), curve.invariant
    (array([0.7391, 0.708 , 0.6574]), True)
    """
    require_plane("guarantee curve", problem, NO_SIDES)
    rows = constraints(problem)
    try:
        radius = np.atleast_1d(np.asarray(radii, dtype=float))
    except (TypeError, ValueError, OverflowError):
        raise UsageError(f"radii: expected numbers >= 0, found {short(radii)}") from None
    if radius.ndim != 1 or not np.all(radius >= 0):
        raise UsageError(f"radii: expected numbers >= 0, found {radius}")
    middle = _centre(problem, tolerances) if centre is None else _vector("centre", centre, problem.n)
    middle = rows.rigid.relative(middle)
    influence = coupling(problem)
    weak = influence.bound < 1.0
    shape = influence.weights if weak else np.ones(problem.n)
    if weights is not None:
        shape = _vector("weights", weights, problem.n)
        if np.any(shape <= 0):
            raise UsageError("weights: expected positive numbers")
        weak = weak and bool(np.all(influence.influence @ shape <= shape))
    unit = _unit(rows, middle)
    found = _first_collapses(rows, middle, radius, unit * shape, tolerances)
    return GuaranteeCurve(
        status=Status.INFEASIBLE if np.any(np.isnan(middle)) else Status.OPTIMAL,
        radii=radius,
        load_factors=np.array([f[0] for f in found]),
        nodes=np.array([f[1] for f in found], dtype=np.intp),
        slips=np.array([f[2] for f in found]),
        centre=middle,
        weights=shape,
        unit=unit,
        invariant=weak and _safe_below(rows, middle, [f[0] for f in found], tolerances),
        pinned=rows.pinned,
    )


def _centre(problem: Problem, tolerances: Tolerances) -> FloatArray:
    upper = upper_bound(problem, certify=False, tolerances=tolerances)
    if upper.status != Status.UNBOUNDED:
        return upper.slip
    return safe_slip(problem, max(1.0, upper.least_load_factor), tolerances=tolerances).slip


def _safe_below(
    rows: Constraints, centre: FloatArray, load_factors: list[float], tolerances: Tolerances
) -> bool:
    """Whether a slip is safe at every load factor up to the largest of these that is finite.

    Safe load factors of one slip are an interval, so both ends tell.
    """
    if np.any(np.isnan(centre)):
        return False
    ends = (0.0, max((each for each in load_factors if each < inf), default=0.0))
    with np.errstate(over="ignore", invalid="ignore"):  # on overflow no slip is safe
        return all(bool(rows.relative_excess(centre, end).max() <= tolerances.feasibility) for end in ends)


def _vector(name: str, values: ArrayLike, n: int) -> FloatArray:
    vector = real_array(name, values)
    if vector.shape != (n,):
        raise UsageError(f"{name}: expected {n} finite numbers, found shape {vector.shape}")
    return vector


def _unit(rows: Constraints, centre: FloatArray) -> float:
    largest = float(np.abs(centre).max())
    if largest != 0.0:
        return largest
    norms = np.linalg.norm(rows.G, axis=1)
    return float(np.max(np.abs(rows.g)[norms > 0] / norms[norms > 0], initial=0.0)) or 1.0


def _first_collapses(
    rows: Constraints, centre: FloatArray, radii: FloatArray, shape: FloatArray, tolerances: Tolerances
) -> list[tuple[float, int, FloatArray]]:
    """(load factor, node, critical slip) of the first collapse with the other nodes' slips in each box.

    From the largest box to the smallest: what a node reaches in a box is a lower bound of what
    it reaches in a smaller one, so that most nodes need no program there.
    """
    nothing = inf, -1, np.full(rows.n, nan)
    if np.any(np.isnan(centre)):
        return [(nan, *nothing[1:])] * len(radii)
    program = Simplex(load_factor_program(rows, towards=+1.0, tolerances=tolerances))
    found = [nothing] * len(radii)
    shape = np.where(np.isin(np.arange(rows.n), rows.pinned), 0.0, shape)
    known = np.zeros(rows.n)  # load factors below which a node does not collapse
    for k in np.argsort(-radii, kind="stable"):
        lower, upper = centre - radii[k] * shape, centre + radii[k] * shape
        program.set_columns(np.arange(rows.n), lower, upper)
        for node in np.argsort(known, kind="stable").tolist():
            if known[node] >= found[k][0]:
                break  # nor do the nodes after it
            value, slip = _collapse(program, rows, node, lower, upper)
            known[node] = max(known[node], value)
            if known[node] < found[k][0]:
                found[k] = known[node], node, slip
    return found


def _collapse(
    program: Simplex, rows: Constraints, node: int, lower: FloatArray, upper: FloatArray
) -> tuple[float, FloatArray]:
    """(load factor, critical slip) where a node collapses first in a box; inf and NaN where it does not.

    Where the size of the box leaves no answer: the load factor in any slip, no larger, without a slip.
    """
    nowhere = np.full(rows.n, nan)
    try:
        vertex = collapse_in_box(program, rows, node, lower, upper)
        return (inf, nowhere) if vertex is None else (float(vertex[-1]), rows.slips(vertex[:-1]))
    except SolverError:
        columns, free = np.setdiff1d(np.arange(rows.n), rows.pinned), np.full(rows.n, INF)
        program.set_columns(columns, -free[columns], free[columns])
        try:
            vertex = collapse_in_box(program, rows, node, lower, upper)
        finally:
            program.set_columns(columns, lower[columns], upper[columns])
        return (inf if vertex is None else float(vertex[-1])), nowhere
