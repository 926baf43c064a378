"""Open nodes are eliminated from the stiffness: what compiled loops have of it, against its definition."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import shakedown
from shakedown.motion.evolution import Evolution


def outputs_from_inputs(kappa, free):
    """κ with the free places exchanged: their displacements and the other reactions, block by block."""
    held, found = ~free, np.empty_like(kappa)
    inverse = np.linalg.inv(kappa[np.ix_(free, free)])
    follows = inverse @ kappa[np.ix_(free, held)]
    found[np.ix_(free, free)], found[np.ix_(free, held)] = inverse, -follows
    found[np.ix_(held, free)] = follows.T
    found[np.ix_(held, held)] = kappa[np.ix_(held, held)] - kappa[np.ix_(held, free)] @ follows
    return found


@pytest.mark.parametrize(("name", "load_factor"), [("four-node-3d", 8.0), ("block-3x3", 20.0)])
def test_the_stiffness_with_open_nodes_eliminated_follows_from_it(name, load_factor):
    motion = Evolution(shakedown.example(name), load_factor)
    for _ in range(3):
        assert motion.cycle() is not None
        joint = motion.method.run.joint
        free = joint.free == 1
        assert free.any()
        exact = outputs_from_inputs(joint.kappa, free)
        size = abs(exact).max(axis=1, keepdims=True)
        assert_allclose(joint.exchanged / size, exact / size, atol=1e-12)


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
