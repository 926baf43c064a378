"""Sizes: how much is processed at one time, and limits on memory and input."""

import os
from math import inf

MANY = 1_000_000  # entries of a list given, kept in memory, or followed one by one
LARGEST_LABEL = 2**62  # label of a node; compiled code counts to twice as many
BLOCK = 1 << 20  # bytes or numbers that are taken at one time: a few MB, a hundred where each has a matrix
EACH_SHOWN = 4  # nodes, patches, instants, numbers of a list that are told or drawn each on its own
ALL_SUBSETS_UP_TO = 6  # nodes: up to this many, every set of them is tried
ALL_PAIRS_UP_TO = 16  # nodes: up to this many, each one and every pair is tried
LARGE = 1000  # nodes: from here on a cone program over all of them takes a minute, and so does its proof
AT_ONCE = 1 << 16  # rows or small matrices that are taken at one time
BATCH = 1 << 12  # states or subsets that one thread takes at one time, or that are kept beside it
TIMES_A_FILE = 100  # largest size of an array by its file; compressed stiffness stays below a tenth of this
READ_AT_ONCE = 1 << 26  # bytes of a table that are read
CONE = 3  # numbers of a small second-order cone: its radius, f p, then a vector in the plane, q_x and q_y
DIRECTIONS = 64  # of a circle, or places of a wave, where something is evaluated all around
DENSE_FROM = 60  # rows or columns: above this, a whole matrix at once is quicker than one after the other
MANY_ROWS = 200  # rows or columns: above this, O(n³) work dominates O(n²)
CYCLES = 1000  # default number of cycles after which a long-term state is left undecided


def memory(unknown: float = inf) -> float:
    """Memory of the machine [bytes]; ``unknown`` where it does not say."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):  # not POSIX
        return unknown
