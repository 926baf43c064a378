"""The share of its own reaction that a node's pressure is given: the same in all units, also where γ vanishes."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown import Problem


def loaded(rng: np.random.Generator, kappa: np.ndarray) -> Problem:
    """A joint in space of some stiffness under random loads."""
    n = len(kappa) // 3
    return Problem(
        A=kappa[: 2 * n, : 2 * n],
        B=kappa[2 * n :, : 2 * n],
        f=0.4,
        q_w=rng.normal(size=(6, 2 * n)),
        p_w=4.0 + rng.normal(size=(6, n)),
    )


@pytest.mark.parametrize("seed", [0, 32])
def test_one_node_has_the_same_share_in_all_units(seed):
    """Its own reaction determines its pressure, so that γ is nothing but round-off at the full share."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(3, 3))
    joint = loaded(rng, root @ root.T + np.eye(3))
    other = replace(joint, **{key: 2.0 * getattr(joint, key) for key in ("A", "B", "q_w", "p_w")})
    one, two = (shakedown.energy_bound(each, certify=False).load_factor for each in (joint, other))
    assert two == pytest.approx(one, rel=1e-9)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("seed", [11, 30])
def test_nodes_without_stiffness_in_one_direction_have_a_share(seed):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(9, int(rng.integers(1, 6))))
    joint = loaded(rng, root @ root.T)
    energy, upper = shakedown.energy_bound(joint, certify=False), shakedown.upper_bound(joint, certify=False)
    assert not energy.load_factor > upper.load_factor * (1 + 1e-9)
