"""Bodies that nothing holds slide away, and are told so, however far they have come: round-off grows with the way."""

import numpy as np
import pytest

from benchmarks.space_verdicts import KINDS, random_joint
from shakedown.motion.evolution import Evolution

FLOATING, STIFF = "floating", "floating, stiff and soft"


def joint(kind, seed, number):
    return random_joint(np.random.default_rng([seed, KINDS.index(kind), number]), kind, 4)


@pytest.mark.parametrize(
    ("kind", "seed", "number", "load_factor"),
    [
        (FLOATING, 24, 0, 20.0),  # the only closed node slips, and round-off of its stiffness held it
        (FLOATING, 22, 0, 40.0),
        (STIFF, 14, 1, 12.0),
        (STIFF, 19, 0, 12.0),  # the slide is looked for after thousands of lengths
        (STIFF, 28, 0, 6.0),
    ],
)
def test_a_body_that_nothing_holds_slides_away(kind, seed, number, load_factor):
    motion = Evolution(joint(kind, seed, number), load_factor)
    motion.advance(2)
    assert motion.stop is not None
    assert motion.stop.slides_away
    assert np.abs(motion.state.u).max() <= 1e6 * motion.scale.length
