"""How much of the gap between what is proved and the first collapse is real: the smallest cycle found.

Of every joint: λ_U, below which shakedown from every state is proved, λ_1, and λ_cycle, the smallest
load factor at which a cycle was found. Its true limit lies between λ_U and λ_cycle. Where λ_cycle is
λ_1, the first collapse is the limit, as far as anybody found; where it is less, that much of the gap
between λ_U and λ_1 is real. λ_single is the bound below which no node alone can cycle.
"""

import time
from dataclasses import replace
from itertools import islice

import numpy as np
from matplotlib.figure import Figure

import shakedown
from benchmarks.adversary import difficult_joint
from shakedown.bounds.uniqueness.coupling import coupling
from shakedown.report.text_table import table

TITLE = "The smallest cycle found, beside what is proved from every state and the first collapse"
NAMED = (
    ("one-node", None),
    ("uncoupled", None),
    ("two-node", None),
    ("two-node", 0.45),
    ("two-node", 0.6),
    ("three-node", None),
    ("block-9", 0.1),
    ("block-9", 0.2),
    ("block-9", 0.3),
    ("block-9", 0.4),
    ("block-9", 0.5),
    ("press-fit", None),
    ("cantilevered-block", None),
    ("block-33", 0.2),
    ("block-33", None),
)
SHORT_NAMED = 7
RANDOM = (
    (3, "known"),
    (2, "unique"),
    *((n, band) for n in (3, 4, 6) for band in ("weak", "below one", "strong", "star")),
)
DRAWN = 40  # times as many joints as are wanted
SAME = 1e-4  # of λ_1 or λ_U: what is this near counts as it


def cases(short: bool) -> list[dict]:
    effort = {"states": 32, "rounds": 6} if short else {"states": 128, "rounds": 20}
    less = {"states": 64, "rounds": 8, "joints": 2 if short else 12}
    named = NAMED[:SHORT_NAMED] if short else NAMED
    return [{"joint": name, "f": f, **effort, "seed": 0} for name, f in named] + [
        {"joint": f"random, {band}", "n": n, "band": band, **less, "seed": 3}
        for n, band in RANDOM[:: 5 if short else 1]
    ]


def measure(case: dict) -> dict:
    if "band" in case:
        generator = np.random.default_rng([case["seed"], case["n"], *case["band"].encode()])
        drawn = (difficult_joint(generator, case["n"], case["band"]) for _ in range(DRAWN * case["joints"]))
        problems = list(islice(filter(collapses, drawn), case["joints"]))
    else:
        problem = shakedown.example(case["joint"])
        problems = [problem if case["f"] is None else replace(problem, f=np.full(problem.n, case["f"]))]
    return {"found": [found for problem in problems if (found := searched(problem, case)) is not None]}


def collapses(problem: shakedown.Problem) -> bool:
    """Whether there is a first collapse, and not at the mean load already."""
    return 0.0 < shakedown.lower_bound(problem, certify=False).load_factor < np.inf


def searched(problem: shakedown.Problem, case: dict) -> dict | None:
    """The numbers of one joint; None where there is no safe slip under the mean load."""
    began = time.process_time()
    cycle = shakedown.smallest_cycle(problem, states=case["states"], rounds=case["rounds"], seed=case["seed"])
    if not np.isfinite(cycle.limits.lower.load_factor):
        return None
    return {
        "n": problem.n,
        "coupling_ratio": finite(coupling(problem).ratio),
        "universal": cycle.limits.universal.load_factor,
        "first_collapse": cycle.limits.lower.load_factor,
        "guarantee": cycle.limits.lower.guarantee,
        "single_node": finite(cycle.limits.lower.single_node_bound),
        "cycle": finite(cycle.load_factor),
        "upper": finite(cycle.limits.upper.load_factor),
        "status": cycle.status,
        "period": cycle.period,
        "slipping": list(cycle.slipping_nodes),
        "tries": cycle.tries,
        "seconds": time.process_time() - began,
    }


def finite(number: float) -> float | None:
    """A number as JSON knows it."""
    return float(number) if np.isfinite(number) else None


