"""Loops, damping and stiffness over amplitude: closed forms, Masing's rule, fixed steps.

- ``row``: Jenkins elements side by side on a bar, limits spread evenly (Iwan): exact sums, to round-off
- ``bar``: a bar on a frictional foundation, pulled at its end (Menq; Gaul): D = 2 F³ / (3 EA τ)
- ``rule``: a block on a floor, where slip and pressure are coupled: Masing's rule on the first loading,
  and Gauss-Seidel at fixed load steps, against the exact curve
"""

import time

import numpy as np
from matplotlib.figure import Figure

import shakedown
from benchmarks.display import curve, listed, panels
from shakedown import Problem, conjugate_displacement, damping
from shakedown.fem import (
    ElasticBody,
    Force,
    Material,
    Pressure,
    block_mesh,
    contact_problem,
)
from shakedown.motion.evolution import evolve

TITLE = "Damping over amplitude: closed forms, Masing's rule, fixed steps"
REACHES = (1.35, 1.38, 1.42, 1.46, 1.5, 1.54, 1.58)  # amplitudes: at rest up to 1.34, slides away at 1.6
PARTS = (8, 32, 128, 512)  # load steps of a period


def cases(short: bool) -> list[dict]:
    rows = [{"part": "row", "n": 40}]
    rows += [{"part": "bar", "n": n} for n in ((10, 20) if short else (10, 20, 40, 80, 160))]
    return [*rows, {"part": "rule", "n": 8 if short else 24}]


def measure(case: dict) -> dict:
    began = time.process_time()
    found = {"row": _row, "bar": _bar, "rule": _rule}
    row = found[case["part"]](case)
    return row | {"seconds": time.process_time() - began}


def _row(case: dict) -> dict:
    """Elements of stiffness k and a limit each on a bar with a spring: X → F, 4 limit (X − limit/k)."""
    n, ground = case["n"], 0.7
    k, limits, X = np.full(n, 1.0 / n), np.linspace(0.02, 2.0, n) / n, np.geomspace(0.01, 10.0, 20)
    total = k.sum() + ground
    joint = Problem(
        A=np.diag(k) - np.outer(k, k) / total, B=np.zeros((n, n)), f=1.0, p_w=np.tile(limits, (2, 1)),
        q_w=np.outer([-1.0, 1.0], k / total), load_reactions=[np.append(-k / total, np.zeros(n))],
        load_history=[[1.0], [-1.0]], load_compliance=[[1 / total]],
    )  # fmt: skip
    loops = damping(joint, ground * X + np.minimum(k * X[:, None], limits).sum(axis=1))
    exact = (4 * limits * np.maximum(X[:, None] - limits / k, 0)).sum(axis=1)
    return {"errors": [_apart(loops.displacement, X), _apart(loops.dissipation, exact)]}


def _bar(case: dict) -> dict:
    """EA = L = τ L = 1, n elements, friction τ per length: as far as slip reaches, F < τ L, D ∝ F³."""
    n = case["n"]
    h = 1.0 / n
    A = (np.diag(np.r_[1.0, np.full(n - 1, 2.0), 1.0]) - np.eye(n + 1, k=1) - np.eye(n + 1, k=-1)) / h
    share, end = h * np.r_[0.5, np.ones(n - 1), 0.5], np.r_[np.zeros(n), -1.0]
    joint = Problem(
        A=A, B=np.zeros((n + 1, n + 1)), f=1.0, q_w=np.outer([1.0, -1.0], end), p_w=np.tile(share, (2, 1)),
        load_reactions=[np.append(end, np.zeros(n + 1))], load_history=[[1.0], [-1.0]],
        load_compliance=[[0.0]],
    )  # fmt: skip
    F = np.linspace(0.1137, 0.8911, 17)  # no whole numbers of elements
    loops = damping(joint, F)
    errors = [_rms(loops.displacement, F**2 / 2), _rms(loops.dissipation, 2 * F**3 / 3)]
    return {"errors": errors}


