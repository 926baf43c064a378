"""Joints that friction alone holds: how they are drawn, and their bounds by HiGHS and in fractions.

Random joints are made in fractions, with rigid slips that change exactly nothing, and then rounded: what
the toolkit sees resists these slips by round-off. Elastic bodies on friction alone come from their meshes.
"""

from dataclasses import dataclass, replace
from math import inf

import highspy
import numpy as np
from flint import fmpq, fmpq_mat

from benchmarks.bounds import highs_model
from benchmarks.drawn_joints import drawn_joint_in_space
from shakedown import Problem
from shakedown.fem import (
    ElasticBody,
    Force,
    Material,
    Pressure,
    Traction,
    block_mesh,
    brick_mesh,
    contact_problem,
)
from shakedown.joint.constraints import constraints
from shakedown.joint.rigid_slips import rigid_slips

AGREES = 1e-8  # relative, with HiGHS
LOAD_STEPS = 6


@dataclass(frozen=True)
class RationalJoint:
    """A joint in fractions: A Z = 0 and B Z = 0 without any error."""

    A: fmpq_mat
    B: fmpq_mat
    C: fmpq_mat
    Z: np.ndarray
    f: fmpq
    q: np.ndarray
    p: np.ndarray

    @property
    def rounded(self) -> Problem:
        """As the toolkit gets it."""
        A, B, C = (_floats(matrix) for matrix in (self.A, self.B, self.C))
        return Problem(A=A, B=B, C=C, f=float(self.f.p) / float(self.f.q), q_w=self.q, p_w=self.p)

    def rows(self) -> tuple[list[list[fmpq]], list[fmpq]]:
        """[G | d] and g of the 2n extremal rows, exactly."""
        n, f = self.A.nrows(), self.f
        q, p = ([[fmpq(int(x)) for x in row] for row in part] for part in (self.q, self.p))
        mean = [[sum((row[j] for row in part), fmpq(0)) / len(part) for j in range(n)] for part in (q, p)]
        matrix, right = [], []
        for j in range(n):
            for side in (1, -1):
                steps = [
                    side * (a[j] - mean[0][j]) - f * (b[j] - mean[1][j]) for a, b in zip(q, p, strict=True)
                ]
                matrix.append([side * self.A[j, i] - f * self.B[j, i] for i in range(n)] + [max(steps)])
                right.append(f * mean[1][j] - side * mean[0][j])
        return matrix, right


def rational_joint(seed: int, n: int, free: int) -> RationalJoint:
    """A random joint with so many rigid slips, in fractions."""
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
    return RationalJoint(A, B, _exact(kappa[n:, n:]), Z, f, q.astype(float), p.astype(float))


def _exact(array: np.ndarray) -> fmpq_mat:
    return fmpq_mat([[fmpq(int(x)) for x in row] for row in array])


def _floats(matrix: fmpq_mat) -> np.ndarray:
    return np.array([[float(int(x.p)) / float(int(x.q)) for x in row] for row in matrix.tolist()])


def floating_block(seed: int) -> Problem:
    """An elastic block that lies on a plane, pressed and sheared, of random shape, material and loads."""
    rng = np.random.default_rng([7, seed])
    steps = 12
    turn = 2 * np.pi * (np.arange(steps) / steps)
    body = ElasticBody(
        block_mesh(
            float(rng.uniform(1, 4)),
            float(rng.uniform(0.5, 2)),
            int(rng.integers(2, 9)),
            int(rng.integers(1, 5)),
        ),
        Material(float(rng.choice([1.0, 200e3])), float(rng.uniform(0.0, 0.4))),
        loads=[
            Pressure(
                "top",
                float(rng.uniform(5, 20)),
                history=1 + rng.uniform(0, 0.5) * np.sin(turn + rng.uniform(0, 6)),
            ),
            Traction("top", (1.0, 0.0), history=np.cos(turn)),
            Traction("right", (float(rng.uniform(0, 1)), float(rng.uniform(-1, 1))), history=np.sin(turn)),
        ],
    )
    made = contact_problem(body, "bottom", float(rng.uniform(0.1, 0.8)), steps=steps)
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

    def solve(self, towards: float, reversed_node: int = -1) -> tuple[float, np.ndarray, list[int]]:
        """Load factor (inf unbounded, NaN infeasible), slips, and the active rows; −λ ≤ 0 is the last row."""
        sign = np.where(self.node == reversed_node, -1.0, 1.0)
        bound = np.append(np.zeros(self.matrix.shape[1] - 1), -1.0)
        solver = highs_model(
            np.vstack([self.matrix * sign[:, None], bound]),
            np.append(self.right * sign, 0.0),
            -towards * bound,
        )
        solver.changeColBounds(len(bound) - 1, -highspy.kHighsInf, highspy.kHighsInf)  # the last row says it
        for side in ("primal", "dual"):
            solver.setOptionValue(f"{side}_feasibility_tolerance", 1e-10)
        solver.run()
        status = solver.getModelStatus().name
        if status != "kOptimal":
            return (inf if status == "kUnbounded" else np.nan), np.zeros(len(bound) - 1), []
        x = np.array(solver.getSolution().col_value) * self.load
        basis = solver.getBasis().row_status
        active = [i for i, state in enumerate(basis) if state != highspy.HighsBasisStatus.kBasic]
        return float(x[-1]) / self.unit, x[:-1], active


