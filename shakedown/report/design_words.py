"""The results of a design sweep and of the search for the smallest cycle, in words."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.shown_values import DIGITS, FEW_DIGITS, at_lambda, cycles_in_words, down, few, up
from shakedown.ground.size_limits import EACH_SHOWN

if TYPE_CHECKING:
    from shakedown.joint.problem import Problem
    from shakedown.studies.diagram import Sweep
    from shakedown.studies.smallest_cycle import SmallestCycle

# What is said of a region, and its name in a table.
SHORT = {
    "proved from every state": "every state",
    "proved from this state": "this state",
    "depends on the state": "depends",
    "never": "never",
    "no joint": "no joint",
}
SAID = {
    "proved from every state": "proved to shake down from every state",
    "proved from this state": "proved to shake down from the state asked about",
    "depends on the state": "open, or dependent on the state,",
    "never": "certain not to shake down while all nodes stay in contact",
}
HERE = "λ_here"  # the largest limit proved from the state asked about
TIED = 10.0**-DIGITS  # as a fraction of the largest limit: differences not shown
SAME = 10.0**-FEW_DIGITS  # as a fraction of λ_1: a cycle this near begins at it
SEPARATES = "nodes open and close in every period, or contact is lost, without slip in contact,"
NOTHING = 1e-5  # as a fraction of where the search began: counts as zero


def sweep_in_words(sweep: "Sweep", load_factor: float = 1.0) -> list[str]:
    """What an engineer asks first: where the joint is safe under a load factor, and where it does best.

    Examples
    --------
    >>> import shakedown
    >>> found = shakedown.sweep(shakedown.example("two-node"), {"f": [0.2, 0.4, 0.6]})
    >>> first, best, *_ = sweep_in_words(found, 0.7)
    >>> print(first)
    At λ = 0.7 the joint is proved to shake down from every state at f = 0.4; proved to shake down from
    the state asked about at f = 0.6; certain not to shake down while all nodes stay in contact at f = 0.2.
    Between these values nothing is proved.
    >>> print(best)
    The largest λ_U (from every state) is 0.7198472, at f = 0.4.
    """
    regions = sweep.regions(load_factor)
    where = [f"{text} {_places(sweep, regions == name)}" for name, text in SAID.items() if name in regions]
    given = "At the nominal load (λ = 1)" if load_factor == 1.0 else f"At λ = {load_factor:g}"
    between = "the points" if len(sweep.parameters) == 2 else "these values"
    only = f" Between {between} nothing is proved." if len(sweep.points) > 1 else ""
    sentences = [f"{given} the joint is {'; '.join(where)}.{only}"] if where else []
    sentences += _best(sweep)
    zones = sum(bool(point.open_nodes) for point in sweep.points)
    if zones and {"upper", "energy"} & set(sweep.bounds):
        sentences.append(
            f"At {zones} of {len(sweep.points)} points λ_max and λ_E are those of a joint with nodes open, "
            "where λ_max is no upper bound of the whole."
        )
    missing = [point for point in sweep.points if not point.exists]
    if missing:
        count = f"{len(missing)} of {len(sweep.points)} points"
        sentences.append(f"There is no joint at {count}, the first because: {missing[0].reason}.")
    return sentences


def _best(sweep: "Sweep") -> Iterator[str]:
    """Where each limit is largest."""
    limits = [
        ("λ_U (from every state)", sweep.universal, down),
        (f"{HERE} (proved from this state)", sweep.from_this_state, down),
        ("λ_max", sweep.upper, up),
    ]
    for text, values, rounded in limits if len(sweep.points) > 1 else []:
        if not np.isfinite(values).any() or np.isinf(values).any():
            continue
        largest = float(np.nanmax(values))
        if largest == 0.0:
            yield f"{text} is 0 at every point."
            continue
        tied, shown = values >= largest * (1.0 - TIED), rounded(largest)
        if tied.all():
            yield f"{text} is {shown} at every point."
        else:
            yield f"The largest {text} is {shown}, {_places(sweep, tied)}."


def _places(sweep: "Sweep", chosen: NDArray[np.bool_]) -> str:
    """Some of the computed points: by value, or counted where many are consecutive or two parameters vary."""
    places = np.argwhere(chosen)
    if len(places) == 1:
        return "at " + ", ".join(_valued(sweep, axis, [k]) for axis, k in enumerate(places[0]))
    if len(sweep.parameters) == 2:
        return f"at {len(places)} of {chosen.size} points"
    runs = np.split(places[:, 0], np.flatnonzero(np.diff(places[:, 0]) > 1) + 1)
    if len(runs[0]) == chosen.size > EACH_SHOWN:
        return f"at all {_counted(sweep, runs[0])}"
    listed = [k for run in runs if len(run) <= EACH_SHOWN for k in run]
    texts = [f"at the {_counted(sweep, run)}" for run in runs if len(run) > EACH_SHOWN]
    return " and ".join(([f"at {_valued(sweep, 0, listed)}"] if listed else []) + texts)


def _valued(sweep: "Sweep", axis: int, places: Sequence[int]) -> str:
    """A parameter with some of its values; with × where they are factors."""
    *most, last = (few(sweep.values[axis][k], DIGITS) for k in places)
    values = f"{', '.join(most)} and {last}" if most else last
    if sweep.is_factor(axis):
        return f"{sweep.meanings[axis]} × {values}"
    return f"{sweep.parameters[axis]} = {values}"


def _counted(sweep: "Sweep", run: NDArray[np.intp]) -> str:
    """Consecutive values of the parameter: their number and range."""
    values = sweep.values[0][run]
    what = f"factors on {sweep.meanings[0]}" if sweep.is_factor(0) else f"values of {sweep.parameters[0]}"
    return f"{len(values)} {what} from {few(values[0], DIGITS)} to {few(values[-1], DIGITS)}"


def cycle_in_words(found: "SmallestCycle", problem: "Problem | None" = None) -> list[str]:
    """Between which load factors the joint's true limit lies, and what that says of its bounds.

    With the problem its nodes are called by their labels.

    Examples
    --------
    >>> import shakedown
    >>> for sentence in cycle_in_words(shakedown.smallest_cycle(shakedown.example("three-node"), rounds=2)):
    ...     print(sentence)
    The load factor up to which the joint shakes down from every state lies between λ_U = 0.309...
    (proved) and λ_cycle = 2.444211 (a cycle was found).
    It lies at 78.9% of the first collapse λ_1 = 3.096, which is no guarantee here.
    In that cycle node 0 slips and returns to where it was every cycle.
    """
    from shakedown.report.node_words import open_in_words

    contradiction = [f"CONTRADICTION: {found.contradiction}, and yet:"] if found.contradiction else []
    sentences = [*contradiction, *_enclosed(found), *_against_first_collapse(found)]
    if found.state is None:
        return [*sentences, _none_found(found)]
    one = len(found.slipping_nodes) == 1
    back = "returns to where it was" if one else "return to where they were"
    after = f"gain{'s' * one} slip" if found.state.drift.any() else back
    apart = found.separation_load_factor < found.load_factor
    which = f"The smallest cycle was found at λ_cycle = {up(found.load_factor)}. " if apart else ""
    who = f"{which}In that cycle {open_in_words(found.slipping_nodes, problem)} slip{'s' * one}"
    return [*sentences, f"{who} and {after} every {cycles_in_words(found.period)}."]


def _none_found(found: "SmallestCycle") -> str:
    """Where no cycle was found, and how far that goes."""
    open_ones = f", {found.undecided} of them undecided," if found.undecided else ""
    return (
        f"No cycle was found: {found.tries} simulations{open_ones} at load factors up to "
        f"{at_lambda(found.tried_up_to)}. What dissipates less than {found.least_dissipation:.1e} per cycle "
        "is no more than round-off of the data, and is called none."
    )


def _enclosed(found: "SmallestCycle") -> Iterator[str]:
    """The interval in which the true limit lies."""
    proved, limit = found.interval
    if not np.isfinite(limit):
        if proved > 0:
            yield f"Shakedown from every state is proved up to λ_U = {down(proved)}."
        return
    if limit == found.load_factor:
        name, what, verb = "λ_cycle", "a cycle was found", "the joint cycles"
    else:
        name, what, verb = "λ", "separation was found", SEPARATES
    if proved > 0:
        yield (
            "The load factor up to which the joint shakes down from every state lies between "
            f"λ_U = {down(proved)} (proved) and {name} = {up(limit)} ({what})."
        )
        if name == "λ":
            yield f"From some state {verb} there."
    elif limit <= NOTHING * found.tried_up_to:
        yield (
            f"No load factor is proved safe from every state, nor can be: from some state {verb} at "
            f"λ = {limit:.1g} already."
        )
    else:
        yield (
            f"From some state {verb} at {name} = {up(limit)}; below it no load factor is proved safe "
            "from every state."
        )


def _against_first_collapse(found: "SmallestCycle") -> Iterator[str]:
    """How the smaller of cycle and separation compares with λ_1, where there is one."""
    lower = found.limits.lower
    limit, first = found.interval[1], lower.load_factor if lower else np.nan
    share = limit / (first or np.nan)
    if not np.isfinite(share):
        return
    if share < 1.0 - SAME or (limit == found.load_factor and found.below_first_collapse):
        yield f"It lies at {share:.1%} of the first collapse λ_1 = {down(first)}, which is no guarantee here."
    elif share - 1.0 <= SAME:
        rest = "cycles" if limit == found.load_factor else "cycles or separates"
        yield (
            f"It begins at the first collapse, λ_1 = {down(first)}: no state was found that {rest} below it, "
            "and some do at once above it."
        )
    else:
        yield f"It lies {share - 1.0:.1%} above the first collapse, λ_1 = {down(first)}."
