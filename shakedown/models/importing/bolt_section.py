"""``[[bolt]]``: a preload, and what keeps it: a shank between two node sets, or a section of the deck."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from shakedown.ground.constants import NEGLIGIBLE, SIX_DIGITS, FloatArray, IntArray
from shakedown.ground.errors import ProblemError
from shakedown.ground.shown_values import few
from shakedown.models.condensation.factorised_interior import WeldedCase
from shakedown.models.condensation.load_case import LoadCase
from shakedown.models.importing.load_section import LoadSection
from shakedown.models.importing.stiffness_section import ImportContext
from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.parsing import quoted
from shakedown.models.readers.toml_table import TomlTable, labels_of, shown


@dataclass(frozen=True, eq=False)
class BoltSection:
    """One bolt.

    Attributes
    ----------
    preload : float
        What it carries once it is tightened and nothing else acts [force].
    stiffness : float
        Stiffness of the shank [force/length]; 0 for a section of the deck, as the matrix has the bolt itself.
    unit : LoadCase
        A force of 1 in the shank on what it pulls together, or a shortening of the section by 1.
    rows : (r,)
        The row of the section, which is held.
    along : (3,) or None
        Unit vector along a shank, from the head to the nut.
    """

    preload: float
    stiffness: float
    unit: LoadCase
    rows: IntArray
    along: FloatArray | None

    def pull(self, own: WeldedCase, other: WeldedCase) -> float:
        """By how much a load at factor 1 raises the force in the bolt while the contact is welded [force].

        ``own`` is what ``unit`` does.
        """
        way = own.conjugate(other)
        return -way if self.rows.size else -self.stiffness * way

    def load(self, own: WeldedCase, force_unit: str) -> LoadSection:
        """The preload as a load: large enough to leave ``preload`` once the contact has given way."""
        left = self.pull(own, own) + (0.0 if self.rows.size else 1.0)
        factor, unit = self.preload / left, self.unit
        force = None if unit.force is None else factor * unit.force
        displacement = None if unit.displacement is None else factor * unit.displacement
        whole = replace(unit, force=force, displacement=displacement)
        stated = replace(whole, value=self.preload, unit=force_unit) if self.preload else whole
        return LoadSection(stated, self.rows)


def bolt_section(table: TomlTable, context: ImportContext) -> BoltSection:
    """Take one bolt from its table.

    Raises
    ------
    ProblemError
        If it is malformed, a set is unknown, or the deck has no such section.
    """
    name = table.text("name", table.where) or table.where
    preload, transient = table.number("preload"), table.array("transient", float, (None,), required=False)
    if preload is None or preload < 0:
        found = "none" if preload is None else f"{preload:g}"
        raise table.wrong("preload", "a force >= 0", found)
    section, size = table.integer("section"), len(context.stiffness.dofs)
    unit = np.zeros(size)
    rows, stiffness, along = np.zeros(0, dtype=np.intp), 0.0, None
    if section is None:
        (unit, along), stiffness = _shortening(table, context), _stiffness(table)
    else:
        rows = np.flatnonzero((context.stiffness.dofs == (-section, 1)).all(axis=1))
        if section not in context.mesh.sections or not rows.size:
            expected = "the node of a *PRE-TENSION SECTION of the deck, with a row in the matrix (not held)"
            raise table.wrong("section", expected, section)
        unit[rows] = 1.0
    table.done()
    force, moved = (unit, None) if section is None else (None, unit)
    case = LoadCase(history=1.0, transient=transient, name=name, force=force, displacement=moved)
    return BoltSection(preload, stiffness, case, rows, along)


def check_bolts(tables: Sequence[TomlTable], others: Sequence[TomlTable], mesh: Mesh, where: str) -> None:
    """Refuse a section of the deck without its bolt, and a static run in which a shank was missing."""
    named = [table.content.get("section") for table in tables]
    lacking = [node for node in mesh.sections if node not in named]
    if lacking:
        raise ProblemError(
            f"{where}: expected a [[bolt]] with section = {lacking[0]} and its preload, for the *PRE-TENSION "
            "SECTION of the deck, found none"
        )
    runs = [(other, key) for other in others for key in ("reactions", "open") if other.has(key)]
    if runs and None in named:
        other, key = runs[0]
        raise other.wrong(
            key,
            "'forces' or 'displacements' beside a [[bolt]] with a 'head'",
            "a static run, in which its shank was missing",
        )


def bolt_notes(
    bolts: Sequence[BoltSection], names: Sequence[str], welded: Sequence[WeldedCase], pulls: FloatArray
) -> Iterator[str]:
    """What every load adds to the force in every bolt, whose own loads are the last ones.

    ``pulls`` has a row for every bolt, a column for every load.
    """
    round_off = [NEGLIGIBLE * np.abs(load.reactions).sum() for load in welded]
    for own, (bolt, added_by) in enumerate(zip(bolts, pulls, strict=True), len(names) - len(bolts)):
        added = [
            f"{quoted(name)} adds {few(pull if abs(pull) > least else 0.0, 3)}"
            for k, (name, least, pull) in enumerate(zip(names, round_off, added_by.tolist(), strict=True))
            if k != own and not np.isnan(pull)
        ]
        way = ""
        if bolt.along is not None:
            way = f" along ({', '.join(few(part, 3) for part in np.round(bolt.along, 3) + 0.0)})"
        yield (
            f"bolt {quoted(names[own])} carries {few(bolt.preload, 4)}{way} once tightened; while "
            f"the contact stays closed and sticks, {', '.join(added) or 'nothing else acts'} at factor 1"
        )


def check_held(bolts: Sequence[BoltSection], held: IntArray, dofs: IntArray) -> None:
    """Refuse a bolt whose head or nut is held, by a support or a load, where the shank pulls."""
    for bolt in bolts:
        if bolt.unit.force is not None and (on := held[bolt.unit.force[held] != 0]).size:
            node, direction = dofs[on[0]].tolist()
            raise ProblemError(
                f"bolt {quoted(bolt.unit.name.rpartition(': ')[2])}: expected free nodes under head and nut, "
                f"found direction {direction} of node {node} held"
            )


def _stiffness(table: TomlTable) -> float:
    """Axial stiffness of the shank, as it is given or E A / l [force/length]."""
    keys = ("stiffness", "area", "length", "young")
    given = {key: value for key in keys if (value := table.number(key)) is not None}
    if [*given] not in (["stiffness"], [*keys[1:]]):
        found = ", ".join(map(quoted, given)) or "none"
        raise table.unfit("'stiffness' of the shank, or 'area', 'length' and 'young'", found)
    for key, value in given.items():
        if value < 0 or (value == 0 and key != "stiffness"):
            raise table.wrong(key, "a number > 0", f"{value:g}")
    return given["stiffness"] if "stiffness" in given else given["young"] * given["area"] / given["length"]


def _shortening(table: TomlTable, context: ImportContext) -> tuple[FloatArray, FloatArray]:
    """e of the shank's shortening e · u (how far its ends approach), (N,), and its axis."""
    ends = [_bolt_end(table, key, context) for key in ("head", "nut")[: 1 + table.has("nut")]]
    axis = table.array("axis", float, (3,), required=False)
    places, shares = [context.mesh.at(labels) for labels, _ in ends], [share for _, share in ends]
    along = _across_head(places, shares, context) if axis is None else np.array(axis)
    if not np.linalg.norm(along) > 0:
        raise table.unfit(
            "a nut apart from the head, or an 'axis' from the head along the shank",
            "none" if axis is None else shown(axis),
        )
    along = along / np.linalg.norm(along)
    middle = shares[0] @ places[0]
    if len(ends) == 2 and not along @ (shares[1] @ places[1] - middle) > 0:
        raise table.wrong("axis", "a direction from the head towards the nut", shown(axis))
    found = np.zeros(len(context.stiffness.dofs))
    if len(ends) == 2 and not context.mesh.axisymmetric:  # rings make no couple
        shares[1] = _about(middle, along, places[1], shares[1], table)
    for (labels, _), share, sign in zip(ends, shares, (1.0, -1.0), strict=False):
        for direction in np.flatnonzero(along).tolist():
            keys = dict.fromkeys(((label, direction + 1) for label in labels.tolist()), 0.0)
            found[context.rows(table.where, keys)] += sign * along[direction] * share
    return found, along


