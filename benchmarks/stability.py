"""Time integration on hard cases: each method's path against the path in rational arithmetic.

The verdict on a path, from its error relative to the range of the exact slips:

    right        error below 1e-9;
    round-off    larger, but no more than 100 times what one unit in the last place
                 of the stiffness, the friction and the load changes in the exact path;
    long step    larger, but the exact states do not solve the equations of single
                 load steps: no method with these load steps can follow the path;
    off          none of these, and the method did not say so;
    says so      the method reported that it failed.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import numpy as np

from benchmarks import siconos_peer
from benchmarks.display import lines
from benchmarks.implicit_steps import ImplicitSteps
from benchmarks.rational_path import NoPath, one_step_holds, rational_path
from benchmarks.stability_scenes import FAMILIES, Scene
from shakedown import Problem
from shakedown.ground.constants import FloatArray
from shakedown.motion.checked_law import scales
from shakedown.motion.course import EventKind
from shakedown.motion.evolution import Evolution, evolve

TITLE = "Hard cases of time integration: error against the path in rational arithmetic"
METHODS = {
    "event": None,
    "GS 1e-06": 1e-6,
    "GS 1e-10": 1e-10,
    "GS 1e-13": 1e-13,
    "nsgs": 1e-12,
    "lemke": 1e-12,
}
RIGHT, ULPS = 1e-9, 100.0
SHOWN = 64  # cycles at the end of a long run on which its error is measured
VERDICTS = ("right", "round-off", "long step", "off", "says so")
Path = tuple[FloatArray, str]  # slips (s, n) after the last load steps of a run, and what it said


def cases(short: bool) -> list[dict]:
    if not siconos_peer.is_here():
        print(siconos_peer.ABSENT)
    return [
        {"family": family, "scene": name, "method": method}
        for family, scenes in FAMILIES.items()
        for name in (_shorter(family, list(scenes)) if short else scenes)
        for method in METHODS
        if method not in ("nsgs", "lemke") or siconos_peer.is_here()
    ]


def _shorter(family: str, names: list[str]) -> list[str]:
    if family == "many cycles":
        return [name for name in names if " 1000 " in name]
    return [names[0], names[-1]]


@cache
def scene(family: str, name: str) -> Scene:
    return FAMILIES[family][name]()


@cache
def reference(family: str, name: str) -> tuple[FloatArray, float, float, bool]:
    """Exact slips after the last load steps, their range, what one unit in the last place changes.

    Last: whether the load steps are long, so that their equations miss the path.
    """
    hard = scene(family, name)
    path = rational_path(hard.problem, 1.0, hard.start, hard.cycles, stop_at_repeat=_long(hard))
    first = path.slips(3)
    last = path.slips(hard.cycles)[-SHOWN * hard.problem.m :]
    size = max(float(np.ptp(first, axis=0).max()), 1e-3 * scales(hard.problem, 1.0).length)
    change, long_step = 0.0, not one_step_holds(hard.problem, path)
    for near in neighbours(hard.problem):
        try:
            moved = rational_path(near, 1.0, hard.start, 3).slips(3)
        except NoPath:
            return last, size, float("inf"), long_step
        change = max(change, float(np.abs(moved - first).max()))
    return last, size, change / size, long_step


def neighbours(problem: Problem) -> Iterator[Problem]:
    """The same problem with one kind of data larger, or smaller, by one unit in the last place."""
    for way in (np.inf, -np.inf):
        yield replace(problem, f=np.nextafter(problem.f, way))
        yield replace(problem, q_w=np.nextafter(problem.q_w, np.where(problem.q_w == 0, 0, way)))
        diagonal = np.diag(np.nextafter(np.diag(problem.A), way))
        yield replace(problem, A=np.where(np.eye(problem.n) > 0, diagonal, problem.A))


def _long(hard: Scene) -> bool:
    return hard.cycles > 3


def measure(case: dict) -> dict:
    hard, method = scene(case["family"], case["scene"]), case["method"]
    exact, size, sensitivity, long_step = reference(case["family"], case["scene"])
    if method == "event":
        slips, said = _event_long(hard) if _long(hard) else _event(hard)
    elif method.startswith("GS"):
        slips, said = _gauss_seidel(hard, METHODS[method] or 0.0)
    else:
        slips, said = _siconos(hard, method)
    if _long(hard) and method == "event":
        exact = exact[hard.problem.m - 1 :: hard.problem.m]
    whole = len(slips) == len(exact) and np.isfinite(slips).all()
    error = float(np.abs(slips - exact).max() / size) if whole else None
    return {
        "n": hard.problem.n,
        "cycles": hard.cycles,
        "verdict": verdict(error, sensitivity, said, long_step and method != "event"),
        "said": said,
        "error": error,
        "sensitivity": sensitivity if np.isfinite(sensitivity) else None,
    }


def verdict(error: float | None, sensitivity: float, said: str, long_step: bool) -> str:
    if said or error is None:
        return "says so"
    if error <= RIGHT:
        return "right"
    if error <= ULPS * sensitivity:
        return "round-off"
    return "long step" if long_step else "off"


def _event(hard: Scene) -> Path:
    run = evolve(hard.problem, 1.0, hard.start, cycles=hard.cycles)
    steps = run.history.rows(run.history.kind == EventKind.LOAD_STEP)
    return steps.v[1:], "" if run.stop is None else run.stop.reason


def _event_long(hard: Scene) -> Path:
    """Without a record: states at the ends of the cycles only."""
    evolution = Evolution(hard.problem, 1.0, hard.start)
    last, said = [], ""
    for cycle in range(hard.cycles):
        if evolution.cycle() is None:
            said = evolution.stop.reason if evolution.stop else "stopped"
            break
        if cycle >= hard.cycles - SHOWN:
            last.append(evolution.state.u[: hard.problem.n])
    return np.array(last), said


def _gauss_seidel(hard: Scene, tolerance: float) -> Path:
    problem, size = hard.problem, scales(hard.problem, 1.0)
    q_w, p_w = (np.tile(part, (hard.cycles, 1)) for part in (problem.q_w, problem.p_w))
    steps = ImplicitSteps(problem.kappa, problem.f, 1, size.force, tolerance * size.length)
    begun = (np.vstack([part[:1], part]) for part in (q_w, p_w))
    slips = steps.follow(hard.start.astype(float), np.zeros(problem.n), *begun).v
    said = "" if len(slips) == len(q_w) else f"not solved at load step {len(slips)}"
    return slips[-SHOWN * problem.m :], said


def _siconos(hard: Scene, solver: str) -> Path:
    problem = hard.problem
    q_w, p_w = (np.tile(part, (hard.cycles, 1)) for part in (problem.q_w, problem.p_w))
    out = siconos_peer.solve_steps(
        problem, q_w, p_w, hard.start, solver, METHODS[solver] or 0.0, hard.peer_units
    )
    said = f"{out.failures} load steps reported as failed" if out.failures else ""
    return out.v[-SHOWN * problem.m :], said


def tables(rows: list[dict]) -> str:
    methods = [m for m in METHODS if any(r["method"] == m for r in rows)]
    cell = {(r["family"], r["scene"], r["method"]): r for r in rows}
    errors = []
    for family, name in dict.fromkeys((r["family"], r["scene"]) for r in rows):
        mine = [cell.get((family, name, m)) for m in methods]
        ulp = next(r for r in mine if r)["sensitivity"]
        errors.append([name, "jumps" if ulp is None else f"{ulp:.0e}", *map(_error, mine)])
    counts = [
        [word, "", *(str(sum(r["verdict"] == word for r in rows if r["method"] == m)) for m in methods)]
        for word in VERDICTS
    ]
    parts = [
        "error of the path, relative; * as 100 ulp of the data; ~ long load step; ! off; FAILED: says so",
        lines(["scene", "ulp does", *methods], errors + counts),
        "\nwhat the methods said",
        *(f"  {r['scene']}, {r['method']}: {r['said']}" for r in rows if r["said"]),
    ]
    return "\n".join(parts)


def _error(row: dict | None) -> str:
    if row is None:
        return ""
    if row["verdict"] == "says so":
        return "FAILED"
    mark = {"round-off": "* ", "long step": "~ ", "off": "! "}.get(row["verdict"], "")
    return f"{mark}{row['error']:.0e}"
