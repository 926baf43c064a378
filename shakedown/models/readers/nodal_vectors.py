"""What a static step gave at nodes: reactions or displacements, of one step or of several together."""

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, NoReturn

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import ProblemError

What = Literal["reactions", "displacements"]


@dataclass(frozen=True, eq=False)
class NodalVectors:
    """Reactions (forces on the body) or displacements at nodes.

    Attributes
    ----------
    what : str
        Which of the two.
    node_sets : tuple of str
        Node sets they were printed for.
    time : float
        Time of the step.
    nodes : (n,)
        Node labels.
    vectors : (n, 3)
        Components along x, y, z [force or length].
    by_calculix : bool
        Whether CalculiX printed them. Its reactions are the internal forces, without loads that act at the
        node itself; those of axisymmetric models lack a part.
    local
        Nodes whose components are along directions of their own (``*TRANSFORM``).
    """

    what: What
    node_sets: tuple[str, ...]
    time: float
    nodes: NDArray[np.intp]
    vectors: FloatArray
    by_calculix: bool = False
    local: frozenset[int] = frozenset()

    def at(
        self, nodes: NDArray[np.intp], axes: tuple[int, ...], tied: NDArray[np.intp] | None = None
    ) -> FloatArray:
        """Components at nodes in two or three directions, (k, 2), with those of nodes tied to them added.

        Raises
        ------
        ProblemError
            If a node was not printed, or there is not one tied node for each.
        """
        if tied is not None:
            if tied.shape != nodes.shape:
                raise ProblemError(
                    f"tied: expected one node for each of {len(nodes)} contact nodes, found {len(tied)}"
                )
            return self.at(nodes, axes) + self.at(tied, axes)
        return self.vectors[self.places(nodes)][:, [axis - 1 for axis in axes]]

    def places(self, nodes: NDArray[np.intp], what: str = "contact node") -> list[int]:
        """The positions of nodes in the table; ``ProblemError`` if one was not printed."""
        index = {int(node): k for k, node in enumerate(self.nodes)}
        absent = [int(node) for node in nodes if int(node) not in index]
        if absent:
            raise ProblemError(
                f"{self.what} at time {self.time:g}: expected {what} {absent[0]}, found it not printed "
                f"({len(absent)} of {len(nodes)} are missing)"
            )
        return [index[int(node)] for node in nodes]


def combined(steps: Sequence[NodalVectors], factors: Sequence[float]) -> NodalVectors:
    """The sum of some steps, each times a factor, at the nodes of the first.

    Raises
    ------
    ProblemError
        If another step lacks one of these nodes.

    Examples
    --------
    >>> zero, nodes = np.zeros((1, 3)), np.array([7])
    >>> one, two = (NodalVectors("reactions", ("N",), t, nodes, zero + t) for t in (1.0, 2.0))
    >>> combined([two, one], [1.0, -1.0]).vectors
    array([[1., 1., 1.]])
    """
    first = steps[0]
    places = [step.places(first.nodes, "node") for step in steps]
    pairs = list(zip(steps, places, factors, strict=True))
    return replace(
        first,
        vectors=np.sum([factor * step.vectors[place] for step, place, factor in pairs], axis=0),
        by_calculix=any(step.by_calculix for step in steps),
        local=frozenset().union(*(step.local for step in steps)),
    )


def in_model_directions(
    run: NodalVectors, directions: Callable[[NDArray[np.intp]], FloatArray]
) -> NodalVectors:
    """The vectors in components along x, y, z; ``directions`` has the axes of every node, (k, 3, 3).

    Examples
    --------
    >>> turned = np.array([[[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]])
    >>> one, nodes = np.array([[5.0, 0.0, 2.0]]), np.array([7])
    >>> run = NodalVectors("reactions", ("N",), 1.0, nodes, one, local=frozenset([7]))
    >>> in_model_directions(run, lambda nodes: turned).vectors
    array([[0., 5., 2.]])
    """
    own = np.isin(run.nodes, list(run.local))
    if not own.any():
        return run
    vectors = run.vectors.copy()
    vectors[own] = np.einsum("ki,kij->kj", vectors[own], directions(run.nodes[own]))
    return replace(run, vectors=vectors, local=frozenset())


def refuse_as_stiffness(path: str | os.PathLike[str]) -> NoReturn:
    """Say that reactions alone are no stiffness."""
    raise ProblemError(
        f"{os.fspath(path)}: expected a matrix, found reactions; they make a stiffness only with the list of "
        f"contact nodes that were moved (import {Path(path).name} with a configuration)"
    )