def _across_head(
    places: Sequence[FloatArray], shares: Sequence[FloatArray], context: ImportContext
) -> FloatArray:
    """The direction from head to nut: across a flat head, else to the middle of the nut; zero without a nut.

    Head and nut of two meshes hardly ever have their middles opposite each other, and slip would tighten a
    shank that leans.
    """
    if len(places) == 1:
        return np.zeros(3)
    way = shares[1] @ places[1] - shares[0] @ places[0]
    head = places[0] - shares[0] @ places[0]
    if len(context.contact.axes) == 2:  # a line, as deep as it is wide
        deep = np.setdiff1d([0, 1, 2], np.array(context.contact.axes) - 1)
        head = np.vstack([head, np.abs(head).max() * np.eye(3)[deep]])
    _, sizes, axes = np.linalg.svd(np.vstack([head, np.zeros((3, 3))]), full_matrices=False)
    flat, across = SIX_DIGITS * sizes[1] >= sizes[2] and sizes[1] > SIX_DIGITS * sizes[0], axes[2] @ way
    # a shank that leans more does not stand across its head
    stands = flat and abs(across) > np.cos(np.radians(60.0)) * np.linalg.norm(way)
    return np.sign(across) * axes[2] if stands else np.asarray(way)


def _about(
    middle: FloatArray, along: FloatArray, places: FloatArray, share: FloatArray, table: TomlTable
) -> FloatArray:
    """Shares of the nut's nodes with a resultant on the axis of the head, so that the ends make no couple.

    They are as even as that allows: the even shares times a function that is linear over the nut.
    """
    off = places - middle
    off = off - np.outer(off @ along, along)
    size = max(np.abs(off).max(), np.ptp(places, axis=0).max(), SIX_DIGITS * np.linalg.norm(places - middle))
    moments = np.column_stack([np.ones(len(off)), off / size])
    changed = share * (moments @ np.linalg.pinv(moments.T @ (share[:, None] * moments))[:, 0])
    left = np.abs(moments.T @ changed - [1.0, 0.0, 0.0, 0.0]).max()
    if not left <= SIX_DIGITS or changed.min() < -NEGLIGIBLE:
        away = few(float(np.linalg.norm(share @ off)), 3)
        raise table.unfit("nodes of the nut around the axis of the head", f"their middle {away} beside it")
    return np.asarray(changed)


def _bolt_end(table: TomlTable, key: str, context: ImportContext) -> tuple[IntArray, FloatArray]:
    """The nodes of a node set (or one node), and the share of an even pressure that each carries."""
    value = table.take(key, "a node set, or a node", required=True)
    where, mesh = table.at(key), context.mesh
    labels = labels_of(mesh, value, where)
    surface = value.strip().upper() if isinstance(value, str) else ""
    area = mesh.node_areas(labels, surface if surface in mesh.surfaces else None) if mesh.elements else None
    share = np.ones(len(labels)) if area is None or not area.sum() > 0 else area
    return labels, share / share.sum()
