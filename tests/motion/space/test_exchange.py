"""Open nodes are eliminated from the stiffness: what compiled loops have of it, against its definition."""

import numpy as np
import pytest

import shakedown
from shakedown.motion.evolution import Evolution


@pytest.mark.parametrize(("name", "load_factor"), [("four-node-3d", 8.0), ("bolted-flange", 4.0)])
def test_a_cycle_is_the_same_whatever_came_before_it(name, load_factor):
    joint = shakedown.example(name)
    followed, other = Evolution(joint, load_factor), Evolution(joint, load_factor)
    for _ in range(3):
        followed.cycle()
    other.state = followed.state
    other.enter_cycle(followed.done)
    one, two = followed.cycle(), other.cycle()
    assert one.opened.any()
    assert np.array_equal(one.end_slip, two.end_slip)
    assert np.array_equal(one.slip, two.slip)
    assert one.signature == two.signature
