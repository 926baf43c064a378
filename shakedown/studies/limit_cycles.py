"""What many states end in: distinct limit cycles, how far slips scatter, whether it is one and the same."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import FloatArray, IntArray
from shakedown.ground.status import Outcome
from shakedown.joint.result import Result
from shakedown.motion.checked_law import least_slip, length_scales, path_accuracy, path_resolution, scales
from shakedown.motion.method import cycles_of
from shakedown.studies.samplers import Sampling

Columns = dict[str, NDArray[Any]]
Rows = IntArray  # numbers of states


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


def slip_scatter(
    final_slip: FloatArray, rows: Rows, places: FloatArray, drift: FloatArray | float = 0.0
) -> Scatter:
    """The scatter of the final slips of some states about the limit cycle of one of them; NaN of none.

    States may have stopped at different cycles of a period: each is compared with the place
    (end of a cycle) that it is nearest to. Of states that drift, the part of the slip along the
    drift says only when they stopped, and is left out.

    Parameters
    ----------
    final_slip : (s, dn)
        Slips that all states end on [length].
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
        return Scatter(np.nan, np.nan)
    size = float(np.linalg.norm(drift))
    along = np.zeros(places.shape[1]) + drift / (size or 1.0)
    ends, places = (at - np.outer(at @ along, along) for at in (final_slip[rows], places))
    away = _from_nearest(ends, places)
    return Scatter(float(np.ptp(away, axis=0).max()), float(np.abs(ends).max()))


def _from_nearest(ends: FloatArray, places: FloatArray) -> FloatArray:
    """Differences from that place which each of the slips is nearest to."""
    nearest = np.argmin([np.abs(ends - place).max(axis=1) for place in places], axis=0)
    return ends - places[nearest]


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


# The limit cycle that a state leads to: its row, slips at the ends of its cycles, growth of slip per period.
_Example = tuple[int, FloatArray, FloatArray]


def limit_cycles(sampling: Sampling, columns: Columns) -> tuple[LimitCycle, ...]:
    """The distinct limit cycles of a map, the most frequent first.

    A limit cycle stands alone where every node slips, so that no slip is locked in, and several states
    end on it, to the tolerance ``same_cycle``. All others with the same period and the same slipping nodes
    count together, as one of a continuum.

    Parameters
    ----------
    sampling
        The joint, λ, and the initial states.
    columns
        What they lead to.
    """
    found, same = list[LimitCycle](), same_slip(sampling)
    for slipping, rows in _by_kind(sampling, columns):
        rest = list[tuple[_Example, Rows]]()
        # limit cycles of a kind that are told apart; further ones count as a continuum
        for _ in range(20 if len(slipping) == sampling.problem.n else 0):
            # states of a kind with a limit cycle of their own; the others then count as a continuum
            if not len(rows) or len(rest) == 2:
                break
            _, places, _ = one = _example(sampling, columns, rows[0])
            here = np.abs(_from_nearest(columns["final_slip"][rows], places)).max(axis=1) <= same
            here[0] = True
            if np.count_nonzero(here) > 1:
                found.append(_counted(sampling, columns, slipping, one, rows[here], alone=True))
            else:
                rest.append((one, rows[here]))
            rows = rows[~here]
        if len(rows):
            rest.append((_example(sampling, columns, rows[0]), rows))
        if rest:  # the largest part is the example
            one, every = max(rest, key=lambda part: len(part[1]))[0], np.concatenate([own for _, own in rest])
            found.append(_counted(sampling, columns, slipping, one, every, alone=False))
    return tuple(sorted(found, key=lambda cycle: (-cycle.count, cycle.example)))


