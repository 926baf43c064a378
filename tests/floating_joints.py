"""Joints that friction alone holds: how they are drawn, and their bounds by HiGHS.

Random joints are made in fractions, with rigid slips that change exactly nothing, and then rounded: what
the toolkit sees resists these slips by round-off. Elastic bodies on friction alone come from their meshes.
"""

from dataclasses import replace
from math import inf

import highspy
import numpy as np
from flint import fmpq, fmpq_mat

from benchmarks.bounds import highs_model
from benchmarks.drawn_joints import drawn_joint_in_space
from shakedown import Problem, fem
from shakedown.joint.constraints import constraints
from shakedown.joint.rigid_slips import rigid_slips

AGREES = 1e-8  # relative, with HiGHS
LOAD_STEPS = 6


def rational_joint(seed: int, n: int, free: int) -> tuple[Problem, np.ndarray]:
    """A random joint made in fractions, then rounded; its rigid slips, which change exactly nothing before."""
    rng = np.random.default_rng([seed, n, free])
    Z = rng.integers(-3, 4, (n, free))
    Z[:, 0] = 1 if rng.random() < 0.5 else np.where(Z[:, 0] == 0, 2, Z[:, 0])
    while np.linalg.matrix_rank(Z) < free:
        Z[:, 1:] = rng.integers(-3, 4, (n, free - 1))
    exact_Z = _exact(Z)
    project = (
        _exact(np.eye(n, dtype=int)) - exact_Z * (exact_Z.transpose() * exact_Z).inv() * exact_Z.transpose()
    )
    root = rng.integers(-5, 6, (2 * n, 2 * n + 2))
    kappa = root @ root.T
    A = project * _exact(kappa[:n, :n]) * project
    B = _exact(kappa[n:, :n]) * project * fmpq(1, int(rng.choice([1, 2, 4, 8])))
    own, coupled = np.diag(_floats(A)), np.abs(np.diag(_floats(B)))
    critical = float(np.min(own / np.maximum(coupled, 1e-9)))
    f = fmpq(max(int(64 * min(0.8, rng.uniform(0.2, 0.8) * critical)), 1), 64)
    q, p = rng.integers(-500, 501, (LOAD_STEPS, n)), 4000 + rng.integers(-400, 401, (LOAD_STEPS, n))
    blocks = {"A": _floats(A), "B": _floats(B), "C": kappa[n:, n:].astype(float)}
    return Problem(**blocks, f=float(f.p) / float(f.q), q_w=q.astype(float), p_w=p.astype(float)), Z


def _exact(array: np.ndarray) -> fmpq_mat:
    return fmpq_mat([[fmpq(int(x)) for x in row] for row in array])


def _floats(matrix: fmpq_mat) -> np.ndarray:
    return np.array([[float(int(x.p)) / float(int(x.q)) for x in row] for row in matrix.tolist()])


def floating_block(seed: int) -> Problem:
    """An elastic block that lies on a plane, pressed and sheared, of random shape, material and loads."""
    rng = np.random.default_rng([7, seed])
    steps = 12
    turn = 2 * np.pi * (np.arange(steps) / steps)
    sides, counts = (rng.uniform(1, 4), rng.uniform(0.5, 2)), (rng.integers(2, 9), rng.integers(1, 5))
    mesh = fem.block_mesh(*map(float, sides), *map(int, counts))
    material = fem.Material(float(rng.choice([1.0, 200e3])), float(rng.uniform(0.0, 0.4)))
    pressure, history = float(rng.uniform(5, 20)), 1 + rng.uniform(0, 0.5) * np.sin(turn + rng.uniform(0, 6))
    loads = [
        fem.Pressure("top", pressure, history=history),
        fem.Traction("top", (1.0, 0.0), history=np.cos(turn)),
        fem.Traction("right", (float(rng.uniform(0, 1)), float(rng.uniform(-1, 1))), history=np.sin(turn)),
    ]
    body = fem.ElasticBody(mesh, material, loads=loads)
    made = fem.contact_problem(body, "bottom", float(rng.uniform(0.1, 0.8)), steps=steps)
    return replace(made, load_reactions=None, load_history=None, load_compliance=None)  # copies are of rows


def other_pins(Z: np.ndarray, pinned: tuple[int, ...]) -> list[int]:
    """Nodes that hold the rigid slips as well, of those that are not pinned as far as there are any."""
    order = [*(i for i in reversed(range(len(Z))) if i not in pinned), *pinned]
    chosen: list[int] = []
    for node in order:
        if np.linalg.matrix_rank(Z[[*chosen, node]]) > len(chosen):
            chosen.append(node)
    return chosen


