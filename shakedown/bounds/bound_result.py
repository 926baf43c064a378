"""One result for every bound, and the evidence of λ_max and of safe slips."""

from collections.abc import Iterator
from dataclasses import dataclass, field, fields, replace
from math import nan
from typing import Any, ClassVar

import numpy as np

from shakedown.bounds.registry import BOUNDS
from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import Missing
from shakedown.ground.shown_values import plain
from shakedown.ground.status import Status
from shakedown.joint.result import Result

NO_SLIP = np.zeros(0)


@dataclass(frozen=True, eq=False, repr=False)
class Evidence(Result):
    """What only one kind of bound has; a kind derives its own class from it.

    ``DOCUMENT`` and ``TABLE`` are those of the bound (:class:`Result`), with words of either.
    """

    def document(self, bound: "Bound") -> dict[str, Any]:
        """The bound as JSON knows it."""
        return {word: plain(getattr(bound, word)) for word in self.DOCUMENT.split()}

    def remark(self, bound: "Bound") -> str:
        """What the bound ends at, or why there is none, in a few words for a table."""
        return bound.reason


@dataclass(frozen=True, eq=False, repr=False)
class Bound(Result):
    """A limit of the load factor, with what proves it.

    What only one kind of bound has stands in ``evidence``, whose attributes are those of the bound, too.

    Attributes
    ----------
    kind
        Its name in :data:`shakedown.BOUNDS`, which says what it is about.
    status
        Optimal, infeasible, unbounded or undecided (:class:`Status`).
    load_factor
        Where it lies; NaN where infeasible or undecided, inf where unbounded.
    evidence
        What only this kind has.
    slip : (dn,)
        The slip that proves it [length]; NaN unless optimal, empty where the kind has none.
    active
        (node, side) of the rows that determine it; with two directions (node, load step) of the limits.
    multipliers : (r,)
        Multipliers that prove it, in the order that the evidence says; empty where the kind has none.
    reason
        The status in words; empty where optimal and nothing needs a reason.
    residual
        Largest relative violation of what the status claims; NaN where the kind has none.
    least_load_factor
        Where it begins: the least load factor ≥ 0 of what it is about. 0 but where the constant part of the
        loading is not the mean and is too little alone; NaN where infeasible.
    certified
        What exact arithmetic confirms, or None: (low, high) with the exact limit between them, of a proof
        from one state the load factor.
    uncertified
        Why nothing is confirmed although it was asked for; else empty.
    disputed
        Whether exact arithmetic on the stored digits contradicts the number by more than the data allow.
    reduced_accuracy
        Whether a program ended only at loosened tolerances (1e-7).
    open_nodes
        The nodes that are open through the whole period.
    pinned
        Where the joint can move as a whole: the nodes, with two directions the slips, that ``slip`` is given
        relative to.
    parts
        Of a joint in uncoupled parts (:mod:`shakedown.joint.contact_zone`) the bound of each, where they
        are computed one by one; else empty.
    """

    kind: str
    status: Status
    load_factor: float
    evidence: Evidence = field(repr=False)
    slip: FloatArray = field(default_factory=lambda: NO_SLIP)
    active: tuple[tuple[int, int], ...] = ()
    multipliers: FloatArray = field(default_factory=lambda: NO_SLIP)
    reason: str = ""
    residual: float = nan
    least_load_factor: float = 0.0
    certified: Any = None
    uncertified: str = ""
    disputed: bool = False
    reduced_accuracy: bool = False
    open_nodes: tuple[int, ...] = ()
    pinned: tuple[int, ...] = ()
    parts: tuple["Bound", ...] = field(default=(), repr=False)

    def __getattr__(self, name: str) -> Any:
        evidence = self.__dict__.get("evidence")
        if evidence is None or name.startswith("_") or not hasattr(evidence, name):
            raise AttributeError(f"a bound of the kind {self.__dict__.get('kind')!r} has no {name!r}")
        return getattr(evidence, name)

    @property
    def symbol(self) -> str:
        """λ with the index of its kind."""
        return BOUNDS[self.kind].symbol

    @property
    def undecided(self) -> bool:
        """Whether a program on which it rests came to no end."""
        return self.status == Status.UNDECIDED

    @property
    def remark(self) -> str:
        """What it ends at, or why there is none, in a few words."""
        return self.evidence.remark(self)

    def but(self, **changes: Any) -> "Bound":
        """The same bound with other values, of its own fields or of those of its evidence."""
        own = {each.name for each in fields(self)}
        of_evidence = {name: value for name, value in changes.items() if name not in own}
        if of_evidence:
            changes = {name: value for name, value in changes.items() if name in own}
            changes["evidence"] = replace(self.evidence, **of_evidence)
        return replace(self, **changes)

    def to_dict(self) -> dict[str, Any]:
        """The bound as JSON knows it: the words of its kind."""
        return self.evidence.document(self)

    def _words(self) -> list[str]:
        return self.evidence.DOCUMENT.split()

    def _table_words(self) -> list[str]:
        return self.evidence.TABLE.split()

    def _shown(self) -> Any:
        yield from super()._shown()
        yield from self.evidence._shown()


