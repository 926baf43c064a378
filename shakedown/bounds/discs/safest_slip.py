"""The slip with most slack at one load factor; whether one is safe under the mean load."""

from dataclasses import dataclass, replace

import numpy as np

from shakedown.bounds.discs.disc_rows import DiscRows, disc_rows
from shakedown.bounds.discs.frictionless import without_frictionless
from shakedown.bounds.discs.scaled_discs import Carrying, scaled_discs
from shakedown.bounds.discs.scaled_solution import solve_scaled
from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.problem import Problem
from shakedown.programs.solver import widest


@dataclass(frozen=True, eq=False)
class Safest:
    """The slip with most slack at one load factor.

    Attributes
    ----------
    x : (k,)
        It, at the unknowns of programs [length].
    margin
        The radius of a ball of slips around it, all of them safe [length]; negative where none is, −inf
        where a limit that no slip changes is broken.
    cap
        The largest margin that was looked for.
    carrying
        The discs and half-spaces that limit it.
    reduced_accuracy
        Whether the interior points reached less than their tolerances.
    """

    x: FloatArray
    margin: float
    cap: float
    carrying: Carrying
    reduced_accuracy: bool


def safest(rows: DiscRows, load_factor: float, tolerances: Tolerances = DEFAULT) -> Safest:
    """max t: f p − |q| ≥ t (f |B_i| + |A_i|) at every node and load step, half-spaces likewise.

    A change δ of the slips changes f p − |q| by (f|B_i| + |A_i|) |δ| at most: slips up to t away are safe.
    Without discs this is a linear program; else the unknown is t + cap ≥ 0.
    """
    H = rows.half_spaces
    slopes = np.linalg.norm(rows.stiffness[:, 0], axis=1) + np.linalg.norm(
        rows.stiffness[:, 1:], axis=(1, 2), ord=2
    )
    other_slopes = np.linalg.norm(H.G if rows.in_plane else H.coefficients, axis=1)
    c, g = rows.c + load_factor * rows.e, H.g - load_factor * H.d
    reach = np.abs(rows.c).max(axis=1) + np.abs(load_factor * rows.e).max(axis=1)
    other_reach = np.abs(H.g) + np.abs(load_factor * H.d)
    steep, also = slopes[rows.node] > 0, other_slopes > 0
    distances = np.append(reach[steep] / slopes[rows.node][steep], other_reach[also] / other_slopes[also])
    cap = 2.0 * float(distances.max(initial=0.0)) or 1.0  # twice the largest bounded margin
    if rows.in_plane:
        found = widest(H.coefficients, other_slopes, g, cap=cap, tolerances=tolerances)
        carrying = rows.node, np.flatnonzero(found.multipliers)
        return Safest(found.x, found.margin, cap, carrying, found.reduced_accuracy)
    down = np.zeros_like(c)
    down[:, 0] = -slopes[rows.node]
    held = replace(H, g=g + cap * other_slopes, d=other_slopes)
    moved = rows.under(c=c - cap * down, e=down, half_spaces=held)
    end = solve_scaled(scaled_discs(moved, -1.0, 2.0 * cap), proves=False)
    margin = end.load_factor - cap if end.optimal else -np.inf
    return Safest(end.x, margin, cap, end.carrying, end.reduced_accuracy)


def safe_under_mean_load(problem: Problem, tolerances: Tolerances) -> bool:
    """Whether some slip keeps every node within its limit under the mean load alone, to ``feasibility``.

    Raises
    ------
    SolverError
        If the program ends without an answer.
    """
    rows = disc_rows(problem)
    one = np.unique(rows.node, return_index=True)[1]  # under the mean all load steps of a node are alike
    held = replace(rows.half_spaces, d=np.zeros_like(rows.half_spaces.d))
    mean = replace(
        rows, node=rows.node[one], step=rows.step[one], c=rows.c[one], e=0 * rows.e[one], half_spaces=held
    )
    x = np.zeros(rows.stiffness.shape[-1])
    if mean.relative_excess(x, 0.0) > 0:
        taken = without_frictionless(mean, tolerances)
        if taken is None:
            x = safest(mean, 0.0).x
        elif taken.against.size:
            return False
        else:
            x = taken.slips(safest(taken.rest, 0.0).x, 0.0)
    return mean.relative_excess(x, 0.0) <= tolerances.feasibility
