"""A sphere that is rolled to and fro on a flat under a constant tangential force (Wetter, Popov)."""

import numpy as np

from benchmarks.bodies.sphere import half_spaces
from shakedown import Problem
from shakedown.ground.constants import FloatArray

SKEW = 0.4  # rad, of the squares against the way of the contact
TURN = np.array([[np.cos(SKEW), np.sin(SKEW)], [-np.sin(SKEW), np.cos(SKEW)]])
FIRST_LOADING = 4  # load steps in which the tangential force is put on, before rolling
MARGIN = 1.0  # squares beyond Hertz's disc that may still touch, in sizes


def rolling_sphere(
    size: float = 0.25, *, amplitude: float = 0.3, shear: float = 0.5, direction: float = 0.0, f: float = 0.5,
    poisson: float = 0.3, steps: int = 8,
) -> Problem:  # fmt: skip
    """A sphere rolled to and fro under a constant tangential force (Wetter, Popov); similar materials.

    Square patches are laid over all that the contact reaches, askew, so that no line of them meets the
    contact's edge at once; which of them touch follows from the gaps, whose lowest place rolls along x as
    ``amplitude`` · sin over the period, from its middle. Transient load steps put the tangential force on
    before. All loads are those of load factor 1. Where the tangential force exceeds :func:`rolling_limit`
    · f N, the sphere creeps on with every period (in the limit of small squares).
    """
    centres = _squares(size, amplitude)
    square = size / 2 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) @ TURN
    along, across = half_spaces([centre + square for centre in centres], poisson)
    places = amplitude * np.sin(2 * np.pi * np.arange(steps) / steps)
    curvature = 1.5 * (1 - poisson**2)  # 1/R = 3 N/4 E* a³, E* = E/2(1 − ν²)
    gaps = [
        ((centres - [place, 0.0]) ** 2).sum(axis=1) * curvature / 2 + size**2 * curvature / 12
        for place in places
    ]
    pressed = across.reactions[:, 0] - np.array(gaps) @ across.stiffness  # symmetric
    sheared = -along.reactions @ (shear * f * np.array([np.cos(direction), np.sin(direction)]))
    n, first = len(centres), np.linspace(0.0, 1.0, FIRST_LOADING + 1)
    return Problem(
        A=along.stiffness, B=np.zeros((n, 2 * n)), C=across.stiffness, f=f,
        q_w=np.tile(sheared, (steps, 1)), p_w=pressed,
        q_transient=np.outer(first, sheared), p_transient=np.tile(pressed[0], (len(first), 1)),
        x=centres, node_area=np.full(n, size**2), name="rolled sphere",
    )  # fmt: skip


def _squares(size: float, amplitude: float) -> FloatArray:
    """Centres of the squares that the unit disc reaches on its way, or nearly."""
    reach = int(np.ceil((1 + amplitude) / size)) + 2
    line = size * np.arange(-reach, reach + 1)
    centres = np.array([(x, y) for y in line for x in line]) @ TURN
    beside = np.maximum(np.abs(centres[:, 0]) - amplitude, 0.0)
    return centres[np.hypot(beside, centres[:, 1]) < 1 + MARGIN * size]


def rolling_limit(amplitude: float) -> float:
    """Largest tangential force over f N that a sphere rolled by ±w holds in the end: 1 − 3w/2a + w³/2a³.

    The integral of the least pressure that Hertz's has at each place over the period: once nothing slips the
    tractions stay as they are, below f times that, and where shear and pressure are not coupled tractions
    that find room there are reached (Melan; docs/space.md, half-spaces). Wetter and Popov found it by their
    reduction to one dimension (Shakedown limits for an oscillating, elastic rolling contact with Coulomb
    friction). 0 from w = a on.
    """
    w = min(amplitude, 1.0)
    return 1.0 - 1.5 * w + 0.5 * w**3
