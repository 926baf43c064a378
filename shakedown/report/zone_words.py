"""What a contact zone means for the joint; every sentence names the open nodes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from shakedown.bounds.bound_result import Bound
from shakedown.ground.shown_values import down, up
from shakedown.ground.status import Status
from shakedown.report.node_words import open_in_words, pinned_in_words

if TYPE_CHECKING:
    from shakedown.joint.problem import Problem


def zone_in_words(upper: Bound, problem: Problem | None = None) -> list[str]:
    """Up to where a slip-free state of the zone exists, what remains open above, and where λ = 1 lies.

    Examples
    --------
    >>> import shakedown
    >>> block = shakedown.example("receding-block")
    >>> for line in zone_in_words(shakedown.upper_bound(block, open_nodes="auto")):
    ...     print(line)
    With nodes 0–4, 28–32 open and all others closed there is a safe slip up to λ_max = 0.2281044: ...
    Above λ_max = 0.2281045 no slip-free state has exactly these nodes open and all others closed ...
    The nominal load (λ = 1) lies at or above λ_max of this zone.
    """
    where = f"With {open_in_words(upper.open_nodes, problem)} open and all others closed"
    if upper.status == Status.INFEASIBLE:
        return [
            f"{where} no load factor is safe: no slip keeps every closed node within its friction "
            "limits and every open one open, even under the mean load alone."
        ]
    if nothing_found := without_safe_slip_in_words(upper):
        return [nothing_found]
    least = upper.least_load_factor
    begins = f" from λ_lo = {up(least)} on" if least > 0 else ""
    begun = f"{where} there is a safe slip{begins}"
    held = "in that state, in equilibrium with its load, no node slips, opens or closes"
    if upper.status == Status.UNBOUNDED:
        sentences = [f"{begun} at every load factor: {held}."]
    else:
        sentences = [
            f"{begun} up to λ_max = {down(upper.load_factor)}: {held}.",
            f"Above λ_max = {up(upper.load_factor)} no slip-free state has exactly these nodes open and all "
            "others closed throughout; of other zones, and of nodes that open and close, nothing is said.",
        ]
    if upper.pinned:
        sentences.append(pinned_in_words(upper.pinned, problem))
    return [*sentences, f"The nominal load (λ = 1) lies {_place(upper)}."]


def without_safe_slip_in_words(upper: Bound) -> str:
    """That no load factor is safe, or none was found to be; empty where some are."""
    if upper.status == Status.UNDECIDED:
        return f"No safe slip was found at any load factor: {upper.reason}."
    safe = upper.status != Status.INFEASIBLE
    return "" if safe else f"No load factor is safe while all nodes stay in contact: {upper.reason}."


def _place(upper: Bound) -> str:
    if upper.least_load_factor > 1:
        return "below λ_lo of this zone"
    return "where this zone has safe slips" if upper.load_factor > 1 else "at or above λ_max of this zone"
