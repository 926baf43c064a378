"""Both bounds of the load factor."""

from dataclasses import dataclass, field
from typing import Any, ClassVar

from shakedown.bounds.bound_result import Bound
from shakedown.ground.errors import Missing
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.result import Result


@dataclass(frozen=True, eq=False, repr=False)
class ShakedownBounds(Result):
    """Both bounds of one problem: between them the outcome depends on the initial state.

    The lower bound is that of the joint with all nodes closed; the upper one names the nodes
    that are open (``upper.open_nodes``), and is then no bound but of that zone. Both are about
    the loop, and so about slips that are locked in when transient load steps are over.
    ``through_transient`` is the largest load factor at which one slip is safe under these too;
    None where there are none, or where nodes are open.

    With two tangential directions ``lower`` is ``Missing``, with the reason: a disc has no sides that a node
    could lose its range of safe slips between. What is proved there is λ_U and λ_E (:func:`assess`).
    """

    DOCUMENT: ClassVar[str] = "lower upper through_transient"

    lower: Bound | Missing
    upper: Bound
    tolerances: Tolerances = field(default=DEFAULT, repr=False)
    through_transient: Bound | None = None

    def columns(self) -> dict[str, Any]:
        """The safe slip, the critical slip state, and the load factor at which each node collapses."""
        lower, safe = self.lower, {"safe_slip": self.upper.slip}
        if isinstance(lower, Missing):
            return safe
        return safe | {"witness": lower.slip, "collapses_at": lower.per_node}
