"""Siconos as a peer: load steps solved in a process of the system's Python, for which Debian builds it."""

import os
import subprocess
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from shakedown import Problem
from shakedown.ground.constants import FloatArray
from shakedown.motion.checked_law import Scales

SYSTEM_PYTHON = "/usr/bin/python3"
ABSENT = "Siconos is left out: the system's Python has no siconos (Debian package python3-siconos)"


@dataclass(frozen=True)
class Steps:
    """Slips and gaps (k, n) after every load step, time in the solver [s], steps that it gave up."""

    v: FloatArray
    w: FloatArray
    seconds: float
    failures: int


@cache
def is_here() -> bool:
    if str(Path(SYSTEM_PYTHON).parent) not in os.get_exec_path():
        return False
    try:
        done = subprocess.run(
            [SYSTEM_PYTHON, "-c", "import siconos.numerics"], capture_output=True, check=False
        )
    except OSError:
        return False
    return done.returncode == 0


def solve_steps(
    problem: Problem,
    q_w: FloatArray,
    p_w: FloatArray,
    slip: FloatArray,
    solver: str,
    tolerance: float,
    size: Scales,
) -> Steps:
    """Load steps q_w, p_w (k, n), each from where the one before ended, or each from its own row of ``slip``.

    Siconos' tolerances are absolute: forces and lengths are given to it in units of ``size``.
    """
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "in.npz", Path(folder) / "out.npz"
        np.savez(
            source,
            kappa=problem.kappa * (size.length / size.force),
            f=problem.f,
            q_w=q_w / size.force,
            p_w=p_w / size.force,
            slip=slip / size.length,
            solver=solver,
            tolerance=tolerance,
        )
        script = Path(__file__).with_name("siconos_steps.py")
        subprocess.run([SYSTEM_PYTHON, script, source, target], check=True, capture_output=True)
        with np.load(target) as out:
            return Steps(
                out["v"] * size.length, out["w"] * size.length, float(out["seconds"]), int(out["failures"])
            )
