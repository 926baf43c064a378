"""The results of a design sweep, in words."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.shown_values import DIGITS, down, few, up
from shakedown.ground.size_limits import EACH_SHOWN

if TYPE_CHECKING:
    from shakedown.studies.sweep import Sweep

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
