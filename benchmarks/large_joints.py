"""How long the bounds of joints of up to a thousand nodes take; other solvers are in ``bounds``."""

import time
from collections.abc import Callable
from dataclasses import replace
from statistics import median

import numpy as np
from threadpoolctl import threadpool_limits

import shakedown
from benchmarks.display import listed
from benchmarks.problems import chain, random_problem
from shakedown import Problem
from shakedown.fem import ElasticBody, Material, Pressure, Support, Traction, block_mesh, contact_problem

TITLE = "Large joints: processor time of the bounds"
BOUNDS = {
    "λ_max": shakedown.upper_bound,
    "λ_1": shakedown.lower_bound,
    "λ_E": shakedown.energy_bound,
}
REPEATED_UP_TO = 100  # nodes: more are timed once


def block(n: int) -> Problem:
    """An elastic block with n contact nodes, held at one end, pressed on a plane and drawn to and fro."""
    body = ElasticBody(
        block_mesh(2.0, 1.0, n - 1, max(8, n // 8)),
        Material(young=200e3, poisson=0.3),
        supports=[Support("left")],
        loads=[
            Pressure("top", 10.0, history=np.ones(24)),
            Traction("right", (1.0, 0.0), history=lambda t: np.cos(2 * np.pi * t)),
        ],
    )
    return contact_problem(body, "bottom", f=0.4, steps=24)


KINDS: dict[str, Callable[[int], Problem]] = {
    "random": lambda n: random_problem(n, seed=0),
    "chain": chain,
    "block": block,
}


def cases(short: bool) -> list[dict]:
    sizes = (2, 10, 30) if short else (2, 10, 30, 100, 250, 500, 1000)
    return [
        {"joint": kind, "n": n} for kind in KINDS for n in sizes if not (kind == "block" and n in (2, 1000))
    ]


def measure(case: dict) -> dict:
    problem, times = KINDS[case["joint"]](case["n"]), 5 if case["n"] <= REPEATED_UP_TO else 1
    with threadpool_limits(limits=1, user_api="blas"):
        return {name: _measured(problem, bound, times) for name, bound in BOUNDS.items()}


def _measured(problem: Problem, bound: Callable, times: int) -> dict:
    seconds = []
    for _ in range(times):
        fresh = replace(problem)  # knows no rows yet
        began = time.process_time()
        value = bound(fresh, certify=False).load_factor
        seconds.append(time.process_time() - began)
    return {"seconds": median(seconds), "value": value}


def tables(rows: list[dict]) -> str:
    return listed(
        rows, {"joint": "{joint}", "n": "{n}"} | {name: f"{{{name}[seconds]:.3g}} s" for name in BOUNDS}
    )
