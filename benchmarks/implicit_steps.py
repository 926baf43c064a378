"""Load steps of a joint, each solved at once (implicit Euler) by the toolkit's sweeps of Gauss–Seidel."""

from typing import NamedTuple

import numpy as np

from shakedown.ground.constants import FloatArray
from shakedown.joint.law import Layout
from shakedown.motion.fixed_steps import MOST_SWEEPS, contact_nodes, load_steps, places_by_node

CLOSE = 1e-13  # change of a displacement in the last sweep, relative to the force over the softest stiffness


class Steps(NamedTuple):
    """Slips and gaps (k, dn), (k, n) after the load steps that were solved, and slip in contact in each."""

    v: FloatArray
    w: FloatArray
    slip: FloatArray


class ImplicitSteps:
    """A joint that is carried from one load step to the next, from any state.

    ``force`` is what "small" is measured against: the largest welded reaction of the scene; ``close`` the
    change of a displacement [length] below which a load step is solved.
    """

    def __init__(
        self, kappa: FloatArray, f: FloatArray, directions: int, force: float, close: float | None = None
    ) -> None:
        self.layout = Layout(len(kappa) // (directions + 1), directions)
        self._at = places_by_node(self.layout)
        self._nodes = contact_nodes(self.layout, kappa, f, True, force)
        stiffness = np.diag(kappa)
        self._close = CLOSE * force / float(stiffness[stiffness > 0].min()) if close is None else close

    def follow(self, v: FloatArray, w: FloatArray, q_w: FloatArray, p_w: FloatArray, parts: int = 1) -> Steps:
        """From a state under the first load through all others (k, dn), (k, n), each in equal parts."""
        layout, at = self.layout, self._at
        given = layout.joined(q_w, p_w)
        share = np.arange(1, parts + 1)[None, :, None] / parts
        loads = (given[:-1, None] + share * (given[1:] - given[:-1])[:, None]).reshape(-1, layout.size)
        found, slip, u = (
            np.empty_like(loads),
            np.empty((len(loads), layout.slip_size)),
            layout.joined(v, w)[at],
        )
        *_, failed, _ = load_steps(self._nodes, loads[:, at].copy(), u, self._close, MOST_SWEEPS, found, slip)
        path = np.empty_like(found)
        path[:, at] = found
        solved = slice(parts - 1, len(loads) if failed < 0 else failed, parts)
        return Steps(*layout.split(path[solved]), slip[solved])