def _by_kind(sampling: Sampling, columns: Columns) -> Iterator[tuple[tuple[int, ...], Rows]]:
    """Of limit cycles alike in outcome, period and slipping nodes: these, and the rows of their states."""
    problem = sampling.problem
    still = least_slip(problem, sampling.tolerances) * length_scales(problem, sampling.load_factor)
    outcome, period, slips = columns["outcome"], columns["period"], columns["slip_per_cycle"] > still
    cyclic = np.flatnonzero((period > 0) & (outcome != Outcome.SHAKEDOWN))
    if not len(cyclic):
        return
    _, names = np.unique(outcome[cyclic], return_inverse=True)
    keys = np.column_stack([names.ravel(), period[cyclic], np.packbits(slips[cyclic], axis=1)])
    _, first, group = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    for number, row in enumerate(cyclic[first]):
        yield tuple(np.flatnonzero(slips[row]).tolist()), cyclic[group.ravel() == number]


def _example(sampling: Sampling, columns: Columns, row: int) -> _Example:
    """The limit cycle that one state leads to."""
    state = sampling.state(columns["initial_slip"][row])
    places = [record.end_slip for record in cycles_of(state.motion(), state.period)] if state.period else []
    return (int(row), np.array(places or [columns["final_slip"][row]]), np.nan_to_num(state.drift))


def _counted(
    sampling: Sampling, columns: Columns, nodes: tuple[int, ...], one: _Example, rows: Rows, alone: bool
) -> LimitCycle:
    """A limit cycle with the states that lead there, and how far apart they end."""
    (row, places, drift), dissipation = one, columns["dissipation"][rows]
    low, high = float(dissipation.min()), float(dissipation.max())
    scatter = slip_scatter(columns["final_slip"], rows, places, drift)
    scale = scales(sampling.problem, sampling.load_factor)
    none = path_resolution(sampling.problem, sampling.tolerances) * scale.length * scale.force
    same_work = high - low <= sampling.tolerances.same_cycle * high + none
    return LimitCycle(
        outcome=str(columns["outcome"][row]),
        period=int(columns["period"][row]),
        slipping_nodes=nodes,
        count=int(np.count_nonzero(rows >= len(sampling.named))),
        dissipation=(low, high),
        contact_sequences=len(np.unique(columns["signature"][rows])),
        example=row,
        final_slip=places,
        spread=scatter.spread,
        coincide=alone or bool(scatter.spread <= same_slip(sampling) and same_work),
        named=tuple(name for k, name in enumerate(sampling.named) if k in rows),
    )


def same_slip(sampling: Sampling) -> float:
    """Difference between the slips of limit cycles that counts as none [length] (``same_cycle``)."""
    # times the error of a path over one cycle: closer states are the same
    known = 160.0 * path_accuracy(sampling.problem, sampling.tolerances)  # of the ends of searches
    share = max(sampling.tolerances.same_cycle, known)
    return share * scales(sampling.problem, sampling.load_factor).length


def final_states(
    sampling: Sampling, outcomes: Mapping[str, int], cycles: Sequence[LimitCycle], at_rest: Scatter
) -> tuple[bool | None, bool | None]:
    """Whether all states have the same outcome, and whether they end in one state; None where not known.

    It is not where some are undecided, or the body leaves, and the others do not differ. One state is one
    with the slips that stay locked in.

    Parameters
    ----------
    sampling
        The joint, λ, and the initial states.
    outcomes
        How many states have each outcome.
    cycles
        The distinct limit cycles.
    at_rest
        Scatter of the slips locked in where it shakes down.
    """
    decided = [word for word in outcomes if word != Outcome.UNDECIDED]
    if len(decided) > 1:
        return False, False
    same_outcome = True if decided and Outcome.UNDECIDED not in outcomes else None
    apart = at_rest.spread > same_slip(sampling) or not all(cycle.coincide for cycle in cycles)
    if apart or len(cycles) > 1:
        return same_outcome, False
    ends = sum(cycle.count + len(cycle.named) for cycle in cycles)
    leaves = decided != [Outcome.SHAKEDOWN] and ends < sum(outcomes.values())
    return same_outcome, None if leaves else same_outcome
