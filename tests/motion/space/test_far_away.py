"""Bodies that nothing holds slide away, and are told so, however far they have come: round-off grows with the way."""

import numpy as np
import pytest

from benchmarks.space_verdicts import KINDS, random_joint
from shakedown.motion import viscous_jump
from shakedown.motion.checked_law import law_violation, reaction_round_off
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


def test_a_body_comes_to_rest_far_away(monkeypatch):
    """Where it has come to 12,000 lengths, reactions are known to 1e-11, and rest is told by that."""
    rests, found = [], viscous_jump.Relaxation._rest

    def noted(moving):
        rest = found(moving)
        rests.append((moving, rest))
        return rest

    monkeypatch.setattr(viscous_jump.Relaxation, "_rest", noted)
    motion = Evolution(joint(STIFF, 16, 0), 12.0)
    motion.cycle()
    far = [
        (moving, rest)
        for moving, rest in rests
        if rest is not None and np.abs(rest.u).max() > 100.0 * moving.scale.length
    ]
    assert far
    for moving, rest in far:
        law, layout = moving.law, moving.layout
        q, p = layout.split(moving.load + moving.kappa @ rest.u)
        still = np.zeros(layout.slip_size)
        violation = law_violation(law.f, q, p, rest.u[layout.gaps], still, moving.scale)
        assert violation.max() <= max(1e-12, reaction_round_off(moving.kappa, rest.u, moving.scale))
