"""Maps of initial states: time per state, and whether interruptions leave a mark on the file.

Throughput is that of whole maps on one core, file written and limit cycles found included. For
the interruptions the command is killed again and again at random instants and resumed, with one
and with two processes in turn; on a local dask cluster a worker is killed. The file must have
the bytes of an undisturbed run.
"""

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import shakedown
from shakedown import plot
from shakedown.joint.constraints import constraints
from shakedown.report.text_table import table

TITLE = "Maps of initial states: throughput, and interrupted runs against an undisturbed one"
SEED = 0
LOADS = {"two-node": 0.7, "two-attractors": 1.0, "three-node": 2.6, "block-9": 4.7, "block-33": 5.1}
INTERRUPTED = "two-node"


def cases(short: bool) -> list[dict]:
    sizes = {
        "two-node": 10**6,
        "two-attractors": 10**5,
        "three-node": 10**5,
        "block-9": 10**4,
        "block-33": 300,
    }
    share = 100 if short else 1
    timed = [{"kind": "time", "joint": name, "states": max(size // share, 8)} for name, size in sizes.items()]
    states, kills = (30_000, 2) if short else (400_000, 20)
    return [
        *timed,
        {"kind": "killed", "states": states, "kills": kills},
        {"kind": "worker killed", "states": states, "kills": 1},
    ]


def measure(case: dict) -> dict:
    if case["kind"] == "time":
        return _timed(case["joint"], case["states"])
    with tempfile.TemporaryDirectory() as folder:
        whole, stopped = Path(folder) / "whole.npz", Path(folder) / "stopped.npz"
        _map(case["states"], whole)
        if case["kind"] == "killed":
            kills = _killed_again_and_again(case, stopped)
        else:
            kills = _with_a_worker_killed(case, stopped)
        left = sorted(entry.name for entry in Path(folder).iterdir())
        same = whole.read_bytes() == stopped.read_bytes()
        return {"killed": kills, "same_bytes": same, "nothing_left": left == ["stopped.npz", "whole.npz"]}


def _timed(name: str, states: int) -> dict:
    joint = shakedown.example(name)
    shakedown.initial_state_map(joint, LOADS[name], states=1)  # compiled code is loaded
    with tempfile.TemporaryDirectory() as folder:
        began, cpu = time.perf_counter(), time.process_time()
        found = shakedown.initial_state_map(joint, LOADS[name], states=states, path=Path(folder) / "map.npz")
        document = found.to_dict()
        seconds, cpu = time.perf_counter() - began, time.process_time() - cpu
    return {
        "load_factor": LOADS[name],
        "seconds": seconds,
        "cpu_s": cpu,
        "shakedown_fraction": document["shakedown_fraction"],
        "limit_cycles": len(found.limit_cycles),
        "undecided": found.undecided,
    }


def _map(states: int, path: Path, **words: object) -> None:
    joint = shakedown.example(INTERRUPTED)
    shakedown.initial_state_map(joint, LOADS[INTERRUPTED], states=states, seed=SEED, path=path, **words)


def _killed_again_and_again(case: dict, path: Path) -> int:
    """Kill the command at random instants, then let it end."""
    generator, kills = np.random.default_rng(SEED), 0
    words = ["map", INTERRUPTED, "--load-factor", str(LOADS[INTERRUPTED]), "--states", str(case["states"])]
    words += ["--seed", str(SEED), "-o", str(path), "--resume", "--json", "--workers"]
    while not path.exists():
        workers = str(1 + kills % 2)
        run = subprocess.Popen(
            [sys.executable, "-m", "shakedown", *words, workers], stdout=subprocess.DEVNULL
        )
        if kills < case["kills"]:
            while not path.with_name(path.name + ".parts").exists() and run.poll() is None:
                time.sleep(0.01)
            time.sleep(generator.uniform(0.5, 2.0))
            kills += run.poll() is None
            run.kill()
        run.wait()
    return kills


def _with_a_worker_killed(case: dict, path: Path) -> int:
    """One of two workers of a local dask cluster is killed after the second piece."""
    from distributed import LocalCluster

    killed: list[int] = []
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=50) as cluster:

        def kill_one(done: int, _: int) -> None:
            if done == 2 and not killed:
                killed.append(next(iter(cluster.workers.values())).process.pid)
                os.kill(killed[0], signal.SIGKILL)

        with cluster.get_client() as client:
            _map(case["states"], path, executor=client.get_executor(), progress=kill_one)
    return len(killed)


def tables(rows: list[dict]) -> str:
    timed = [
        [
            row["joint"],
            f"{row['load_factor']:g}",
            str(row["states"]),
            f"{row['seconds']:.1f}",
            f"{1e6 * row['cpu_s'] / row['states']:.0f}",
            f"{100 * row['shakedown_fraction']:.1f} %",
            str(row["limit_cycles"]),
            str(row["undecided"]),
        ]
        for row in rows
        if row["kind"] == "time"
    ]
    head = [
        "joint",
        "λ",
        "states",
        "time [s]",
        "CPU per state [µs]",
        "shake down",
        "limit cycles",
        "undecided",
    ]
    stopped = [
        [
            row["kind"],
            str(row["states"]),
            str(row["killed"]),
            str(row["same_bytes"]),
            str(row["nothing_left"]),
        ]
        for row in rows
        if row["kind"] != "time"
    ]
    return (
        table(head, timed) + "\n\n" + table(["", "states", "killed", "same bytes", "nothing left"], stopped)
    )


def figures(rows: list[dict]) -> dict[str, Figure]:
    figure = Figure(figsize=(12.0, 5.4), layout="constrained")
    for axes, name in zip(figure.subplots(1, 2), ("two-node", "two-attractors"), strict=True):
        assert isinstance(axes, Axes)
        found = shakedown.initial_state_map(
            shakedown.example(name), LOADS[name], states=10_000, sampler="grid"
        )
        plot.basin(found, ax=axes).set_title(f"{name}, λ = {LOADS[name]:g}")
        if name == "two-node":
            _draw_ball_and_apex(axes, found.problem, LOADS[name])
    return {"initial-states": figure}


def _draw_ball_and_apex(axes: Axes, problem: shakedown.Problem, load_factor: float) -> None:
    """The energy ball, dashed, and the line through the apex of node 1, at which both its rows are active."""
    angle, rows = np.linspace(0.0, 2.0 * np.pi, 181), constraints(problem)
    ball = shakedown.energy_ball(problem, load_factor).at(np.stack([np.cos(angle), np.sin(angle)], axis=1))
    own = rows.limits_of(1)
    apex = np.linalg.solve(rows.G[own], (rows.g - load_factor * rows.d)[own])
    axes.plot(*ball.T, "b--")
    axes.axvline(apex[0], color="r", ls="-.")
