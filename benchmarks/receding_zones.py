"""Chapter III of the thesis in pictures: unloading to zero, p_max/3, the ninth cycle, the steady state.

The block of ``benchmarks.receding``, its right half; plane strain, which is our choice:
the thesis does not say which plane it means, nor its mesh. It prints the zones as
drawings, with these words, each of which is a number here:

- fig. 3.3, unloading to zero: stick at the edges of the contact at once; the contact
  area falls monotonically; at zero load all slip reverts and all gaps close;
- fig. 3.5, ninth cycle: three stick regions (of the whole contact) separated by small
  slip regions during unloading, which stay stuck during reloading (here the outermost of
  their nodes slip again in its last hundredths);
- fig. 3.7, steady state: points that reach |q| = f p but do not slip.
"""

from dataclasses import replace
from itertools import groupby
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import shakedown
from benchmarks.bodies.blocks import receding_block
from benchmarks.receding import LETTERS
from shakedown import Problem, plot
from shakedown.motion.event_history import EventHistory
from shakedown.motion.evolution import evolve
from shakedown.report.facts import table

TITLE = "Chapter III: zones at full unloading, in the ninth cycle and in the steady state"
P_MAX, THIRD, NINTH = -0.5, 0.0, 7.5  # times in cycles: p_max, p_max/3 in the first cycle, p_max again
SOON = 1e-3  # of a cycle: "at once"
NEARLY_ALL = 0.9  # how much of an unloading or reloading counts as its main part
AT_THE_LIMIT = 1e-9  # as the marks of plot.zones


def cases(short: bool) -> list[dict[str, Any]]:
    return [{"refinement": refinement} for refinement in ((2, 4) if short else (4, 8, 12))]


def measure(case: dict[str, Any]) -> dict[str, Any]:
    """What the thesis says in words about figs. 3.3, 3.5 and 3.7, as numbers."""
    refinement = case["refinement"]
    down, _ = unloading(refinement)
    cycling, block = ninth_cycle(refinement)
    half = cycling.cycle < THIRD + 8 - 1e-9
    early = cycling.cycle < THIRD + 8 + 0.5 * NEARLY_ALL  # nine tenths of the reloading
    inner = (cycling.state[half] == -1).any(axis=0)  # slips outwards while the pressure falls
    steady = shakedown.long_term_state(block, 1.0).history
    assert steady is not None
    return {
        "nodes": block.n,
        "slip_left": _left(down.v),
        "gap_left": _left(down.w),
        "sticks_at_once": int((down.at(np.array([P_MAX + SOON])).state[0] == 0).sum()),
        "in_contact_at_p_max": int((down.state[0] != 2).sum()),
        "contact_grows": int((np.diff((down.state[:-1] != 2).sum(axis=1)) > 0).sum()),
        "unloading_zones": pattern(down, P_MAX + 0.5 * NEARLY_ALL),
        "ninth_zones": pattern(cycling, NINTH + 0.5 * NEARLY_ALL),
        "ninth_inner": int(inner.sum()),
        "ninth_inner_slipping_again": _slipping(cycling.rows(~half), inner),
        "ninth_inner_slipping_early": _slipping(cycling.rows(~half & early), inner),
        "steady_zones": pattern(steady, steady.cycle[0] + 0.5 * NEARLY_ALL),
        "steady_slipping": int(steady.slips().sum()),
        "first_slipping": int(first_cycle(refinement)[0].slips().sum()),
        "steady_at_limit": limit_reached(steady, block),
    }


def unloading(refinement: int) -> tuple[EventHistory, Problem]:
    """The path from p_max to no load, and the block."""
    block = receding_block(refinement, symmetric=True, unloading=0.0)
    return between(evolve(block, 1.0, cycles=1).history, P_MAX, 0.0), block


def first_cycle(refinement: int) -> tuple[EventHistory, Problem]:
    """The path p_max → p_max/3 → p_max after the first loading, and the block."""
    block = right_half(refinement)
    return between(evolve(block, 1.0, cycles=1).history, P_MAX, P_MAX + 1), block


def ninth_cycle(refinement: int) -> tuple[EventHistory, Problem]:
    """The path of the ninth cycle, and the block."""
    block = right_half(refinement)
    return between(evolve(block, 1.0, cycles=9).history, NINTH, NINTH + 1), block


def between(path: EventHistory, begin: float, end: float) -> EventHistory:
    """The rows of a path from one load step to another; of several at the beginning the last."""
    first = int(np.searchsorted(path.cycle, begin + 1e-9, side="right")) - 1
    last = int(np.searchsorted(path.cycle, end - 1e-9))
    return path.rows(np.arange(first, last + 1))


def pattern(path: EventHistory, time: float) -> str:
    """Zones from the middle outwards, one letter each: s stick, + slip outwards, - inwards, o open."""
    states = path.state[np.searchsorted(path.cycle, time, side="right") - 1]
    return "".join(letter for letter, _ in groupby(LETTERS[int(state)] for state in states))


