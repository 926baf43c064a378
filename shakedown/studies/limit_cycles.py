"""The distinct limit cycles among many long-term states, and how far their slips scatter."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.size_limits import AT_ONCE
from shakedown.ground.status import Outcome
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.long_term.find_state import long_term_state
from shakedown.motion.checked_law import length_scales, path_accuracy, path_resolution, scales
from shakedown.motion.method import cycles_of
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

MOST_ALONE = 20  # limit cycles of a kind that are told apart; further ones count as a continuum
MOST_LONELY = 2  # states of a kind with a limit cycle of their own; the others then count as a continuum
APART = 160.0  # times the error of a path over one cycle: closer states are the same


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

    A limit cycle stands alone where every node slips, so that no slip is locked in, and several states
    end on it, to the tolerance ``same_cycle``. All others with the same period and the same slipping nodes
    count together, as one of a continuum.

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
        rest = list[tuple[_Examined, Rows]]()
        for _ in range(MOST_ALONE if len(kind.slipping_nodes) == problem.n else 0):
            if not len(rows) or len(rest) == MOST_LONELY:
                break
            one = _examined(seen, kind, int(rows[0]))
            here = _ends_on(seen, rows, one.cycle)
            if np.count_nonzero(here) > 1:
                found.append(_counted(seen, one, rows[here], alone=True))
            else:
                rest.append((one, rows[here]))
            rows = rows[~here]
        if len(rows):
            rest.append((_examined(seen, kind, int(rows[0])), rows))
        if rest:  # the largest part is the example
            one = max(rest, key=lambda part: len(part[1]))[0]
            found.append(_counted(seen, one, np.concatenate([part for _, part in rest])))
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


def _examined(seen: _Seen, kind: _Kind, example: int) -> _Examined:
    """The limit cycle that one state leads to, with the slips at the ends of its cycles."""
    cycle = LimitCycle(
        count=1,
        outcome=kind.outcome,
        period=kind.period,
        dissipation=(np.nan, np.nan),
        slipping_nodes=kind.slipping_nodes,
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
    if state.period:
        ends = np.array([record.end_slip for record in cycles_of(state.motion(), state.period)])
        cycle = replace(cycle, final_slip=ends)
    return _Examined(cycle, state.drift)


def _counted(seen: _Seen, one: _Examined, rows: Rows, *, alone: bool = False) -> LimitCycle:
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
        coincide=alone or bool(scatter.spread <= seen.same and same_work),
    )


def _known(drift: FloatArray) -> FloatArray | None:
    return None if np.isnan(drift).any() else drift


def same_slip(problem: Problem, load_factor: float, tolerances: Tolerances) -> float:
    """Difference between the slips of limit cycles that counts as none [length] (``same_cycle``)."""
    known = APART * path_accuracy(problem, tolerances)  # the accuracy of the ends of searches
    share = max(tolerances.same_cycle, known)
    return share * scales(problem, load_factor).length
