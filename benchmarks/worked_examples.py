"""Worked examples: one node above the critical friction (appendix A), and the jump (chapter VI)."""

from matplotlib.figure import Figure

import shakedown
from shakedown import plot
from shakedown.motion.evolution import evolve
from shakedown.report.facts import table

TITLE = "Worked examples: separation and stick, cyclic slip above the critical friction, a jump"
NAMES = ("one-node-separation", "one-node-cyclic", "jump")
DAMPINGS = {"diagonal of κ": None, "equal": [1.0, 1.0, 1.0, 1.0], "unequal": [1.0, 10.0, 3.0, 0.2]}


def cases(short: bool) -> list[dict]:
    slow = [{"name": name, "damping": "diagonal of κ"} for name in NAMES]
    return slow + [{"name": "jump", "damping": key} for key in list(DAMPINGS)[1:]]


def measure(case: dict) -> dict:
    problem = shakedown.example(case["name"])
    start = problem.initial_slip[0]
    run = evolve(problem, 1.0, start, cycles=3, damping=DAMPINGS[case["damping"]])
    state = shakedown.long_term_state(problem, 1.0, start)
    jumps = [jump for cycle in run.cycles for jump in cycle.jumps]
    return {
        "outcome": state.outcome.value,
        "slip_per_cycle": state.slip_per_cycle.tolist(),
        "end_slip": run.history.v[-1].tolist(),
        "end_gap": run.history.w[-1].tolist(),
        "jumps": len(jumps),
        "energy_released": float(sum(jump.energy_released for jump in jumps)),
        "friction_work": float(sum(jump.friction_work for jump in jumps)),
    }


def tables(rows: list[dict]) -> str:
    lines = [
        [
            row["name"], row["damping"], row["outcome"], _numbers(row["end_slip"]),
            _numbers(row["end_gap"]), str(row["jumps"]),
            f"{row['energy_released']:.6g}", f"{row['friction_work']:.6g}",
        ]
        for row in rows
    ]  # fmt: skip
    head = ["example", "damping", "outcome", "end slip", "end gap", "jumps", "energy released", "friction"]
    return table(head, lines)


def _numbers(values: list[float]) -> str:
    return " ".join(f"{value:.7g}" for value in values)


def figures(rows: list[dict]) -> dict[str, Figure]:
    out = {}
    for name in NAMES:
        problem = shakedown.example(name)
        run = evolve(problem, 1.0, problem.initial_slip[0], cycles=3)
        if problem.n == 2:
            axes = plot.slip_space(problem, 1.0, {"path": run})
        else:
            axes = plot.reaction_space(run, problem)
        out[f"worked-{name}"] = axes.figure
    return out
