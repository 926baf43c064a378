"""Coupled parts: the joints that a joint falls into where A, B and C do not couple some nodes with others.

Nothing that happens in one part changes another: limits, motions and verdicts are those of each alone, in
whatever units each is.
"""

import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Status
from shakedown.joint.conjugate_loads import NO_LOADS
from shakedown.joint.derived import once_per_problem
from shakedown.joint.field_table import FORCES
from shakedown.joint.problem import Problem


@dataclass(frozen=True, eq=False)
class Part:
    """Nodes of a joint that are coupled with no other node.

    Attributes
    ----------
    nodes, slips
        Their numbers in the whole joint, and the places of their slips there.
    joint
        The joint of these nodes alone, without unit loads.
    """

    nodes: NDArray[np.intp]
    slips: NDArray[np.intp]
    joint: Problem

    def renumbered(self, text: str) -> str:
        """A text about nodes of the part, with the numbers that they have in the whole joint.

        Examples
        --------
        >>> import shakedown
        >>> part = Part(np.array([3, 7]), np.array([3, 7]), shakedown.example("two-node"))
        >>> part.renumbered("nodes 0, 1 open, node 1 after 5 cycles")
        'nodes 3, 7 open, node 7 after 5 cycles'
        """

        def in_whole(found: re.Match[str]) -> str:
            return re.sub(r"\d+", lambda number: str(self.nodes[int(number.group())]), found.group())

        return re.sub(r"\bnodes? \d+(, \d+)*", in_whole, text)

    def among(self, nodes: Collection[int]) -> tuple[int, ...]:
        """Those of some nodes of the whole joint that are the part's, by its own numbers."""
        return tuple(np.flatnonzero(np.isin(self.nodes, list(nodes))).tolist())

    def number(self, node: int) -> int:
        """The number of a node of the part in the whole joint; −1, no node, stays."""
        return int(self.nodes[node]) if node >= 0 else node


def coupled_parts(problem: Problem, open_nodes: Collection[int] = ()) -> tuple[Part, ...]:
    """The parts that a joint falls into, in the order of their first nodes; mostly one, the joint itself.

    So it is, too, where all nodes of a part are open, which is then no joint in contact, and where a part
    alone is no valid joint, as its stiffness is round-off beside that of others.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("two-node")
    >>> apart = shakedown.Problem(
    ...     A=np.kron(joint.A, np.eye(2)), B=np.kron(joint.B, np.eye(2)), f=0.4,
    ...     q_w=np.repeat(joint.q_w, 2, axis=1), p_w=np.repeat(joint.p_w, 2, axis=1),
    ... )
    >>> [part.nodes.tolist() for part in coupled_parts(apart)], coupled_parts(joint)[0].joint is joint
    ([[0, 2], [1, 3]], True)
    """
    parts = _parts(problem)
    if not parts or any(len(part.among(open_nodes)) == len(part.nodes) for part in parts):
        return (Part(np.arange(problem.n), np.arange(problem.layout.slip_size), problem),)
    return parts


def of_nodes(parts: Sequence[Part], values: Iterable[FloatArray]) -> FloatArray:
    """What is known of the nodes of each part, (…, k), for the nodes of the whole joint, (…, n)."""
    return np.concatenate(list(values), axis=-1)[..., np.argsort(np.concatenate([p.nodes for p in parts]))]


def of_slips(parts: Sequence[Part], values: Iterable[FloatArray]) -> FloatArray:
    """The same of slips, (…, dk): (…, dn)."""
    return np.concatenate(list(values), axis=-1)[..., np.argsort(np.concatenate([p.slips for p in parts]))]


def weakest(bounds: Sequence[Any]) -> int:
    """Which of the bounds on the load factors of parts is that of the whole joint.

    The first one that is infeasible, else the first one that is undecided, else the smallest.
    """
    ranks = {Status.INFEASIBLE: -2.0, Status.UNDECIDED: -1.0}
    return min(range(len(bounds)), key=lambda k: ranks.get(bounds[k].status, bounds[k].load_factor))


@once_per_problem
def _parts(problem: Problem) -> tuple[Part, ...]:
    """The parts, where there are several."""
    labels = _labels(problem)
    if not labels.any():
        return ()
    try:
        return tuple(_part(problem, np.flatnonzero(labels == k)) for k in range(labels.max() + 1))
    except ProblemError:
        return ()


def _labels(problem: Problem) -> NDArray[np.intp]:
    """The number of the part of every node, (n,)."""
    n, d = problem.n, problem.directions
    coupled = np.asarray(problem.A.reshape(n, d, n, d).any(axis=(1, 3)))
    coupled |= problem.B.reshape(n, n, d).any(axis=2)
    if problem.C is not None:
        coupled |= problem.C != 0.0
    if coupled[0].all():
        return np.zeros(n, dtype=np.intp)
    from scipy.sparse import csr_array  # needed only where some entries are zero
    from scipy.sparse.csgraph import connected_components

    return np.asarray(connected_components(csr_array(coupled), directed=False)[1], dtype=np.intp)


def _part(problem: Problem, nodes: NDArray[np.intp]) -> Part:
    slips = problem.layout.slips_of(nodes)
    cut: dict[str, Any] = {key: getattr(problem, key) for key in (*FORCES, "initial_slip")}
    for key, values in cut.items():
        if values is not None:
            cut[key] = values[..., nodes if key.startswith("p_") else slips]
    joint = replace(
        problem,
        **NO_LOADS,  # these work along displacements of the whole joint
        A=problem.A[np.ix_(slips, slips)],
        B=problem.B[np.ix_(nodes, slips)],
        C=None if problem.C is None else problem.C[np.ix_(nodes, nodes)],
        **cut,
        **problem.node_data(nodes),
    )
    return Part(nodes, slips, joint)
