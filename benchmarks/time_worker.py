"""Times calls of one checkout in one process: a line of JSON says which, a line of JSON says how long.

Started as a file by that checkout's interpreter (``python -P``), so it knows nothing of this one's package.
"""

import gc
import json
import os
import sys
import time
import warnings
from collections.abc import Callable
from importlib import import_module

import numpy as np

import shakedown

LEAST = 0.05  # seconds of the processor that one measurement takes at least
MOST = 10_000  # calls in one measurement
SPREAD = 0.3  # standard deviation of initial slips [length]
ELSEWHERE = {  # names that have moved; where they stood is at the top
    "evolve": "shakedown.motion.evolution",
    "conic_lower_bound": "shakedown.bounds.independent_solver",
}


def call_of(name: str, joint: str, value: float, times: int) -> Callable[[], object]:
    """The call that is timed; ``value`` is its load factor, ``times`` its number of states or cycles."""
    load = shakedown.load_problem if joint.endswith(".npz") else shakedown.example
    problem, function = load(joint), found(name)
    slips = SPREAD * np.random.default_rng(0).normal(size=(times, problem.n))
    calls = {
        "evolve": lambda: function(problem, value, cycles=times),
        "initial_state_map": lambda: function(problem, value, states=times),
        "long_term_state": lambda: [function(problem, value, slip) for slip in slips],
        "long_term_states": lambda: function(problem, value, slips),
        "simulate": lambda: function(problem, value, cycles=times, method="gauss-seidel"),
    }
    return calls.get(name, lambda: function(problem))


def found(name: str) -> Callable:
    try:
        return getattr(shakedown, name)
    except AttributeError:
        return getattr(import_module(ELSEWHERE[name]), name)


class Timer:
    """A call that is repeated until that takes long enough to be timed."""

    def __init__(self, call: Callable[[], object]) -> None:
        self.call = call
        call()  # compiles, fills caches
        began = time.process_time()
        call()
        self.repeats = max(1, min(MOST, int(LEAST / max(time.process_time() - began, 1e-7))))

    def seconds(self) -> float:
        """Processor time of one call."""
        gc.collect()
        began = time.process_time()
        for _ in range(self.repeats):
            self.call()
        return (time.process_time() - began) / self.repeats


def main() -> None:
    warnings.simplefilter("ignore")
    timers: dict[str, Timer] = {}
    with os.fdopen(os.dup(1), "w") as answers:
        os.dup2(2, 1)  # what a solver prints itself is no answer
        print(json.dumps({"package": shakedown.__file__}), file=answers, flush=True)
        for line in sys.stdin:
            if line not in timers:
                timers[line] = Timer(call_of(**json.loads(line)))
            print(json.dumps({"seconds": timers[line].seconds()}), file=answers, flush=True)


if __name__ == "__main__":
    main()
