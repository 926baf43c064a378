"""Of all safe slips at one load factor the least one."""

import numpy as np

from shakedown.ground.evidence import Missing, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.constraints import CONE, Constraints
from shakedown.programs.program import Program
from shakedown.programs.solver import solve

LARGEST = 300  # closed nodes: with more the program takes longer than all others
WITHIN = 0.5  # of what counts as safe: so far it may be outside, as safe slips at λ_max may have no inside


def least_slip(
    rows: Constraints, directions: int, load_factor: float, known: FloatArray, tolerances: Tolerances
) -> FloatArray:
    """The safe slip whose largest slip of a node is least (k,); ``known``, a safe one, where none is found.

    Where no more than its open nodes hold a body safe slips may be far away, and many: the program of λ_max
    ends in any of them. This one minimises t, |v_i| ≤ t at every node, v in every row.
    """
    G, room, slips = rows.coefficients, rows.g - load_factor * rows.d, rows.n
    terms = np.maximum(np.abs(room), np.abs(G) @ np.abs(known))
    room[rows.heads] += WITHIN * tolerances.feasibility * np.maximum.reduceat(terms, rows.heads)
    limited, v = np.column_stack([G, np.zeros(len(G))]), rows.slips(np.eye(slips)).T
    if slips > LARGEST * directions:
        return known
    if directions == 1:
        own = np.column_stack([np.vstack([v, -v]), -np.ones(2 * slips)])
        cones: tuple[int, ...] = ()
    else:
        own = np.zeros((slips // 2, CONE, slips + 1))
        own[:, 0, -1] = -1.0
        own[:, 1:, :-1] = -v.reshape(-1, 2, slips)
        own, cones = own.reshape(-1, slips + 1), (*rows.cones.tolist(), *[CONE] * (slips // 2))
    program = Program(
        np.vstack([limited, own]),
        np.append(room, np.zeros(len(own))),
        cost=np.append(np.zeros(slips), 1.0),
        cones=cones,
        tolerances=tolerances,
    )
    found = sought(solve, program)
    if isinstance(found, Missing) or not found.optimal:
        return known
    slip = rows.slips(found.x[:-1])
    return slip if rows.relative_excess(slip, load_factor).max() <= tolerances.feasibility else known
