"""A joint whose slips, gaps and reactions are averaged over a length, by hat functions."""

import logging
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.linalg import block_diag

from shakedown.ground.argument_kinds import checked
from shakedown.ground.constants import NEGLIGIBLE, SIX_DIGITS, FloatArray, IntArray
from shakedown.ground.errors import UsageError
from shakedown.joint.arguments import is_finite
from shakedown.joint.contact_surface import Surface, around, cell_weights, surface_of
from shakedown.joint.fields import OF_NODES
from shakedown.joint.problem import AXES, Problem


@checked
def averaged(problem: Problem, radius: float) -> Problem:
    """A joint whose slips, gaps and reactions are averaged over a length (docs/mesh.md).

    Some nodes, the knots, stay, about a radius apart and at both ends of the contact. Slips and gaps are
    linear between them, v = P v′, and reactions are averaged with the same weights:

        A′ = Pᵀ A P,   B′ = Pᵀ B P,   C′ = Pᵀ C P,   q_w′ = Pᵀ q_w,   p_w′ = Pᵀ p_w.

    The result is a problem like any other, and all that is proved of such is true of it. It is no proof
    for the joint itself, whose slips may vary within a radius.

    In space the weights are those of Laplace's interpolation between natural neighbours, within each patch
    and along it where it is curved. Friction is the mean under each hat. An initial slip becomes the
    nearest one in the energy norm, so that its averaged tangential reactions stay.

    Parameters
    ----------
    problem
        The joint, with the positions of its nodes.
    radius
        The distance of knots [length]: where nodes are farther apart than that they all stay.

    Raises
    ------
    UsageError
        If the radius is not above 0, or the joint does not know where its nodes are, or has two at one place.

    Examples
    --------
    >>> import shakedown
    >>> block = shakedown.example("block-9")
    >>> shakedown.averaged(block, 0.5).x.tolist()
    [0.0, 0.5, 1.0, 1.5, 2.0]
    """
    if not (is_finite(radius) and radius > 0):
        raise UsageError(f"radius: expected a length above 0, found {radius!r}")
    surface = surface_of(problem)
    if surface is None:
        raise UsageError("averaged: expected positions x of nodes that are apart, found none")
    if surface.in_plane:
        knots = _knots_along(surface, radius)
    else:
        knots = spread_knots(surface, np.full(problem.n, float(radius)))
    if len(knots) == problem.n:
        logging.getLogger("shakedown").warning("averaging over %g does nothing: elements are as long", radius)
    return between_knots(problem, surface, knots)


def coarsened(problem: Problem) -> Problem | None:
    """The joint on every second node of its contact; None where it does not know where its nodes are.

    Examples
    --------
    >>> import shakedown
    >>> coarsened(shakedown.example("block-9")).n
    5
    """
    surface = surface_of(problem)
    if surface is None:
        return None
    if surface.in_plane:
        strips = zip(surface.parts, surface.rings, strict=True)
        ends = [part[-1:] for part, ring in strips if not ring]  # a ring has none
        knots = np.unique(np.concatenate([*(part[::2] for part in surface.parts), *ends]))
    else:
        knots = spread_knots(surface, 2.0 * surface.spacing)
    return between_knots(problem, surface, knots)


def _knots_along(surface: Surface, radius: float) -> IntArray:
    """The nodes nearest to points about a radius apart, on every strip, in order."""
    found, x = [], surface.points[:, 0]
    for part, closing in zip(surface.parts, surface.rings, strict=True):
        length = x[part[-1]] - x[part[0]] + closing
        count = max(1, round(length / max(radius, NEGLIGIBLE * length)))
        middles = (x[part[1:]] + x[part[:-1]]) / 2 - x[part[0]]
        before = np.floor(count * middles / length)  # the last point that is nearer to the node on the left
        found.append(part[np.diff(before, prepend=-1, append=count - bool(closing)) > 0])
    return np.unique(np.concatenate(found))


def spread_knots(surface: Surface, apart: FloatArray) -> IntArray:
    """Nodes of patches at the distance required of each from the others, (k,), the rim first."""
    chosen = []
    for part in surface.parts:
        points = surface.points[part]
        order = np.lexsort(
            (*np.round(points / np.ptp(points, axis=0).max(initial=1e-300), 6).T, ~surface.edge[part])
        )
        nearest = np.full(len(part), np.inf)
        for k in order:
            if nearest[k] >= (1.0 - SIX_DIGITS) * apart[part[k]]:
                chosen.append(part[k])
                nearest = np.minimum(nearest, np.linalg.norm(points - points[k], axis=1))
    return np.sort(np.array(chosen))


def hat_functions(surface: Surface, knots: IntArray) -> FloatArray:
    """The hat function of every knot at every node, (n, k): not negative, their sum is one."""
    P = np.zeros((len(surface.points), len(knots)))
    place = np.full(len(P), -1)
    place[knots] = np.arange(len(knots))
    rings = surface.rings or (0.0,) * len(surface.parts)
    for part, closing in zip(surface.parts, rings, strict=True):
        own = part[place[part] >= 0]
        if surface.in_plane:
            x = surface.points[:, 0]
            period = x[part[-1]] - x[part[0]] + closing if closing else None
            for knot, hat in zip(own, np.eye(len(own)), strict=True):
                P[part, place[knot]] = np.interp(x[part], x[own], hat, period=period)
            continue
        P[own, place[own]] = 1.0
        for node in part[place[part] < 0]:
            beside, offsets = around(surface, int(node), own)
            P[node, place[beside]] = cell_weights(offsets) if len(beside) > 1 else 1.0
    return P


def between_knots(problem: Problem, surface: Surface, knots: IntArray) -> Problem:
    """The joint whose slips and gaps are those between some of its nodes."""
    normal = hat_functions(surface, knots)
    tangential = _tangential(problem, normal, knots)
    of_axis = {"dn": tangential, "n": normal, "(d+1)n": block_diag(tangential, normal)}
    changed: dict[str, Any] = problem.node_data(knots) | {"faces": None}
    for key, axes in AXES.items():
        value = getattr(problem, key)
        if value is None or key in (*OF_NODES, "initial_slip"):
            continue
        for number, axis in enumerate(axes):
            if axis in of_axis:
                value = np.moveaxis(np.tensordot(value, of_axis[str(axis)], axes=(number, 0)), -1, number)
                changed[key] = value
    # exactly the common value where all nodes have the same
    changed["f"] = np.clip(problem.f @ normal / normal.sum(axis=0), problem.f.min(), problem.f.max())
    if problem.node_area is not None:
        changed["node_area"] = normal.T @ problem.node_area
    if problem.initial_slip is not None:
        right = tangential.T @ problem.A @ problem.initial_slip.T
        changed["initial_slip"] = np.linalg.lstsq(changed["A"], right, rcond=NEGLIGIBLE)[0].T
    return replace(problem, **changed)


def _tangential(problem: Problem, hats: FloatArray, knots: IntArray) -> FloatArray:
    """Slips of all nodes by those of the knots, (dn, dk), carried along where the tangents turn."""
    d = problem.directions
    turned = np.broadcast_to(np.eye(d), (problem.n, len(knots), d, d))
    if d == 2 and problem.tangents is not None:
        left, _, right = np.linalg.svd(np.einsum("iad,jbd->ijab", problem.tangents, problem.tangents[knots]))
        turned = left @ right
    blocks = hats[:, :, None, None] * turned
    return np.asarray(blocks.transpose(0, 2, 1, 3).reshape(d * problem.n, d * len(knots)))
