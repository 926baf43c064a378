"""The judge of every path, clause by clause; compiled code restates Coulomb's law, each method in its own way.

Whatever follows a path names contact states and reactions itself: by rates from event to event in the plane,
along smooth curves in space, by sweeps over the nodes. All of them are held against the one law here, node by
node, on joints whose nodes stick, slip and open.
"""

import numpy as np
import pytest
from joints_in_space import random_joint

import shakedown
from shakedown.ground.status import OPEN, STICK
from shakedown.long_term.plane import search
from shakedown.motion.checked_law import Scales, law_resolution, law_violation, scales
from shakedown.motion.course import EventKind
from shakedown.motion.evolution import Evolution
from shakedown.motion.fixed_steps import FixedSteps
from shakedown.motion.method import walk

# (f, q, p, w, slip), and by how much the law is broken
STATES = {
    "no penetration": ((0.5, 0.0, 0.0, -0.25, 0.0), 0.25),
    "no tension": ((0.0, 0.0, -0.25, 0.0, 0.0), 0.25),
    "an open node carries nothing": ((0.5, 0.0, 0.25, 2.0, 0.0), 0.25),
    "Coulomb": ((0.5, 0.75, 1.0, 0.0, 0.0), 0.25),
    "forward slip": ((0.5, 0.25, 1.0, 0.0, 0.5), 0.5),
    "backward slip": ((0.5, -0.25, 1.0, 0.0, -0.5), 0.5),
    "lawful stick": ((0.5, 0.25, 1.0, 0.0, 0.0), 0.0),
    "lawful stick on the backward limit": ((0.5, 0.5, 1.0, 0.0, 0.0), 0.0),
    "lawful forward slip": ((0.5, -0.5, 1.0, 0.0, 0.5), 0.0),
    "lawful backward slip": ((0.5, 0.5, 1.0, 0.0, -0.5), 0.0),
    "lawful open": ((0.5, 0.0, 0.0, 1.0, 0.0), 0.0),
    "lawful apex": ((0.5, 0.0, 0.0, 0.0, 0.0), 0.0),
    "lawful frictionless slip": ((0.0, 0.0, 1.0, 0.0, 0.5), 0.0),
}


def violation(judge, state, scale):
    f, q, p, w, slip = (np.array([x]) for x in state)
    return float(judge(f, q * scale.force, p * scale.force, w * scale.length, slip * scale.length, scale)[0])


@pytest.mark.parametrize("case", STATES)
@pytest.mark.parametrize("scale", [Scales(1.0, 1.0), Scales(1e9, 1e-6)], ids=str)
def test_what_breaks_a_clause_is_found_and_measured_and_what_obeys_the_law_passes(case, scale):
    state, size = STATES[case]
    assert violation(law_violation, state, scale) == pytest.approx(size, rel=1e-12, abs=0.0)


def test_the_compiled_check_of_a_cycle_says_the_same(monkeypatch):
    monkeypatch.setattr(search, "larger", max)
    monkeypatch.setattr(search, "smaller", min)
    random = np.random.default_rng(0).normal(size=(200, 5)) * (0, 1, 1, 1, 1) + (0.5, 0, 0, 0, 0)
    states = [*(state for state, _ in STATES.values()), *random]
    scale = Scales(1e9, 1e-6)

    def compiled(f, q, p, w, slip, scale):
        return np.maximum([search.broken_law.py_func(scale, f[0], q[0], p[0], w[0], slip[0])], 0.0)

    for state in states:
        expected = max(violation(law_violation, state, scale), 0.0)
        assert violation(compiled, state, scale) == pytest.approx(expected, rel=1e-14)


PLANE = shakedown.example("receding-block")
SPACE = random_joint(np.random.default_rng(1), 3, pressure=1.0)
MOTIONS = {
    "event in the plane": (Evolution, PLANE, 0.7),
    "event in space": (Evolution, SPACE, 1.0),
    "sweeps in the plane": (FixedSteps, PLANE, 0.7),
    "sweeps in space": (FixedSteps, SPACE, 1.0),
}


def together(motion, history):
    """Rows, slips that belong to their reactions, contact states, and where a node comes down in between."""
    if isinstance(motion, Evolution) and motion.problem.directions == 2:
        begin = np.flatnonzero(history.duration > 0)  # slips at the rate there
        return begin, history.curve[begin, 0][:, motion.problem.layout.slips], history.state[begin], False
    smooth = np.flatnonzero(history.kind[1:] != EventKind.JUMPS)
    slip, lands = np.diff(history.v, axis=0)[smooth], history.w[smooth] > 0  # on its way it rubs on nothing
    of_state = smooth if isinstance(motion, Evolution) else smooth + 1  # from this row on, or up to it
    slip[np.repeat(lands, motion.problem.directions, axis=1)] = 0.0
    return smooth + 1, slip, history.state[of_state], lands


@pytest.mark.parametrize("method", MOTIONS)
def test_contact_states_and_reactions_are_those_of_the_law(method):
    follow, problem, load_factor = MOTIONS[method]
    motion = follow(problem, load_factor)
    history = walk(motion, 2, record=True).history
    of_none = [EventKind.LOAD_STEP, EventKind.JUMPS, EventKind.CURVES]
    np.testing.assert_array_equal(history.node == -1, np.isin(history.kind, of_none))
    rows, slip, state, lands = together(motion, history)
    scale, law = scales(problem, load_factor), problem.law
    resolution = law_resolution(problem, motion.tolerances)
    q, p, w = history.q[rows] / scale.force, history.p[rows] / scale.force, history.w[rows] / scale.length
    is_open, sticks = state == OPEN, state == STICK
    slips, closed = ~(is_open | sticks | lands), ~is_open
    slip = np.where(np.repeat(is_open, problem.directions, axis=1), 0.0, slip / scale.length)
    assert all(part.any() for part in (is_open, sticks, slips))
    assert law.size(slip)[sticks].max() <= resolution
    assert np.abs(law.excess(q, p)[slips]).max() <= resolution
    assert law.violation(q, p, slip)[closed].max() <= resolution
    assert max(np.abs(w[closed]).max(), -w.min(), -p.min()) <= resolution
    assert max(np.abs(p[is_open]).max(), law.size(q)[is_open].max()) <= resolution
