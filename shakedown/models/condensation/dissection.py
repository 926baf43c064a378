"""An order of elimination for large solid models: nested dissection by the positions of the nodes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import dijkstra

from shakedown.ground.float_array import FloatArray

IntArray = NDArray[np.intp]
LEAF = 60  # nodes eliminated together without further dissection
LANDMARKS = 8  # nodes whose distances from all others replace unknown positions


@dataclass(frozen=True, eq=False)
class DissectionPiece:
    """Nodes that are eliminated together, after the pieces on both sides that they separate.

    Attributes
    ----------
    nodes : (k,)
        Nodes, by number.
    children
        Positions of these pieces in the order of elimination.
    """

    nodes: IntArray
    children: tuple[int, ...]


def dissection(graph: sparse.csr_array, places: FloatArray | None = None) -> list[DissectionPiece]:
    """Cut a graph in two again and again; every cut comes after both of its sides.

    Each part is cut across its longest side through the middle of its nodes. The cut is
    the nodes of one side that are coupled to the other: whichever are fewer.

    Parameters
    ----------
    graph : (k, k)
        Which nodes are coupled; symmetric pattern.
    places : (k, 3), optional
        Positions of the nodes [length]; by default distances in the graph replace them.

    Examples
    --------
    >>> chain = sparse.csr_array(np.eye(200, k=1) + np.eye(200, k=-1))
    >>> pieces = dissection(chain, np.arange(200.0)[:, None])
    >>> [len(piece.nodes) for piece in pieces], pieces[-1].nodes
    ([48, 50, 1, 49, 50, 1, 1], array([99]))
    """
    found: list[DissectionPiece] = []
    where = _by_distances(graph) if places is None else places
    mark = np.zeros(graph.shape[0], dtype=np.int8)

    def cut(nodes: IntArray) -> tuple[int, ...]:
        """Pieces of these nodes below no other: one, or those of parts that nothing couples."""
        if not nodes.size:
            return ()
        if len(nodes) <= LEAF:
            return (_add(nodes, ()),)
        axis = int(np.argmax(np.ptp(where[nodes], axis=0)))
        order = nodes[np.argsort(where[nodes, axis], kind="stable")]
        one, other = order[: len(order) // 2], order[len(order) // 2 :]
        between, own = min((_facing(one, other), 0), (_facing(other, one), 1), key=lambda side: len(side[0]))
        sides = [one, other]
        sides[own] = np.setdiff1d(sides[own], between, assume_unique=True)
        children = cut(sides[0]) + cut(sides[1])
        return (_add(between, children),) if between.size else children

    def _facing(side: IntArray, beyond: IntArray) -> IntArray:
        """Nodes of one side that are coupled to the other."""
        mark[beyond] = 1
        rows = graph[side]
        touching = np.add.reduceat(np.append(mark[rows.indices], 0), rows.indptr[:-1].clip(max=rows.nnz))
        mark[beyond] = 0
        return side[(touching > 0) & (np.diff(rows.indptr) > 0)]

    def _add(nodes: IntArray, children: tuple[int, ...]) -> int:
        found.append(DissectionPiece(np.sort(nodes), children))
        return len(found) - 1

    cut(np.arange(graph.shape[0]))
    return found


def _by_distances(graph: sparse.csr_array) -> FloatArray:
    """Positions made of distances in the graph: their three main components, (k, 3)."""
    farthest, rows = 0, []
    nearest = np.full(graph.shape[0], np.inf)
    for _ in range(min(LANDMARKS, graph.shape[0])):
        away = dijkstra(abs(graph), unweighted=True, indices=farthest)
        away[np.isinf(away)] = graph.shape[0]  # another part: far away
        rows.append(away)
        nearest = np.minimum(nearest, away)
        farthest = int(np.argmax(nearest))
    away = np.array(rows).T
    away -= away.mean(axis=0)
    return np.asarray(away @ np.linalg.eigh(away.T @ away)[1][:, -3:])
