"""The judge of every path: each clause of the contact and friction law has an example that breaks it alone."""

import numpy as np
import pytest

from shakedown.long_term.plane import search
from shakedown.motion.checked_law import Scales, law_violation

UNIT = Scales(1.0, 1.0)
# clause: (f, q, p, w, slip), by how much it is broken
BROKEN = {
    "no penetration": ((0.5, 0.0, 0.0, -0.25, 0.0), 0.25),
    "no tension": ((0.0, 0.0, -0.25, 0.0, 0.0), 0.25),
    "an open node carries nothing": ((0.5, 0.0, 0.25, 2.0, 0.0), 0.25),
    "Coulomb": ((0.5, 0.75, 1.0, 0.0, 0.0), 0.25),
    "forward slip": ((0.5, 0.25, 1.0, 0.0, 0.5), 0.5),
    "backward slip": ((0.5, -0.25, 1.0, 0.0, -0.5), 0.5),
}
LAWFUL = {
    "stick": (0.5, 0.25, 1.0, 0.0, 0.0),
    "stick on the backward limit": (0.5, 0.5, 1.0, 0.0, 0.0),
    "forward slip": (0.5, -0.5, 1.0, 0.0, 0.5),
    "backward slip": (0.5, 0.5, 1.0, 0.0, -0.5),
    "open": (0.5, 0.0, 0.0, 1.0, 0.0),
    "apex": (0.5, 0.0, 0.0, 0.0, 0.0),
    "frictionless slip": (0.0, 0.0, 1.0, 0.0, 0.5),
}


def violation(judge, state, scale=UNIT):
    f, q, p, w, slip = (np.array([x]) for x in state)
    return float(judge(f, q * scale.force, p * scale.force, w * scale.length, slip * scale.length, scale)[0])


@pytest.mark.parametrize("clause", BROKEN)
@pytest.mark.parametrize("scale", [UNIT, Scales(1e9, 1e-6)], ids=str)
def test_what_breaks_a_clause_is_found_and_measured(clause, scale):
    state, size = BROKEN[clause]
    assert violation(law_violation, state, scale) == pytest.approx(size, rel=1e-12)


@pytest.mark.parametrize("case", LAWFUL)
def test_what_obeys_the_law_passes(case):
    assert violation(law_violation, LAWFUL[case]) == 0.0


def test_the_compiled_check_of_a_cycle_says_the_same(monkeypatch):
    monkeypatch.setattr(search, "larger", max)
    monkeypatch.setattr(search, "smaller", min)
    random = np.random.default_rng(0).normal(size=(200, 5)) * (0, 1, 1, 1, 1) + (0.5, 0, 0, 0, 0)
    states = [*(state for state, _ in BROKEN.values()), *LAWFUL.values(), *random]
    scale = Scales(1e9, 1e-6)

    def compiled(f, q, p, w, slip, scale):
        return np.maximum([search.broken_law.py_func(scale, f[0], q[0], p[0], w[0], slip[0])], 0.0)

    for state in states:
        expected = max(violation(law_violation, state, scale), 0.0)
        assert violation(compiled, state, scale) == pytest.approx(expected, rel=1e-14)