def limit_reached(path: EventHistory, problem: Problem) -> int:
    """How many nodes reach |q| = f p, but never slip or open; the middle, with q = 0, aside."""
    limit = problem.f * path.p
    noise = AT_THE_LIMIT * float(limit.max())
    reached = ((np.abs(path.q) >= limit - noise) & (limit > noise)).any(axis=0)
    return int((reached & ~path.slips() & (path.state != 2).all(axis=0)).sum())


def _left(values: np.ndarray) -> float:
    """What is left at the end, of the largest before."""
    return float(np.abs(values[-1]).max() / np.abs(values).max())


def _slipping(path: EventHistory, nodes: np.ndarray) -> int:
    """How many of these nodes slip."""
    return int((path.slips() & nodes).sum())


def tables(rows: list[dict[str, Any]]) -> str:
    head = [
        "nodes", "slip left", "gap left", "stick at once", "contact grows", "zones, unloading",
        "ninth cycle", "of its inner nodes slip again, early / ever", "steady", "slipping, first / steady",
        "at the limit only",
    ]  # fmt: skip
    lines = [
        [
            str(row["nodes"]), f"{row['slip_left']:.0e}", f"{row['gap_left']:.0e}",
            f"{row['sticks_at_once']} of {row['in_contact_at_p_max']}", f"{row['contact_grows']} times",
            row["unloading_zones"], row["ninth_zones"],
            " / ".join(str(row[f"ninth_inner_slipping_{when}"]) for when in ("early", "again"))
            + f" of {row['ninth_inner']}",
            row["steady_zones"],
            f"{row['first_slipping']} / {row['steady_slipping']}", str(row["steady_at_limit"]),
        ]
        for row in rows
    ]  # fmt: skip
    return table(head, lines)


def figures(rows: list[dict[str, Any]]) -> dict[str, Figure]:
    refinement = max(row["refinement"] for row in rows)
    return {
        "receding-histories": zone_figure(refinement),
        "receding-unloaded": traction_figure(refinement),
    }


def zone_figure(refinement: int) -> Figure:
    """Zones over position and time at full unloading, in the ninth cycle, in the steady state."""
    (down, block), (ninth, _) = unloading(refinement), ninth_cycle(refinement)
    steady = shakedown.long_term_state(right_half(refinement), 1.0).history
    assert steady is not None
    figure = Figure(figsize=(11.5, 5.4), layout="constrained")
    left, middle, right = figure.subplots(1, 3, sharex=True)
    for axes, path, title in (
        (left, down, "unloading to zero (thesis fig. 3.3)"),
        (middle, ninth, "ninth cycle (fig. 3.5)"),
        (right, steady, "steady state (fig. 3.7)"),
    ):
        plot.zones(path, block, ax=axes, marks=axes is right)
        axes.set(title=title, xlabel="distance from the middle [h]", ylabel="")
        _pressure_ticks(axes, path)
        legend = axes.get_legend()
        assert legend is not None
        legend.remove()  # one for all: the last one has every entry
    figure.legend(
        handles=legend.legend_handles, labels=[text.get_text() for text in legend.get_texts()],
        loc="outside lower center", ncols=5, frameon=False,
    )  # fmt: skip
    left.set_ylabel("pressure, in the order of time")
    figure.suptitle(f"Receding contact, {block.n} nodes on the half, plane strain")
    return figure


def right_half(refinement: int) -> Problem:
    return receding_block(refinement, symmetric=True)


def _pressure_ticks(axes: Axes, path: EventHistory) -> None:
    begin, end = path.cycle[[0, -1]]
    if end - begin < 0.75:
        axes.set_yticks(np.linspace(begin, end, 3), ["p_max", "p_max/2", "0"])
    else:
        axes.set_yticks(np.linspace(begin, end, 3), ["p_max", "p_max/3", "p_max"])


def traction_figure(refinement: int) -> Figure:
    """Tractions at p_max and p_max/3 of the first unloading (fig. 3.4), and the use of friction."""
    path, block = first_cycle(refinement)
    area = np.full(block.n, 0.25 / refinement)
    area[[0, -1]] /= 2
    figure = Figure(figsize=(11.5, 4.4), layout="constrained")
    left, right = figure.subplots(1, 2, sharex=True)
    times = [P_MAX, THIRD]
    plot.pressure(path, replace(block, node_area=area), cycles=times, ax=left)
    plot.friction_use(path, block, cycles=times, ax=right)
    for axes in (left, right):
        for line, label in zip(axes.get_lines(), ("p_max", "p_max/3, unloading"), strict=False):
            line.set_label(label)
        axes.legend(fontsize="small")
        axes.set_xlabel("distance from the middle [h]")
    left.set_ylabel("pressure [p_max]")
    figure.suptitle(f"First unloading of the receding contact (thesis fig. 3.4), {block.n} nodes on the half")
    return figure
