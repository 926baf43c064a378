"""The state of the compiled walk through the row subsets: what is asked, where it stands, what it found."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray

IntArray = NDArray[np.int64]

# Indices into the counters of ``Found``.
REGULAR, SUSPECTS, STORED, VIOLATED = range(4)


class WalkSearch(NamedTuple):
    """The settings of the walk.

    Attributes
    ----------
    rows : (R, N + 1)
        Rows of size about 1: N − 1 slips, the load factor, the right-hand side.
    one_pair
        Only the paths 0, 1, then one of every further two rows.
    feasibility
        Largest violation of a row that a point on the safe region may have, relative
        to the largest terms.
    cut
        Load factors above it are stored; at +inf none is.
    """

    rows: FloatArray
    one_pair: bool
    feasibility: float
    cut: float


class WalkElimination(NamedTuple):
    """The state of the walk: the rows chosen, and all others after elimination.

    Attributes
    ----------
    work : (N, N + 1, R)
        At every depth, column by column, the rows without the slips eliminated so far.
    path, last : (N,)
        The row chosen at every depth, and the last one that can be.
    pivots : (N,)
        The column eliminated at every depth.
    known, level : (N + 1,)
        Whether the load factor is eliminated above a depth, and its value.
    x : (N,)
        Array for one point.
    square : (N, N + 1)
        Arrays for the equations of one subset.
    """

    work: FloatArray
    path: IntArray
    last: IntArray
    pivots: IntArray
    known: NDArray[np.bool_]
    level: FloatArray
    x: FloatArray
    square: FloatArray


class Suspects(NamedTuple):
    """Receives the suspect prefixes (S, N) and their lengths (S,), as far as it reaches; counts them all."""

    prefixes: IntArray
    lengths: IntArray
    counters: IntArray


class WalkFindings(NamedTuple):
    """The findings of the walk.

    Attributes
    ----------
    values
        Receives the load factors above the cut, as far as it reaches.
    record : (2,)
        In and out: smallest positive load factor so far, and smallest one on the safe region.
    subsets : (2, N)
        Their rows, where the walk found them; else zero.
    counters : (4,)
        Number of regular subsets, suspect prefixes, load factors above the cut, and the
        row found violated last.
    """

    values: FloatArray
    record: FloatArray
    subsets: IntArray
    counters: IntArray


class Whole(NamedTuple):
    """The data of one walk."""

    search: WalkSearch
    state: WalkElimination
    found: WalkFindings
    suspects: Suspects


class Limits(NamedTuple):
    """The last row that can stand third from the end, the number of rows given, and the cut."""

    last: int
    given: int
    cut: float
