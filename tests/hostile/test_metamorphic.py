"""Laws over random joints, singular, sparse, of whole numbers and above the friction thresholds included.

The same joint in other words has the same answers: words are equal, and numbers
agree to the round-off of the joint's condition, in units of a power of two to the
last digits.
"""

import numpy as np
import pytest
from hostile.campaign import named, numbers
from hostile.laws import EXACT, SAME_BOUNDS, SAME_EVOLUTION
from hostile.random_joints import KINDS, bounds_said, joint, outcome_said

import shakedown

ROUND_OFF = 1e-6  # a joint whose κ is singular to rounding may have a condition of 1e8
NOUGHT = 1e-9
LAST_DIGITS = 1e-12


def agree(one: tuple[float, ...], two: tuple[float, ...]) -> bool:
    return np.allclose(one, two, rtol=ROUND_OFF, atol=NOUGHT, equal_nan=True)


@pytest.mark.parametrize("law", SAME_BOUNDS)
def test_bounds(law):
    for number in numbers(len(KINDS)):
        rng = np.random.default_rng([21, number])
        problem = joint(rng, KINDS[number % len(KINDS)])
        with named(number, law):
            said, other = bounds_said(problem), bounds_said(SAME_BOUNDS[law](problem, rng))
            assert said.words == other.words
            assert agree(said.numbers, other.numbers), (said.numbers, other.numbers)
            if law in EXACT:
                assert np.allclose(said.exact, other.exact, rtol=LAST_DIGITS, atol=0.0, equal_nan=True)


@pytest.mark.parametrize("law", SAME_EVOLUTION)
def test_what_becomes_of_a_joint(law):
    for number in numbers(len(KINDS)):
        rng = np.random.default_rng([22, number])
        problem = joint(rng, KINDS[number % len(KINDS)])
        upper = shakedown.upper_bound(problem).load_factor
        load_factor = float(rng.choice([0.5, 0.9, 1.3])) * (upper if 0 < upper < 1e3 else 1.0)
        with named(number, law):
            said = outcome_said(problem, load_factor)
            other = outcome_said(SAME_EVOLUTION[law](problem, rng), load_factor)
            assert said.words == other.words