@dataclass(frozen=True, eq=False, repr=False)
class LargestLoadFactor(Evidence):
    """What only λ_max has, the largest load factor at which a safe slip exists (thesis (5.16)).

    With all nodes in contact: above it no slip keeps every node closed and at rest
    through the period. With nodes of a zone open: above it there is no state at rest with
    exactly these nodes open throughout; other zones may do better. It is infeasible where no slip is safe
    at any load factor, unbounded where safe slips exist at arbitrarily large ones, undecided where a search
    found no zone with a safe slip, and not all zones were tried, or where that there is no limit rests on a
    resistance in doubt or on a direction that breaks a row.

    Its ``slip`` (dn,) is the safe slip at λ_max [length]; the slip of an open node is its displacement under
    the mean load. Of a zone with open nodes it is the one in which the largest slip of a closed node is
    least. Steps of a transient are counted from −k to −1 in ``active``. Its ``multipliers`` y ≥ 0 (r,) prove
    the status, of the r rows of the constraints (with two directions, in their cones). Optimal: yᵀG = 0,
    yᵀd = 1, yᵀg = λ_max. Infeasible (Farkas): yᵀG = 0, yᵀd ≥ 0, yᵀg < 0. Zero where unbounded.
    ``residual`` is the largest relative violation of the rows at ``slip`` or along ``direction``, or of the
    equalities of ``multipliers``. ``certified`` are neighbouring floats, with two directions 1e-10 apart as a
    rule, relatively (docs/space.md, Theorems U1, U2); (inf, inf) where it is proved unbounded. Of a joint in
    uncoupled parts ``multipliers`` are 0 but in the part with the least bound.

    Attributes
    ----------
    direction : (dn,)
        Where unbounded: v with G v + d ≤ 0, along which every load factor stays
        safe [length]; else NaN.
    exact
        Whether the status was checked in exact arithmetic, with two directions with every rounding bounded.
    missing
        Other evidence that a solver failed to give, and why: ``multipliers`` or ``direction``,
        ``least_load_factor``, which is NaN then.
    """

    DOCUMENT: ClassVar[str] = (
        "status load_factor least_load_factor slip open_nodes direction active certified uncertified "
        "disputed missing exact reduced_accuracy reason residual pinned"
    )
    TABLE: ClassVar[str] = "slip"

    direction: FloatArray
    exact: bool
    missing: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False, repr=False)
class SafeSlip(Result):
    """The slip with the largest margin to all 2n rows at one load factor.

    Attributes
    ----------
    status
        Optimal; infeasible (no safe slip at this load factor); unbounded (the margin can
        be made as large as one likes; ``slip`` is a safe slip with a margin typical of
        the load).
    load_factor
        The load factor asked for.
    slip : (dn,)
        The safe slip [length]; NaN where there is none.
    margin
        Distance in slip space from the nearest row's hyperplane [length]; with two directions the
        largest t with |q_i| + t (f_i |B_i| + |A_i|) ≤ f_i p_i, which all slips up to t away keep
        (|A_i|: the spectral norm of the two rows). Inf where unbounded, negative where infeasible.
    active
        (node, side) of the rows at that distance; with two directions (node, load step).
    residual
        Largest relative violation of a row at ``slip``; ≤ 0 where it is safe.
    reduced_accuracy
        Whether the linear program ended only at loosened tolerances (1e-7).
    open_nodes
        The nodes that are open; their slip is their displacement under the mean load.
    pinned
        The nodes that slips are given relative to, where the joint can move as a whole.
    """

    status: Status
    load_factor: float
    slip: FloatArray
    margin: float
    active: tuple[tuple[int, int], ...]
    residual: float
    reduced_accuracy: bool = False
    open_nodes: tuple[int, ...] = ()
    pinned: tuple[int, ...] = ()


def open_ends(*results: Bound | Missing) -> Iterator[str]:
    """One sentence for each result that is open or disputed.

    A limit that does not exist, like λ_1 with two tangential directions, is not open.

    Examples
    --------
    >>> import shakedown
    >>> list(open_ends(shakedown.upper_bound(shakedown.example("two-node"))))
    []
    """
    for result in results:
        if isinstance(result, Missing):
            continue
        if result.undecided:
            yield f"{result.symbol} is open: {result.reason}"
        elif result.disputed:
            yield f"{result.symbol} is disputed: {result.uncertified}"
