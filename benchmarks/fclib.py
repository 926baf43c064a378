"""Frictional contact problems of the FCLib collection, ``python -m benchmarks fclib --folder FOLDER``.

Read are its HDF5 files (Acary, Brémond, Koziara and Pérignon, FCLIB: a collection of discrete 3D
frictional contact problems, 2014; they need the extra ``hdf5``) and Siconos' text files. Local problems
are u = W r + q, contact by contact, normal component first; of a global one, M v = H r + f and
u = Hᵀ v + w, the unknowns v are eliminated. Where Siconos is installed its solvers get the same problems.
The merit is FCLib's: the natural map of the cone, |r − P(r − (u + μ |u_T| e_N))| over |q|.
"""

import argparse
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse

from benchmarks import siconos_peer
from benchmarks.friction_problems import solve_friction_problem
from benchmarks.timing import in_turn
from shakedown.ground.constants import FloatArray
from shakedown.report.facts import table

ROWS, COLUMNS = -2, -1  # what nz says of a compressed matrix; anything else counts triplets
SOLVERS = ("nsgs", "newton", "admm")
MOST = {"nsgs": 100_000, "newton": 1000, "admm": 100_000}  # iterations
TOLERANCE = 1e-10
LONGEST = 120.0  # seconds for a solver and a problem
NO_HDF5 = "left out: HDF5 files need the extra 'hdf5' (pip install 'shakedown-bounds[hdf5]')"


class FrictionProblem(NamedTuple):
    """u = W r + q with friction coefficients mu, normal components first."""

    W: FloatArray
    q: FloatArray
    mu: FloatArray


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks fclib", description=TITLE)
    parser.add_argument("--folder", type=Path, required=True, help="where the problems are, *.hdf5 and *.dat")
    folder = parser.parse_args(arguments).folder
    paths = sorted(path for path in folder.rglob("*") if path.suffix in READERS)
    if not paths:
        parser.error(f"no problem (*.hdf5, *.dat) in {folder}")
    rows, lines = [], []
    for path in paths:
        if path.suffix == ".hdf5" and find_spec("h5py") is None:
            lines.append(f"{path.name}: {NO_HDF5}")
            continue
        rows += solved(path.name, READERS[path.suffix](path))
    if not siconos_peer.is_here():
        lines.append(siconos_peer.ABSENT)
    headers = ["problem", "contacts", "rank", "solver", "ms", "merit", "solved"]
    print("\n".join([TITLE, "", table(headers, rows, longest=10_000), *lines]))
    return 0


def solved(name: str, problem: FrictionProblem) -> Iterator[list[str]]:
    """A line of the table for every solver."""
    start = [name, str(len(problem.mu)), str(np.linalg.matrix_rank(problem.W, hermitian=True))]
    ((seconds, found),) = in_turn(lambda: solve_friction_problem(*problem))
    yield [*start, "proximal", *_line(problem, seconds, found.r, found.status.value == "solved")]
    for solver in SOLVERS if siconos_peer.is_here() else ():
        done = _siconos(problem, solver)
        yield [*start, solver, *(["", "", "no"] if done is None else _line(problem, *done))]


def _line(problem: FrictionProblem, seconds: float, r: FloatArray, done: bool) -> list[str]:
    return [f"{1e3 * seconds:.1f}", f"{merit(problem, r):.0e}", "yes" if done else "no"]


def merit(problem: FrictionProblem, r: FloatArray) -> float:
    """How far reactions are from solving the problem: its natural map, relative to |q|."""
    W, q, mu = problem
    reaction, u = r.reshape(-1, 3), (W @ r + q).reshape(-1, 3).copy()
    u[:, 0] += mu * np.linalg.norm(u[:, 1:], axis=1)
    weight = np.diag(W).reshape(-1, 3).mean(axis=1, keepdims=True)  # forces and velocities do not add
    aim = reaction - u / weight
    apart = weight * (reaction - _on_cone(aim, mu))
    return float(np.linalg.norm(apart) / np.linalg.norm(q))


def _on_cone(points: FloatArray, mu: FloatArray) -> FloatArray:
    """The nearest points with |r_T| ≤ μ r_N."""
    normal, size = points[:, 0], np.linalg.norm(points[:, 1:], axis=1)
    inside, below = size <= mu * normal, mu * size <= -normal
    height = np.where(inside, normal, (normal + mu * size) / (1 + mu**2))
    share = np.where(inside, 1.0, mu * height / np.where(size > 0, size, 1.0))
    nearest = np.column_stack([height, points[:, 1:] * share[:, None]])
    return np.where(below[:, None], 0.0, nearest)


