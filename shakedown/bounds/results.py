"""Results on safe slips: evidence of λ_max, the safest slip, the comparison of zones."""

from dataclasses import dataclass
from typing import ClassVar

from shakedown.bounds.bound_result import Evidence
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Status
from shakedown.joint.result import Result

UNSAFE_MEAN = "under the mean load alone no slip keeps every node within its friction limits"
NO_SAFE_STATE = "no slip keeps every node within its friction limits, even under the mean load alone"
MOVED = "no slip is safe both under the transient load steps and in the loop, at any load factor"
ZERO_AMPLITUDE = "zero-amplitude loop: the loading does not change over the period, whatever the load factor"
RELIEVING = "the periodic part of the loading brings no node nearer to its limits at any load factor"
WEDGING = "wedging: slip along one direction raises the friction limits faster than any load factor needs"


@dataclass(frozen=True, eq=False, repr=False)
class LargestLoadFactor(Evidence):
    """What only λ_max has, the largest load factor at which a safe slip exists (thesis (5.16)).

    With all nodes in contact: above it no slip keeps every node closed and at rest
    through the period. With nodes of a zone open: above it there is no state at rest with
    exactly these nodes open throughout; other zones may do better. It is infeasible where no slip is safe
    at any load factor, unbounded where safe slips exist at arbitrarily large ones, undecided where a search
    found no zone with a safe slip, and not all zones were tried, or where that there is no limit rests on a
    resistance in doubt.

    Its ``slip`` (dn,) is the safe slip at λ_max [length]; the slip of an open node is its displacement under
    the mean load. Of a zone with open nodes it is the one in which the largest slip of a closed node is
    least. Steps of a transient are counted from −k to −1 in ``active``. Its ``multipliers`` y ≥ 0 (r,) prove
    the status, of the r rows of the constraints (with two directions, in their cones). Optimal: yᵀG = 0,
    yᵀd = 1, yᵀg = λ_max. Infeasible (Farkas): yᵀG = 0, yᵀd ≥ 0, yᵀg < 0. Zero where unbounded.
    ``residual`` is the largest relative violation of the rows at ``slip`` or along ``direction``, or of the
    equalities of ``multipliers``. ``certified`` are neighbouring floats, with two directions 1e-10 apart as a
    rule, relatively (docs/space.md, U1 and U2); (inf, inf) where it is proved unbounded. Of a joint in
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
