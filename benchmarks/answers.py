"""Answers of the command of a checkout, asked now or kept from before, and where two of them differ."""

import json
import os
import re
import select
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from benchmarks.commands_compared import Run

WORKER = Path(__file__).with_name("command_worker.py")
ALONE = dict.fromkeys(["OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "NUMBA_NUM_THREADS"], "1")
NO_ANSWER, ABSENT = "no answer", "(absent)"
NOT_COMPARED = (  # leaves, and what in their text differs from run to run of the same checkout
    ("seconds", ".+"),  # how long the command took
    (r"out\.runs\[\d+\]\.seconds", ".+"),  # how long a simulation of `verify` took
    ("err", r"they would take about .*? on one core of this machine"),  # `critical`, beyond its budget
)

Answer = dict[str, Any]


class Checkout:
    """One process of a checkout's own interpreter in a folder of its own, started again where it ends."""

    def __init__(self, python: str, files: dict[str, bytes], limit: float, worker: Path = WORKER) -> None:
        self.python, self.files, self.limit, self.worker = python, files, limit, worker
        self._start()

    def _start(self) -> None:
        self._folder = TemporaryDirectory(prefix="same-results-")
        for name, content in self.files.items():
            (Path(self._folder.name) / name).write_bytes(content)
        told = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
        self._process = subprocess.Popen(
            [self.python, "-P", str(self.worker)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            cwd=self._folder.name,
            env=told | ALONE,
        )
        hello = self._line()
        if "package" not in hello:
            raise RuntimeError(f"{self.python}: {hello['code']}")
        self.package = hello["package"]

    def answer(self, run: Run) -> Answer:
        """What the command says and writes; a process that dies or thinks too long says that instead."""
        return self.ask({"words": run.words})

    def ask(self, question: dict[str, Any]) -> Answer:
        """What the worker answers."""
        if self._process.poll() is not None:
            self._start()
        self._process.stdin.write(json.dumps(question).encode() + b"\n")
        self._process.stdin.flush()
        return self._line()

    def _line(self) -> Answer:
        began = time.monotonic()
        stdout = self._process.stdout
        ready = select.select([stdout], [], [], self.limit)[0]
        line = stdout.readline() if ready else b""
        if line:
            return json.loads(line)
        if not ready:
            self._process.kill()
        self.close()
        ended = f"the process ended with {self._process.returncode}"
        why = ended if ready else f"none within {self.limit:g} s"
        return {"code": f"{NO_ANSWER}: {why}", "seconds": time.monotonic() - began}

    def close(self) -> None:
        """End the process, and remove its folder with what it left there."""
        self._process.stdin.close()
        self._process.stdout.close()
        self._process.wait()
        self._folder.cleanup()


class Difference(NamedTuple):
    """One leaf of two answers, by its path, as the reference and the new checkout have it."""

    path: str
    reference: str
    new: str


def differences(reference: Answer, new: Answer) -> list[Difference]:
    """Every leaf in which two answers differ; numbers are the same if they are to the last bit."""
    was, found = dict(leaves(reference)), dict(leaves(new))
    pairs = [Difference(path, was.get(path, ABSENT), found.get(path, ABSENT)) for path in was | found]
    return [pair for pair in pairs if _compared(pair.path, pair.reference) != _compared(pair.path, pair.new)]


def _compared(path: str, text: str) -> str:
    """What counts of a leaf's text; that it is there always does."""
    for leaf, part in NOT_COMPARED:
        if text != ABSENT and re.fullmatch(leaf, path):
            text = re.sub(part, "…", text)
    return text


def leaves(document: object, path: str = "") -> Iterator[tuple[str, str]]:
    """Path and text of every number, word and empty list; ``repr`` tells floats apart that differ in a bit.

    Lists keep their order; the order of keys in an object is no result.

    >>> list(leaves({"code": 0, "out": {"lower": [0.1, None]}}))
    [('code', '0'), ('out.lower[0]', '0.1'), ('out.lower[1]', 'None')]
    """
    if isinstance(document, dict) and document:
        for key, value in document.items():
            yield from leaves(value, f"{path}.{key}" if path else key)
    elif isinstance(document, list) and document:
        for k, value in enumerate(document):
            yield from leaves(value, f"{path}[{k}]")
    else:
        yield path, repr(document)