class PinnedPrograms:
    """The programs of both bounds by HiGHS, as it comes, with some slips left out, in units of the rows."""

    def __init__(self, problem: Problem, pins: list[int]) -> None:
        rows = constraints(problem)
        self.node, kept = rows.node, [i for i in range(rows.n) if i not in pins]
        matrix = np.column_stack([rows.G[:, kept], rows.d])
        size = np.abs(matrix[:, :-1]).max(axis=1)
        matrix, right = matrix / size[:, None], rows.g / size
        self.unit, self.load = float(np.abs(matrix[:, -1]).max()) or 1.0, float(np.abs(right).max()) or 1.0
        matrix[:, -1] /= self.unit
        self.matrix, self.right = matrix, right / self.load

    def solve(self, towards: float, reversed_node: int = -1) -> tuple[float, np.ndarray]:
        """Load factor (inf unbounded, NaN infeasible) and slips; −λ ≤ 0 is the last row."""
        sign = np.where(self.node == reversed_node, -1.0, 1.0)
        bound = np.append(np.zeros(self.matrix.shape[1] - 1), -1.0)
        rows = np.vstack([self.matrix * sign[:, None], bound])
        solver = highs_model(rows, np.append(self.right * sign, 0.0), -towards * bound)
        solver.changeColBounds(len(bound) - 1, -highspy.kHighsInf, highspy.kHighsInf)  # the last row says it
        for side in ("primal", "dual"):
            solver.setOptionValue(f"{side}_feasibility_tolerance", 1e-10)
        solver.run()
        status = solver.getModelStatus().name
        if status != "kOptimal":
            return (inf if status == "kUnbounded" else np.nan), np.zeros(len(bound) - 1)
        x = np.array(solver.getSolution().col_value) * self.load
        return float(x[-1]) / self.unit, x[:-1]


def by_highs(problem: Problem, pins: list[int]) -> dict:
    """λ_max and λ_1 with their slips; λ_1 is λ_max where no node collapses before."""
    programs = PinnedPrograms(problem, pins)
    most, _ = programs.solve(-1.0)
    ends = [programs.solve(1.0, node) for node in range(problem.n)]
    values = [inf if np.isnan(end[0]) else end[0] for end in ends]
    first = int(np.argmin(values))
    size = float(np.abs(ends[first][1]).max(initial=0.0))
    return {"upper": most, "lower": min(most, values[first]), "witness": size}


def floating_joint(kind: str, seed: int) -> Problem:
    """A joint that friction alone holds: of random matrices, or a body with the places of its nodes."""
    if kind == "matrices":
        return rational_joint(seed, n := 2 + seed % 11, 1 + (n > 3 and seed % 3 == 0))[0]
    if kind == "matrices in space":
        return drawn_joint_in_space(seed, 29)  # of this number four nodes in a row of springs
    return floating_block(seed) if kind == "block" else floating_solid(seed)


def floating_solid(seed: int) -> Problem:
    """A brick that lies on a plane, pressed and pushed to and fro, of random shape, material and loads."""
    rng = np.random.default_rng([9, seed])
    turn = 2 * np.pi * np.arange(12) / 12
    mesh = fem.brick_mesh(tuple(rng.uniform(1, 4, 3)), (int(rng.integers(1, 4)), int(rng.integers(1, 4)), 1))
    aside = (0.0, float(rng.uniform(1, 9)), float(rng.uniform(-2, 2)))
    material = fem.Material(float(rng.choice([1.0, 210e3])), float(rng.uniform(0.0, 0.4)))
    loads = [
        fem.Pressure("top", float(rng.uniform(5, 20)), history=1 + 0.3 * np.sin(turn + rng.uniform(0, 6))),
        fem.Force("top", (float(rng.uniform(1, 9)), 0.0, 0.0), history=np.cos(turn)),
        fem.Force("right", aside, history=np.sin(turn)),
    ]
    body = fem.ElasticBody(mesh, material, loads=loads)
    return fem.contact_problem(body, "bottom", float(rng.uniform(0.1, 0.8)), steps=12)


def printed(matrix: np.ndarray, digits: int) -> np.ndarray:
    """A matrix as it is read again where so many digits were printed."""
    return np.array([[float(f"{x:.{digits - 1}e}") for x in row] for row in matrix])


def rounded(problem: Problem, digits: int) -> Problem:
    """The joint with a stiffness of so many digits."""
    C = None if problem.C is None else printed(problem.C, digits)
    return replace(problem, A=printed(problem.A, digits), B=printed(problem.B, digits), C=C)


def without_places(problem: Problem) -> Problem:
    """The joint of matrices alone."""
    return replace(problem, coordinates=None, normal=None, tangent=None, tangents=None)


def stiffened(problem: Problem, share: float) -> Problem:
    """The joint with a stiffness against its rigid slips of a share of the largest."""
    Z = np.linalg.qr(rigid_slips(problem).motions)[0]
    return replace(problem, A=problem.A + share * np.linalg.eigvalsh(problem.A)[-1] * Z @ Z.T)
