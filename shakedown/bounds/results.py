"""Results on safe slips: the largest load factor with one, the safest slip, the comparison of zones."""

from dataclasses import dataclass, field
from math import nan
from typing import ClassVar

import numpy as np

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
class UpperBound(Result):
    """Largest load factor at which a safe slip exists: λ_max of thesis (5.16).

    With all nodes in contact: above it no slip keeps every node closed and at rest
    through the period. With nodes of a zone open: above it there is no state at rest with
    exactly these nodes open throughout; other zones may do better.

    Attributes
    ----------
    status
        Optimal; infeasible (no safe slip at any load factor); unbounded (safe slips
        exist at arbitrarily large load factors); undecided where a search found no zone with a safe slip,
        and not all zones were tried, or where that there is no limit rests on a resistance in doubt.
    load_factor
        λ_max; NaN where infeasible, inf where unbounded.
    slip : (dn,)
        The safe slip at λ_max [length]; NaN unless optimal. Of a zone with open nodes the one in which
        the largest slip of a closed node is least.
    active
        (node, side) of the rows that determine it; with two directions (node, load step) of the limits,
        steps of a transient counted from −k to −1.
    multipliers : (r,)
        y ≥ 0 that prove the status, of the r rows of the constraints (with two directions, in their cones).
        Optimal: yᵀG = 0, yᵀd = 1, yᵀg = λ_max. Infeasible (Farkas): yᵀG = 0, yᵀd ≥ 0, yᵀg < 0.
        Zero where unbounded.
    direction : (dn,)
        Where unbounded: v with G v + d ≤ 0, along which every load factor stays
        safe [length]; else NaN.
    reason
        The status in words; empty where optimal.
    residual
        Largest relative violation of what the status claims: of the rows at
        ``slip`` or along ``direction``, or of the equalities of ``multipliers``.
    least_load_factor
        λ_lo, the smallest load factor ≥ 0 with a safe slip: safe slips exist from λ_lo
        to λ_max. It is 0 but where the constant part of the loading is not the mean
        and has no safe slip of its own; NaN where infeasible.
    certified
        (low, high) with the exact λ_max of the problem as stored between them: neighbouring floats, with
        two directions 1e-10 apart as a rule, relatively (docs/space.md, U1 and U2); (inf, inf) where it is
        proved unbounded, else None.
    exact
        Whether the status was checked in exact arithmetic, with two directions with every rounding bounded.
    uncertified
        Why there is no certificate although it was asked for; else empty.
    disputed
        Whether exact arithmetic on the stored digits contradicts the number by more than the data allow.
    missing
        Other evidence that a solver failed to give, and why: ``multipliers`` or ``direction``,
        ``least_load_factor``, which is NaN then.
    reduced_accuracy
        Whether the linear program ended only at loosened tolerances (1e-7).
    open_nodes
        The nodes that are open through the whole period; empty with all nodes in contact.
        The slip of an open node is its displacement under the mean load.
    pinned
        Where the joint can move as a whole: the nodes that slips are given relative to. Their own
        slips are 0, as safe slips are known only up to that motion; empty for a joint that is held.
    in_floats : (dn + 1,)
        Safe slip [length] and load factor as the linear program found them, before exact arithmetic moved
        their last digits: where searches that end at λ_max begin. NaN where it found none.
    parts
        With two directions, of a joint in uncoupled parts (:mod:`shakedown.joint.coupled_parts`), the bound
        of each; ``multipliers`` are 0 but in the part with the least one. Else empty.
    """

    DOCUMENT: ClassVar[str] = (
        "status load_factor least_load_factor slip open_nodes direction active certified uncertified "
        "disputed missing exact reduced_accuracy reason residual pinned"
    )
    TABLE: ClassVar[str] = "slip"

    status: Status
    load_factor: float
    slip: FloatArray
    active: tuple[tuple[int, int], ...]
    multipliers: FloatArray
    direction: FloatArray
    reason: str
    residual: float
    least_load_factor: float
    certified: tuple[float, float] | None
    exact: bool
    uncertified: str = ""
    disputed: bool = False
    missing: tuple[str, ...] = ()
    reduced_accuracy: bool = False
    open_nodes: tuple[int, ...] = ()
    pinned: tuple[int, ...] = ()
    in_floats: FloatArray = field(default_factory=lambda: np.full(1, nan), repr=False)
    parts: tuple["UpperBound", ...] = field(default=(), repr=False)


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


@dataclass(frozen=True, eq=False)
class ZoneLimit:
    """λ_max of a contact zone that is compared with others.

    Attributes
    ----------
    load_factor
        −inf where the zone has no safe slip, inf where nothing limits it.
    x : (k,)
        Where it is reached: slips, with two directions the unknowns of programs; empty without a limit.
    multipliers : (r,) or (3j + o,)
        Of rows, with two directions of discs and gaps; empty where nothing limits it.
    margin
        By how much (negative) its limits exclude every slip under the mean load [length]; else 0: it tells
        zones without a safe slip apart.
    """

    load_factor: float
    x: FloatArray
    multipliers: FloatArray
    margin: float = 0.0
