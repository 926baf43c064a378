"""What counts as nothing beside 1 where no tolerance decides, and when an iteration has failed: one for all.

Sizes are relative to the terms of what they are compared with. ``python -m benchmarks constants`` sets each
to half and to twice its value and says what changes.
"""

from typing import Final

import numpy as np

EPS: Final = float(np.finfo(float).eps)
HALVINGS: Final = int(np.finfo(float).nmant) + 2  # of a bracket, after which no number lies between its ends
ROUND_OFF = 1e-13  # what a few hundred operations leave of a sum that cancels
NEGLIGIBLE = 1e-9  # a share that decides nothing: far above round-off, below the seven digits that are shown
SIX_DIGITS = 1e-6  # what is left of numbers that were printed, or of what half the digits is known to
FOUR_DIGITS = 1e-4  # of what is sought roughly, to be made sharper, or where more takes seconds
THREE_DIGITS = 1e-3  # what is told from nothing for certain; a coarse search ends there
PER_CENT = 1e-2  # a gain or a loss that nobody asks about
MUCH = 0.1  # relative difference of two limits from which on it is mentioned
SETTLED: Final = 8 * EPS  # the last change of an iteration: round-off lets none come nearer
ITERATIONS = 100  # of a method that is done in a dozen or three: what still runs then has failed
SWEEPS = 400  # the same where each may leave nine tenths of the error: 0.9⁴⁰⁰ is less than round-off
