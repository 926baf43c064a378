"""Two blocks of hexahedra on each other, condensed to their contact: time, memory, and beside SuperLU.

Each case but the smallest runs in a process of its own, whose largest memory is told. Up to some size the
same model is condensed by SuperLU too, in the same process, one after the other.
"""

import multiprocessing
import resource
import sys
import time
from concurrent.futures import ProcessPoolExecutor

import numpy as np
from matplotlib.figure import Figure
from scipy.sparse.linalg import splu
from threadpoolctl import threadpool_limits

from shakedown.fem import ElasticBody, Force, Material, Support, brick_mesh, contact_problem
from shakedown.ground.float_array import FloatArray
from shakedown.report.text_table import table

TITLE = "Condensing large solids"
SIDES = (28.0, 25.0, 28.0)
# Elements along x, y, z of each block, and whether SuperLU is timed too.
SIZES = {(6, 5, 6): True, (9, 8, 9): True, (13, 12, 13): True, (19, 17, 19): False, (27, 24, 27): False}
COLUMNS = 64  # right sides solved for at a time
UNIT = 2**20 if sys.platform == "darwin" else 2**10  # of ru_maxrss, per MiB


def cases(short: bool) -> list[dict]:
    sizes = list(SIZES)[: 2 if short else None]
    return [{"elements": list(size)} for size in sizes]


def measure(case: dict) -> dict:
    if case["elements"] == list(next(iter(SIZES))):
        return _measured(tuple(case["elements"]))
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as alone:
        return alone.submit(_measured, tuple(case["elements"])).result()


def _measured(elements: tuple[int, int, int]) -> dict:
    steel = Material(210e3, 0.3)
    top = (0.0, 0.0, SIDES[2])
    push = Force("top", (100.0, 50.0, -1000.0), history=1.0)
    upper = ElasticBody(brick_mesh(SIDES, elements, origin=top), steel, loads=[push])
    lower = ElasticBody(brick_mesh(SIDES, elements), steel, supports=[Support("bottom")])
    began = time.process_time()
    nodes = len(upper.stiffness.indptr) // 3 + len(lower.stiffness.indptr) // 3
    assembled = time.process_time()
    with threadpool_limits(limits=1, user_api="blas"):
        joint = contact_problem(upper, "bottom", 0.4, against=(lower, "top"))
    done = time.process_time()
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / UNIT
    found = {
        "nodes": nodes,
        "pairs": joint.n,
        "assembly": assembled - began,
        "condensation": done - assembled,
        "memory": memory,
        "out_of_balance": float(abs(joint.p_w[0].sum() - 1000.0) / 1000.0),
    }
    return found | (_by_superlu(upper, lower, joint.kappa) if SIZES.get(elements) else {})


def _by_superlu(upper: ElasticBody, lower: ElasticBody, kappa: FloatArray) -> dict:
    """Each block by itself with SuperLU, then κ = κ₁ − κ₁ (κ₁ + κ₂)⁻¹ κ₁."""
    began = time.process_time()
    with threadpool_limits(limits=1, user_api="blas"):
        one, two = _schur(upper, "bottom"), _schur(lower, "top")
        other = one - one @ np.linalg.solve(one + two, one)
    seconds = time.process_time() - began
    return {
        "superlu": seconds,
        "superlu_memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / UNIT,
        "apart": float(np.abs(other - kappa).max() / np.abs(kappa).max()),
    }


def _schur(body: ElasticBody, boundary: str) -> FloatArray:
    """The stiffness of a block against its contact nodes: their slips x, y node by node, then gaps z."""
    x, y, z = (body.rows_on(boundary, direction) for direction in (1, 2, 3))
    contact = np.concatenate([np.column_stack([x, y]).ravel(), z])
    inside = np.setdiff1d(np.arange(body.basis.N), np.concatenate([contact, body.held_rows()]))
    K = body.stiffness
    lu = splu(
        K[inside][:, inside].tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.01,
        options={"SymmetricMode": True},
    )
    across, found = K[inside][:, contact].tocsc(), K[contact][:, contact].toarray()
    for start in range(0, len(contact), COLUMNS):
        block = slice(start, start + COLUMNS)
        found[:, block] -= across.T @ lu.solve(across[:, block].toarray())
    return found


def tables(rows: list[dict]) -> str:
    headers = [
        "nodes", "pairs", "assembly [s]", "condensation [s]", "memory [MiB]", "out of balance",
        "SuperLU [s]", "with it [MiB]", "κ apart",
    ]  # fmt: skip
    lines = [
        [
            str(row["nodes"]), str(row["pairs"]), f"{row['assembly']:.1f}", f"{row['condensation']:.1f}",
            f"{row['memory']:.0f}", f"{row['out_of_balance']:.0e}",
            *([f"{row['superlu']:.1f}", f"{row['superlu_memory']:.0f}", f"{row['apart']:.0e}"]
              if "superlu" in row else ["–"] * 3),
        ]
        for row in rows
    ]  # fmt: skip
    return f"Seconds of one processor, largest memory of the process:\n{table(headers, lines)}"


def figures(rows: list[dict]) -> dict[str, Figure]:
    figure = Figure(figsize=(5.2, 3.6), layout="constrained")
    ax = figure.add_subplot()
    ax.loglog([row["nodes"] for row in rows], [row["condensation"] for row in rows], "o-", label="by fronts")
    other = [row for row in rows if "superlu" in row]
    ax.loglog([row["nodes"] for row in other], [row["superlu"] for row in other], "s--", label="SuperLU")
    ax.set(xlabel="nodes of the model", ylabel="condensation [s]")
    ax.legend()
    return {"solid_condensation": figure}
