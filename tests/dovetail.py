"""A dovetail: a wedge-shaped root pulled into the two inclined flanks of its slot."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from skfem import MeshQuad

from shakedown import Problem
from shakedown.fem import ElasticBody, Material, Support, Traction, block_mesh, contact_problem
from shakedown.ground.constants import FloatArray

OUTER = 2.5  # half-width of the slot's walls; the root is 2 wide at the bottom and 1 high


def dovetail(
    refinement: int = 1,
    *,
    slope: float = 0.8,
    f: float = 0.3,
    pull: float = 40.0,
    side: float = 10.0,
    steps: int = 24,
) -> Problem:
    """A dovetail joint: a mean pull and a cyclic side load on the root, which the two flanks hold.

    The root's half-width is 1 − slope · y, so that the pull presses it into both flanks;
    their inner ends open. Steel, plane strain; tractions act on the top of the root.

    Parameters
    ----------
    refinement
        Multiplies the elements; each flank has 12 · refinement + 1 node pairs.
    slope
        Inclination of the flanks, 0 < slope < 0.9.
    f
        Friction coefficient [–]; a joint with f > slope can hold itself wedged.
    pull, side
        Mean traction upwards and amplitude of the cyclic one sideways [force/length²].
    steps
        Load steps of one period.

    Examples
    --------
    >>> dovetail().n
    26
    """

    def half(y: FloatArray) -> FloatArray:
        return np.asarray(1.0 - slope * y)

    along = 12 * refinement
    block = block_mesh(2.0, 1.0, 16 * refinement, along, origin=(-1.0, 0.0))
    root = replace(block, doflocs=np.ascontiguousarray([block.p[0] * half(block.p[1]), block.p[1]]))
    root = root.with_boundaries({"flanks": lambda x: np.isclose(np.abs(x[0]), half(x[1]), atol=1e-9)})
    loads = [
        Traction("top", (0.0, pull), history=1.0),
        Traction("top", (side, 0.0), history=lambda t: np.cos(2 * np.pi * t)),
    ]
    steel = Material(200e3, 0.3)
    slot = ElasticBody(_walls(half, 8 * refinement, along), steel, supports=[Support("outer")])
    body = ElasticBody(root, steel, loads=loads)
    return contact_problem(
        body, "flanks", f, against=(slot, "flanks"), steps=steps, name="dovetail", units="N, mm"
    )


def _walls(half: Callable[[FloatArray], FloatArray], across: int, along: int) -> MeshQuad:
    """Both walls of the slot, from the flanks to where they are held."""
    block = block_mesh(1.0, 1.0, across, along)
    eta, y = block.p
    right = np.array([half(y) + eta * (OUTER - half(y)), y])
    left = right * [[-1.0], [1.0]]  # mirrored, so its elements run the other way round
    points = np.hstack([right, left])
    elements = np.hstack([block.t, block.t[::-1] + right.shape[1]])
    mesh = MeshQuad(np.ascontiguousarray(points), np.ascontiguousarray(elements))
    return mesh.with_boundaries(
        {
            "flanks": lambda x: np.isclose(np.abs(x[0]), half(x[1]), atol=1e-9),
            "outer": lambda x: np.isclose(np.abs(x[0]), OUTER, atol=1e-9),
        }
    )
