"""Common constants: what is negligible beside 1 where no tolerance decides, and when an iteration has failed.

Sizes are relative to the terms of what they are compared with.
"""

from typing import Final

import numpy as np

EPS: Final = float(np.finfo(float).eps)
HALVINGS: Final = int(np.finfo(float).nmant) + 2  # halvings after which no float is left in a bracket
ROUND_OFF = 1e-13  # round-off of a few hundred operations
NEGLIGIBLE = 1e-9  # a negligible share: far above round-off, below the seven digits shown
SEVEN_DIGITS = 1e-7  # accuracy of limits as they are shown, and of what finite-element codes print
SIX_DIGITS = 1e-6  # accuracy of numbers that were printed, or known to half their digits
FOUR_DIGITS = 1e-4  # accuracy of rough searches that are refined later, or where more takes seconds
THREE_DIGITS = 1e-3  # clearly distinguishable from zero; a coarse search ends there
PER_CENT = 1e-2  # an irrelevant gain or loss
MUCH = 0.1  # relative difference of two limits from which on it is mentioned
SETTLED: Final = 8 * EPS  # round-off of stored data, and of an iteration that has converged
ITERATIONS = 100  # for methods that need a few dozen; beyond this they have failed
SWEEPS = 400  # the same for linear convergence: 0.9⁴⁰⁰ is below round-off
NEWTON_ROUNDS = 20  # for Newton's method, whose digits double: beyond this it has diverged
MISJUDGED = 2.0  # factor by which an estimated error may be too small
DISTINCT = 8.0  # factor above an estimated error at which a difference is real
RESOLVED = 100.0  # ratio to its error from which on a number has a certain digit
ALTERNATIONS = 4  # of two programs that improve each other: the last one gains 1e-4 or less
