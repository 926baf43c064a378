"""A discrete elastic contact with Coulomb friction and one period of its loading; read-only data."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from contextlib import nullcontext
from dataclasses import dataclass, field, fields, is_dataclass
from functools import cached_property, wraps
from typing import TYPE_CHECKING, Any, Generic, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.constants import FloatArray, T
from shakedown.ground.errors import ProblemError
from shakedown.ground.shown_values import one_line, same, shortened, visible
from shakedown.joint.fields import (
    DOMAIN,
    LOOP,
    NAMES,
    OF_NODES,
    TEXTS,
    Axes,
    check_shapes,
    check_values,
    load_path,
    names,
    origin,
    plain_text,
    real_numbers,
)
from shakedown.joint.law import Law, Layout, layout_of
from shakedown.joint.places import checked_faces, faces_among


class ReadOnly:
    """Base of frozen dataclasses whose arrays are read-only, and those in their parts.

    Tuples, lists, dictionaries and frozen dataclasses are parts, and so is what a ``cached_property``
    works out later. Arrays that somebody else holds as well stay as they are: here is a view of them.
    A copy, shallow or deep, and what comes out of a pickle is read-only again. A class with a
    ``__post_init__`` of its own calls this one at its end.

    Examples
    --------
    >>> import copy
    >>> from dataclasses import dataclass
    >>> @dataclass(frozen=True)
    ... class Slip(ReadOnly):
    ...     slip: np.ndarray
    >>> given = np.zeros(2)
    >>> made = Slip(given)
    >>> [array.flags.writeable for array in (made.slip, copy.deepcopy(made).slip, given)]
    [False, False, True]
    """

    def __init_subclass__(cls, **words: Any) -> None:
        super().__init_subclass__(**words)
        for attribute in vars(cls).values():
            if isinstance(attribute, cached_property):
                attribute.func = _read_only_once_found(attribute.func)
                if hasattr(attribute, "lock"):  # one for all objects, up to Python 3.11: threads would wait
                    attribute.lock = nullcontext()

    def __post_init__(self) -> None:
        for name, value in list(self.__dict__.items()):
            if (held := read_only(value)) is not value:
                self.__dict__[name] = held

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        ReadOnly.__post_init__(self)


def _read_only_once_found(find: Any) -> Any:
    @wraps(find)
    def found(self: Any) -> Any:
        return read_only(find(self))

    return found


def read_only(value: Any) -> Any:
    """The same value, its arrays as read-only views; the value itself where nothing in it can be written.

    Examples
    --------
    >>> given = np.zeros(2), "slip"
    >>> read_only(given)[0].flags.writeable, given[0].flags.writeable
    (False, True)
    """
    kind = type(value)
    if kind is np.ndarray:
        view = value.view() if value.flags.writeable else value
        view.flags.writeable = False
        return view
    if kind in (tuple, list) or (isinstance(value, tuple) and hasattr(value, "_fields")):
        parts = [read_only(part) for part in value]
        if all(new is old for new, old in zip(parts, value, strict=True)):
            return value
        return value._make(parts) if hasattr(value, "_make") else kind(parts)
    if kind is dict:
        entries = {key: read_only(part) for key, part in value.items()}
        return entries if any(entries[key] is not part for key, part in value.items()) else value
    if is_dataclass(kind) and kind.__dataclass_params__.frozen and not issubclass(kind, ReadOnly):  # type: ignore[attr-defined]
        ReadOnly.__post_init__(value)
    return value


def stored(axes: str) -> Any:
    """A field with an array of these axes, or names; as fields.py calls them."""
    names = tuple(int(axis) if axis.isdigit() else axis for axis in axes.split())
    return field(default=None, metadata={"axes": names})


if TYPE_CHECKING:

    class Stored(Generic[T]):
        """A field that takes whatever NumPy converts to an array, and holds a checked copy."""

        def __get__(self, instance: object, owner: object) -> T: ...
        def __set__(self, instance: object, value: ArrayLike | None) -> None: ...


class NamedLoad(NamedTuple):
    """A load case as its user knows it: at a load factor λ it is mean ± λ · amplitude [unit]."""

    name: str
    mean: float
    amplitude: float
    unit: str


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Problem(ReadOnly):
    """Contact stiffness, friction and loading loop of a joint, validated on construction.

    The reactions at the n contact nodes are (thesis (2.10), (2.11))

        q = q_w(t) + A v + Bᵀ w,        p = p_w(t) + B v + C w,

    with the slip v, the gap w ≥ 0, the tangential reaction q and the normal
    reaction p (compression positive). Units are free but must be consistent:
    stiffness = force / length.

    Every node has d tangential directions, one in the plane or two in space: two where B is
    (n, 2n). With two, slips and tangential reactions stand node by node, (x0, y0, x1, y1, …).

    Parameters
    ----------
    A, B : (dn, dn), (n, dn)
        Tangential stiffness and coupling [force/length]; A symmetric, B general.
    f : () or (n,)
        Friction coefficient(s) ≥ 0; stored per node.
    q_w, p_w : (m, dn), (m, n)
        Welded reactions over one loading period, one row per load step, at load
        factor 1 [force]. The period closes from the last row to the first.
    C : (n, n), optional
        Normal stiffness [force/length]; needed only where a node may separate.
    q_mean, p_mean : (dn,), (n,), optional
        The constant part of the loading [force]; the sample mean by default.
    load_path : str, optional
        What the load steps are: ``"loop"`` (default), followed in their order in every
        period; or ``"domain"``, corners of which the loads take any mixture in any order.
        Of a domain only what holds for every such path is called a bound or proved.
    q_transient, p_transient : (k, dn), (k, n), optional
        Load steps before the first period (thesis (4.18)) [force].
    initial_slip : (dn,) or (s, dn), optional
        Initial states to verify [length]; stored as (s, dn).
    x : (n,), optional
        Node positions along the contact [length], for pictures and meshes; with two directions
        (n, 2) or (n, 3) as well. A contact in the plane may turn by any angle. It is closed where
        ``coordinates`` have the last node beside the first and, where areas are known, these include the
        step between the two.
    coordinates : (n, 3), optional
        Where the nodes are in the model that the problem was made from [length].
    normal, tangent : (n, 3), optional
        Unit vectors there, into the (first) body and in the direction of positive slip [–].
    tangents : (n, 2, 3), optional
        Instead of ``tangent`` with two directions: a perpendicular pair for every node [–].
    node_area : (n,), optional
        Area of the contact that a node stands for, ≥ 0 [length²]: reactions over it are
        tractions. Of a plane model it is that of unit thickness, or of the one it has.
    faces : (k, 4) of int, optional
        With two directions: corners of the contact's faces, numbers of nodes in order around each,
        −1 as the last of a triangle. For pictures only.
    stiffness_accuracy : float, optional
        How accurate the stored A and B are, relative to their entries, at most 1e-3: 1e-7 where
        they come from seven printed digits. What meets less resistance than that is a rigid slip
        (:class:`~shakedown.joint.rigid_slips.RigidSlips`). By default that of floating-point
        numbers which went through the condensation of a large model.
    label : (n,), optional
        What each node, or pair of nodes, is called in that model.
    load_reactions : (L, (d + 1) n), optional
        Welded reactions of a unit of each load, q of all slips and then p [force per unit]. What is left of
        ``q_w``, ``p_w`` without ``load_history @ load_reactions`` is the same at every load step.
    load_history : (m, L), optional
        How many units of each load act at the load steps, at load factor 1.
    load_compliance : (L, L), optional
        The displacement conjugate to load i under a unit of load j while all nodes are welded, symmetric.
    load_frequency : (L,), optional
        Circular frequency of the mode that a load has the shape of [1/time]; NaN of a load that is none.
    load_names : (c,), optional
        Names of the load cases that the loading is made of.
    load_mean, load_amplitude : (c,), optional
        What λ = 1 stands for: the constant part of every load case and its largest departure
        from that, in a unit of its own. At a load factor λ the load is mean ± λ · amplitude.
    load_units : (c,), optional
        These units, as text; empty where the load is a plain number.
    name, units : str, optional
        Shown in reports.
    source : str, optional
        Where the problem comes from, as JSON: ``{"toolkit", "command", "configuration",
        "files": [{"name", "sha256"}, …], "warnings": […]}`` where it was imported.

    Raises
    ------
    ProblemError
        If an entry is missing, mis-shaped, not real and finite or out of range
        (1e-100 to 1e100 in whatever units), if f < 0, if A
        or C is not symmetric, if κ = [[A, Bᵀ], [B, C]] is not positive
        semi-definite, if q_w and p_w are not what the loads say, or if an area or amplitude is
        negative, directions no perpendicular unit vectors, a corner of a face no node, a label cannot
        be shown in one line, ``source`` is no JSON object or ``load_path`` neither word. The message
        names the key, what was expected and found.

    Examples
    --------
    >>> problem = Problem(A=[[2.0]], B=[[0.5]], f=0.4, q_w=[[1.0], [-1.0]], p_w=[[3.0], [3.0]])
    >>> problem.n, problem.m, problem.f
    (1, 2, array([0.4]))
    """

    A: Stored[FloatArray] = stored("dn dn")
    B: Stored[FloatArray] = stored("n dn")
    f: Stored[FloatArray] = stored("n")
    q_w: Stored[FloatArray] = stored("m dn")
    p_w: Stored[FloatArray] = stored("m n")
    C: Stored[FloatArray | None] = stored("n n")
    q_mean: Stored[FloatArray | None] = stored("dn")
    p_mean: Stored[FloatArray | None] = stored("n")
    q_transient: Stored[FloatArray | None] = stored("k dn")
    p_transient: Stored[FloatArray | None] = stored("k n")
    initial_slip: Stored[FloatArray | None] = stored("s dn")
    x: Stored[FloatArray | None] = stored("n")
    coordinates: Stored[FloatArray | None] = stored("n 3")
    normal: Stored[FloatArray | None] = stored("n 3")
    tangent: Stored[FloatArray | None] = stored("n 3")
    tangents: Stored[FloatArray | None] = stored("n 2 3")
    node_area: Stored[FloatArray | None] = stored("n")
    faces: Stored[NDArray[np.intp] | None] = stored("e 4")
    stiffness_accuracy: float | None = stored("")
    label: Stored[tuple[str, ...] | None] = stored("n")
    load_reactions: Stored[FloatArray | None] = stored("L (d+1)n")
    load_history: Stored[FloatArray | None] = stored("m L")
    load_compliance: Stored[FloatArray | None] = stored("L L")
    load_frequency: Stored[FloatArray | None] = stored("L")
    load_names: Stored[tuple[str, ...] | None] = stored("c")
    load_mean: Stored[FloatArray | None] = stored("c")
    load_amplitude: Stored[FloatArray | None] = stored("c")
    load_units: Stored[tuple[str, ...] | None] = stored("c")
    name: str = ""
    units: str = ""
    source: str = ""
    load_path: str = LOOP

    def __post_init__(self) -> None:
        for key in TEXTS:
            check = {"source": origin, "load_path": load_path}.get(key, plain_text)
            object.__setattr__(self, key, check(key, getattr(self, key)))
        given = [key for key in AXES if getattr(self, key) is not None]
        listed = {key: names(key, getattr(self, key)) for key in given if key in NAMES}
        arrays = {key: real_numbers(key, getattr(self, key)) for key in given if key not in NAMES}
        check_shapes({key: np.shape(value) for key, value in (listed | arrays).items()}, AXES)
        n = len(arrays["B"])
        arrays["f"] = np.array(np.broadcast_to(arrays["f"], n))
        if "initial_slip" in arrays:
            arrays["initial_slip"] = np.atleast_2d(arrays["initial_slip"])
        found: dict[str, Any] = dict(listed)
        if "faces" in arrays:
            found["faces"] = checked_faces(arrays.pop("faces"), n)
        check_values(arrays)
        if "stiffness_accuracy" in arrays:
            found["stiffness_accuracy"] = float(arrays.pop("stiffness_accuracy"))
        for key, array in arrays.items():
            empty = key in ("q_transient", "p_transient") and not len(array)  # an empty transient is none
            found[key] = None if empty else array
        for key, value in found.items():
            object.__setattr__(self, key, value)
        super().__post_init__()

    @property
    def n(self) -> int:
        """Number of contact nodes."""
        return self.B.shape[0]

    @property
    def m(self) -> int:
        """Number of load steps in one period."""
        return self.q_w.shape[0]

    @property
    def directions(self) -> int:
        """Tangential directions of a node: 1 in the plane, 2 in space."""
        return self.B.shape[1] // self.B.shape[0]

    @property
    def layout(self) -> Layout:
        """Where the slip and the gap of a node stand in states, reactions and κ."""
        return layout_of(self.n, self.directions)

    @property
    def law(self) -> Law:
        """Coulomb's law at the nodes."""
        return Law(self.f, self.directions)

    @property
    def is_domain(self) -> bool:
        """Whether the load steps are the corners of a load domain, and not a loop in their order."""
        return self.load_path == DOMAIN

    @cached_property
    def kappa(self) -> FloatArray:
        """The contact stiffness κ = [[A, Bᵀ], [B, C]], ((d + 1) n, (d + 1) n) [force/length].

        Raises ``ProblemError`` where the problem has no C.
        """
        if self.C is None:
            raise ProblemError("key 'C': needed because nodes may separate, found none")
        return self.layout.of_blocks(self.A, self.B, self.C)

    @property
    def loads(self) -> tuple[NamedLoad, ...]:
        """The load cases at λ = 1, in units of their own; none where the problem does not say them."""
        if self.load_names is None or self.load_mean is None or self.load_amplitude is None:
            return ()
        units = self.load_units or ("",) * len(self.load_names)
        numbers = self.load_mean.tolist(), self.load_amplitude.tolist()
        return tuple(map(NamedLoad._make, zip(self.load_names, *numbers, units, strict=True)))

    @property
    def warnings(self) -> tuple[str, ...]:
        """What was doubtful in the model that the problem was made from, by its ``source``.

        Examples
        --------
        >>> loop = {"f": 0.4, "q_w": [[1.0]], "p_w": [[3.0]]}
        >>> Problem(A=[[2.0]], B=[[0.5]], **loop, source='{"warnings": ["no load varies"]}').warnings
        ('no load varies',)
        """
        found = json.loads(self.source).get("warnings", []) if self.source else []
        return tuple(one_line(line) for line in found)

    def node_name(self, node: int) -> str:
        """A node by its number, and by its label where it has one.

        Examples
        --------
        >>> loop = {"f": 0.4, "q_w": [[1.0]], "p_w": [[3.0]]}
        >>> Problem(A=[[2.0]], B=[[0.5]], **loop, label=[4711]).node_name(0)
        '0 (FE 4711)'
        """
        return f"{node}" if self.label is None else f"{node} (FE {self.label[node]})"

    def node_data(self, nodes: Iterable[int]) -> dict[str, Any]:
        """What belongs to each of some nodes alone, by field: friction, position, label, area, …

        With it, faces between them included, a problem of some of the nodes is made.

        Examples
        --------
        >>> import shakedown
        >>> shakedown.example("two-node").node_data([1])
        {'f': array([0.35])}
        """
        chosen, found = list(nodes), dict[str, Any]()
        for key in OF_NODES:
            value = getattr(self, key)
            if isinstance(value, tuple):
                found[key] = tuple(value[i] for i in chosen)
            elif value is not None:
                found[key] = value[chosen]
        if self.faces is not None:
            found["faces"] = faces_among(self.faces, chosen)
        return found

    def to_dict(self) -> dict[str, Any]:
        """How a document introduces the joint: name, size, labels, units, load path, loads, warnings."""
        known = {
            "labels": list(self.label or ()),
            "units": self.units,
            "load_path": self.load_path if self.is_domain else None,
            "loads": [load._asdict() for load in self.loads],
            "warnings": list(self.warnings),
        }
        return {"name": self.name, **self._size} | {key: value for key, value in known.items() if value}

    @property
    def _size(self) -> dict[str, int]:
        """How many nodes and load steps there are; two directions are named, one is not."""
        return {"n": self.n, "m": self.m} | ({"directions": 2} if self.directions > 1 else {})

    @property
    def fingerprint(self) -> str:
        """SHA-256 of all arrays of the problem, and that they are a load domain: what runs are compared by.

        Examples
        --------
        >>> import shakedown
        >>> shakedown.example("two-node").fingerprint[:12]
        '3053854690ce'
        """
        digest = hashlib.sha256()
        for each in fields(self):
            value = getattr(self, each.name)
            if isinstance(value, np.ndarray):
                digest.update(f"{each.name} {value.dtype.str} {value.shape};".encode())
                digest.update(np.ascontiguousarray(value).tobytes())
        if self.is_domain:
            digest.update(b"load domain;")
        return digest.hexdigest()

    def __getstate__(self) -> dict[str, Any]:
        """Without the results kept with it, as they can be rebuilt."""
        return {name: value for name, value in vars(self).items() if name != "_derived"}

    def __repr__(self) -> str:
        parts = [repr(shortened(visible(self.name), 60))] if self.name else []
        parts += [f"{name}={count}" for name, count in self._size.items()]
        parts += [repr(shortened(visible(self.units), 20))] if self.units else []
        parts += ["load domain"] if self.is_domain else []
        return f"<Problem {', '.join(parts)}>"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Problem):
            return NotImplemented
        return all(same(getattr(self, d.name), getattr(other, d.name)) for d in fields(self))

    __hash__ = None  # type: ignore[assignment]


AXES: dict[str, Axes] = {each.name: each.metadata["axes"] for each in fields(Problem) if each.metadata}