def block(elements: int, steps: int) -> Problem:
    """A block on a floor, pressed and pushed on top by a triangular force of so many load steps."""
    wave = np.interp(np.arange(steps) / steps, [0.0, 0.25, 0.75, 1.0], [0.0, 1.0, -1.0, 0.0])
    loads = [Pressure("top", 1.0, history=1.0), Force(boundary="top", value=(1.0, 0.0), history=wave)]
    body = ElasticBody(
        block_mesh(4.0, 1.0, elements, max(elements // 3, 2)), Material(100.0, 0.3), loads=loads
    )
    return contact_problem(body, "bottom", 0.4)


def _rule(case: dict) -> dict:
    """Exact loops; Masing's rule on the first loading; fixed load steps, their error and time."""
    joint = block(case["n"], 4)
    began = time.process_time()
    loops = [damping(joint, [reach], load=1) for reach in REACHES]
    exact_seconds = (time.process_time() - began) / len(REACHES)
    steps = []
    for parts in PARTS:
        fine = block(case["n"], parts)
        began = time.process_time()
        found = [_stepped(fine, amplitude) for amplitude in REACHES]
        seconds = (time.process_time() - began) / len(REACHES)
        steps.append({"parts": parts, "seconds": seconds, "dissipation": found})
    return {
        "amplitudes": list(REACHES),
        "exact": [float(loop.dissipation[0]) for loop in loops],
        "loss": [float(loop.loss_factor[0]) for loop in loops],
        "exact_seconds": exact_seconds,
        "masing": [_masing(joint, amplitude) for amplitude in REACHES],
        "steps": steps,
    }


def _stepped(joint: Problem, amplitude: float) -> float:
    run = shakedown.simulate(joint, amplitude, method="gauss-seidel", cycles=200)
    return float(run.dissipation_per_cycle)


def _masing(joint: Problem, amplitude: float) -> float:
    """8 ∫ F dx − 4 F X of the first loading, F and x counted from the preload."""
    path = evolve(joint, amplitude, cycles=1).history
    rising = (path.cycle >= 0) & (path.cycle <= 0.25)
    moved, F = conjugate_displacement(joint, path)[rising, 1], 4.0 * amplitude * path.cycle[rising]
    X = moved - moved[0]
    return float(8 * (0.5 * (F[1:] + F[:-1]) * np.diff(X)).sum() - 4 * F[-1] * X[-1])


def _apart(found: np.ndarray, exact: np.ndarray) -> float:
    return float(np.abs(found / np.where(exact == 0, 1, exact) - (exact != 0)).max())


def _rms(found: np.ndarray, exact: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(found - exact))) / np.max(exact))


def order(rows: list[dict], which: int) -> float:
    """Fitted order of an error over the number of elements."""
    count, errors = [row["n"] for row in rows], [row["errors"][which] for row in rows]
    return float(-np.polyfit(np.log(count), np.log(errors), 1)[0])


def of_part(rows: list[dict], part: str) -> list[dict]:
    return [row for row in rows if row["part"] == part]


def tables(rows: list[dict]) -> str:
    errors = {
        "part": "{part}", "n": "{n}", "displ.": "{errors[0]:.1e}",
        "diss.": "{errors[1]:.1e}", "s": "{seconds:.1f}",
    }  # fmt: skip
    text = "Relative errors of displacement and dissipation\n"
    text += listed([row for row in rows if "errors" in row], errors)
    if len(found := of_part(rows, "bar")) > 1:
        text += f"\nbar: orders {order(found, 0):.2f} and {order(found, 1):.2f}"
    for row in of_part(rows, "rule"):
        text += f"\n\nA block, dissipation by amplitude\n{listed(_departures(row), DEPARTURES)}"
        text += f"\nexact: {row['exact_seconds']:.2g} s each; "
        text += ", ".join(f"{step['parts']} steps: {step['seconds']:.2g} s" for step in row["steps"])
    return text


DEPARTURES = {"amplitude": "{amplitude:g}", "exact D": "{exact:.4g}", "η": "{loss:.3f}"} | {
    name: f"{{{name}:+.1%}}" for name in ("Masing", *(f"{parts} steps" for parts in PARTS))
}


def _departures(row: dict) -> list[dict]:
    """Of Masing's rule and of fixed steps from the exact dissipation, where there is some."""
    others = {"Masing": row["masing"]} | {f"{s['parts']} steps": s["dissipation"] for s in row["steps"]}
    return [
        {"amplitude": amplitude, "exact": exact, "loss": row["loss"][k]}
        | {name: found[k] / exact - 1 if exact else None for name, found in others.items()}
        for k, (amplitude, exact) in enumerate(zip(row["amplitudes"], row["exact"], strict=True))
    ]


def figures(rows: list[dict]) -> dict[str, Figure]:
    figure, (left, right) = panels(2, 2, (4.5, 3.8))
    for which, name in enumerate(("displacement", "dissipation")):
        errors = [{"n": row["n"], "error": row["errors"][which]} for row in of_part(rows, "bar")]
        curve(left, errors, "n", "error", label=f"bar, {name}")
    left.set(xlabel="elements of the bar", ylabel="relative error")
    left.set_title("against closed forms")
    for row in of_part(rows, "rule"):
        for name in list(DEPARTURES)[3:]:
            errors = [one | {name: abs(one[name])} for one in _departures(row) if one[name] is not None]
            curve(right, errors, "amplitude", name, "k^:" if name == "Masing" else "o-", label=name)
    right.set(xlabel="amplitude of the force", ylabel="relative error of dissipation", xscale="linear")
    right.set_title("a block on a floor")
    for axes in (left, right):
        if axes.get_lines():
            axes.legend(fontsize=8)
    return {"damping": figure}
