"""How sharp the energy bound is.

λ_E, the load factor to which shakedown from slip zero is proved, beside λ_1 (first collapse), λ_T
(where the simulated joint stops shaking down) and λ_max: against the strength of the coupling,
against friction and against the mesh. Where slip zero is far from every safe slip λ_E falls
short of λ_T; then the number of cycles counts after which a simulated state is inside the ball.
In space, what each node's share of its own coupling gains. What the bound costs is in
``large_joints`` and ``verify_times``.
"""

import statistics
from dataclasses import replace
from math import isfinite

import numpy as np

import shakedown
from benchmarks.display import listed
from benchmarks.problems import joint
from benchmarks.refinement import block_on_plane, brick
from shakedown import Problem, energy_ball, energy_bound, transient_limit, upper_bound
from shakedown.bounds.coupling import coupling
from shakedown.motion.evolution import Evolution

TITLE = "The energy bound: how sharp it is"
SHARES = (0.9, 0.98, 0.999)  # of λ_T
MOST_CYCLES = 64
IN_SPACE = ("one-node-3d", "two-node-3d", "four-node-3d", "block-3x3")


def cases(short: bool) -> list[dict]:
    couplings, seeds = ((0.3, 1.0), 2) if short else ((0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5), 8)
    frictions = (0.2, 0.5) if short else (0.1, 0.2, 0.3, 0.4, 0.5)
    elements = (8,) if short else (8, 16, 32, 64)
    in_space, bricks = (("one-node-3d",), ()) if short else (IN_SPACE, (4, 6, 10))
    return [
        *({"study": "coupling", "value": c, "seed": seed} for c in couplings for seed in range(seeds)),
        *({"study": "friction", "value": f, "block": b} for b in ("block-9", "block-33") for f in frictions),
        *({"study": "mesh", "value": e, "f": f} for f in (0.2, 0.4) for e in elements),
        *({"study": "space", "joint": name} for name in in_space),
        *({"study": "space", "joint": "brick", "value": e, "f": f} for f in (0.3, 0.5) for e in bricks),
    ]


def measure(case: dict) -> dict:
    if case["study"] == "coupling":
        return sharpness(joint(case["seed"], n=6, coupling=case["value"]))
    if case["study"] == "space":
        name = case["joint"]
        return gained(brick(case["value"], case["f"]) if name == "brick" else shakedown.example(name))
    if case["study"] == "friction":
        problem = shakedown.example(case["block"])
        return sharpness(replace(problem, f=np.full(problem.n, case["value"])))
    return sharpness(block_on_plane(case["value"], case["f"]))


def sharpness(problem: Problem) -> dict:
    """λ_1, λ_E and λ_T relative to λ_max, and cycles until a state is in a ball; null where undefined."""
    upper = upper_bound(problem, certify=False)
    if upper.status != "optimal":
        return {"nodes": problem.n, "upper": None}
    bound, lower = energy_bound(problem), shakedown.lower_bound(problem, certify=False)
    limit = transient_limit(problem, steps=20, accuracy=1e-5).load_factor
    found = {"first_collapse": lower.load_factor, "energy": bound.load_factor, "transient": limit}
    relative = {key: x / upper.load_factor if isfinite(x) else None for key, x in found.items()}
    cycles = [cycles_to_ball(problem, share * limit) if isfinite(limit) else None for share in SHARES]
    ratio = coupling(problem).ratio
    row = {"nodes": problem.n, "upper": upper.load_factor, "cycles": cycles, "status": str(bound.status)}
    return row | relative | {"coupling_ratio": ratio if isfinite(ratio) else None}


def gained(problem: Problem) -> dict:
    """λ_E of a joint in space relative to λ_max, with the best shares of the own coupling and without."""
    upper = upper_bound(problem, certify=False).load_factor
    row: dict = {"nodes": problem.n, "upper": upper}
    for name, split in (("energy", True), ("zero", False)):
        relative = energy_bound(problem, split=split, certify=False).load_factor / upper
        row[name] = relative if isfinite(relative) else None
    return row


def cycles_to_ball(problem: Problem, load_factor: float) -> int | None:
    """Cycles from slip zero until a ball holds the state; None where it takes too many."""
    evolution = Evolution(problem, load_factor)
    n, no_gap = problem.n, 1e-12 * evolution.scale.length
    for cycle in range(1, MOST_CYCLES + 1):
        if evolution.cycle() is None:
            return None
        u = evolution.state.u
        if np.abs(u[n:]).max() > no_gap:
            continue
        if energy_ball(problem, load_factor, around=u[:n], transient=False).contains(u[:n]):
            return cycle
    return None


def tables(rows: list[dict]) -> str:
    space = [row for row in rows if row["study"] == "space"]
    parts, in_space = [], {"joint": "{joint}", "nodes": "{nodes}", "f": "{f:g}", "λ_E/λ_max": "{energy:.4f}"}
    for study in dict.fromkeys(row["study"] for row in rows if row not in space):
        chosen = [row for row in rows if row["study"] == study and row["upper"] is not None]
        # joints of one coupling together; the other studies have one joint per line
        keys = [row["value"] if study == "coupling" else number for number, row in enumerate(chosen)]
        groups = [
            [row for row, own in zip(chosen, keys, strict=True) if own == key] for key in dict.fromkeys(keys)
        ]
        columns = {
            "coupling": {"coupling": "{value:g}"},
            "friction": {"joint": "{block}", "f": "{value:g}"},
            "mesh": {"nodes": "{nodes}", "f": "{f:g}"},
        }[study] | {
            "joints": "{joints}", "ρ": "{coupling_ratio:.4f}", "λ_1/λ_max": "{first_collapse:.4f}",
            "λ_E/λ_max": "{energy:.4f}", "λ_T/λ_max": "{transient:.4f}", "λ_E/λ_T": "{share:.4f}",
            **{f"cycles at {share:g} λ_T": f"{{cycles_{k}:g}}" for k, share in enumerate(SHARES)},
        }  # fmt: skip
        parts.append(f"against {study}, medians\n{listed(map(_medians, groups), columns)}")
    parts.append(f"in space\n{listed(space, in_space | {'without shares': '{zero:.4f}'})}")
    return "\n\n".join(parts)


def _medians(group: list[dict]) -> dict:
    """Of the values that there are, over joints of one kind."""

    def median(values: list) -> float | None:
        known = [value for value in values if value is not None]
        return statistics.median(known) if known else None

    keys = ("coupling_ratio", "first_collapse", "energy", "transient")
    shares = [row["energy"] / row["transient"] for row in group if row["energy"] and row["transient"]]
    cycles = {f"cycles_{k}": median([row["cycles"][k] for row in group]) for k in range(len(SHARES))}
    found = {key: median([row[key] for row in group]) for key in keys}
    return group[0] | found | cycles | {"joints": len(group), "share": median(shares)}
