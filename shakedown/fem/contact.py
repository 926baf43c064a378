"""A contact problem from elastic bodies with loads and supports."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.spatial import KDTree

from shakedown.fem import loads
from shakedown.fem.body import ElasticBody, tied
from shakedown.fem.loads import Bolt, History, ModalLoad
from shakedown.fem.mesh import origin_text
from shakedown.ground.argument_kinds import checked
from shakedown.ground.constants import FloatArray, IntArray
from shakedown.ground.errors import ProblemError
from shakedown.joint.arguments import node_numbers, real_array
from shakedown.joint.places import arc_lengths, bearing_no_pressure, faces_among, without_cancelled
from shakedown.joint.problem import Problem
from shakedown.models.condensation.condense import Condensation, condensed_stiffness
from shakedown.models.condensation.contact_frame import in_space, node_names, patch_positions
from shakedown.models.condensation.load_case import LoadCase, without_closing
from shakedown.models.condensation.stiffness_checks import with_shanks
from shakedown.models.condensation.surface_coupling import SurfaceCoupling, surface_coupling
from shakedown.models.condensation.surface_mesh import hat_areas


@checked
def contact_problem(
    body: ElasticBody,
    boundary: str,
    f: ArrayLike,
    *,
    against: tuple[ElasticBody, str] | None = None,
    coupling: Literal["nodes", "mortar"] = "nodes",
    reach: float | None = None,
    bolts: Sequence[Bolt] = (),
    modal: Sequence[ModalLoad] = (),
    tangent: ArrayLike | None = None,
    gap: ArrayLike | Callable[[FloatArray], ArrayLike] = 0.0,
    steps: int | None = None,
    name: str = "",
    units: str = "",
) -> Problem:
    """The problem of a body on a rigid obstacle, or on a second body.

    Plane bodies have one direction of slip, solid ones two. The contact may be inclined: normals are
    those of the body's boundary. All reactions are nodal forces; over ``node_area`` they are
    tractions. Labels are the numbers of the nodes in the meshes of the bodies. ``source`` tells, as
    JSON, the materials, meshes, supports and loads.

    Parameters
    ----------
    body
        The first body: slip and gap are its displacements (relative to the second).
    boundary
        Its contact boundary. Nodes that a support holds in every direction are
        left out; a node that a support guides along its normal, as a plane of
        symmetry does, stays.
    f : () or (n,)
        Friction coefficient(s), along the boundary in the direction of slip [–].
    against
        The second body and its contact boundary, with matching nodes unless ``coupling`` says otherwise.
    coupling
        ``"nodes"``: node to node. ``"mortar"``: meshes that need not match (docs/mortar.md); results are at
        the nodes of the first body, which should be the coarser.
    reach
        With a mortar coupling: the largest distance at which facets count as meeting, by default a quarter of
        the size of a facet [length].
    bolts
        What pulls the bodies together.
    modal
        Loads in the shape of modes (:func:`modal_load`). Where nothing supports two bodies and all loads
        are in equilibrium, a statically determinate support holds them while they are condensed, and
        ``source`` says so.
    tangent : (3,) or (n, 3), optional
        For solid bodies: the direction towards which the first tangent points
        (:func:`~shakedown.models.condensation.contact_frame.tangent_pairs`).
    gap : (), (n,) or a function of the nodes' coordinates (2, n) or (3, n), optional
        Initial gap between the bodies [length]; negative is interference.
    steps
        Number of load steps m at which time functions are sampled. Those given as arrays have as many
        factors; without it, a last one that repeats the first, in all of them, is left out, and
        ``warnings`` of the problem says so: the period closes by itself.
    name, units
        As in :class:`shakedown.Problem`.

    Raises
    ------
    ProblemError
        If the bodies do not match, are not held, or a load or the length of its history does not fit.

    Examples
    --------
    >>> import numpy as np
    >>> from shakedown.fem import Displacement, ElasticBody, Material, block_mesh
    >>> press = Displacement("top", x=0.0, y=-1e-3, history=1.0)
    >>> shear = Displacement("top", x=1e-4, y=0.0, history=lambda t: np.sin(2 * np.pi * t))
    >>> body = ElasticBody(block_mesh(2.0, 1.0, 4, 2), Material(1.0, 0.3), loads=[press, shear])
    >>> contact_problem(body, "bottom", 0.5, steps=8).q_w.shape
    (8, 5)
    """
    f, gap = real_array("f", f), gap if callable(gap) else real_array("gap", gap)
    joint = _Joint(body, boundary, against, bolts, coupling, reach, tangent)
    cases, closing = without_closing(joint.cases(steps, modal), steps)
    frame = joint.reduced.frame
    plane = frame.directions == 1
    own, label = joint.numbers.reshape(frame.n, -1)[:, 0], node_names(joint.numbers)
    if plane:
        x = arc_lengths(joint.place, frame.tangents, body.strips(boundary, own, frame.normals))
    else:
        x = patch_positions(joint.place, frame.normals, tangent)
    initial = gap(joint.place.T) if callable(gap) else gap
    area = joint.areas(own, body.thickness)
    return joint.reduced.problem(
        cases,
        f,
        x=x,
        gap=initial,
        name=name,
        units=units,
        label=label,
        coordinates=in_space(joint.place),
        normal=in_space(frame.normals),
        tangent=in_space(frame.tangents) if plane else None,
        node_area=area,
        faces=None if plane else faces_among(np.array(joint.surface.split()), own.tolist()),
        load_names=tuple(case.name for case in cases),
        source=origin_text(
            [(body, boundary), *([] if against is None else [against])],
            steps,
            {
                "friction": f,
                "gap": gap if callable(gap) or np.any(gap) else "none",
                "coupling": None if coupling == "nodes" else coupling,
                "bolts": tuple(bolts),
                "free": "held, statically determinate, for the condensation alone" if joint.free else None,
                "modes": tuple({"mode": load.mode, "frequency": load.frequency} for load in modal),
            },
            (
                *closing,
                *bearing_no_pressure(area, label),
                *(() if joint.coupling is None else joint.coupling.warnings),
            ),
        ),
    )


@checked
def contact_condensation(
    body: ElasticBody,
    boundary: str,
    *,
    against: tuple[ElasticBody, str] | None = None,
    coupling: Literal["nodes", "mortar"] = "nodes",
    reach: float | None = None,
    bolts: Sequence[Bolt] = (),
    tangent: ArrayLike | None = None,
) -> Condensation:
    """The condensed stiffness alone, with its evidence (rigid motions, residual)."""
    return _Joint(body, boundary, against, bolts, coupling, reach, tangent).reduced


@checked
def modal_load(
    body: ElasticBody,
    boundary: str,
    mode: int = 0,
    *,
    against: tuple[ElasticBody, str] | None = None,
    coupling: Literal["nodes", "mortar"] = "nodes",
    reach: float | None = None,
    bolts: Sequence[Bolt] = (),
    open_nodes: Sequence[int] = (),
    history: History | None = None,
) -> ModalLoad:
    """The inertia forces M φ of a mode as a load: what a structure bears that vibrates in this mode.

    The mode is that of the structure with its contact stuck, but for nodes that the preload leaves
    open: long-term states of the joint under its preload tell which (``open_nodes``). Of a load M φ α
    the conjugate displacement is the modal amplitude. Nothing has to support two bodies.

    Parameters
    ----------
    body, boundary, against, coupling, reach, bolts
        As for :func:`contact_problem`; materials need a density.
    mode
        Number of the mode, from 0, by rising frequency; rigid motions do not count.
    open_nodes
        Contact nodes that stay open, in the order of the problem.
    history
        Time function of the modal force α; one sine in a period by default.

    Raises
    ------
    ProblemError
        If the bodies do not match or have no density, or there is no such mode or node.

    Examples
    --------
    >>> from shakedown.fem import ElasticBody, Material, Support, block_mesh
    >>> upper, lower = (block_mesh(4.0, 1.0, 8, 2, origin=(0.0, y)) for y in (1.0, 0.0))
    >>> steel = Material(100.0, 0.3, density=1.0)
    >>> first, second = ElasticBody(upper, steel), ElasticBody(lower, steel)
    >>> load = modal_load(first, "bottom", against=(second, "top"))
    >>> load.free, round(load.frequency, 3)
    (True, 5.526)
    """
    joint = _Joint(body, boundary, against, bolts, coupling, reach)
    opened = node_numbers("open nodes", open_nodes, joint.reduced.n)
    M = sparse.csr_array(sparse.block_diag([loads.mass_of(b) for b in joint.bodies], format="csr"))
    motions = sparse.csr_array(joint.ties @ joint.reduced.motions(opened, released=joint.free))
    rigid = body.dimension * (body.dimension + 1) // 2 if joint.free else 0
    frequency, shape = loads.stuck_mode(joint.stiffness, M, motions, mode, rigid)
    force = np.asarray(M @ shape)
    return ModalLoad(mode, frequency, shape, force, joint.free, loads.sine if history is None else history)


class _Joint:
    """One or two bodies in one numbering, condensed to their contact.

    The contact nodes have the ``numbers`` (n,) or (n, 2) in the meshes of their own bodies. Bodies have the
    unknowns u' of u = T u' (``ties``), fewer than u where boundaries move as rigid bodies.
    """

    def __init__(
        self,
        body: ElasticBody,
        boundary: str,
        against: tuple[ElasticBody, str] | None,
        bolts: Sequence[Bolt],
        coupling: str,
        reach: float | None,
        tangent: ArrayLike | None = None,
    ) -> None:
        self.bodies = [body] if against is None else [body, against[0]]
        if against is not None and against[0].dimension != body.dimension:
            raise ProblemError("contact: expected two plane bodies or two solid ones, found one of each")
        shift = int(body.dofs[:, 0].max()) + 1 + len(body.rigid)  # where the nodes of the second body begin
        self.surface = body.surface(boundary)
        self.coupling: SurfaceCoupling | None = None
        if coupling == "mortar" and against is not None:
            self.coupling = surface_coupling(self.surface, against[0].surface(against[1], shift), reach=reach)
        elif coupling == "mortar" or reach is not None:
            raise ProblemError(
                "coupling, reach: expected a second body beside 'mortar', and it beside a reach"
            )
        nodes, normals = body.normals_on(boundary)
        normals, place = _in_symmetry_planes(body, nodes, normals), body.positions(nodes)
        kept, met, numbers = _not_held(body, nodes), [nodes], nodes
        if self.coupling is not None:
            met.append(self.coupling.master - shift)
            kept = kept[np.isin(nodes[kept], self.coupling.labels)]
        elif against is not None:
            met.append(_matching(place, *against))
            numbers = np.column_stack(met)
        if body.dimension == 2:
            kept = kept[np.concatenate(body.strips(boundary, nodes[kept], normals[kept]))]
        *self.starts, self.size = np.cumsum([0, *(b.basis.N for b in self.bodies)])
        self.bolts = [(bolt, bolt.shortening(self.bodies, self.starts, self.size)) for bolt in bolts]
        K = sparse.block_diag([b.stiffness for b in self.bodies], format="csr")
        shanks = [(bolt.stiffness, shortening) for bolt, shortening in self.bolts]
        self.stiffness = sparse.csr_array(with_shanks(K, shanks))
        held = [b.held_rows() + start for b, start in zip(self.bodies, self.starts, strict=True)]
        self.free = against is not None and not np.concatenate(held).size
        of_bodies = [tied(b, own) for b, own in zip(self.bodies, met, strict=True)]
        self.ties = sparse.csr_array(sparse.block_diag([T for T, _ in of_bodies], format="csr"))
        dofs = np.vstack([own + np.array([k * shift, 0]) for k, (_, own) in enumerate(of_bodies)])
        places = _all_places(self.bodies, shift)
        if self.free:
            inner = np.isin(dofs[:, 0], body.dofs[:, 0]) & ~np.isin(dofs[:, 0], nodes)
            fixed = loads.determinate_rows(dofs, places, np.flatnonzero(inner))
        else:
            fixed = np.flatnonzero(self.ties.T @ np.isin(np.arange(self.size), np.concatenate(held)))
        self.place, self.numbers = place[kept], numbers[kept]
        self.middle_nodes = self.surface.middle_nodes
        self.reduced = condensed_stiffness(
            self.ties.T @ self.stiffness @ self.ties,
            dofs,
            self.numbers + ([0, shift] if numbers.ndim > 1 else 0),
            normals[kept],
            fixed=fixed,
            tangent=tangent,
            coupling=self.coupling,
            middle_nodes=self.middle_nodes,
            places=places if body.dimension == 3 else None,
            allow_sparse=True,  # one layer of elements
        )

    def areas(self, own: IntArray, thickness: float) -> FloatArray:
        """The area that each node stands for, in the basis of the contact.

        With a mortar coupling only what the second body covers counts.
        """
        if self.coupling is None:
            area = self.surface.node_areas()[np.searchsorted(self.surface.labels, own)]
            return without_cancelled(thickness * hat_areas(area, own, self.middle_nodes))
        covered = dict(zip(self.coupling.labels.tolist(), self.coupling.area.tolist(), strict=True))
        return thickness * np.array([covered[node] for node in own.tolist()])

    def cases(self, steps: int | None, modal: Sequence[ModalLoad] = ()) -> list[LoadCase]:
        """The load cases of all bodies, then the preloads, then the modes."""
        found = [
            case
            for b, start in zip(self.bodies, self.starts, strict=True)
            for load in b.loads
            for case in load.cases(b, steps, slice(start, start + b.basis.N), self.size)
        ]
        for bolt, shortening in self.bolts:
            if bolt.preload:
                history = loads.sampled(bolt.history, steps, "Bolt")
                found.append(LoadCase(history=history, force=bolt.preload * shortening, name="bolt"))
        for load in modal:
            if load.force.shape != (self.size,):
                raise ProblemError(f"mode {load.mode}: expected the mode of these bodies, found another")
            history = loads.sampled(load.history, steps, "ModalLoad")
            mode = f"mode {load.mode}"
            found.append(LoadCase(history=history, force=load.force, frequency=load.frequency, name=mode))
        if not found:
            raise ProblemError("loads: expected at least one load on a body, found none")
        if self.free:
            places = np.concatenate([b.basis.doflocs.T for b in self.bodies])
            loads.check_balanced(found, places, np.concatenate([b.dofs[:, 1] for b in self.bodies]))
        return [_reduced(case, self.ties) for case in found]


def _reduced(case: LoadCase, ties: sparse.csr_array) -> LoadCase:
    """A load case in the unknowns of bodies with rigid boundaries (:func:`~shakedown.fem.body.tied`)."""
    parts = {key: getattr(case, key) for key in ("force", "displacement")}
    return replace(case, **{key: ties.T @ part for key, part in parts.items() if part is not None})


def _all_places(bodies: Sequence[ElasticBody], shift: int) -> dict[int, list[float]]:
    """Where the nodes of all bodies are, by their labels in the common numbering."""
    own = [body.positions(np.arange(body.dofs[:, 0].max() + 1)).tolist() for body in bodies]
    return {k * shift + node: place for k, places in enumerate(own) for node, place in enumerate(places)}


def _in_symmetry_planes(body: ElasticBody, nodes: IntArray, normals: FloatArray) -> FloatArray:
    """Normals without their components along directions that a support holds, where these are small.

    At the end of a curved boundary on a plane of symmetry there is only one facet, tilted by half the angle
    of an element. The mean of its normal and that of its mirror image lies in the plane.
    """
    held = body.dofs[body.held_rows()]
    inside = normals.copy()
    for direction in range(1, body.dimension + 1):
        inside[np.isin(nodes, held[held[:, 1] == direction, 0]), direction - 1] = 0.0
    length = np.linalg.norm(inside, axis=1)
    keep = length < np.cos(np.pi / 8)  # held along the normal, not across it
    inside[keep], length[keep] = normals[keep], 1.0
    return inside / length[:, None]


def _matching(place: FloatArray, other: ElasticBody, boundary: str) -> IntArray:
    """The nodes of the second body that lie where the first body's contact nodes are."""
    nodes, _ = other.normals_on(boundary)
    distance, nearest = KDTree(other.positions(nodes)).query(place)
    reach = 1e-6 * max(np.ptp(place, axis=0).max(), np.finfo(float).tiny)
    if len(nodes) != len(place) or distance.max() > reach:
        raise ProblemError(
            f"contact: expected matching nodes on both bodies, found {len(place)} and {len(nodes)} nodes, "
            f"up to {distance.max():.3g} apart"
        )
    return nodes[nearest]


def _not_held(body: ElasticBody, nodes: IntArray) -> IntArray:
    """Which contact nodes can move: positions of those that no support holds in every direction."""
    held = body.dofs[body.held_rows(), 0]
    labels, count = np.unique(held, return_counts=True)
    kept = np.flatnonzero(~np.isin(nodes, labels[count == body.dimension]))
    if kept.size == 0:
        raise ProblemError("contact: expected contact nodes that can move, found all of them held")
    return kept
