"""Of all safe slips at one load factor the least one."""

import numpy as np

from shakedown.bounds.methods import methods_of
from shakedown.ground.evidence import Missing, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.contact_zone import Zone
from shakedown.programs.program import Program
from shakedown.programs.solver import solve

LARGEST = 300  # closed nodes: with more the program takes longer than all others
WITHIN = 0.5  # of what counts as safe: so far it may be outside, as safe slips at λ_max may have no inside


def least_slip(zone: Zone, load_factor: float, known: FloatArray, tolerances: Tolerances) -> FloatArray:
    """The safe slip whose largest slip of a node is least (k,); ``known``, a safe one, where none is found.

    Where no more than its open nodes hold a body safe slips may be far away, and many: the program of λ_max
    ends in any of them. This one minimises t, |v_i| ≤ t at every node, v in every row.
    """
    if len(zone.closed_nodes) > LARGEST:
        return known
    rows = zone.constraints
    G, right, slips = rows.coefficients, rows.g - load_factor * rows.d, rows.n
    terms = np.maximum(np.abs(right), np.abs(G) @ np.abs(known))
    right[rows.heads] += WITHIN * tolerances.feasibility * np.maximum.reduceat(terms, rows.heads)
    limited, v = np.column_stack([G, np.zeros(len(G))]), rows.slips(np.eye(slips)).T
    own, cones = methods_of(zone.problem).slip_limits(rows, v)
    program = Program(
        np.vstack([limited, own]),
        np.append(right, np.zeros(len(own))),
        cost=np.append(np.zeros(slips), 1.0),
        cones=cones,
        tolerances=tolerances,
    )
    found = sought(solve, program)
    if isinstance(found, Missing) or not found.optimal:
        return known
    slip = rows.slips(found.x[:-1])
    return slip if rows.relative_excess(slip, load_factor).max() <= tolerances.feasibility else known
