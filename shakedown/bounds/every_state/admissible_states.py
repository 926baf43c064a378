"""The states that a closed joint can be in while its load runs over the loop, as linear programs."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.joint.constraints import constraints, rows_of, step_loads
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem
from shakedown.programs.program import INF, Program
from shakedown.programs.scaling import power_of_two
from shakedown.programs.simplex import Simplex
from shakedown.programs.solver import solve


@dataclass(frozen=True)
class AdmissibleStates:
    """Slips within the limits of some load of the loop: G v + S α ≤ g, α ≥ 0, Σ α = λ.

    The load is r⁰ + Σ α_k r¹_k: anywhere in the convex hull of the load steps at λ. Where the
    mean load is in that hull, as their sample mean is, these sets grow with λ.

    Attributes
    ----------
    G : (r, n)
        Coefficients of the slip [force/length], row 2i the backward and row 2i + 1 the
        forward limit of node i; zero for pinned nodes, whose slips are zero. The r − 2n pressures of nodes
        without friction follow.
    g : (r,)
        Distance of the mean load from the limits [force].
    loads : (r, k)
        S: what each different load step of the loop takes from g at load factor 1 [force].
    """

    G: FloatArray
    g: FloatArray
    loads: FloatArray

    @property
    def n(self) -> int:
        """Number of contact nodes."""
        return self.G.shape[1]

    @property
    def units(self) -> tuple[float, float]:
        """A force and a length, powers of two, that take the units out of the programs without round-off."""
        force = power_of_two(max(np.abs(self.g).max(), np.abs(self.loads).max()))
        return force, force / power_of_two(np.abs(self.G).max())


class Extreme(NamedTuple):
    """The least value of a linear function of the slip, and the multipliers of the limits that prove it.

    The value is inf where there is no state, −inf where it is unbounded; the multipliers are NaN there.
    """

    value: float
    multipliers: FloatArray


class Swing(NamedTuple):
    """Least −direction · v in forward slip and least direction · v in backward slip of a node."""

    forward: Extreme
    backward: Extreme

    def apart(self, margin: float) -> bool:
        """Whether direction · v in forward slip is smaller than in backward slip, by a relative margin."""
        values = self.forward.value, self.backward.value
        if np.inf in values:  # one of the two slips cannot happen
            return True
        return sum(values) > margin * max(abs(x) for x in values)


def admissible_states(problem: Problem) -> AdmissibleStates:
    """The rows of every load step; load steps with identical rows are taken once.

    Examples
    --------
    >>> import shakedown
    >>> states = admissible_states(shakedown.example("two-node"))
    >>> states.G.shape, states.loads.shape
    ((4, 2), (4, 50))
    """
    rows = constraints(problem)
    loads = np.ascontiguousarray(step_loads(problem)[different_steps(problem)].T)
    return AdmissibleStates(rows.coefficients, rows.g, loads)


def different_steps(problem: Problem) -> NDArray[np.intp]:
    """Indices of load steps that differ from each other."""
    loop = loading(problem)
    return np.unique(np.hstack([loop.q1, loop.p1]), axis=0, return_index=True)[1]


class StateProgram:
    """Extremes of linear functions of the slip over the admissible states at load factors in an interval.

    The columns are (v, α, λ). One row at a time can be made active; each solve starts from the last basis.

    Parameters
    ----------
    states
        What is admissible.
    """

    def __init__(self, states: AdmissibleStates) -> None:
        n, k = states.n, states.loads.shape[1]
        self.states, self._n, self._k = states, n, k
        self._force, self._length = states.units
        self._g = states.g / self._force
        half = np.column_stack([states.G * self._length, states.loads, np.zeros_like(self._g)]) / self._force
        share = np.concatenate([np.zeros(n), np.ones(k), [-1.0]])
        self._program = Simplex(
            Program(
                np.vstack([half, share]),
                np.append(self._g, 0.0),
                cost=np.append(np.zeros(len(share) - 1), 1.0),
                left=np.append(np.full(len(half), -INF), 0.0),
                lower=np.concatenate([np.full(n, -INF), np.zeros(k + 1)]),
            )
        )
        self._active = -1

    def set_load_factors(self, low: float, high: float) -> None:
        """Let the load factor run over [low, high]."""
        self._program.set_columns(np.array([self._n + self._k]), np.array([low]), np.array([high]))

    def activate(self, row: int) -> None:
        """Make one row active, and the one before it an inequality again; −1 for none."""
        g = self._g
        if self._active >= 0:
            self._program.set_rows(np.array([self._active]), np.array([-INF]), g[[self._active]])
        if row >= 0:
            self._program.set_rows(np.array([row]), g[[row]], g[[row]])
        self._active = row

    def swing(self, node: int, direction: FloatArray) -> Swing:
        """The range of direction · v in forward and in backward slip of a node."""
        backward_row, forward_row = rows_of(node).tolist()
        self.activate(forward_row)
        forward = self.least(-direction)
        self.activate(backward_row)
        return Swing(forward, self.least(direction))

    def least(self, direction: FloatArray) -> Extreme:
        """The least value of direction · v."""
        cost = direction / power_of_two(np.abs(direction).max())
        self._program.set_cost(np.append(cost, np.zeros(self._k + 1)))
        end = self._program.solve()
        if not end.optimal:
            return Extreme(np.inf if end.status == "infeasible" else -np.inf, end.multipliers[:-1])
        slip, scale = end.x[: self._n] * self._length, power_of_two(np.abs(direction).max())
        return Extreme(float(direction @ slip), end.multipliers[:-1] * scale * self._length / self._force)


def first_overlap(
    states: AdmissibleStates, node: int, direction: FloatArray
) -> tuple[float, FloatArray, FloatArray]:
    """The least load factor at which a node can slip forward at no smaller direction · v than backward.

    One program in two states, of which each has its own load: minimise λ ≥ 0 subject to both
    being admissible, forward row active at the first, backward row at the second, and
    direction · (v' − v'') ≥ 0. Returns (λ, v', v''); λ is inf where there is no such pair.
    """
    n, (r, k) = states.n, states.loads.shape
    force, length = states.units
    half, g = np.column_stack([states.G * length, states.loads]) / force, states.g / force
    share, zero = np.append(np.zeros(n), np.ones(k)), np.zeros((r, n + k))
    swing = np.append(direction / power_of_two(np.abs(direction).max()), np.zeros(k))
    matrix = np.block(
        [
            [half, zero, np.zeros((r, 1))],
            [zero, half, np.zeros((r, 1))],
            [share, 0 * share, -np.ones(1)],
            [0 * share, share, -np.ones(1)],
            [swing, -swing, np.zeros(1)],
        ]
    )
    left = np.append(np.full(2 * r + 2, -INF), 0.0)
    left[2 * node + 1], left[r + 2 * node] = g[2 * node + 1], g[2 * node]
    left[2 * r : 2 * r + 2] = 0.0  # Σ α = λ
    least = np.append(np.full(n, -INF), np.zeros(k))
    program = Program(
        matrix,
        np.concatenate([g, g, [0.0, 0.0, INF]]),
        cost=np.append(np.zeros(2 * (n + k)), 1.0),
        left=left,
        lower=np.concatenate([least, least, [0.0]]),
    )
    found = solve(program)
    if not found.optimal:
        return np.inf, np.full(n, np.nan), np.full(n, np.nan)
    return max(float(found.x[-1]), 0.0), found.x[:n] * length, found.x[n + k : 2 * n + k] * length
