"""Problems on which float solvers go wrong, and how far each method is off the exact answer."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from math import inf, isfinite, isnan, nan
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

import shakedown
from benchmarks.bounds import Answer, Peer, by_cvxpy, by_highs, by_scipy, upper_program
from benchmarks.display import lines, panels, shown
from benchmarks.problems import joint
from benchmarks.rational_reference import fraction_rows, load_factor_range
from shakedown import Problem
from shakedown.bounds.independent_solver import conic_upper_bound
from shakedown.joint.constraints import constraints

TITLE = "Hard cases: error of each method against the exact rational answer"

ENUMERATED_UP_TO = 6  # nodes whose subsets of rows are few enough for fractions
RIGHT = 1e-9
VERDICTS = ("right", "off", "wrong status", "open", "self")
LABELS = {"wrong status": "wrong status", "open": "no answer", "self": "not checked"}


def twins(tilt: float = 0.0) -> Problem:
    """Two nodes that are alike, or nearly: their rows are (nearly) parallel."""
    return Problem(
        A=[[1.0 + tilt, 1.0], [1.0, 1.0 + 2 * abs(tilt)]],
        B=[[0.3, 0.1], [0.3, 0.1]],
        f=0.3,
        q_w=[[1.0, 0.5], [-1.0, -0.5], [0.2, 0.7]],
        p_w=[[4.0, 3.0], [4.5, 2.5], [3.0, 3.5]],
    )


def symmetric_block() -> Problem:
    """Mirror symmetry and equal loads: every row comes twice or four times."""
    A = 4 * np.eye(6) - np.eye(6, k=1) - np.eye(6, k=-1)
    B = np.eye(6, k=1) - np.eye(6, k=-1)
    loop = np.array([[1.0], [0.0], [-1.0], [0.0]]) * np.ones(6)
    return Problem(A=A, B=B, f=0.4, q_w=loop, p_w=3.0 + np.roll(loop, 1, axis=0))


def graded(decades: float) -> Problem:
    """Stiffness with eigenvalues over many decades: κ of that condition."""
    rng = np.random.default_rng(5)
    basis = np.linalg.qr(rng.normal(size=(5, 5)))[0]
    A = basis @ np.diag(10.0 ** -np.linspace(0, decades, 5)) @ basis.T
    A = 0.5 * (A + A.T)
    return replace(joint(5, 5), A=A, B=0.1 * A, C=None)


def with_friction(factor: float) -> Problem:
    """The two-node system at a multiple of node 0's critical friction A₀₀ / |B₀₀|."""
    problem = shakedown.example("two-node")
    return replace(problem, f=factor * problem.A[0, 0] / problem.B[0, 0])


def floating() -> Problem:
    """A chain held by the contact alone: A has a rigid translation."""
    A = 2 * np.eye(4) - np.eye(4, k=1) - np.eye(4, k=-1)
    A[0, 0] = A[-1, -1] = 1.0
    return replace(joint(7, 4), A=A, B=np.zeros((4, 4)), C=None)


def mixed_units() -> Problem:
    """Every node in units of its own, twelve decades apart."""
    force = 10.0 ** np.array([-6.0, -2.0, 2.0, 6.0])
    return joint(8, 4, units=(force, 1.0 / force))


def amplitude(size: float) -> Problem:
    problem = joint(9, 3)
    q0, p0 = problem.q_w.mean(axis=0), problem.p_w.mean(axis=0)
    q_w, p_w = q0 + size * (problem.q_w - q0), p0 + size * (problem.p_w - p0)
    return replace(problem, q_w=q_w, p_w=p_w, q_mean=q0, p_mean=p0)


def no_slack() -> Problem:
    """A mean load exactly on the limits of node 0, both sides: λ_max = 0."""
    return Problem(
        A=np.eye(2), B=np.zeros((2, 2)), f=0.5, q_w=[[1.0, 1.0], [-1.0, -1.0]], p_w=[[0.0, 2.0]] * 2
    )


def silent_node() -> Problem:
    problem = joint(3, 4)
    q, p = problem.q_w.copy(), problem.p_w.copy()
    q[:, 2], p[:, 2] = 0.25, 3.0
    return replace(problem, q_w=q, p_w=p)


