"""How long real joints take: ``verify`` with its report, λ_max, λ_E, λ_U; from builders and from files.

``VERIFY_TIMES=joint.npz,other.npz python -m benchmarks verify_times --short`` takes files of the user's own.
"""

import os
import time
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import shakedown
from benchmarks.bodies.lap_joint import lap_joint
from benchmarks.display import listed
from benchmarks.half_space import half_space
from shakedown import Problem
from shakedown.fem import ElasticBody, Force, Material, Pressure, Support, brick_mesh, contact_problem
from shakedown.report.html import write_report

TITLE = "Real joints: processor time of verify with its report, and of the bounds"
FILES = "VERIFY_TIMES"  # problem files instead of the joints below, separated by commas
JOINTS: dict[str, Callable[[], Problem]] = {
    "four-node-3d": lambda: shakedown.example("four-node-3d"),
    "bolted-flange": lambda: shakedown.example("bolted-flange"),
    "half-space 10 × 10": lambda: half_space(10, 10),
    "lap joint, 189 pairs": lambda: lap_joint((36, 8, 3)),
    "lap joint, 441 pairs": lambda: lap_joint((36, 20, 3)),
    "lap joint, 675 pairs": lambda: lap_joint((48, 24, 3)),
    "plates, 169 pairs": lambda: plates(12),
    "plates, 441 pairs": lambda: plates(20),
}
LARGE = "half-space 45 × 45"  # 2,025 pairs: λ_max alone
BOUNDS = ("λ_max", "λ_E", "λ_U")


def plates(k: int) -> Problem:
    """Two plates of k × k elements, pressed together; friction alone holds the upper one, drawn round."""
    loads = [
        Pressure("top", 40.0, history=np.ones(24)),
        Force("top", (6000.0, 0.0, 0.0), history=lambda t: np.cos(2 * np.pi * t)),
        Force("top", (0.0, 4000.0, 0.0), history=lambda t: np.sin(2 * np.pi * t)),
    ]
    above, below = (brick_mesh((40.0, 40.0, 12.0), (k, k, 4), origin=(0.0, 0.0, z)) for z in (12.0, 0.0))
    upper = ElasticBody(above, Material(210e3, 0.3), loads=loads)
    lower = ElasticBody(below, Material(210e3, 0.3), supports=[Support("bottom")])
    return contact_problem(upper, "bottom", f=0.3, against=(lower, "top"), steps=24)


def cases(short: bool) -> list[dict]:
    files = [name for name in os.environ.get(FILES, "").split(",") if name]
    joints = files or list(JOINTS)[: 2 if short else None]
    verified = [{"joint": name, "what": "verify"} for name in joints]
    bounds = [{"joint": name, "what": what} for name in joints for what in BOUNDS]
    if not (files or short):
        bounds.append({"joint": LARGE, "what": "λ_max"})
    return verified + bounds


def measure(case: dict) -> dict:
    joint = replace(joint_of(case["joint"]))  # nothing of it has been computed yet
    began, spent = time.perf_counter(), time.process_time()
    found = {
        "verify": lambda: _verified(joint),
        "λ_max": lambda: {"value": shakedown.upper_bound(joint, certify=False).load_factor},
        "λ_E": lambda: {"value": shakedown.energy_bound(joint, certify=False).load_factor},
        "λ_U": lambda: {"value": shakedown.universal_bound(joint).load_factor},
    }[case["what"]]()
    seconds = {"processor": time.process_time() - spent, "clock": time.perf_counter() - began}
    return found | seconds | {"pairs": joint.n}


@cache
def joint_of(name: str) -> Problem:
    """A joint by name, or of a file; compiled code is there already when its time is taken."""
    if name == LARGE:
        return half_space(45, 45)
    load = shakedown.load_problem if Path(name).exists() else shakedown.example
    joint = JOINTS[name]() if name in JOINTS else load(name)
    shakedown.simulate(joint, 0.0, cycles=1)
    return joint


def _verified(joint: Problem) -> dict:
    found = shakedown.verify(joint)
    with TemporaryDirectory() as folder:
        write_report(Path(folder) / "report.html", found)
    return {
        "runs": len(found.runs),
        "open": len(found.open_questions),
        "disagreements": len(found.disagreements),
    }


def tables(rows: list[dict]) -> str:
    columns = {
        "joint": "{joint}", "pairs": "{pairs}", "what": "{what}",
        "processor, s": "{processor:.3g}", "clock, s": "{clock:.3g}", "runs": "{runs}", "open": "{open}",
        "disagree": "{disagreements}",
    }  # fmt: skip
    return listed(rows, columns)
