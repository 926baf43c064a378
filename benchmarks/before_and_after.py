"""Whether a checkout is as fast as another one: ``python -m benchmarks before_and_after --reference PYTHON``.

Each checkout has one process of its own interpreter; they take turns, and only the time of the processor
counts. Commands are processes of their own, the first of all on an empty cache of compiled code. A ratio is
that of the medians, new over reference; its spread are the quartiles of the ratios of the turns.
"""

import argparse
import os
import resource
import statistics
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from functools import partial
from tempfile import TemporaryDirectory
from typing import NamedTuple

from benchmarks.answers import ALONE, Checkout
from benchmarks.problems import chain, file_of
from shakedown.report.facts import table

COMPILE = (
    "import compileall, shakedown, sys; sys.exit(not compileall.compile_dir(shakedown.__path__[0], quiet=1))"
)
LIMIT = 600.0  # seconds for one measurement
SIZES = (5, 10, 33, 250)
TURNS, FEW = 15, 5  # of calls; of commands on an empty cache
LARGER = 1.03  # a ratio beyond which a call has become slower

Turn = tuple[float, float]  # seconds of the reference, and of this checkout


class Call(NamedTuple):
    """A function of the library on a joint, at a load factor, for so many states or cycles."""

    name: str
    joint: str
    value: float = 0.0
    times: int = 1

    @property
    def title(self) -> str:
        joint = self.joint.removesuffix(".npz")
        at = f", λ = {self.value:g}" * (self.value > 0)
        return f"{self.name} {joint}{at}" + f" × {self.times:,}" * (self.times > 1)


CALLS = (
    Call("lower_bound", "two-node"),
    Call("lower_bound", "chain-10.npz"),
    Call("conic_lower_bound", "chain-5.npz"),
    Call("upper_bound", "chain-33.npz"),
    Call("upper_bound", "chain-250.npz"),
    Call("energy_bound", "chain-5.npz"),
    Call("energy_bound", "chain-33.npz"),
    Call("shakedown_bounds", "two-node"),
    Call("shakedown_bounds", "block-9"),
    Call("long_term_state", "two-node", 0.7, 10),
    Call("long_term_state", "block-9", 4.0, 10),
    Call("long_term_states", "two-node", 0.7, 2000),
    Call("initial_state_map", "two-node", 0.7, 2000),
    Call("verify", "two-node"),
    Call("verify", "block-9"),
    Call("evolve", "two-node", 0.2, 200),  # nothing slips: quiet load steps
    Call("evolve", "two-node", 0.9, 200),
    Call("evolve", "block-9", 5.0, 200),
    Call("simulate", "block-9", 5.0, 3),
)
WARM = {
    "import shakedown": ["-c", "import shakedown; shakedown.lower_bound"],
    "--help": ["-m", "shakedown", "--help"],
    "solve two-node": ["-m", "shakedown", "solve", "two-node", "-q"],
    "verify two-node, warm": ["-m", "shakedown", "verify", "two-node", "-q"],
}
COLD = {"verify two-node, cold": WARM["verify two-node, warm"]}


def main(words: list[str] | None = None) -> int:
    """Exit code 0 where nothing has become slower, 1 where anything has."""
    arguments = _parser().parse_args(words)
    pythons = (arguments.reference, sys.executable)
    rows, slower = [], False
    for title, turns in measured(pythons, arguments.only, arguments.turns):
        ratio = statistics.median(b for _, b in turns) / statistics.median(a for a, _ in turns)
        slower |= ratio > LARGER
        rows.append([title, *shown(turns, ratio)])
        print("  ".join(rows[-1]), file=sys.stderr, flush=True)
    print(table(["call", "reference", "new", "ratio", "quartiles"], rows))
    return int(slower)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks before_and_after", description=__doc__)
    add = parser.add_argument
    add("--reference", required=True, metavar="PYTHON", help="the other checkout's interpreter")
    add("--only", default="", metavar="WORD", help="calls whose title contains this")
    add("--turns", type=int, default=TURNS, help=f"of both checkouts, per call ({TURNS})")
    return parser


def measured(pythons: tuple[str, str], only: str, turns: int) -> Iterator[tuple[str, list[Turn]]]:
    """Title and seconds of both checkouts in every turn, call by call."""
    for python in pythons:
        subprocess.run([python, "-P", "-c", COMPILE], env=_environment(), check=True)
    calls = [call for call in CALLS if only in call.title]
    with ExitStack() as stack:
        sides = [stack.enter_context(closing(Checkout(python, joint_files(), LIMIT))) for python in pythons]
        for call in calls:
            yield call.title, in_turns(turns, [partial(time_of, side, call) for side in sides])
    for commands, most in ((WARM, turns), (COLD, min(turns, FEW))):
        for title, words in commands.items():
            if only in title:
                yield title, commands_in_turn(pythons, words, most, cold=commands is COLD)


def in_turns(turns: int, sides: list[Callable[[], float]]) -> list[Turn]:
    """Seconds of the reference and the new checkout; who begins changes from turn to turn."""
    for side in sides:
        side()  # not counted: compiles
    found = []
    for turn in range(turns):
        order = (0, 1) if turn % 2 else (1, 0)
        seconds = {k: sides[k]() for k in order}
        found.append((seconds[0], seconds[1]))
    return found


def time_of(side: Checkout, call: Call) -> float:
    answer = side.ask(call._asdict())
    if "code" in answer:
        raise SystemExit(f"{side.python}: {call.title}: {answer['code']}")
    return answer["seconds"]


def joint_files() -> dict[str, bytes]:
    """Chains of nodes, as both checkouts read them."""
    return {f"chain-{n}.npz": file_of(chain(n)) for n in SIZES}


def commands_in_turn(pythons: tuple[str, str], words: list[str], turns: int, *, cold: bool) -> list[Turn]:
    """Seconds of a command of both checkouts; its files, and its compiled code, are in folders of its own."""
    with ExitStack() as stack:
        folders = [stack.enter_context(TemporaryDirectory(prefix="before-and-after-")) for _ in pythons]

        def run(k: int) -> float:
            cache = stack.enter_context(TemporaryDirectory()) if cold else f"{folders[k]}/compiled"
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run(
                [pythons[k], "-P", *words],
                cwd=folders[k],
                env=_environment() | {"NUMBA_CACHE_DIR": cache},
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                check=True,
            )
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

        return in_turns(turns, [lambda: run(0), lambda: run(1)])


def _environment() -> dict[str, str]:
    return {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")} | ALONE


def shown(turns: list[Turn], ratio: float) -> list[str]:
    """Medians of both, the ratio, and the quartiles of the ratios of the turns."""
    low, _, high = statistics.quantiles([b / a for a, b in turns], n=4)
    medians = (statistics.median(side) for side in zip(*turns, strict=True))
    return [*(_time(seconds) for seconds in medians), f"{ratio:.3f}", f"{low:.3f} … {high:.3f}"]


def _time(seconds: float) -> str:
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-6:.3g} µs"
