"""The distinct limit cycles among many long-term states, whether they are stable, how far slips scatter."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.ground.size_limits import AT_ONCE
from shakedown.ground.status import Outcome
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.long_term.cycle_map import CycleMap, follow_period
from shakedown.long_term.find_state import long_term_state
from shakedown.long_term.state import LongTermState
from shakedown.motion.checked_law import length_scales, path_accuracy, path_resolution, scales
from shakedown.motion.method import cycles_of, walk
from shakedown.studies.map_file import Columns
from shakedown.studies.map_pieces import MapSearch


class Scatter(NamedTuple):
    """The scatter of the slips that some states end on.

    Attributes
    ----------
    spread
        Largest difference between any two of them at any one node [length].
    largest
        Largest slip among them [length], to compare with.
    """

    spread: float
    largest: float


NONE = Scatter(np.nan, np.nan)  # of no states


def slip_scatter(
    final_slip: FloatArray, rows: NDArray[np.intp], places: FloatArray, drift: FloatArray | None = None
) -> Scatter:
    """The scatter of the final slips of some states about the limit cycle of one of them.

    States may have stopped at different cycles of a period: each is compared with the place
    (end of a cycle) that it is nearest to. Of states that drift, the part of the slip along the
    drift says only when they stopped, and is left out.

    Parameters
    ----------
    final_slip : (s, dn)
        Slips that all states end on [length]; they may lie on the disk.
    rows
        Numbers of the states to compare.
    places : (p, dn)
        Slips at the ends of the cycles of the limit cycle of one of them [length].
    drift : (dn,), optional
        Growth of its slip per period [length].

    Examples
    --------
    >>> slip_scatter(np.array([[0.0, 1.0], [0.5, 1.0], [9.0, 9.0]]), np.array([0, 1]), np.zeros((1, 2)))
    Scatter(spread=0.5, largest=1.0)
    """
    if not len(rows):
        return NONE
    size = 0.0 if drift is None else float(np.linalg.norm(drift))
    along = np.zeros(places.shape[1]) if drift is None or not size else drift / size
    places = places - np.outer(places @ along, along)
    low, high, largest = np.full(len(along), np.inf), np.full(len(along), -np.inf), 0.0
    for start in range(0, len(rows), AT_ONCE):
        ends = np.asarray(final_slip[rows[start : start + AT_ONCE]])
        if size:
            ends = ends - np.outer(ends @ along, along)
        away = _from_nearest(ends, places)
        low, high = np.minimum(low, away.min(axis=0)), np.maximum(high, away.max(axis=0))
        largest = max(largest, float(np.abs(ends).max()))
    return Scatter(float((high - low).max()), largest)


def _from_nearest(ends: FloatArray, places: FloatArray) -> FloatArray:
    """Differences from that place which each of the slips is nearest to."""
    away = ends - places[0]
    for place in places[1:]:
        other = ends - place
        nearer = np.abs(other).max(axis=1) < np.abs(away).max(axis=1)
        away[nearer] = other[nearer]
    return np.asarray(away)


Rows = NDArray[np.intp]  # numbers of states

MOST_ALONE = 20  # limit cycles of a kind distinguished without multipliers; further ones count as a continuum
APART = 160.0  # times the error of a path over one cycle: closer states are the same

STABLE, BORDER, UNSTABLE, UNKNOWN = "stable", "border", "unstable", "unknown"


@dataclass(frozen=True, eq=False, repr=False)
class LimitCycle(Result):
    """A limit cycle that initial states lead to, or a continuum of them.

    Attributes
    ----------
    count
        How many of the sampled states lead there.
    named
        Which of the states with a name do.
    outcome
        Cyclic slip, ratchetting or separation.
    period
        Cycles of the load after which the motion repeats.
    dissipation
        Smallest and largest dissipation per cycle [force × length]: the same for one limit
        cycle, mostly a range for a continuum.
    slipping_nodes
        The nodes that slip.
    stability
        ``"stable"``: every multiplier is below 1 in size, and small disturbances die out.
        ``"border"``: one is 1: a disturbance may lead to a neighbouring limit cycle of a
        continuum; whether the states found make use of that, ``coincide`` says.
        ``"unstable"``: one is above 1. ``"unknown"``: the state jumps, or the joint has two
        tangential directions, where the cycle map is not worked out.
    multipliers : (k,)
        Eigenvalues of the derivative of the map over one period with respect to the slips
        of the nodes stuck at its start, the largest first, at the example.
    contact_sequences
        How many different sequences of contact states were seen, wherever a period is cut.
    example
        Number of a state that leads there.
    final_slip : (period, dn)
        Slips at the ends of its cycles, from the example [length].
    spread
        Largest difference, at any node, between the slips that the states end on, in the same
        phase of the period and drift apart [length].
    coincide
        Whether the states end in one and the same limit cycle: spread and dissipation
        agree to the tolerance ``same_cycle``.
    """

    count: int
    outcome: str
    period: int
    dissipation: tuple[float, float]
    slipping_nodes: tuple[int, ...]
    stability: str
    multipliers: NDArray[np.complex128]
    contact_sequences: int
    example: int
    final_slip: FloatArray
    spread: float = 0.0
    coincide: bool = True
    named: tuple[str, ...] = ()


class _Kind(NamedTuple):
    """The properties shared by limit cycles of one continuum."""

    outcome: str
    period: int
    slipping_nodes: tuple[int, ...]


class _Examined(NamedTuple):
    """A limit cycle examined closely, and the growth of its slip per period, (dn,) [length]."""

    cycle: LimitCycle
    drift: FloatArray


@dataclass(frozen=True)
class _Seen:
    """The states of a map, and the tolerances for comparing slips."""

    problem: Problem
    load_factor: float
    columns: Columns
    search: MapSearch
    named: tuple[str, ...]

    @property
    def still(self) -> FloatArray:
        """Slip per period that counts as none, (n,) [length]."""
        share = path_resolution(self.problem, self.search.tolerances)
        return 4.0 * share * length_scales(self.problem, self.load_factor)

    @property
    def same(self) -> float:
        """Difference of slips that counts as none [length]."""
        return same_slip(self.problem, self.load_factor, self.search.tolerances)

    @property
    def same_work(self) -> float:
        """Difference of dissipations that counts as none, beside a share of the larger [force × length]."""
        scale = scales(self.problem, self.load_factor)
        return path_resolution(self.problem, self.search.tolerances) * scale.length * scale.force

    def parts(self) -> Iterator[slice]:
        """All states, in batches."""
        count = len(self.columns["outcome"])
        return (slice(start, min(start + AT_ONCE, count)) for start in range(0, count, AT_ONCE))


def limit_cycles(
    problem: Problem, load_factor: float, columns: Columns, search: MapSearch, named: tuple[str, ...] = ()
) -> tuple[LimitCycle, ...]:
    """The distinct limit cycles of a map, the most frequent first.

    Where no multiplier is 1, a limit cycle stands alone, and the states count that end on
    it, to the tolerance ``same_cycle``. Else it is one of a continuum; limit cycles of a
    continuum have the period and the slipping nodes in common, and count together. With two
    tangential directions there are no multipliers: there it stands alone where every node slips
    and several states end on it.

    Parameters
    ----------
    problem, load_factor
        The joint and λ.
    columns
        The states.
    search
        How long-term states were searched for.
    named
        Names of the first states.
    """
    seen, found = _Seen(problem, load_factor, columns, search, named), list[LimitCycle]()
    for kind, rows in _by_kind(seen).items():
        continuum: list[tuple[_Examined, Rows]] = []
        while len(rows):
            one = _examined(seen, kind, int(rows[0]))
            here = _ends_on(seen, rows, one.cycle)
            alone = one.cycle.stability in (STABLE, UNSTABLE) or _gathers(seen, kind, here, len(found))
            mine = here if alone else _like(seen, rows, kind)
            if alone:
                found.append(_counted(seen, one, rows[mine]))
            else:
                continuum.append((one, rows[mine]))
            rows = rows[~mine]
        if continuum:  # or several with the same slipping nodes; the largest part is the example
            one = max(continuum, key=lambda part: len(part[1]))[0]
            found.append(_counted(seen, one, np.concatenate([part for _, part in continuum])))
    return tuple(sorted(found, key=lambda cycle: (-cycle.count, cycle.example)))


def _by_kind(seen: _Seen) -> dict[_Kind, Rows]:
    """Numbers of the states that end in limit cycles of each kind."""
    found: dict[_Kind, list[Rows]] = {}
    for part in seen.parts():
        outcome, period = seen.columns["outcome"][part], seen.columns["period"][part]
        slips = seen.columns["slip_per_cycle"][part] > seen.still
        cyclic = np.flatnonzero((period > 0) & (outcome != Outcome.SHAKEDOWN))
        if not len(cyclic):
            continue
        _, names = np.unique(outcome[cyclic], return_inverse=True)
        keys = np.column_stack([names.ravel(), period[cyclic], np.packbits(slips[cyclic], axis=1)])
        _, first, group = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        for number, row in enumerate(cyclic[first]):
            nodes = tuple(np.flatnonzero(slips[row]).tolist())
            kind = _Kind(str(outcome[row]), int(period[row]), nodes)
            found.setdefault(kind, []).append(part.start + cyclic[group.ravel() == number])
    return {kind: np.concatenate(rows) for kind, rows in found.items()}


def _ends_on(seen: _Seen, rows: Rows, cycle: LimitCycle) -> NDArray[np.bool_]:
    """Which states end on a limit cycle, at whichever of its cycles; the first of them does."""
    mine = np.zeros(len(rows), dtype=bool)
    mine[0] = True
    for start in range(0, len(rows), AT_ONCE):
        ends = seen.columns["final_slip"][rows[start : start + AT_ONCE]]
        for place in cycle.final_slip:
            mine[start : start + AT_ONCE] |= np.abs(ends - place).max(axis=1) <= seen.same
    return mine


def _gathers(seen: _Seen, kind: _Kind, here: NDArray[np.bool_], known: int) -> bool:
    """Whether a limit cycle without multipliers stands alone for all that is seen.

    Every node slips, so that no slip is locked in, and other states end on it, too.
    """
    if tells_stability(seen.problem) or len(kind.slipping_nodes) < seen.problem.n:
        return False
    return bool(np.count_nonzero(here) > 1) and known < MOST_ALONE


def _like(seen: _Seen, rows: Rows, kind: _Kind) -> NDArray[np.bool_]:
    """Which states are taken to end in the same continuum as the first of them.

    They pass through the same contact states. Where a node keeps its slip, which is locked in and selects the
    limit cycle, they are all states of the kind.
    """
    if len(kind.slipping_nodes) < seen.problem.n or not tells_stability(seen.problem):
        return np.ones(len(rows), dtype=bool)
    signature = seen.columns["signature"][rows]
    return np.asarray(signature == signature[0])


def _examined(seen: _Seen, kind: _Kind, example: int) -> _Examined:
    """The limit cycle that one state leads to, with the multipliers of its cycle map."""
    cycle = LimitCycle(
        count=1,
        outcome=kind.outcome,
        period=kind.period,
        dissipation=(np.nan, np.nan),
        slipping_nodes=kind.slipping_nodes,
        stability=UNKNOWN,
        multipliers=np.empty(0, dtype=complex),
        contact_sequences=1,
        example=example,
        final_slip=np.asarray(seen.columns["final_slip"][example])[None],
    )
    state = long_term_state(
        seen.problem,
        seen.load_factor,
        np.asarray(seen.columns["initial_slip"][example]),
        max_cycles=seen.search.max_cycles,
        longest_period=seen.search.longest_period,
        tolerances=seen.search.tolerances,
    )
    if not state.period:
        return _Examined(cycle, state.drift)
    if not tells_stability(seen.problem):
        ends = np.array([record.end_slip for record in cycles_of(state.motion(), state.period)])
        return _Examined(replace(cycle, final_slip=ends), state.drift)
    over = _one_more_period(state)
    if over is None:
        return _Examined(cycle, state.drift)
    ends = np.array([record.end_slip for record in over.records])
    if any(record.jumps for record in over.records):
        return _Examined(replace(cycle, final_slip=ends), state.drift)
    multipliers = np.linalg.eigvals(over.jacobian).astype(complex)
    multipliers = multipliers[np.argsort(-np.abs(multipliers), kind="stable")]
    cycle = replace(cycle, stability=_stability(multipliers), multipliers=multipliers, final_slip=ends)
    return _Examined(cycle, state.drift)


def _one_more_period(state: LongTermState) -> CycleMap | None:
    """The map of the period after the one that has shown the long-term state."""
    motion = state.motion()
    walk(motion, state.period, record=True)
    return follow_period(motion, state.period)


def _stability(multipliers: NDArray[np.complex128]) -> str:
    largest = float(np.abs(multipliers).max(initial=0.0))
    if largest > 1.0 + NEGLIGIBLE:
        return UNSTABLE
    return BORDER if largest >= 1.0 - NEGLIGIBLE else STABLE


def _counted(seen: _Seen, one: _Examined, rows: Rows) -> LimitCycle:
    """A limit cycle with the states that lead there, and how far apart they end."""
    dissipation = seen.columns["dissipation"][rows]
    low, high = float(dissipation.min()), float(dissipation.max())
    scatter = slip_scatter(seen.columns["final_slip"], rows, one.cycle.final_slip, _known(one.drift))
    same_work = high - low <= seen.search.tolerances.same_cycle * high + seen.same_work
    return replace(
        one.cycle,
        count=int(np.count_nonzero(rows >= len(seen.named))),
        named=tuple(name for k, name in enumerate(seen.named) if k in rows),
        dissipation=(low, high),
        contact_sequences=len(np.unique(seen.columns["signature"][rows])),
        spread=scatter.spread,
        coincide=one.cycle.stability in (STABLE, UNSTABLE) or bool(scatter.spread <= seen.same and same_work),
    )


def _known(drift: FloatArray) -> FloatArray | None:
    return None if np.isnan(drift).any() else drift


def tells_stability(problem: Problem) -> bool:
    """Whether the map over a period and its multipliers are computed, as in the plane."""
    return problem.directions == 1


def same_slip(problem: Problem, load_factor: float, tolerances: Tolerances) -> float:
    """Difference between the slips of limit cycles that counts as none [length] (``same_cycle``)."""
    known = APART * path_accuracy(problem, tolerances)  # the accuracy of the ends of searches
    share = max(tolerances.same_cycle, known)
    return share * scales(problem, load_factor).length
