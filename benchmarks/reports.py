"""What a report costs: time, memory and size of the page, from one node to two hundred and fifty-one.

Every size is a process of its own, as a user starts it: ``shakedown-bounds verify`` with a report.
"""

import json
import os
import sys
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

import shakedown
from benchmarks.bodies.dovetail import dovetail
from shakedown import Problem
from shakedown.fem import ElasticBody, Material, Pressure, Traction, block_mesh, contact_problem
from shakedown.report.text_table import table

TITLE = "Verification with a report: time, memory, size of the page"
LARGEST_PAGE = 2e6  # bytes
PICTURES = "<svg"


def cases(short: bool) -> list[dict[str, Any]]:
    names = ["one-node", "two-node", "dovetail"]
    return [{"joint": name} for name in (names if short else [*names, "block-151", "block-251"])]


def joint(name: str) -> Problem:
    """One of the joints by name: shipped, a dovetail of two flanks, or a block with so many nodes."""
    if name == "dovetail":
        return dovetail()
    if name in shakedown.example_names():
        return shakedown.example(name)
    return block(int(name.removeprefix("block-")))


def block(nodes: int) -> Problem:
    """A steel block pressed on a rigid flat and sheared from side to side."""
    loads = [
        Pressure("top", 10.0, history=np.ones(24)),
        Traction("top", (1.0, 0.0), history=lambda t: np.cos(2 * np.pi * t)),
    ]
    mesh = block_mesh(2.0, 1.0, nodes - 1, (nodes - 1) // 2)
    body = ElasticBody(mesh, Material(young=200e3, poisson=0.3), loads=loads)
    return contact_problem(body, "bottom", f=0.4, steps=24, name=f"block, {nodes} nodes", units="N, mm")


def measure(case: dict[str, Any]) -> dict[str, Any]:
    """One run of the command: seconds of the wall and of the processor, peak memory, bytes."""
    with tempfile.TemporaryDirectory() as folder:
        problem, page = Path(folder) / "joint.npz", Path(folder) / "report.html"
        shakedown.save_problem(problem, joint(case["joint"]))
        compiled()
        wall, own, memory = timed(
            [sys.executable, "-m", "shakedown", "verify", str(problem), "-o", str(page)]
        )
        text = page.read_text()
        found = json.loads(page.with_suffix(".json").read_text())
    return {
        "nodes": found["problem"]["n"],
        "runs": len(found["runs"]),
        "seconds": wall,
        "processor_seconds": own,
        "megabytes": memory,
        "page_bytes": len(text.encode()),
        "pictures": text.count(PICTURES),
        "small_enough": len(text.encode()) < LARGEST_PAGE,
    }


@cache
def compiled() -> None:
    """What a verification compiles is on disk when the first one is timed."""
    for name in ("two-node", "jump"):
        shakedown.verify(shakedown.example(name))


def timed(words: list[str]) -> tuple[float, float, float]:
    """Wall time and processor time [s] and peak memory [MB] of a command."""
    before = os.times()
    quiet = [(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)]
    process = os.posix_spawn(words[0], words, os.environ, file_actions=quiet)
    _, status, usage = os.wait4(process, 0)
    if os.waitstatus_to_exitcode(status) not in (0, 1):
        raise RuntimeError(f"{' '.join(words)} failed")
    return os.times().elapsed - before.elapsed, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1e3


def tables(rows: list[dict[str, Any]]) -> str:
    head = ["joint", "nodes", "runs", "time [s]", "processor [s]", "memory [MB]", "page [kB]", "pictures"]
    lines = [
        [
            row["joint"],
            str(row["nodes"]),
            str(row["runs"]),
            f"{row['seconds']:.1f}",
            f"{row['processor_seconds']:.1f}",
            f"{row['megabytes']:.0f}",
            f"{row['page_bytes'] / 1e3:.0f}",
            str(row["pictures"]),
        ]
        for row in rows
    ]
    return table(head, lines)


def figures(rows: list[dict[str, Any]]) -> dict[str, Figure]:
    return {}
