"""Whatever is given to a public function, what it refuses is a ShakedownError with one line."""

import numpy as np
import pytest

import shakedown
from shakedown.bounds.critical import subset_count
from shakedown.motion.evolution import evolve

JOINT = shakedown.example("two-node")
MISUSE = {
    "slip a word": lambda: shakedown.simulate(JOINT, 0.5, "nought"),
    "slip complex": lambda: shakedown.simulate(JOINT, 0.5, [0, 1j]),
    "load factor none": lambda: shakedown.safe_slip(JOINT, None),
    "load factor overflows": lambda: shakedown.simulate(JOINT, 1e308),
    "longest period zero": lambda: shakedown.long_term_state(JOINT, 0.5, longest_period=0),
    "damping negative": lambda: evolve(JOINT, 0.5, damping=[-1.0] * 4),
    "seed negative": lambda: shakedown.verify(JOINT, seed=-1),
    "seed a word": lambda: shakedown.verify(JOINT, seed="a"),
    "threads negative": lambda: shakedown.critical_load_factors(JOINT, threads=-1),
    "nodes negative": lambda: subset_count(-1),
    "path none": lambda: shakedown.load_problem(None),
    "path empty": lambda: shakedown.load_problem(""),
    "masked array": lambda: shakedown.Problem(
        A=np.ma.array([[1.0]], mask=[[True]]), B=[[0.0]], f=0.3, q_w=[[1.0]], p_w=[[1.0]]
    ),
}


@pytest.mark.parametrize("kind", MISUSE)
def test_misuse_is_refused_in_one_line(kind):
    with pytest.raises(shakedown.ShakedownError) as caught:
        MISUSE[kind]()
    assert "\n" not in str(caught.value)
