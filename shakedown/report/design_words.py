"""What a sweep over designs says, in words."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from shakedown.designs.diagram import Sweep

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
    "never": "certain not to shake down with all nodes in contact",
}
BEST = {"universal": "λ_U (from every state)", "energy": "λ_E (from this state)", "upper": "λ_max"}


def sweep_in_words(sweep: "Sweep", load_factor: float = 1.0) -> list[str]:
    """What an engineer asks first: where the joint is safe under a load factor, and where it does best.

    Examples
    --------
    >>> import shakedown
    >>> found = shakedown.sweep(shakedown.example("two-node"), {"f": [0.2, 0.4, 0.6]})
    >>> first, best, *_ = sweep_in_words(found, 0.7)
    >>> print(first)
    At λ = 0.7 the joint is proved to shake down from every state for f = 0.4; proved to shake down from
    the state asked about for f = 0.6; certain not to shake down with all nodes in contact for f = 0.2.
    >>> print(best)
    The largest λ_U (from every state) is 0.7198472, at f = 0.4.
    """
    regions = sweep.regions(load_factor)
    where = [
        f"{text} for {_places(sweep, regions == name)}" for name, text in SAID.items() if name in regions
    ]
    given = "At the loading as given (λ = 1)" if load_factor == 1.0 else f"At λ = {load_factor:g}"
    sentences = [f"{given} the joint is {'; '.join(where)}."] if where else []
    sentences += _best(sweep)
    missing = [point for point in sweep.points if not point.exists]
    if missing:
        count = f"{len(missing)} of {len(sweep.points)} points"
        sentences.append(f"There is no joint at {count}, the first because: {missing[0].reason}.")
    return sentences


def _best(sweep: "Sweep") -> Iterator[str]:
    """Where each limit is largest."""
    for name, text in BEST.items():
        if name not in sweep.bounds or len(sweep.points) < 2:
            continue
        values = sweep.load_factors(name)
        if np.isfinite(values).any() and not np.isinf(values).any():
            place = np.unravel_index(np.nanargmax(values), sweep.shape)
            pairs = zip(sweep.parameters, sweep.values, place, strict=True)
            at = ", ".join(f"{parameter} = {v[k]:.6g}" for parameter, v, k in pairs)
            yield f"The largest {text} is {values[place]:.7g}, at {at}."


def _places(sweep: "Sweep", chosen: NDArray[np.bool_]) -> str:
    """The points of a region: ranges of one parameter, or how many of two."""
    if len(sweep.parameters) == 2:
        return f"{chosen.sum()} of {chosen.size} points"
    values, places = sweep.values[0], np.flatnonzero(chosen)
    runs = np.split(places, np.flatnonzero(np.diff(places) > 1) + 1)
    texts = [
        f"{values[run[0]]:.6g}" if len(run) == 1 else f"{values[run[0]]:.6g} … {values[run[-1]]:.6g}"
        for run in runs
    ]
    return f"{sweep.parameters[0]} = {', '.join(texts)}"
