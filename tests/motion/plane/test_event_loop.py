"""The compiled loop: quiet load steps against event by event, many cycles in one call, interruptions."""

import numpy as np
import pytest

import shakedown
from shakedown.motion.course import EventKind
from shakedown.motion.evolution import Evolution

SCENES = [("two-node", 0.8), ("two-node", 1.5), ("three-node", 2.6), ("block-9", 5.0), ("uncoupled", 1.5)]


def evolution_of(name, load_factor):
    problem = shakedown.example(name)
    start = None if problem.initial_slip is None else problem.initial_slip[0]
    return Evolution(problem, load_factor, start)


@pytest.mark.parametrize(("name", "load_factor"), SCENES)
def test_many_cycles_in_one_call_are_the_cycles_one_by_one(name, load_factor):
    one, many = evolution_of(name, load_factor), evolution_of(name, load_factor)
    for _ in range(12):
        assert one.cycle() is not None
    assert many.advance(12) == 12
    assert many.done == one.done == 12
    assert np.array_equal(one.state.u, many.state.u)
    assert np.array_equal(one.state.contact, many.state.contact)


@pytest.mark.parametrize(("name", "load_factor"), SCENES)
def test_a_record_changes_nothing(name, load_factor):
    plain, recorded = evolution_of(name, load_factor), evolution_of(name, load_factor)
    for _ in range(3):
        a, b = plain.cycle(), recorded.cycle(record=True)
        assert (a.events, a.dissipation, a.signature) == (b.events, b.dissipation, b.signature)
        assert np.array_equal(a.slip, b.slip)
    starts = recorded.history.kind == EventKind.LOAD_STEP
    assert starts.sum() >= 3 * plain.problem.m