def by_highs(problem: Problem, pins: list[int]) -> dict:
    """λ_max and λ_1 with their slips; λ_1 is λ_max where no node collapses before."""
    programs = PinnedPrograms(problem, pins)
    most, _, top = programs.solve(-1.0)
    ends = [programs.solve(1.0, node) for node in range(problem.n)]
    values = [inf if np.isnan(end[0]) else end[0] for end in ends]
    first = int(np.argmin(values))
    sizes = [float(np.abs(end[1]).max(initial=0.0)) for end in ends]
    return {
        "upper": most,
        "lower": min(most, values[first]),
        "witness": sizes[first],
        "active": [top, *(end[2] for end in ends)],
    }


def true_bounds(
    joint: RationalJoint, pins: list[int], active: list[list[int]]
) -> tuple[float | None, float | None]:
    """Both bounds of the joint before it was rounded, where the bases of HiGHS are proved to be optimal."""
    matrix, right = joint.rows()
    kept = [j for j in range(joint.A.nrows()) if j not in pins]
    table_ = [[row[j] for j in kept] + [row[-1]] for row in matrix]
    table_.append([fmpq(0)] * len(kept) + [fmpq(-1)])
    limits = [*right, fmpq(0)]
    upper = _optimum(table_, limits, active[0], 1)
    if upper is None:
        return None, None
    least = upper
    for node, rows in enumerate(active[1:]):
        if not rows:  # no slip has both limits of this node reversed, at any load factor
            continue
        signs = [-1 if i // 2 == node else 1 for i in range(len(table_))]
        turned = [[sign * x for x in row] for sign, row in zip(signs, table_, strict=True)]
        value = _optimum(turned, [s * x for s, x in zip(signs, limits, strict=True)], rows, -1)
        if value is None:
            return _nearest(upper), None
        least = min(least, -value)
    return _nearest(upper), _nearest(least)


def _optimum(matrix: list, right: list, active: list[int], sign: int) -> fmpq | None:
    """The maximum of sign · λ where some rows meet, if fractions prove that it is one."""
    count = len(matrix[0])
    if len(active) != count:
        return None
    square = fmpq_mat([matrix[i] for i in active])
    try:
        x = square.solve(fmpq_mat([[right[i]] for i in active]))
        y = square.transpose().solve(fmpq_mat([[fmpq(sign * (j == count - 1))] for j in range(count)]))
    except ZeroDivisionError:
        return None
    if min(y.entries()) < 0:
        return None
    values = (fmpq_mat(matrix) * x).entries()
    if any(value > limit for value, limit in zip(values, right, strict=True)):
        return None
    return sign * x[count - 1, 0]


def _nearest(value: fmpq) -> float:
    return int(value.p) / int(value.q)


def floating_joint(kind: str, seed: int) -> Problem:
    """A joint that friction alone holds: of random matrices, or a body with the places of its nodes."""
    if kind == "matrices":
        return rational_joint(seed, n := 2 + seed % 11, 1 + (n > 3 and seed % 3 == 0)).rounded
    if kind == "matrices in space":
        return drawn_joint_in_space(seed, 29)  # of this number four nodes in a row of springs
    return floating_block(seed) if kind == "block" else floating_solid(seed)


def floating_solid(seed: int) -> Problem:
    """A brick that lies on a plane, pressed and pushed to and fro, of random shape, material and loads."""
    rng = np.random.default_rng([9, seed])
    turn = 2 * np.pi * np.arange(12) / 12
    mesh = brick_mesh(tuple(rng.uniform(1, 4, 3)), (int(rng.integers(1, 4)), int(rng.integers(1, 4)), 1))
    aside = (0.0, float(rng.uniform(1, 9)), float(rng.uniform(-2, 2)))
    body = ElasticBody(
        mesh,
        Material(float(rng.choice([1.0, 210e3])), float(rng.uniform(0.0, 0.4))),
        loads=[
            Pressure("top", float(rng.uniform(5, 20)), history=1 + 0.3 * np.sin(turn + rng.uniform(0, 6))),
            Force("top", (float(rng.uniform(1, 9)), 0.0, 0.0), history=np.cos(turn)),
            Force("right", aside, history=np.sin(turn)),
        ],
    )
    return contact_problem(body, "bottom", float(rng.uniform(0.1, 0.8)), steps=12)


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
