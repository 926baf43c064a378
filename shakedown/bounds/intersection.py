"""Where n + 1 frictional constraints meet: subsets of rows solved in batches, and the best of many kept."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from math import inf, nan
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import BATCH, FloatArray
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.constraints import Constraints, rows_named
from shakedown.joint.result import Result
from shakedown.programs.program import equilibration

Candidate = tuple[float, tuple[int, ...]]
NONE: Candidate = (inf, ())


@dataclass(frozen=True, eq=False, repr=False)
class Intersection(Result):
    """The point in slip space and load factor where n + 1 rows meet.

    Attributes
    ----------
    load_factor
        λ; NaN where there is no such point.
    slip : (n,)
        v [length].
    rows
        (node, side) of the n + 1 rows.
    residual
        Largest distance from one of these rows, relative to its terms.
    excess
        Largest violation of any of the 2n rows, relative to its terms; ≤ 0 (to round-off)
        where the point lies on the safe region.
    """

    DOCUMENT: ClassVar[str] = "load_factor slip rows residual"
    TABLE: ClassVar[str] = "slip"

    load_factor: float
    slip: FloatArray
    rows: tuple[tuple[int, int], ...]
    residual: float
    excess: float


@dataclass(frozen=True)
class ScaledRows:
    """The 2n rows with every row and column near the size 1.

    Attributes
    ----------
    matrix : (2n, n + 1)
        [G | d], equilibrated.
    right : (2n,)
        g, scaled like the rows.
    column_scale : (n + 1,)
        Unscaled unknowns = scaled ones times this.
    """

    matrix: FloatArray
    right: FloatArray
    column_scale: FloatArray


def scaled_rows(rows: Constraints) -> ScaledRows:
    """Equilibrate the rows of a problem by powers of two, the same way in all units."""
    stiffness, force = _power(rows.coefficients), _power(np.column_stack([rows.d, rows.g]))
    matrix = np.column_stack([np.ldexp(rows.coefficients, -stiffness), np.ldexp(rows.d, -force)])
    row_scale, column_scale = equilibration(matrix)
    unit = np.append(np.full(rows.n, np.ldexp(1.0, force - stiffness)), 1.0)
    right = np.ldexp(rows.g, -force) * row_scale
    return ScaledRows(matrix * row_scale[:, None] * column_scale, right, column_scale * unit)


def _power(values: FloatArray) -> int:
    """The exponent of the largest: dividing by that power of two gives the same bits in all units."""
    return int(np.frexp(np.abs(values).max(initial=0.0))[1])


def intersection(rows: Constraints, subset: Iterable[int]) -> Intersection:
    """One intersection, solved in its own scale, with its residuals; NaN for the empty subset."""
    chosen = list(subset)
    if not chosen:
        return Intersection(nan, np.full(rows.n, nan), (), nan, nan)
    scaled = scaled_rows(rows)
    row_scale, column_scale = equilibration(scaled.matrix[chosen])
    matrix = scaled.matrix[chosen] * row_scale[:, None] * column_scale
    x = np.linalg.solve(matrix, scaled.right[chosen] * row_scale) * column_scale * scaled.column_scale
    excess = rows.relative_excess(x[:-1], x[-1])
    return Intersection(
        load_factor=float(x[-1]),
        slip=x[:-1],
        rows=rows_named(rows, np.array(chosen)),
        residual=float(np.abs(excess[chosen]).max()),
        excess=float(excess.max()),
    )


@dataclass(frozen=True)
class SubtreeFindings:
    """The findings of a part of the tree.

    Attributes
    ----------
    subsets, regular
        Number of subsets worked through, and of those with a load factor.
    smallest_positive, smallest_feasible
        (load factor, rows) of the smallest positive one, and of the smallest on the safe region.
    load_factors
        Of all regular ones, where asked for.
    """

    subsets: int
    regular: int
    smallest_positive: Candidate
    smallest_feasible: Candidate
    load_factors: FloatArray


def solve_subsets(
    subsets: NDArray[np.intp], rows: ScaledRows, tolerances: Tolerances, *, values: bool
) -> SubtreeFindings:
    """What subsets (b, n + 1) of the rows give; those that are singular to the tolerance give nothing."""
    square, target = rows.matrix[subsets], rows.right[subsets]
    spectrum = np.linalg.svd(square, compute_uv=False)
    condition = spectrum[:, -1] / np.where(spectrum[:, 0] > 0, spectrum[:, 0], 1.0)
    regular = condition > tolerances.degeneracy
    x = np.full(subsets.shape, nan)
    x[regular] = np.linalg.solve(square[regular], target[regular][..., None])[..., 0]
    with np.errstate(invalid="ignore", divide="ignore"):
        size = np.abs(x).max(axis=1)
        blur = np.finfo(float).eps * size / condition  # round-off of a zero load factor
        excess = (x @ rows.matrix.T - rows.right).max(axis=1)
        reach = np.maximum(size, np.abs(rows.right).max())  # the entries of the matrix are near 1
    load_factors = x[:, -1] * rows.column_scale[-1]
    positive = regular & (x[:, -1] > blur)
    feasible = positive & (excess <= tolerances.feasibility * reach)

    def smallest(admitted: NDArray[np.bool_]) -> Candidate:
        if not admitted.any():
            return NONE
        i = int(np.argmin(np.where(admitted, load_factors, inf)))
        return float(load_factors[i]), tuple(subsets[i].tolist())

    return SubtreeFindings(
        subsets=len(subsets),
        regular=int(regular.sum()),
        smallest_positive=smallest(positive),
        smallest_feasible=smallest(feasible),
        load_factors=load_factors[regular] if values else np.empty(0),
    )


def in_batches(subsets: Iterator[tuple[int, ...]]) -> Iterator[list[tuple[int, ...]]]:
    """The same subsets, ``BATCH`` at a time."""
    return iter(lambda: list(islice(subsets, BATCH)), [])


def joined(parts: list[SubtreeFindings]) -> SubtreeFindings:
    """Several findings combined."""
    return SubtreeFindings(
        subsets=sum(part.subsets for part in parts),
        regular=sum(part.regular for part in parts),
        smallest_positive=min((part.smallest_positive for part in parts), default=NONE),
        smallest_feasible=min((part.smallest_feasible for part in parts), default=NONE),
        load_factors=np.concatenate([part.load_factors for part in parts]) if parts else np.empty(0),
    )
