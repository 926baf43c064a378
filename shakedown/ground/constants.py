"""Common constants: sizes, what is negligible, when an iteration has failed."""

import os
from math import inf
from typing import Final, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
Mask = NDArray[np.bool_]
P = ParamSpec("P")
T = TypeVar("T")


EPS: Final = float(np.finfo(float).eps)
HALVINGS: Final = int(np.finfo(float).nmant) + 2  # halvings after which no float is left in a bracket
ROUND_OFF = 1e-13  # round-off of a few hundred operations
NEGLIGIBLE = 1e-9  # a negligible share: far above round-off, below the seven digits shown
SEVEN_DIGITS = 1e-7  # accuracy of limits as they are shown, and of what finite-element codes print
SIX_DIGITS = 1e-6  # accuracy of numbers that were printed, or known to half their digits
FOUR_DIGITS = 1e-4  # accuracy of rough searches that are refined later, or where more takes seconds
THREE_DIGITS = 1e-3  # clearly distinguishable from zero; a coarse search ends there
MINOR = 1e-2  # an irrelevant gain or loss
NOTABLE = 0.1  # relative difference of two limits from which on it is mentioned
CONVERGED: Final = 8 * EPS  # round-off of stored data, and of an iteration that has converged
ITERATIONS = 100  # for methods that need a few dozen; beyond this they have failed
SWEEPS = 400  # the same for linear convergence: 0.9⁴⁰⁰ is below round-off
NEWTON_ROUNDS = 20  # for Newton's method, whose digits double: beyond this it has diverged
ERROR_FACTOR = 2.0  # factor by which an estimated error may be too small
DISTINCT = 8.0  # factor above an estimated error at which a difference is real
RESOLVED = 100.0  # ratio to its error from which on a number has a certain digit
ALTERNATIONS = 4  # of two programs that improve each other: the last one gains 1e-4 or less


MOST_ENTRIES = 1_000_000  # entries of a list given, kept in memory, or followed one by one
LARGEST_LABEL = 2**62  # label of a node; compiled code counts to twice as many
BLOCK = 1 << 20  # bytes or numbers that are taken at one time: a few MB, a hundred where each has a matrix
EACH_SHOWN = 4  # nodes, patches, instants, numbers of a list that are listed or drawn one by one
ALL_SUBSETS_UP_TO = 6  # nodes: up to this many, every set of them is tried
ALL_PAIRS_UP_TO = 16  # nodes: up to this many, each one and every pair is tried
LARGE = 1000  # nodes: from here on a cone program over all of them takes a minute, and so does its proof
BATCH = 1 << 12  # states or subsets that one thread takes at one time, or that are kept beside it
TIMES_A_FILE = 100  # largest size of an array by its file; compressed stiffness stays below a tenth of this
READ_AT_ONCE = 1 << 26  # bytes of a table that are read
CONE = 3  # numbers of a small second-order cone: its radius, f p, then a vector in the plane, q_x and q_y
DIRECTIONS = 64  # of a circle, or places of a wave, where something is evaluated all around
MANY_ROWS = 200  # rows or columns: above this, O(n³) work dominates O(n²)
CYCLES = 1000  # default number of cycles after which a long-term state is left undecided


def memory(unknown: float = inf) -> float:
    """Memory of the machine [bytes]; ``unknown`` where it does not say."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):  # not POSIX
        return unknown
