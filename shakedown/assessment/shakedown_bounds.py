"""Both bounds of the load factor, and the one there is in space."""

from dataclasses import dataclass, field
from typing import Any, ClassVar

from shakedown.bounds.collapse.lower import LowerBound
from shakedown.bounds.upper import UpperBound
from shakedown.ground.evidence import Missing
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import NO_SIDES, in_the_plane_only
from shakedown.joint.result import Result


@dataclass(frozen=True, eq=False, repr=False)
class ShakedownBounds(Result):
    """Both bounds of one problem: between them the outcome depends on the initial state.

    The lower bound is that of the joint with all nodes closed; the upper one names the nodes
    that are open (``upper.open_nodes``), and is then no bound but of that zone. Both are about
    the loop, and so about slips that are locked in when transient load steps are over.
    ``through_transient`` is the largest load factor at which one slip is safe under these too;
    None where there are none, or where nodes are open.
    """

    lower: LowerBound
    upper: UpperBound
    tolerances: Tolerances = field(default=DEFAULT, repr=False)
    through_transient: UpperBound | None = None

    def columns(self) -> dict[str, Any]:
        """The safe slip, the critical slip state, and the load factor at which each node collapses."""
        lower, upper = self.lower, self.upper
        return {"safe_slip": upper.slip, "witness": lower.slip, "collapses_at": lower.per_node}

    @property
    def have_gap(self) -> bool:
        """Whether there are load factors between the bounds, with a safe slip to keep near to.

        Never where nodes are open: the bounds are then of different zones.
        """
        first, last = self.lower.load_factor, self.upper.load_factor
        if self.upper.open_nodes:
            return False
        return self.upper.status == Status.OPTIMAL and bool(first < last * (1 - self.tolerances.feasibility))


@dataclass(frozen=True, eq=False, repr=False)
class SpaceBounds(Result):
    """What :class:`ShakedownBounds` is in the plane, of a joint with two tangential directions: λ_max alone.

    ``lower`` is ``Missing``, with the reason: a disc has no sides that a node could lose its range of safe
    slips between. What is proved there is λ_U and λ_E (:func:`assess`).
    """

    DOCUMENT: ClassVar[str] = "lower upper through_transient"

    upper: UpperBound
    tolerances: Tolerances = field(default=DEFAULT, repr=False)
    through_transient: UpperBound | None = None

    lower: ClassVar[Missing] = Missing(in_the_plane_only("first collapse", NO_SIDES))
    have_gap: ClassVar[bool] = False

    def columns(self) -> dict[str, Any]:
        """The safe slip."""
        return {"safe_slip": self.upper.slip}
