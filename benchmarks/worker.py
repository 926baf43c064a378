"""Runs the command of one checkout again and again in one process, or times calls of its library.

A line of JSON in, a line of JSON out. Started as a file by that checkout's interpreter (``python -P``), so it
knows nothing of this one's package.
"""

import csv
import gc
import hashlib
import io
import json
import math
import os
import re
import runpy
import shutil
import sys
import time
import warnings
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from importlib import import_module
from pathlib import Path
from unittest.mock import patch

import numpy as np

import shakedown

SHOWN = 200  # entries of an array that an answer holds beside its checksum
TURNS = (
    0.0,
    math.sqrt(2.0),
    math.e,
    1e-3,
)  # of the weights of those sums: slow and fast ones
MARKUP = (".html", ".svg")
LEAST = 0.05  # seconds of the processor that one measurement takes at least
MOST_CALLS = 10_000  # calls in one measurement
SPREAD = 0.3  # standard deviation of initial slips [length]
ELSEWHERE = {  # names that have moved; where they stood is at the top
    "evolve": "shakedown.motion.evolution",
    "conic_lower_bound": "shakedown.bounds.independent_solver",
}


def answer(words: list[str]) -> dict:
    """What the command answers: exit code, stdout (read as JSON), stderr, the files that it leaves here."""
    before, out, err = set(Path().iterdir()), io.StringIO(), io.StringIO()
    began = time.perf_counter()
    with redirect_stdout(out), redirect_stderr(err), patch.object(sys, "argv", ["shakedown-bounds", *words]):
        try:
            runpy.run_module("shakedown", run_name="__main__")
            code = None
        except SystemExit as stop:
            code = stop.code
        except Exception as error:
            code = f"{type(error).__name__}: {error}"
    seconds = time.perf_counter() - began
    files = {path.name: contents(path) for path in sorted(set(Path().iterdir()) - before)}
    said = {"code": code, "out": parsed(out.getvalue()), "err": err.getvalue()}
    return said | {"files": files, "seconds": seconds}


def parsed(text: str) -> object:
    """A document, or the lines of what is none."""
    try:
        return json.loads(text)
    except ValueError:
        return text.splitlines()


def contents(path: Path) -> object:
    """What a file or folder holds; it is gone afterwards."""
    if path.is_dir():
        found: object = {inner.name: inside(inner) for inner in sorted(path.iterdir())}
        shutil.rmtree(path)
        return found
    found = inside(path)
    path.unlink()
    return found


def inside(path: Path) -> object:
    """Arrays by their bits, tables by their cells, pages and pictures by what stands between their tags."""
    if path.suffix == ".npz":
        with np.load(path, allow_pickle=False) as archive:
            return {key: array(archive[key]) for key in archive.files}
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".csv":
        return list(csv.DictReader(io.StringIO(text)))  # by the heading: columns come and go
    if path.suffix in MARKUP:
        return [line for part in re.split("(<[^>]*>)", text) for line in part.splitlines() if line.strip()]
    return parsed(text)


def array(values: np.ndarray) -> object:
    if values.dtype.kind == "U":
        return parsed(str(values)) if values.ndim == 0 else values.tolist()
    bits = hashlib.sha256(np.ascontiguousarray(values).tobytes()).hexdigest()
    few = values.ravel().tolist() if values.size <= SHOWN else None
    sums = weighted_sums(values) if few is None else None
    found = {"values": few, "weighted_sums": sums, "dtype": values.dtype.str, "shape": list(values.shape)}
    return found | {"sha256": bits}


def weighted_sums(values: np.ndarray) -> list[float]:
    """A few means of a long array that are near each other where two arrays are, and hardly else."""
    flat = values.astype(float).ravel()
    finite = np.where(np.isfinite(flat), flat, 0.0)
    weights = (np.cos(turn * np.arange(flat.size)) for turn in TURNS)
    sums = [float(weight @ finite) / flat.size for weight in weights]
    return [float(np.abs(finite).max()), *sums, float(np.isnan(flat).sum()), float(np.isinf(flat).sum())]


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
        self.repeats = max(1, min(MOST_CALLS, int(LEAST / max(time.process_time() - began, 1e-7))))

    def seconds(self) -> float:
        """Processor time of one call."""
        gc.collect()
        began = time.process_time()
        for _ in range(self.repeats):
            self.call()
        return (time.process_time() - began) / self.repeats


def main() -> None:
    warnings.simplefilter("ignore")  # shown once per process, so no answer to one command
    timers: dict[str, Timer] = {}
    with os.fdopen(os.dup(1), "w") as answers:
        os.dup2(2, 1)  # what a solver prints itself is no answer
        print(json.dumps({"package": shakedown.__file__}), file=answers, flush=True)
        for line in sys.stdin:
            question = json.loads(line)
            if "words" in question:
                found = answer(question["words"])
            else:
                timers[line] = timers.get(line) or Timer(call_of(**question))
                found = {"seconds": timers[line].seconds()}
            print(json.dumps(found), file=answers, flush=True)


if __name__ == "__main__":
    main()