def point_loop() -> Problem:
    problem = joint(2, 3)
    return replace(problem, q_w=problem.q_w[:1], p_w=problem.p_w[:1])


def line_loop() -> Problem:
    problem, t = joint(2, 3), np.linspace(-1, 1, 5)[:, None]
    return replace(problem, q_w=t * problem.q_w[0], p_w=4.0 + 0.5 * t * problem.q_w[0])


def one_frictionless_node() -> Problem:
    problem = joint(1, 3)
    q = problem.q_w.copy()
    q[:, 1] = 0.0
    return replace(problem, f=[0.3, 0.0, 0.4], q_w=q)


HARD_CASES: dict[str, Callable[[], Problem]] = {
    "plain": joint,
    "parallel rows": twins,
    "nearly parallel 1e-8": lambda: twins(1e-8),
    "nearly parallel 1e-13": lambda: twins(1e-13),
    "nearly parallel 1e-15": lambda: twins(1e-15),
    "symmetric block": symmetric_block,
    "silent node": silent_node,
    "point loop": point_loop,
    "line loop": line_loop,
    "frictionless": lambda: replace(joint(1, 3), f=0.0),
    "one frictionless node": one_frictionless_node,
    "at critical friction": lambda: with_friction(1.0),
    "just below critical friction": lambda: with_friction(1.0 - 1e-12),
    "beyond critical friction": lambda: with_friction(1.3),
    "far beyond critical friction": lambda: with_friction(20.0),
    "condition 1e8": lambda: graded(8.0),
    "condition 1e12": lambda: graded(12.0),
    "condition 1e14": lambda: graded(14.0),
    "floating": floating,
    "mixed units": mixed_units,
    "large forces": lambda: joint(4, units=(1e12, 1.0)),
    "small forces": lambda: joint(4, units=(1e-12, 1.0)),
    "large lengths": lambda: joint(4, units=(1.0, 1e12)),
    "small lengths": lambda: joint(4, units=(1.0, 1e-12)),
    "steel in newton and metre": lambda: joint(4, units=(1e3, 1e-8)),
    "load factor 1e9": lambda: amplitude(1e-9),
    "load factor 1e-9": lambda: amplitude(1e9),
    "load factor 0": no_slack,
    "pulled off": lambda: replace(joint(6, 3), p_w=-np.ones((6, 3))),
    "barely pulled off": lambda: replace(no_slack(), p_w=[[-1e-12, 2.0]] * 2),
    "barely pressed": lambda: replace(no_slack(), p_w=[[1e-12, 2.0]] * 2),
    "wedged": lambda: replace(joint(3, 3), f=4.0, B=np.full((3, 3), 0.3) + np.eye(3), C=None),
    "block-9": lambda: shakedown.example("block-9"),
    "block-9 at f = 0.2": lambda: replace(shakedown.example("block-9"), f=0.2),
}


def by_toolkit(**how: bool) -> Callable[[Problem], Answer]:
    def answer(problem: Problem) -> Answer:
        upper = shakedown.upper_bound(problem, **how)
        return upper.status, upper.load_factor

    return answer


def by_cones(problem: Problem) -> Answer:
    upper = conic_upper_bound(problem)
    return upper.status, upper.load_factor


def by_peer(peer: Peer) -> Callable[[Problem], Answer]:
    """A solver as it comes, with its default tolerances, on the data as they are."""

    def answer(problem: Problem) -> Answer:
        status, cost = peer(*upper_program(constraints(problem)))
        return status, inf if status == "unbounded" else -cost

    return answer


OWN = "shakedown"
METHODS: dict[str, Callable[[Problem], Answer]] = {
    OWN: by_toolkit(),  # as a user calls it
    "shakedown, floats only": by_toolkit(certify=False),
    "shakedown, conic": by_cones,
    "highspy": by_peer(by_highs),
    "scipy linprog": by_peer(by_scipy),
    "cvxpy default": by_peer(by_cvxpy(None)),
    "cvxpy Clarabel": by_peer(by_cvxpy("CLARABEL")),
}


def cases(short: bool) -> list[dict]:
    return [{"problem": name, "method": method} for name in HARD_CASES for method in METHODS]