def _siconos(problem: FrictionProblem, solver: str) -> tuple[float, FloatArray, bool] | None:
    """Processor time [s], reactions and whether the solver was content; None where it broke off."""
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "in.npz", Path(folder) / "out.npz"
        W, q, mu = problem
        np.savez(source, M=W, free=q[None], f=mu, solver=solver, tolerance=TOLERANCE, iterations=MOST[solver])
        script = Path(__file__).with_name("siconos_space_steps.py")
        command = [siconos_peer.SYSTEM_PYTHON, str(script), str(source), str(target)]
        try:
            subprocess.run(command, check=True, capture_output=True, timeout=LONGEST)
        except (subprocess.TimeoutExpired, subprocess.CalledProcessError):
            return None
        with np.load(target) as out:
            return float(out["seconds"][0]), out["r"][0], not int(out["failures"])


def read_hdf5(path: Path) -> FrictionProblem:
    """A local problem, or a global one with its unknowns eliminated."""
    import h5py  # an extra

    with h5py.File(path) as file:
        if "fclib_local" in file:
            local = file["fclib_local"]
            _in_space(path, int(local["spacedim"][0]))
            return FrictionProblem(
                _matrix(local["W"]).toarray(), local["vectors/q"][()], local["vectors/mu"][()]
            )
        whole = file["fclib_global"]
        _in_space(path, int(whole["spacedim"][0]))
        M, H = _matrix(whole["M"]).toarray(), _matrix(whole["H"]).toarray()
        f, w, mu = (whole[f"vectors/{key}"][()] for key in ("f", "w", "mu"))
    free = np.linalg.solve(M, np.column_stack([H, f]))
    W = H.T @ free[:, :-1]
    return FrictionProblem(0.5 * (W + W.T), H.T @ free[:, -1] + w, mu)


def _matrix(group: Any) -> Any:
    """A sparse matrix: compressed rows or columns, or triplets."""
    shape, count = (int(group["m"][0]), int(group["n"][0])), int(group["nz"][0])
    i, p, x = (group[key][()] for key in ("i", "p", "x"))
    if count == ROWS:
        return sparse.csr_array((x, i, p), shape=shape)
    if count == COLUMNS:
        return sparse.csc_array((x, i, p), shape=shape)
    return sparse.coo_array((x[:count], (i[:count], p[:count])), shape=shape)


def read_text(path: Path) -> FrictionProblem:
    """Siconos' text: dimension, contacts, W by sparse blocks (storage 1) or dense (0), q, mu."""
    words = iter(path.read_text().split())

    def whole(count: int) -> list[int]:
        return [int(next(words)) for _ in range(count)]

    def numbers(count: int) -> FloatArray:
        return np.array([float(next(words)) for _ in range(count)])

    dimension, contacts, storage, rows, columns = whole(5)
    _in_space(path, dimension)
    W = numbers(rows * columns).reshape(columns, rows).T if storage == 0 else _blocks(rows, whole, numbers)
    return FrictionProblem(0.5 * (W + W.T), numbers(rows), numbers(contacts))


def _blocks(size: int, whole: Any, numbers: Any) -> FloatArray:
    """Blocks of a matrix, row by row of blocks; each has its number and its entries, column by column."""
    _, down, across = whole(3)
    tops, lefts = [0, *whole(down)], [0, *whole(across)]
    filled = whole(2)
    first, column = whole(filled[0]), whole(filled[1])
    W = np.zeros((size, size))
    for row in range(len(first) - 1):
        for k in range(first[row], first[row + 1]):
            whole(1)
            place = slice(tops[row], tops[row + 1]), slice(lefts[column[k]], lefts[column[k] + 1])
            tall, wide = tops[row + 1] - tops[row], lefts[column[k] + 1] - lefts[column[k]]
            W[place] = numbers(tall * wide).reshape(wide, tall).T
    return W


def _in_space(path: Path, dimension: int) -> None:
    if dimension != 3:
        sys.exit(f"{path}: expected a problem in three dimensions, found {dimension}")


TITLE = "Frictional contact problems of a folder: proximal steps, and Siconos"
READERS = {".hdf5": read_hdf5, ".dat": read_text}