def tables(rows: list[dict]) -> str:
    named = [row for row in rows if "band" not in row and row["found"]]
    groups = [row for row in rows if "band" in row and row["found"]]
    return f"{_named_table(named)}\n\n{_random_table(groups)}"


def _named_table(rows: list[dict]) -> str:
    headers = [
        "joint",
        "f",
        "λ_U",
        "λ_cycle",
        "λ_1",
        "guarantee",
        "λ_max",
        "cycle / λ_1",
        "nodes",
        "tries",
        "s",
    ]
    lines = []
    for row in rows:
        (found,) = row["found"]
        share = (
            found["cycle"] / found["first_collapse"] if found["cycle"] and found["first_collapse"] else None
        )
        lines.append(
            [
                row["joint"],
                "" if row["f"] is None else f"{row['f']:g}",
                f"{found['universal']:.6g}",
                "-" if found["cycle"] is None else f"{found['cycle']:.6g}",
                f"{found['first_collapse']:.6g}",
                found["guarantee"],
                "-" if found["upper"] is None else f"{found['upper']:.6g}",
                "-" if share is None else f"{share:.6f}",
                ",".join(map(str, found["slipping"])),
                str(found["tries"]),
                f"{found['seconds']:.1f}",
            ]
        )
    return table(headers, lines)


def _random_table(rows: list[dict]) -> str:
    """Per kind: how often the cycle begins at λ_1, below it, above it; whether the interval is closed."""
    headers = [
        "random",
        "n",
        "joints",
        "at λ_1",
        "below",
        "above",
        "least / λ_1",
        "at min(λ_1, λ_single)",
        "closed",
        "λ_U / λ_1",
        "contr.",
    ]
    lines = []
    for row in rows:
        found = [f for f in row["found"] if f["cycle"] is not None and f["first_collapse"] > 0]
        shares = np.array([f["cycle"] / f["first_collapse"] for f in found])
        least = np.array([min(f["first_collapse"], f["single_node"] or np.inf) for f in found])
        cycles = np.array([f["cycle"] for f in found])
        proved = np.array([f["universal"] / f["first_collapse"] for f in found])
        lines.append(
            [
                row["band"],
                str(row["n"]),
                str(len(found)),
                str(int((np.abs(shares - 1) <= SAME).sum())),
                str(int((shares < 1 - SAME).sum())),
                str(int((shares > 1 + SAME).sum())),
                f"{shares.min(initial=1.0):.3f}",
                str(int((np.abs(cycles / least - 1) <= SAME).sum())),
                str(int((shares <= proved * (1 + SAME)).sum())),
                f"{np.median(proved):.3f}" if len(proved) else "-",
                str(sum(f["status"] == "contradiction" for f in row["found"])),
            ]
        )
    return table(headers, lines)


def figures(rows: list[dict]) -> dict[str, Figure]:
    """Of every random joint the interval of its true limit, relative to λ_1, over the coupling ratio."""
    found = [f for row in rows if "band" in row for f in row["found"]]
    found = [f for f in found if f["cycle"] and f["first_collapse"] > 0 and f["coupling_ratio"]]
    if not found:
        return {}
    figure = Figure(figsize=(7.2, 4.4), layout="constrained")
    axes = figure.subplots()
    ratio = np.array([f["coupling_ratio"] for f in found])
    low, high = (np.array([f[key] / f["first_collapse"] for f in found]) for key in ("universal", "cycle"))
    axes.vlines(ratio, low, high, color="#999999", lw=0.7, zorder=1)
    axes.plot(ratio, low, ".", color="#009E73", ms=5, label="λ_U, proved from every state")
    axes.plot(ratio, high, ".", color="#D55E00", ms=5, label="λ_cycle, the smallest cycle found")
    axes.axhline(1.0, color="black", lw=0.8, ls="--")
    axes.set(xlabel="coupling ratio ρ", ylabel="load factor, relative to λ_1", ylim=(0.0, None))
    axes.set_xscale("log")
    axes.legend(fontsize="small", loc="lower left")
    return {"smallest-cycles": figure}