def measure(case: dict) -> dict:
    reference = reference_upper(case["problem"])
    status, found = METHODS[case["method"]](HARD_CASES[case["problem"]]())
    verdict, error = judged(case["method"], reference, status, found)
    return {
        "exact_status": reference.status,
        "exact": as_number(reference.load_factor),
        "reference": reference.kind,
        "status": status,
        "value": as_number(found),
        "error": as_number(error),
        "verdict": verdict,
    }


class Reference(NamedTuple):
    """The answer that every method is held against."""

    kind: str  # "rational" (all subsets in fractions), or "certificate" (the package's own) of more nodes
    status: str
    load_factor: float


@cache
def reference_upper(name: str) -> Reference:
    problem = HARD_CASES[name]()
    if problem.n > ENUMERATED_UP_TO:
        upper = shakedown.upper_bound(problem, certify=True)
        return Reference("certificate", upper.status, upper.load_factor)
    found = load_factor_range(*fraction_rows(problem))
    if found is None:
        return Reference("rational", "infeasible", nan)
    return Reference("rational", "unbounded" if found[1] == inf else "optimal", float(found[1]))


def judged(method: str, reference: Reference, status: str, found: float) -> tuple[str, float]:
    """The verdict on an answer, and its relative error.

    "right", "off" (by more than 1e-9), "wrong status", "open" (no answer given), or
    "self": the package's answer where there is only its own certificate to compare with.
    """
    if method == OWN and reference.kind == "certificate":
        return "self", nan
    if status in ("undecided", "unknown"):
        return "open", nan
    if status != reference.status:
        return "wrong status", nan
    if status != "optimal":
        return "right", 0.0
    value = reference.load_factor
    error = abs(found - value) / value if value > 0 else abs(found)
    return "right" if error <= RIGHT else "off", error


def as_number(value: float) -> float | str | None:
    return None if isnan(value) else value if isfinite(value) else "inf"


def tables(rows: list[dict]) -> str:
    names = list(dict.fromkeys(r["problem"] for r in rows))
    cell = {(r["problem"], r["method"]): r for r in rows}
    found = []
    for name in names:
        first = cell[name, OWN]
        exact = f"{first['exact']:.5g}" if first["exact_status"] == "optimal" else first["exact_status"]
        found.append([name, first["reference"], exact, *(cell_text(cell[name, m]) for m in METHODS)])
    for verdict in VERDICTS:
        counts = [sum(cell[name, method]["verdict"] == verdict for name in names) for method in METHODS]
        found.append([f"{verdict}, of {len(names)}", "", "", *map(str, counts)])
    return lines(["", "reference", "exact", *(m.replace("shakedown", "sd") for m in METHODS)], found)


def cell_text(row: dict) -> str:
    if row["verdict"] == "wrong status":
        return f"! {row['status']}"
    if row["verdict"] in ("open", "self"):
        return row["verdict"]
    return shown(row, "{error:.1e}") if row["status"] == "optimal" else "right"


def figures(rows: list[dict]) -> dict[str, Figure]:
    figure, (axes,) = panels(1, size=(8.0, 4.0))
    for k, method in enumerate(METHODS):
        mine = [r for r in rows if r["method"] == method]
        errors = [max(r["error"], 1e-17) for r in mine if r["verdict"] in ("right", "off")]
        heights = np.full(len(errors), k) + np.linspace(-0.25, 0.25, len(errors))
        axes.semilogx(errors, heights, "o", ms=4, alpha=0.6)
        counts = {v: sum(r["verdict"] == v for r in mine) for v in LABELS}
        text = "\n".join(f"{LABELS[v]}: {count}" for v, count in counts.items() if count)
        # beside the axes, where no point can be
        axes.text(1.02, k, text, transform=axes.get_yaxis_transform(), va="center", fontsize=8)
    axes.axvline(RIGHT, color="k", lw=0.8, ls="--")
    axes.set_yticks(range(len(METHODS)), list(METHODS))
    axes.set(xlim=(3e-18, 10), xlabel="relative error of the upper bound (0 drawn at 1e-17)")
    axes.invert_yaxis()
    return {"hard_cases": figure}
