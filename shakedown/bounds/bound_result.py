"""One result for every limit of the load factor: what all kinds have, and the evidence that only one has."""

from dataclasses import dataclass, field, fields, replace
from math import nan
from typing import Any

import numpy as np

from shakedown.bounds.registry import BOUNDS
from shakedown.ground.float_array import FloatArray
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
        Of a joint in uncoupled parts (:mod:`shakedown.joint.coupled_parts`) the bound of each, where they
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
