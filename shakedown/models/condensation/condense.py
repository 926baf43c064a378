"""Static condensation of an elastic model to its contact nodes."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from shakedown.ground.argument_kinds import checked
from shakedown.ground.constants import FloatArray, Mask
from shakedown.ground.errors import ProblemError
from shakedown.ground.tolerances import DEFAULT
from shakedown.joint.constraints import with_initial_gap
from shakedown.joint.fields import DOMAIN, LOOP
from shakedown.joint.law import Layout
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.rigid_slips import basis_of, deflated, zero_modes
from shakedown.models.condensation import contact_frame, stiffness_checks
from shakedown.models.condensation.contact_frame import ContactFrame
from shakedown.models.condensation.factorised_interior import Interior, WeldedCase, interior_of
from shakedown.models.condensation.load_case import LoadCase, histories, stated_loads
from shakedown.models.condensation.surface_mesh import NodeCoupling


@dataclass(frozen=True, eq=False, repr=False)
class Condensation(Result):
    """An elastic model reduced to slip and gap, with evidence for its correctness.

    Attributes
    ----------
    frame : ContactFrame
        Contact nodes, normals and tangents.
    stiffness : ((d + 1) n, (d + 1) n)
        κ = [[A, Bᵀ], [B, C]] (thesis (2.10), (2.11)) [force/length]; d tangential directions, slips
        node by node.
    interior, held : int
        Rows that were condensed out, and rows that do not move.
    zero_modes : int
        Motions of the contact nodes that meet no resistance: 0 for a supported
        body, up to 3 (in space 6) for one that is held by the contact alone.
    asymmetry : float
        Largest |κ − κᵀ| before it was averaged away, relative to max |κ|.
    residual : float
        Largest force left on the interior by the unit contact displacements,
        relative to the largest contact force.
    notes : tuple of str
        What a user should know: rows taken as held, rows without stiffness,
        a floating body.
    """

    frame: ContactFrame
    stiffness: FloatArray
    interior: int
    held: int
    zero_modes: int
    asymmetry: float
    residual: float
    notes: tuple[str, ...]
    _model: Interior

    @property
    def n(self) -> int:
        """Number of contact nodes."""
        return self.frame.n

    @property
    def layout(self) -> Layout:
        """Where the slip and the gap of a node stand."""
        return self.frame.layout

    @property
    def A(self) -> FloatArray:
        """Tangential stiffness, (dn, dn) [force/length]."""
        return self.layout.blocks(self.stiffness)[0]

    @property
    def B(self) -> FloatArray:
        """Coupling p = B v, (n, dn) [force/length]."""
        return self.layout.blocks(self.stiffness)[1]

    @property
    def C(self) -> FloatArray:
        """Normal stiffness, (n, n) [force/length]."""
        return self.layout.blocks(self.stiffness)[2]

    def welded(self, case: LoadCase) -> WeldedCase:
        """What a load case at factor 1 does with all nodes welded; the interior is solved: worth keeping.

        Raises
        ------
        ProblemError
            If an array of the case does not fit the model, or a displacement is
            prescribed at a row that is not held.
        """
        total, expected = self.layout.zeros(), (self.n, self.layout.d + 1)
        for key in ("reactions", "opened"):
            given = getattr(case, key)
            if given is not None and given.shape != expected:
                raise ProblemError(f"{case.name}: {key}: expected shape {expected}, found {given.shape}")
        if case.reactions is not None:
            total += self.frame.to_local(self.frame.carried(case.reactions))
        if case.opened is not None:  # reactions that close the contact again: 0 = κ u + r_w
            total -= self.stiffness @ self._opened(case.opened)
        elsewhere = case.reactions is not None or case.opened is not None
        if case.force is not None or case.displacement is not None:
            welded = self._model.welded(case)
            if not elsewhere:
                return welded
            total += welded.reactions
        return WeldedCase(total, *[np.full(self._model.K.shape[0], np.nan)] * 4)

    def motions(self, open_nodes: Sequence[int] = (), *, released: bool = False) -> sparse.csr_array:
        """The motions, (N, k), that the model has while its contact sticks but for some open nodes.

        With ``released`` the held rows can move too.
        """
        model, opened = self._model, self.layout.of_nodes(list(open_nodes))
        columns = [model.T_i, model.T_c[:, opened], *([model.T_h] if released else [])]
        found = sparse.csc_array(sparse.hstack(columns, format="csc"))
        return sparse.csr_array(found[:, np.diff(found.indptr) > 0])

    def _opened(self, apart: FloatArray) -> FloatArray:
        """Displacements of the contact nodes (n, d + 1), with a coupling û₁ − P u₂, as slips and gaps."""
        frame = self.frame
        return frame.to_local(apart if frame.coupled else frame.weighted(apart))

    def check_against_run(
        self, displacement: ArrayLike, reactions: ArrayLike, *, what: str = "static run"
    ) -> float:
        """Compare with a static run of the same model, without loads.

        Parameters
        ----------
        displacement, reactions : (n, d + 1)
            Prescribed displacements (x, y[, z]) of the contact nodes [length], and the
            forces on the (first) body that the run gave for them [force].
        what
            The run, for the message.

        Returns
        -------
        float
            Largest difference, relative to the largest reaction.

        Raises
        ------
        ProblemError
            If they are not (n, d + 1), or differ by more than ``Tolerances.cross_check``;
            a wrong sign or factor is named.
        """
        moved, forces = np.asarray(displacement, dtype=float), np.asarray(reactions, dtype=float)
        expected = (self.n, self.layout.d + 1)
        if moved.shape != expected or forces.shape != expected:
            raise ProblemError(
                f"{what}: expected displacements and reactions of shape {expected}, "
                f"found {moved.shape} and {forces.shape}"
            )
        reaction = self.frame.to_local(self.frame.carried(forces))
        predicted = self.stiffness @ self._opened(moved)
        size = max(float(np.abs(reaction).max()), np.finfo(float).tiny)
        error = float(np.abs(predicted - reaction).max() / size)
        if error <= DEFAULT.cross_check:
            return error
        hint, along = "", float(predicted @ reaction) / max(float(reaction @ reaction), np.finfo(float).tiny)
        if np.abs(predicted - along * reaction).max() <= DEFAULT.cross_check * abs(along) * size:
            hint = f"; they differ by the factor {along:.6g}" + (" (wrong sign)" if along < 0 else "")
        raise ProblemError(
            f"{what}: expected the reactions of the condensed stiffness to {DEFAULT.cross_check:g}, found a "
            f"relative difference of {error:.2g}{hint}"
        )

    def problem(
        self,
        loads: Sequence[LoadCase],
        f: ArrayLike,
        *,
        gap: ArrayLike = 0.0,
        welded: Sequence[WeldedCase] | None = None,
        **about: Any,
    ) -> Problem:
        """The problem with these loads and friction coefficients, () or (n,), and an initial gap.

        The gap [length] is a number, or one per node or pair; negative is interference. Where a
        load has a range, the load steps are the corners of a load domain (``load_path``). ``welded`` is what
        :meth:`welded` has found of the loads, where that is known already; ``about`` are other fields of the
        problem, as ``x``, ``name`` and ``units``.
        """
        factors = histories(loads)
        welded = [self.welded(case) for case in loads] if welded is None else welded
        unit = np.array([each.reactions for each in welded])
        modal = [case.frequency for case in loads]  # NaN: no mode
        # the displacement conjugate to each load under a unit of each
        S = np.array([[one.conjugate(other) for other in welded] for one in welded])
        acting: dict[str, Any] = {"label": self.frame.names, **stated_loads(loads, factors)}
        if self.layout.d > 1:
            acting |= {"normal": self.frame.normals, "tangents": self.frame.tangents}
        for part, factor in (("w", factors.period), ("mean", factors.mean), ("transient", factors.transient)):
            if factor is not None:
                acting[f"q_{part}"], acting[f"p_{part}"] = self.layout.split(factor @ unit)
        touching = Problem(
            A=self.A,
            B=self.B,
            C=self.C,
            f=f,
            load_reactions=unit,
            load_history=factors.period,
            load_compliance=None if np.isnan(S).any() else 0.5 * (S + S.T),
            load_frequency=None if all(each is None for each in modal) else np.array(modal, dtype=float),
            load_path=DOMAIN if any(case.range is not None for case in loads) else LOOP,
            **{**acting, **about},
        )
        initial = np.asarray(gap)
        if initial.ndim == 1 and len(initial) == self.n:
            initial = self.frame.weighted(initial)
        return with_initial_gap(touching, initial) if initial.any() else touching


@checked
def condense(
    K: sparse.sparray | sparse.spmatrix | FloatArray,
    dofs: ArrayLike,
    contact: ArrayLike,
    normals: ArrayLike,
    loads: Sequence[LoadCase],
    f: ArrayLike,
    *,
    x: ArrayLike | None = None,
    gap: ArrayLike = 0.0,
    name: str = "",
    units: str = "",
    **options: Any,
) -> Problem:
    """Reduce an elastic model of one or two bodies to a problem in slip and gap.

    Normals of three components give every node two tangential directions. The short form of
    ``condensed_stiffness(...).problem(loads, f)``; see
    :func:`condensed_stiffness` for ``K`` to ``normals``.

    Parameters
    ----------
    loads
        Load cases, each with its time function.
    f : () or (n,)
        Friction coefficient(s) [–].
    gap : () or (n,)
        Initial gap per node or pair [length]; negative is interference.
    x, name, units
        As in :class:`shakedown.Problem`.
    options
        What :func:`condensed_stiffness` takes by name, from ``fixed`` to ``middle_nodes``.

    Raises
    ------
    ProblemError
        As :func:`condensed_stiffness`; or if a load does not fit the model.

    Examples
    --------
    A node on a rigid plane, hung from a held node by an inclined spring:

    >>> import numpy as np
    >>> spring = np.array([[2.0, 1.0], [1.0, 3.0]])
    >>> K = np.block([[spring, -spring], [-spring, spring]])
    >>> push = LoadCase(history=[1.0, 0.5], displacement=[0, 0, 0.0, -1.0])
    >>> dofs = [(1, 1), (1, 2), (2, 1), (2, 2)]
    >>> joint = condense(K, dofs, [1], [0, 1], [push], f=0.4, fixed=[2, 3])
    >>> joint.B, joint.p_w.ravel()
    (array([[1.]]), array([3. , 1.5]))

    A node in space, on springs of its own:

    >>> push = LoadCase(history=[1.0], force=[0.5, 0.25, -3.0])
    >>> joint = condense(
    ...     np.diag([2.0, 4.0, 8.0]), [(1, 1), (1, 2), (1, 3)], [1], [0, 0, 1], [push], 0.4, tangent=[0, 1, 0]
    ... )
    >>> joint.directions, joint.A.tolist(), joint.q_w.tolist(), joint.tangents[0].tolist()
    (2, [[4.0, 0.0], [0.0, 2.0]], [[-0.25, 0.5]], [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    """
    reduced = condensed_stiffness(K, dofs, contact, normals, **options)
    return reduced.problem(loads, f, x=x, gap=gap, name=name, units=units)


@checked
def condensed_stiffness(
    K: sparse.sparray | sparse.spmatrix | FloatArray,
    dofs: ArrayLike,
    contact: ArrayLike,
    normals: ArrayLike,
    *,
    fixed: ArrayLike = (),
    axes: tuple[int, int] = contact_frame.PLANE,
    tangent: ArrayLike | None = None,
    allow_sparse: bool = False,
    coupling: NodeCoupling | None = None,
    middle_nodes: ArrayLike | None = None,
    places: Mapping[int, Sequence[float]] | None = None,
    rigid: FloatArray | None = None,
) -> Condensation:
    """Condense a stiffness matrix to the contact nodes, κ = K_cc − K_ci K_ii⁻¹ K_ic.

    One sparse factorization of the interior serves all (d + 1) n right-hand sides and
    all loads. Memory: the factors (about 10 N log₂N numbers in two dimensions),
    64 dense vectors of length N, and κ; a 200 × 50 mesh (N = 20,502) takes 50 MB. A large solid is cut
    into pieces by where its nodes are (nested dissection, Cholesky): 40,000 nodes with 700 pairs take 2 GB.

    Parameters
    ----------
    K : (N, N)
        Symmetric stiffness, sparse or dense [force/length]. A diagonal entry of
        1e35 or more is the mark that Abaqus leaves on a constrained row: the row
        is taken as held.
    dofs : (N, 2)
        Node label and direction of every row. Directions 1, 2, 3 are x, y, z;
        others (rotations, pressures, multipliers; negative labels) are condensed
        like any other unknown.
    contact : (n,) or (n, 2)
        Contact nodes against a rigid obstacle, or matching pairs (node of the
        first body, node of the second). Slip and gap are then u₁ − u₂. A slip
        that is held while the normal is free (a plane of symmetry) gets a spring
        of its own in A, coupled to nothing, so that it stays zero.
    normals : (2,) or (n, 2), in space (3,) or (n, 3)
        Contact normals, pointing into the first body. With three components, along x, y, z, every
        node has two tangential directions.
    fixed : (k,) int or (N,) bool
        Rows of K that are held, or move by what a load case prescribes.
    axes
        The two directions that span the plane of a plane problem.
    tangent : (3,) or (n, 3) or (n, 2, 3), optional
        In space the direction towards which the first tangent leads, one for all or one per node, or
        a pair per node (:func:`~shakedown.models.condensation.contact_frame.tangent_pairs`). A node that is
        held in one direction takes that as a tangent.
    allow_sparse
        Accept a matrix that holds contact nodes only and yet couples few of them.
    coupling
        The coupling of two bodies whose meshes do not match
        (:func:`~shakedown.models.condensation.surface_coupling.surface_coupling`): ``contact`` are
        then nodes of its first surface, slip and gap are u₁ − P u₂.
    middle_nodes : (t, 3), optional
        For quadratic faces with six or eight nodes: (node between two corners, these corners). With the
        change of basis the corners carry a share of a pressure, of which they otherwise carry nothing or the
        opposite; slips, gaps and forces at the nodes between them are then weighted ones (docs/mortar.md).
    places
        Node → (x, y, z) [length]: for the message about an interior that can move, and the pieces into
        which a large solid is cut (without them it is factorised as a whole, which takes longer).
    rigid : (N, k), optional
        Motions that meet no resistance. What the digits of a printed matrix leave of one is taken out of κ.

    Raises
    ------
    ProblemError
        If K is not symmetric, real and finite; if a contact row is missing or
        held; if the interior can move without resistance; if K holds contact
        nodes only but is sparse, as a matrix that was never condensed is; if a large solid takes more
        memory than there is.
    """
    table = contact_frame.checked_dofs(dofs)
    matrix, constrained = stiffness_checks.checked_matrix(K, table)
    frame = contact_frame.contact_frame(
        table, contact, normals, axes=axes, tangent=tangent, coupling=coupling, middle_nodes=middle_nodes
    )
    held = _held_rows(fixed, constrained, len(table))
    frame, guided = contact_frame.with_guides(frame, table, held)
    across = contact_frame.out_of_plane_notes(frame, table, held, axes)
    if not allow_sparse and np.isin(table[~held, 0], frame.labels).all():
        found = stiffness_checks.uncoupled(matrix[~held][:, ~held], table[~held, 0])
        if found:
            raise ProblemError(f"K: expected a condensed matrix, {found}")
    empty = ~held & (np.diff(matrix.indptr) == 0)
    interior = interior_of(matrix, table, frame, held | empty, guided, places)
    stiffness, residual = interior.schur()
    error = stiffness_checks.asymmetry(stiffness)
    if error > DEFAULT.symmetry:
        raise ProblemError(
            f"K: expected a symmetric condensed matrix, found an asymmetry of {error:.2g}; its interior "
            f"resists least: {interior.loosest(table, places)}"
        )
    stiffness = 0.5 * (stiffness + stiffness.T)
    if rigid is not None and rigid.size:
        stiffness = deflated(stiffness, basis_of(interior.contact_motions(rigid)))
    A, _, _ = frame.layout.blocks(stiffness)
    A += np.diag(np.where(guided, A.max(), 0.0))
    modes = zero_modes(stiffness)
    return Condensation(
        frame=frame,
        stiffness=stiffness,
        interior=interior.T_i.shape[1],
        held=int(held.sum()),
        zero_modes=modes,
        asymmetry=error,
        residual=residual,
        notes=(*_notes(frame, guided, constrained, empty, modes), *across),
        _model=interior,
    )


def _held_rows(fixed: ArrayLike, constrained: Mask, size: int) -> Mask:
    rows, held = np.asarray(fixed), constrained.copy()
    if not rows.size:
        return held
    flags = rows.dtype == bool and rows.shape == (size,)
    if not flags and not (
        rows.ndim == 1 and rows.dtype.kind in "iu" and 0 <= rows.min() <= rows.max() < size
    ):
        raise ProblemError(f"fixed: expected row numbers 0 to {size - 1} or a flag for each, found {rows!r}")
    held[rows] = True
    return held


def _notes(
    frame: ContactFrame,
    guided: Mask,
    constrained: Mask,
    empty: Mask,
    modes: int,
) -> Iterator[str]:
    on_planes = np.flatnonzero(frame.layout.by_node(guided).any(axis=1))
    if on_planes.size:
        yield (
            f"{on_planes.size} contact node(s) are held along a tangent (a plane of symmetry), the first "
            f"{frame.names[on_planes[0]]}: these slips are coupled to nothing and stay zero"
        )
    if constrained.any():
        yield f"{constrained.sum()} rows carry 1e36 on the diagonal and were taken as held"
    if empty.any():
        yield f"{empty.sum()} rows without any stiffness were taken as held"
    if modes:
        yield (
            f"floating: {modes} rigid motion(s) of the contact nodes meet no resistance; the body is held "
            "by the contact alone"
        )
    if weighted := len(frame.middle_nodes):
        yield (
            f"quadratic faces: slips, gaps and forces at {weighted} node(s) between corners are weighted "
            "ones, so that every node carries a share of a pressure (docs/mortar.md)"
        )
