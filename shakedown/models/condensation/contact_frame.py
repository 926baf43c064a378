"""The directions of contact nodes, and the slips and gaps of pairs in them."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from shakedown.ground.constants import NEGLIGIBLE, THREE_DIGITS, FloatArray, IntArray, Mask
from shakedown.ground.errors import ProblemError
from shakedown.ground.tolerances import DEFAULT
from shakedown.joint.law import Layout
from shakedown.models.condensation.surface_mesh import NodeCoupling, corner_basis, own_basis


def tangent_pairs(normals: FloatArray, tangent: ArrayLike | None = None) -> FloatArray:
    """A pair of unit tangents for every unit normal, t₁ × t₂ = n.

    t₁ is a given direction less its part along the normal, t₂ = n × t₁. Where no direction is given, one of
    the axes x, y, z is taken for all nodes: the one that lies least along their normals (the first of several
    alike). Nodes whose normal points along that axis take the axis that lies least along their own.

    Parameters
    ----------
    normals : (n, 3)
        Unit normals [–].
    tangent : (3,) or (n, 3) or (n, 2, 3), optional
        The direction towards which t₁ points, one for all or one per node; or the pairs themselves, of which
        the second says on which side t₂ is.

    Returns
    -------
    (n, 2, 3)

    Raises
    ------
    ProblemError
        If a tangent leads along its normal, or the shape is another.

    Examples
    --------
    >>> tangent_pairs(np.array([[0.0, 0.0, 1.0]])).tolist()
    [[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]
    >>> tangent_pairs(np.array([[0.0, 0.0, 1.0]]), [0.0, 2.0, 5.0]).tolist()
    [[[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]]
    """
    if tangent is None:
        along = normals**2
        everywhere = _least_column(along.mean(axis=0, keepdims=True))[0]
        # sine of the angle between an axis and a normal below which the axis gives no tangent there
        steep = along[:, everywhere] > 1.0 - 0.2**2
        return _completed(normals, np.eye(3)[np.where(steep, _least_column(along), everywhere)])
    given = np.asarray(tangent, dtype=np.float64)
    n = len(normals)
    if given.shape not in ((3,), (n, 3), (n, 2, 3)):
        raise ProblemError(f"tangent: expected shape (3,), ({n}, 3) or ({n}, 2, 3), found {given.shape}")
    towards = np.broadcast_to(given, (n, 3)) if given.ndim < 3 else given[:, 0]
    size = np.linalg.norm(towards, axis=1)
    across = np.linalg.norm(np.cross(normals, towards), axis=1)
    wrong = ~(np.isfinite(size) & (across > DEFAULT.printed_digits * size))
    if wrong.any():
        j = int(np.argmax(wrong))
        raise ProblemError(
            f"tangent: expected a finite direction across the normal {normals[j].round(6).tolist()}, found "
            f"{towards[j].tolist()} at node {j}"
        )
    pairs = _completed(normals, towards)
    if given.ndim == 3:  # t₂ on the side of given second tangents
        pairs[:, 1] *= np.where((pairs[:, 1] * given[:, 1]).sum(axis=1) < 0, -1.0, 1.0)[:, None]
    return pairs


def patch_positions(places: FloatArray, normals: FloatArray, tangent: ArrayLike | None = None) -> FloatArray:
    """Positions of nodes on the plane of a flat patch along its tangents, (n, 2); on a curved one (n, 3).

    Examples
    --------
    >>> places, up = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 3.0]]), np.array([[0.0, 0.0, 1.0]] * 2)
    >>> patch_positions(places, up).tolist()
    [[1.0, 2.0], [4.0, 5.0]]
    """
    mean = normals.mean(axis=0)
    # unit normals of a flat patch may differ from their mean by as much
    if (np.abs(normals - mean) > THREE_DIGITS).any():
        return places
    towards = None if tangent is None else np.asarray(tangent, dtype=np.float64).reshape(-1, 3)[0]
    return np.asarray(places @ tangent_pairs((mean / np.linalg.norm(mean))[None], towards)[0].T)


def _least_column(along: FloatArray) -> IntArray:
    """The column with the least number of every row, the first of those that are equal to round-off."""
    return np.argmax(along <= along.min(axis=1, keepdims=True) + NEGLIGIBLE, axis=1)


def _completed(normals: FloatArray, towards: FloatArray) -> FloatArray:
    first = towards - (towards * normals).sum(axis=1)[:, None] * normals
    first /= np.linalg.norm(first, axis=1)[:, None]
    first -= (first * normals).sum(axis=1)[:, None] * normals  # what round-off has left
    first /= np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(normals, first)], axis=1) + 0.0  # no -0.0


Axes = tuple[int, ...]  # two directions that span a plane, or all three
PLANE, SPACE = (1, 2), (1, 2, 3)  # directions of the contact nodes, unless others are given


def in_space(vectors: FloatArray, axes: Axes | None = None) -> FloatArray:
    """Vectors along two of the axes x, y, z (n, 2), the first two of them, or along all, as vectors (n, 3).

    Examples
    --------
    >>> in_space(np.array([[0.6, 0.8]]), (1, 3)).tolist()
    [[0.6, 0.0, 0.8]]
    """
    found = np.zeros((len(vectors), 3))
    found[:, [axis - 1 for axis in axes or SPACE[: vectors.shape[1]]]] = vectors
    return found


@dataclass(frozen=True)
class ContactFrame:
    """The contact nodes in rows of the stiffness matrix.

    Attributes
    ----------
    labels : (n,) or (n, 2)
        Contact node of the first body, or pairs (first body, second body).
    rows : (n, d + 1)
        Row of the stiffness matrix of node j of the first body, direction (x, y) or (x, y, z).
    normals : (n, d + 1)
        Unit normals; they point into the first body, the way the gap opens.
    tangents : (n, 2) or (n, 2, 3)
        In the plane unit tangents (n_y, −n_x): normal (0, 1) gives the slip direction (1, 0). In space
        a perpendicular pair for every node, t₁ × t₂ = n.
    followed : (n (d + 1), N)
        How the nodes move with the second body while slip and gap are zero; zero without one.
    coupled : bool
        Whether they follow a surface with another mesh.
    middle_nodes : (t, 3)
        For quadratic faces: nodes between two corners, and these corners. In the basis û of u = T û,
        u_middle = α (u_corner + u_corner) + (1 − 2 α) û_middle, every node has a share of a pressure
        (docs/mortar.md); slips and forces there are those of û.
    between : (t (d + 1), 3)
        Their rows, direction by direction; −1 where one is missing.
    """

    labels: IntArray
    rows: IntArray
    normals: FloatArray
    tangents: FloatArray
    followed: sparse.csr_array
    coupled: bool
    middle_nodes: IntArray
    between: IntArray

    @property
    def n(self) -> int:
        """Number of contact nodes (or pairs)."""
        return len(self.rows)

    @property
    def directions(self) -> int:
        """Tangential directions of a node: 1 in the plane, 2 in space."""
        return self.normals.shape[1] - 1

    @property
    def slip_axes(self) -> FloatArray:
        """The directions of slip of every node, (n, d, d + 1)."""
        return self.tangents.reshape(self.n, self.directions, self.directions + 1)

    @property
    def names(self) -> tuple[str, ...]:
        """What each contact node is called (:func:`node_names`)."""
        return node_names(self.labels)

    def transformation(self, size: int) -> tuple[sparse.csr_array, sparse.csr_array, IntArray]:
        """Express all displacements by slip and gap and by what is left, u = T_c (v, w) + T_r u_r.

        Against a second body the relative displacement u₁ − u₂ takes the place
        of u₁, so that u₁ = T_c (v, w) + u₂ and the second body is condensed with
        the interior; where surfaces do not match, P u₂ stands for u₂.

        Parameters
        ----------
        size
            Rows of the stiffness matrix.

        Returns
        -------
        T_c : (size, (d + 1) n)
            Columns v_1 … v_n, w_1 … w_n; slips node by node.
        T_r : (size, r)
            Columns for the rows that are not contact rows of the first body.
        rest : (r,)
            Those rows.
        """
        first = self.rows.ravel()
        slips, gaps = self.layout.split(np.arange(self.layout.size))
        columns = [*self.layout.by_node(slips).T, gaps]
        entries = [
            (self.rows[:, a], columns[k], axis[:, a])
            for k, axis in enumerate((*self.slip_axes.transpose(1, 0, 2), self.normals))
            for a in range(self.directions + 1)
        ]
        row, column, value = (np.concatenate(part) for part in zip(*entries, strict=True))
        T_c = sparse.csr_array((value, (row, column)), shape=(size, self.layout.size))
        rest = np.setdiff1d(np.arange(size), first)
        unit = sparse.eye_array(size, format="csr")
        T_r = unit[:, rest] + unit[:, first] @ self.followed[:, rest]
        if self.between.size:
            T = corner_basis(self.between, size)
            T_c, T_r = T @ T_c, T @ T_r if self.coupled else T_r  # of pairs T_r has u₂ itself
        return sparse.csr_array(T_c), sparse.csr_array(T_r), rest

    @property
    def layout(self) -> Layout:
        """Where the slip and the gap of a node stand."""
        return Layout(self.n, self.directions)

    @property
    def first(self) -> IntArray:
        """Labels of the contact nodes of the first body, (n,)."""
        return self.labels.reshape(self.n, -1)[:, 0]

    def carried(self, forces: FloatArray) -> FloatArray:
        """Nodal forces (n, …) in the basis of the contact: Tᵀ r."""
        return np.asarray(own_basis(self.first, self.middle_nodes).T @ forces)

    def weighted(self, values: FloatArray) -> FloatArray:
        """Displacements or gaps at the nodes (n, …) in the basis of the contact: T⁻¹ u."""
        return np.asarray(own_basis(self.first, self.middle_nodes, inverse=True) @ values)

    def to_local(self, vectors: FloatArray) -> FloatArray:
        """Components (x, y[, z]) per node, (n, d + 1), in the local frame: (tangential…, normal…)."""
        q = (vectors[:, None, :] * self.slip_axes).sum(axis=2).ravel()
        return self.layout.joined(q, (vectors * self.normals).sum(axis=1))


def node_names(labels: IntArray) -> tuple[str, ...]:
    """What contact nodes (n,) are called, or pairs (n, 2) of the first body and the second.

    Examples
    --------
    >>> node_names(np.array([4711])), node_names(np.array([[4711, 12]]))
    (('4711',), ('4711/12',))
    """
    return tuple("/".join(map(str, np.atleast_1d(row).tolist())) for row in labels)


def contact_frame(
    dofs: ArrayLike,
    contact: ArrayLike,
    normals: ArrayLike,
    *,
    axes: tuple[int, int] = PLANE,
    tangent: ArrayLike | None = None,
    coupling: NodeCoupling | None = None,
    middle_nodes: ArrayLike | None = None,
) -> ContactFrame:
    """Find contact nodes in a (node, direction) map and set up their local frames.

    Parameters
    ----------
    dofs : (N, 2)
        Node label and direction (1, 2, 3 = x, y, z) of every row of the matrix.
    contact : (n,) or (n, 2)
        Labels of the contact nodes, or pairs (node of the first body, node of the second).
    normals : (2,) or (n, 2), in space (3,) or (n, 3)
        Normals that point into the first body; any length.
    axes
        The two directions that span the plane of a plane problem.
    tangent : (3,) or (n, 3) or (n, 2, 3), optional
        In space, as :func:`~shakedown.models.condensation.contact_frame.tangent_pairs` takes it.
    coupling
        The coupling to a surface with another mesh; None where nodes face nodes, or an obstacle.
    middle_nodes : (t, 3), optional
        (node between two corners, these corners) of faces whose corners would carry no pressure otherwise; a
        coupling brings its own.

    Raises
    ------
    ProblemError
        If a contact node has no row for one of the directions, occurs twice, or
        a normal is zero or of the wrong shape, or a tangent leads along a normal; if the contact nodes are
        not those of the coupling, or none of its second body's nodes has a row.

    Examples
    --------
    >>> frame = contact_frame([(7, 1), (7, 2), (9, 1), (9, 2)], [9], [0.0, 2.0])
    >>> frame.rows.tolist(), frame.tangents.tolist()
    ([[2, 3]], [[1.0, -0.0]])
    """
    table = checked_dofs(dofs)
    labels = np.asarray(contact)
    if (
        labels.size == 0
        or labels.dtype.kind not in "iu"
        or not (labels.ndim == 1 or labels.shape[1:] == (2,))
    ):
        raise ProblemError(
            "contact: expected node labels (n,) or pairs (n, 2), "
            f"found {labels.dtype} of shape {labels.shape}"
        )
    check_unique(labels)
    unit = _unit_normals(normals, len(labels))
    own = axes if unit.shape[1] == 2 else SPACE
    if unit.shape[1] == 2 and tangent is not None:
        raise ProblemError("tangent: expected only beside normals of three components, found two")
    if unit.shape[1] == 3 and axes != PLANE:
        expected = f"normals of two components, along directions {_listed(axes)}"
        raise ProblemError(f"axes: expected {expected}, found three")
    index = {(int(node), int(direction)): k for k, (node, direction) in enumerate(table)}
    bodies = labels.reshape(len(labels), -1)
    wanted = [(int(node), axis) for pair in bodies for node in pair for axis in own]
    missing = [key for key in wanted if key not in index]
    if missing:
        listed = ", ".join(f"({node}, {axis})" for node, axis in missing[:4])
        raise ProblemError(
            f"contact: expected a row for every contact node in directions {_listed(own)}, "
            f"found none for {len(missing)} of {len(wanted)}, first (node, direction) {listed} "
            "(a direction that is constrained or tied has no row)"
            + ("; of a plane problem the normals have two components" if len(own) == 3 else "")
        )
    rows = np.array([index[key] for key in wanted]).reshape(len(labels), bodies.shape[1], len(own))
    if coupling is not None:
        followed, given = _followed(coupling, labels, index, own, len(table)), coupling.middle_nodes
        given = given[np.isin(given[:, 0], labels)]
    else:  # the other side is a basis of its own: nothing but contact nodes may be mixed
        leaders = rows[:, 1:].ravel()
        where = np.arange(len(leaders)), leaders
        shape = (rows[:, 0].size, len(table))
        followed = sparse.csr_array((np.ones(len(leaders)), where), shape=shape)
        given = np.zeros((0, 3), np.intp) if middle_nodes is None else np.asarray(middle_nodes, dtype=np.intp)
        given = given.reshape(-1, 3)
        given = given[np.isin(given, bodies[:, 0]).all(axis=1)]
    between = [[index.get((node, axis), -1) for node in three] for three in given.tolist() for axis in own]
    plane = unit.shape[1] == 2
    return ContactFrame(
        labels=labels,
        rows=rows[:, 0],
        normals=unit,
        tangents=np.column_stack([unit[:, 1], -unit[:, 0]]) if plane else tangent_pairs(unit, tangent),
        followed=followed,
        coupled=coupling is not None,
        middle_nodes=given,
        between=np.array(between, dtype=np.intp).reshape(-1, 3),
    )


def _followed(
    coupling: NodeCoupling,
    labels: IntArray,
    index: Mapping[tuple[int, int], int],
    own: tuple[int, ...],
    size: int,
) -> sparse.csr_array:
    """P by rows of the model, (n (d + 1), N): the motion of the contact nodes without slip and gap."""
    d = coupling.normals.shape[1]
    place = {label: k for k, label in enumerate(coupling.labels.tolist())}
    alien = [label for label in labels.ravel().tolist() if label not in place]
    if alien or labels.ndim != 1 or max(own) > d:
        found = "pairs" if labels.ndim != 1 else f"node {alien[0]}" if alien else f"directions {own}"
        raise ProblemError(
            f"coupling: expected contact nodes of its first surface in {d} dimensions, found {found}"
        )
    rows = [d * place[label] + axis - 1 for label in labels.tolist() for axis in own]
    master = coupling.master.tolist()
    target = np.array([index.get((node, axis), -1) for node in master for axis in range(1, d + 1)])
    if (target < 0).all():
        raise ProblemError(
            f"coupling: expected rows of the nodes of the second surface, first {master[0]}, found none"
        )
    there = target >= 0  # a missing row is held
    where = np.flatnonzero(there), target[there]
    return sparse.csr_array(
        coupling.P[rows] @ sparse.csr_array((np.ones(there.sum()), where), shape=(len(target), size))
    )


def with_guides(frame: ContactFrame, table: IntArray, held: Mask) -> tuple[ContactFrame, Mask]:
    """The frame with tangents along held directions; which slips are held while the normal is free, (dn,).

    In space a node that is held in one direction takes that direction as a tangent, unless it has it already.

    Raises
    ------
    ProblemError
        If a contact node of the first body is held in any other way, or along a tangent in which those of
        the second are free and slip on it.
    """
    first = held[frame.rows]
    across = np.abs(frame.normals) <= DEFAULT.symmetry
    follow = abs(frame.followed)
    alone = ((follow.sum(axis=1) > 0) & (follow @ held == 0)).reshape(first.shape)  # the other body is free
    blocked = np.any(first & (~across | alone), axis=1) | np.all(first, axis=1)
    if blocked.any():
        j = int(np.argmax(blocked))
        node, direction = table[frame.rows[j, int(np.argmax(first[j]))]]
        raise ProblemError(
            f"contact: expected free contact nodes, found direction {direction} of node {node} held "
            "(release the contact nodes in the model; on a plane of symmetry hold those of both bodies)"
        )
    if frame.directions > 1:
        pairs = frame.tangents.copy()
        for j in np.flatnonzero(first.any(axis=1)).tolist():
            axis = np.eye(3)[int(np.argmax(first[j]))]
            if np.abs(pairs[j] @ axis).max() < 1.0 - DEFAULT.symmetry:
                pairs[j] = _completed(frame.normals[j : j + 1], axis[None])[0]
        frame = replace(frame, tangents=pairs)
    moving = sparse.diags_array((~first).ravel().astype(float))  # a held row follows nothing
    frame = replace(frame, followed=sparse.csr_array(moving @ frame.followed))
    along = np.abs(frame.slip_axes) >= 1.0 - DEFAULT.symmetry
    return frame, np.any(along & first[:, None, :], axis=2).ravel()


def out_of_plane_notes(
    frame: ContactFrame, table: IntArray, held: Mask, axes: tuple[int, int]
) -> tuple[str, ...]:
    """A note on contact nodes of a plane problem that are held in a third direction, across the plane.

    Raises
    ------
    ProblemError
        If such a node can move there: friction acts along one tangent only.
    """
    if frame.directions > 1:
        return ()
    across = np.isin(table[:, 0], frame.labels) & (table[:, 1] <= 3) & ~np.isin(table[:, 1], axes)
    if (free := across & ~held).any():
        node, direction = table[np.argmax(free)]
        raise ProblemError(
            f"contact: expected one tangential direction per node, found node {node} free in direction "
            f"{direction} too; ask for friction in both directions (normals of three components; in an "
            "import directions = 2), or hold every contact node there (fixed)"
        )
    across &= table[:, 1] >= 1
    if not across.any():
        return ()
    return (
        f"direction {table[np.argmax(across), 1]} of the contact nodes is held: friction across the plane of "
        "slip and normal is left out",
    )


def checked_dofs(dofs: ArrayLike) -> IntArray:
    """A (node, direction) map as an (N, 2) integer array without repetition, or ``ProblemError``."""
    table = np.asarray(dofs)
    if table.ndim != 2 or table.shape[1] != 2 or table.dtype.kind not in "iu":
        raise ProblemError(
            "dofs: expected integer pairs (node, direction) of shape (N, 2), "
            f"found {table.dtype} of shape {table.shape}"
        )
    unique, count = np.unique(table, axis=0, return_counts=True)
    if len(unique) < len(table):
        node, direction = unique[np.argmax(count > 1)]
        raise ProblemError(f"dofs: expected every (node, direction) once, found ({node}, {direction}) twice")
    return table.astype(np.intp)


def check_unique(labels: IntArray) -> None:
    """Raise ``ProblemError`` where a node is in the contact twice."""
    unique, count = np.unique(labels, return_counts=True)
    if len(unique) < labels.size:
        raise ProblemError(
            f"contact: expected every node once, found node {unique[np.argmax(count > 1)]} twice"
        )


def _listed(axes: tuple[int, ...]) -> str:
    """Directions as a message names them."""
    return f"{', '.join(map(str, axes[:-1]))} and {axes[-1]}"


def _unit_normals(normals: ArrayLike, n: int) -> FloatArray:
    vectors = np.asarray(normals, dtype=np.float64)
    if vectors.shape not in ((2,), (n, 2), (3,), (n, 3)):
        raise ProblemError(
            f"normals: expected shape (2,) or ({n}, 2), components along the two axes, or (3,) or ({n}, 3), "
            f"found {vectors.shape}"
        )
    vectors = np.broadcast_to(vectors, (n, vectors.shape[-1]))
    length = np.hypot(vectors[:, 0], vectors[:, 1])
    if vectors.shape[1] == 3:
        length = np.hypot(length, vectors[:, 2])
    if not np.all(np.isfinite(length) & (length > 0)):
        j = int(np.argmin(np.isfinite(length) & (length > 0)))
        raise ProblemError(f"normals: expected vectors of finite length > 0, found {vectors[j]} at node {j}")
    return vectors / length[:, None]
