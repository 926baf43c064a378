"""Siconos as a peer: load steps solved in a process of the system's Python, for which Debian builds it."""

import os
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from shakedown import Problem
from shakedown.ground.constants import FloatArray
from shakedown.motion.checked_law import Scales

SYSTEM_PYTHON = "/usr/bin/python3"
ABSENT = "Siconos is left out: the system's Python has no siconos (Debian package python3-siconos)"


class Solved(NamedTuple):
    """Reactions and velocities (k, (d + 1) n) of the steps, seconds of each (k,), how many it gave up."""

    r: FloatArray
    u: FloatArray
    seconds: FloatArray
    failures: int


class Steps(NamedTuple):
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


def solved(M: FloatArray, free: FloatArray, f: FloatArray, slip: FloatArray, **how: object) -> Solved:
    """The contact problems of :mod:`benchmarks.siconos_steps`; ``timeout`` [s] is on the clock."""
    timeout = how.pop("timeout", None)
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "in.npz", Path(folder) / "out.npz"
        np.savez(source, M=M, free=free, f=f, slip=slip, **{"iterations": 100_000, "budget": np.inf} | how)
        script = Path(__file__).with_name("siconos_steps.py")
        command = [SYSTEM_PYTHON, script, source, target]
        subprocess.run(command, check=True, capture_output=True, timeout=timeout)
        with np.load(target) as out:
            return Solved(out["r"], out["u"], out["seconds"], int(out["failures"]))


def compliance(problem: Problem, size: Scales) -> tuple[FloatArray, np.ndarray]:
    """κ⁻¹ in units of the scales, normal first at every node, and the order of displacements there."""
    n, d = problem.n, problem.directions
    order = np.column_stack([d * n + np.arange(n), np.arange(d * n).reshape(n, d)]).ravel()
    M = np.linalg.inv(problem.kappa) * (size.force / size.length)
    return 0.5 * (M + M.T)[np.ix_(order, order)], order


def solve_steps(
    problem: Problem,
    q_w: FloatArray,
    p_w: FloatArray,
    slip: FloatArray,
    solver: str,
    tolerance: float,
    size: Scales,
) -> Steps:
    """Load steps q_w, p_w (k, n) of a joint in the plane, each from where the one before ended.

    Siconos' tolerances are absolute: forces and lengths are given to it in units of ``size``.
    """
    M, order = compliance(problem, size)
    free = -(np.hstack([q_w, p_w])[:, order] / size.force) @ M
    out = solved(M, free, problem.f, slip / size.length, solver=solver, tolerance=tolerance)
    v = slip + np.cumsum(out.u[:, 1::2], axis=0) * size.length
    return Steps(v, out.u[:, 0::2] * size.length, float(out.seconds.sum()), out.failures)
