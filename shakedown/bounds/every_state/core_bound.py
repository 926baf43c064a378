"""Proofs from every state away from the edges of a contact, where a single element determines λ_U."""

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.every_state.admissible_states import admissible_states
from shakedown.bounds.every_state.bound_of_floating import core_of_floating
from shakedown.bounds.every_state.scaled_joint import scaled_joint
from shakedown.bounds.every_state.swing_lines import known_lines, limit_multipliers
from shakedown.bounds.every_state.universal_bound import UniversalBound
from shakedown.ground.errors import Missing, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.coupled_parts import coupled_parts
from shakedown.joint.places import ACROSS
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result

NEAR = 1 / 16  # of the width: nodes nearer to an edge are excluded


@dataclass(frozen=True, eq=False, repr=False)
class CoreBound(Result):
    """The load factor below which no cycle persists without slip near the edges, whatever is locked in.

    With all nodes closed and motions without jumps. What the other nodes slip in a cycle is at most in
    proportion to the slip near the edges (docs/universal.md, statement 6.9).

    Attributes
    ----------
    load_factor
        λ_core; 0 where nothing is proved, inf where no load factor ends it.
    node
        The node that ends it; −1 where none does, or where friction alone holds the body.
    depth
        Nodes that are nearer than this to an edge are left out [length].
    near_edge
        These nodes.
    """

    load_factor: float
    node: int
    depth: float
    near_edge: tuple[int, ...]


def core_bound(
    problem: Problem, every: UniversalBound, *, tolerances: Tolerances = DEFAULT
) -> CoreBound | Missing:
    """λ_core of a joint whose λ_U a node near an edge decides; Missing of others, and without places.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("block-33")
    >>> found = core_bound(joint, shakedown.universal_bound(joint))
    >>> round(found.load_factor, 4), found.near_edge  # and found.node is 2 or, by symmetry, 30
    (2.8169, (0, 1, 31, 32))
    """
    places = problem.coordinates if problem.x is None else problem.x
    if places is None:
        return Missing("the nodes have no places (x)")
    distances = edge_distances(places)
    depth = 2.0 * NEAR * float(distances.max())
    near = distances < depth * (1.0 - NEGLIGIBLE)
    if every.node < 0 or not near[every.node]:
        return Missing("λ_U is not decided near an edge")
    near_edge = tuple(np.flatnonzero(near).tolist())
    found = _farthest(problem, every, ~near, tolerances)
    return found if isinstance(found, Missing) else CoreBound(*found, depth, near_edge)


def _farthest(
    problem: Problem, every: UniversalBound, inside: NDArray[np.bool_], tolerances: Tolerances
) -> tuple[float, int] | Missing:
    """λ_core of the nodes inside, and the node that ends it, −1 for none."""
    core = np.flatnonzero(inside)
    if every.parts:
        least = inf, -1
        for part, bound in zip(coupled_parts(problem), every.parts, strict=True):
            found = _farthest(part.joint, bound, inside[part.nodes], tolerances)
            if isinstance(found, Missing):
                return found
            least = min(least, (found[0], part.number(found[1])))
        return least
    if not core.size:
        return inf, -1
    if scaled_joint(problem).floats:
        limit = sought(core_of_floating, problem, core, tolerances)
        return limit if isinstance(limit, Missing) else (limit, -1)
    if every.pressures is not None:
        of_nodes = every.pressures.of_nodes
    else:
        lines = known_lines(admissible_states(problem), limit_multipliers(problem, tolerances))
        of_nodes = np.maximum(lines.meetings(), 0.0)
    lowest = int(core[of_nodes[core].argmin()])
    load_factor = float(of_nodes[lowest])
    return load_factor, lowest if load_factor < inf else -1


def edge_distances(places: FloatArray) -> FloatArray:
    """The distances of nodes from the ends of a line, or from the edges and holes of a patch, (n,) [length].

    Examples
    --------
    >>> edge_distances(np.array([0.0, 1.0, 4.0])).tolist()
    [0.0, 1.0, 0.0]
    """
    n = len(places)
    offsets = places.reshape(n, -1) - places.reshape(n, -1).mean(axis=0)
    _, sizes, axes = np.linalg.svd(offsets, full_matrices=False)
    flat = offsets @ axes[sizes > NEGLIGIBLE * sizes.max(initial=0.0)][:2].T
    if flat.shape[1] < 2:
        line = flat.sum(axis=1)
        return np.asarray(np.minimum(line - line.min(), line.max() - line))
    ends = flat[_rim(flat)]
    along = ends[:, 1] - ends[:, 0]
    away = flat[:, None] - ends[:, 0]
    share = np.clip(np.sum(away * along, axis=2) / np.sum(along**2, axis=1), 0.0, 1.0)
    return np.asarray(np.linalg.norm(away - share[..., None] * along, axis=2).min(axis=1))


def _rim(places: FloatArray) -> NDArray[np.intp]:
    """Pairs of nodes (e, 2) of places in a plane between which an edge runs, outer and around holes.

    Of triangles between neighbours those that reach farther than nodes are from each other there are none.
    """
    from scipy.spatial import Delaunay  # needed only where a patch has an edge

    corners = Delaunay(places).simplices
    sides = np.sort(corners[:, [[0, 1], [1, 2], [2, 0]]], axis=2)
    lengths = np.linalg.norm(places[sides[..., 0]] - places[sides[..., 1]], axis=2)
    at = [np.median(lengths[(sides == k).any(axis=2)]) if k in corners else 0.0 for k in range(len(places))]
    kept = lengths.max(axis=1) <= ACROSS * np.median(np.array(at)[corners], axis=1)
    between, count = np.unique(sides[kept].reshape(-1, 2), axis=0, return_counts=True)
    return np.asarray(between[count == 1])
