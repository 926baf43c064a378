"""Answers of the command of a checkout, asked now or kept from before, and where two of them differ."""

import json
import os
import re
import select
import subprocess
import time
from collections.abc import Iterator
from decimal import Decimal
from functools import partial
from math import isfinite
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from benchmarks.commands_compared import Run

WORKER = Path(__file__).with_name("worker.py")
ALONE = dict.fromkeys(["OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "NUMBA_NUM_THREADS"], "1")
UNDATED = {"SOURCE_DATE_EPOCH": "0"}  # what matplotlib writes into a picture
NO_ANSWER, ABSENT = "no answer", "(absent)"
NOT_COMPARED = (  # leaves, and what in their text differs from run to run of the same checkout
    ("seconds", ".+"),  # how long the command took
    (r"(out|files\.report\.json)\.runs\[\d+\]\.seconds", ".+"),  # how long a simulation of `verify` took
    (r"files\.report\.html\[\d+\]", r"(?<=')[\d.,]+ (ms|s|min)(?=')"),  # the same in a table
    (r"files\.report\.html\[\d+\]", r"\d{4}-\d\d-\d\d \d\d:\d\d UTC"),  # when the report was written
    (r"files\..*\.(svg|html)\[\d+\]", r'(id="|url\(#|href="#)\w+'),  # names of the parts of a picture
    ("err", r"they would take about .*? on one core of this machine"),  # `critical`, beyond its budget
)
GONE_WORDS = ("single-node-excluded",)  # statuses that stand for another one now
GONE = (  # leaves of what was deleted: they may be null, or not there at all
    r"out\.(maps\[\d+\]\.)?limit_cycles\[\d+\]\.(stability|multipliers)\b.*",
    r"(out|files\.).*\.(box|closing_box|core|guarantee_curve)\b.*",
    r"(out|files\.).*\.single_node_bound",
    r"out\.bounds\[\d+\]",  # of a sweep: their number shifts the others
    r"files\..*\.csv\[\d+\]\.lambda_box.*",
)
KEPT = r"code|out\..*|files\..*\.(npz|csv|json)\b.*"  # what programs read
OF_BITS = r"\.sha256$"  # what says nothing of numbers that are only near
NUMBER = re.compile(r"[-−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")

Answer = dict[str, Any]


class Checkout:
    """One process of a checkout's own interpreter in a folder of its own, started again where it ends."""

    def __init__(self, python: str, files: dict[str, bytes], limit: float) -> None:
        self.python, self.files, self.limit = python, files, limit
        self._start()

    def _start(self) -> None:
        self._folder = TemporaryDirectory(prefix="same-results-")
        for name, content in self.files.items():
            path = Path(self._folder.name) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        told = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
        self._process = subprocess.Popen(
            [str(Path(self.python).absolute()), "-P", str(WORKER)],  # it starts in another folder
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            cwd=self._folder.name,
            env=told | ALONE | UNDATED,
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


def differences(reference: Answer, new: Answer, within: float = 0.0, kept: bool = False) -> list[Difference]:
    """Every leaf in which two answers differ; or only those, of the reference, that programs read.

    Numbers are the same if they are to the last bit; or, where a share is given, if they are within that
    share of the largest in their array. Those in a text may also be rounded to the next decimal shown.
    """
    was, found = dict(leaves(reference)), dict(leaves(new))
    if kept:
        was = {path: value for path, value in was.items() if _is_kept(path, value)}
        found = {path: found[path] for path in was.keys() & found.keys()}
    sizes = _sizes(was, found) if within else {}
    differing = []
    for path in was | found:
        pair = Difference(path, *(repr(side[path]) if path in side else ABSENT for side in (was, found)))
        same = _compared(path, pair.reference) == _compared(path, pair.new)
        if within and not same and ABSENT not in pair:
            near = _near(was[path], found[path], within, sizes.get(_array(path), 0.0))
            same = near or re.search(OF_BITS, path) is not None
        if not same:
            differing.append(pair)
    return differing


def _is_kept(path: str, value: object) -> bool:
    """Whether programs read a leaf: a number, a status; no sentences, no bits of near numbers."""
    words = path != "code" and isinstance(value, str) and (" " in value or value in GONE_WORDS)
    known = re.fullmatch(KEPT, path) and not re.search(OF_BITS, path)
    return bool(known) and not words and not any(re.fullmatch(gone, path) for gone in GONE)


def _compared(path: str, text: str) -> str:
    """What counts of a leaf's text; that it is there always does."""
    for leaf, part in NOT_COMPARED:
        if text != ABSENT and re.fullmatch(leaf, path):
            text = re.sub(part, "…", text)
    return text


def _array(path: str) -> str:
    """The array that a leaf is an entry of, or the leaf itself."""
    return re.sub(r"(\[\d+\])+$", "", path)


def _sizes(*documents: dict[str, object]) -> dict[str, float]:
    """The largest number of every array."""
    sizes: dict[str, float] = {}
    for document in documents:
        for path, value in document.items():
            if isinstance(value, float) and isfinite(value):
                sizes[_array(path)] = max(sizes.get(_array(path), 0.0), abs(value))
    return sizes


def _near(one: object, other: object, within: float, size: float) -> bool:
    """Whether two numbers are near, or two texts say the same of near numbers."""
    if isinstance(one, float) and isinstance(other, float):
        return abs(one - other) <= within * size
    if not (isinstance(one, str) and isinstance(other, str)):
        return False
    if NUMBER.sub("#", one) != NUMBER.sub("#", other):
        return False
    return all(map(partial(_shown_near, within), NUMBER.findall(one), NUMBER.findall(other)))


def _shown_near(within: float, one: str, other: str) -> bool:
    """Whether two numbers in a text are near; the last of their decimals may be rounded up or down."""
    was, found = (Decimal(text.replace("−", "-")) for text in (one, other))
    last = max(was.as_tuple().exponent, found.as_tuple().exponent)
    rounding = Decimal(1).scaleb(last) if last < 0 else 0
    return abs(was - found) <= max(rounding, Decimal(within) * max(abs(was), abs(found)))


def leaves(document: object, path: str = "") -> Iterator[tuple[str, object]]:
    """Path and value of every number, word and empty list; ``repr`` tells floats apart that differ in a bit.

    Lists keep their order; the order of keys in an object is no result.

    >>> list(leaves({"code": 0, "out": {"lower": [0.1, None]}}))
    [('code', 0), ('out.lower[0]', 0.1), ('out.lower[1]', None)]
    """
    if isinstance(document, dict) and document:
        for key, value in document.items():
            yield from leaves(value, f"{path}.{key}" if path else key)
    elif isinstance(document, list) and document:
        for k, value in enumerate(document):
            yield from leaves(value, f"{path}[{k}]")
    else:
        yield path, document
