"""Problems that several studies share: joints of any size, changed units, refined loops."""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import ArrayLike

from shakedown import Problem, save_problem
from shakedown.ground.constants import FloatArray
from shakedown.joint.units import without_loads


def joint(
    seed: int = 0,
    n: int = 4,
    coupling: float = 0.3,
    m: int = 6,
    units: tuple[ArrayLike, ArrayLike] = (1.0, 1.0),
) -> Problem:
    """A random positive definite joint of moderate coupling, pressed together at the mean load.

    ``units`` are the sizes of a force and of a length, of all nodes or of each.
    """
    rng = np.random.default_rng(seed)
    root = coupling * rng.normal(size=(2 * n, 2 * n))
    kappa = root @ root.T / np.sqrt(2 * n) + np.eye(2 * n)
    problem = Problem(
        A=kappa[:n, :n],
        B=kappa[n:, :n],
        C=kappa[n:, n:],
        f=rng.uniform(0.1, 0.5, n),
        q_w=rng.normal(size=(m, n)),
        p_w=4.0 + rng.normal(size=(m, n)),
    )
    return in_units(problem, *units)


def in_units(problem: Problem, force: ArrayLike, length: ArrayLike) -> Problem:
    """The same joint in other units; units of each node need force · length to be the same at all."""
    d = problem.directions
    forces, lengths = (np.broadcast_to(np.asarray(size, dtype=float), problem.n) for size in (force, length))
    tangential = np.repeat(forces, d)
    stiffness = tangential[:, None] / np.repeat(lengths, d)
    stiffness = 0.5 * (stiffness + stiffness.T)  # what round-off leaves unsymmetric
    sizes = {"A": stiffness, "B": stiffness[::d], "C": stiffness[::d, ::d]}
    sizes["initial_slip"] = np.repeat(lengths, d)
    sizes |= dict.fromkeys(("q_w", "q_mean", "q_transient"), tangential)
    sizes |= dict.fromkeys(("p_w", "p_mean", "p_transient"), forces)
    given = {key: getattr(problem, key) for key in sizes}
    changed = {key: value * sizes[key] for key, value in given.items() if value is not None}
    return replace(without_loads(problem), **changed)


def file_of(problem: Problem) -> bytes:
    """What its problem file holds."""
    with TemporaryDirectory() as folder:
        save_problem(path := Path(folder) / "joint.npz", problem)
        return path.read_bytes()


def chain(n: int, f: float = 0.2, m: int = 50, seed: int = 0) -> Problem:
    """A strip of n nodes: influence that decays with distance, antisymmetric coupling, a travelling load."""
    rng = np.random.default_rng(seed)
    x, node, t = np.linspace(0, 1, n), np.arange(n), 2 * np.pi * np.arange(m) / m
    distance = np.abs(node[:, None] - node)
    root = 2.0 * np.eye(n) - 0.15 * np.exp(-distance / 3.0)
    side = np.sign(node - node[:, None]) * (1 + 0.1 * rng.normal(size=(n, n)))
    q = np.cos(t)[:, None] * (0.5 + 0.5 * np.sin(3 * x)) + 0.2 * np.sin(2 * t)[:, None] * x
    p = 6 + np.sin(t + 0.7)[:, None] * (1 - x) + 0.5 * rng.random(n)
    return Problem(A=root @ root, B=0.3 * side * np.exp(-distance / 4.0), f=f, q_w=q, p_w=p)


def random_problem(n: int, seed: int, *, m: int = 24, coupling: float = 0.5, f: float = 0.4) -> Problem:
    """A system with κ positive definite whose friction stays below the thresholds of uniqueness.

    The mean pressure is large enough for every node to stay in contact near the
    bounds; the loop is smooth and its tangential part has a phase per node.
    """
    generator = np.random.default_rng(seed)
    half = generator.normal(size=(n, n)) / np.sqrt(n)
    A = half @ half.T + 2.0 * np.eye(n)
    # Rows of B far below those of A keep every A ± f B diagonally safe.
    B = coupling * generator.uniform(-1.0, 1.0, (n, n)) / np.sqrt(n)
    C = 4.0 * np.eye(n) + half.T @ half
    t = np.arange(m)[:, None] / m
    phase, size = generator.uniform(0, 1, n), generator.uniform(0.5, 1.5, n)
    q_w = generator.normal(size=n) * 0.2 + size * np.cos(2 * np.pi * (t - phase))
    p_w = 5.0 + 0.5 * np.sin(2 * np.pi * (t + generator.uniform(0, 1, n)))
    return Problem(A=A, B=B, C=C, f=f, q_w=q_w, p_w=p_w, name=f"random, n = {n}, seed {seed}")


def refined(problem: Problem, parts: int) -> Problem:
    """The same piecewise linear loop with every load step split into ``parts``."""
    return replace(
        without_loads(problem),
        q_w=_split(problem.q_w, parts),
        p_w=_split(problem.p_w, parts),
        q_mean=problem.q_w.mean(axis=0) if problem.q_mean is None else problem.q_mean,
        p_mean=problem.p_w.mean(axis=0) if problem.p_mean is None else problem.p_mean,
    )


def _split(samples: FloatArray, parts: int) -> FloatArray:
    following = np.roll(samples, -1, axis=0)
    share = np.arange(parts)[None, :, None] / parts
    split = samples[:, None] * (1 - share) + following[:, None] * share
    return split.reshape(len(samples) * parts, samples.shape[1])
