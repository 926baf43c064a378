"""Pictures of a verification: the limits on one scale, and one panel of runs per load factor."""

from collections.abc import Callable, Sequence
from functools import partial
from itertools import groupby
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from shakedown import plot
from shakedown.joint.units import units_of
from shakedown.motion.contact_law import scales
from shakedown.plot.inline_svg import PANEL, Panel, Picture, panel
from shakedown.plot.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, RED
from shakedown.report.node_words import open_in_words, resolution, without_round_off
from shakedown.report.page_tables import limits_on_page, transient_is_proved
from shakedown.verification.verify import Run, Verification

COLOURS = {"zero": BLACK, "safe": GREEN, "witness": RED, "given": PURPLE, "random": BLUE, "ball": ORANGE}
WIDE, NARROW = (5.4, 2.1), (3.4, 2.6)  # of the scale of load factors [inch]
LINE = 0.18  # height of one line of a legend [inch]
LONG_LABEL = 16  # letters; of longer ones two stand side by side


def scale_picture(v: Verification) -> Picture:
    """Every limit of the load factor on one scale, with λ = 1."""
    upper = v.bounds.upper
    marks = limits_on_page(v, 4)
    known = v.from_state
    here, everywhere = (np.nan_to_num(x, posinf=np.inf) for x in (known.load_factor, v.universal.load_factor))
    proved = (0.0, everywhere) if everywhere >= here else (known.least_load_factor, here)
    bands = {"proved": proved}
    if np.isfinite(upper.load_factor) and not upper.open_nodes:
        bands["excluded"] = (upper.load_factor, np.inf)
    shown = ", ".join(f"{name} = {value:.4g}" for name, value in marks.items() if np.isfinite(value))
    alt = f"Scale of the load factor with {shown or 'no limit'} and λ = 1, the loading as given"
    state = (
        f"with {open_in_words(upper.open_nodes, v.problem)} open" if upper.open_nodes else "from this state"
    )
    caption = (
        (
            f"Green: proved to shake down, {state} ({known.symbol}) or from every state (λ_U). "
            if proved[1] > 0
            else ""
        )
        + ("Red: no safe state with all nodes in contact. " if "excluded" in bands else "")
        + "λ_1: first collapse. λ_T: up to there it shakes down from this state, simulated"
        + ", proved there" * transient_is_proved(v)
        + ". λ_max: largest "
        + ("load factor with a safe state of the zone." if upper.open_nodes else "one with a safe state.")
    )
    drawn = panel(alt, partial(plot.load_factor_scale, marks, bands=bands), size=WIDE)
    narrow = panel(
        f"{alt}, for a narrow screen",
        partial(plot.load_factor_scale, marks, bands=bands, short=True),
        size=NARROW,
    )
    return Picture(caption, (drawn, narrow))  # the style of the page shows one of them


def run_pictures(v: Verification) -> list[Picture]:
    """Slip per cycle, paths in the slip plane of two nodes, final slips along the contact."""
    pictures = [
        Picture(
            "Slip per cycle of the node that slips most, against the cycle number. Slips too small to count "
            "are drawn on the floor, “no slip”. A line that falls to it has shaken down, or is separation: "
            "nodes open and close in every cycle, without slip in contact. One that ends on its way down was "
            "followed no further: shakedown was proved there, or the run is undecided. A level line above "
            "the floor is cyclic slip or ratchetting.",
            _panels(v, "Slip per cycle against the cycle number", _slip_per_cycle),
        )
    ]
    if v.problem.n == 2:
        pictures.append(
            Picture(
                "Slip space: the limits of both nodes at their extreme load steps, the safe region between "
                "them, and the paths from the initial states (circle: start, square: end).",
                _panels(v, "Limits, safe region and paths in the plane of both slips", _slip_space, 5),
            )
        )
    if v.problem.n > 2:
        pictures.append(
            Picture(
                "Slip along the contact at the end of each run.",
                _panels(v, "Final slip of every run along the contact", _final_slip),
            )
        )
    return pictures


def guarantee_picture(v: Verification) -> Picture | None:
    """First collapse λ_1(R) against the radius within which initial states keep to the safe slip."""
    if v.curve is None:
        return None
    stays = (
        "No slip leads out of such a box, so that a joint that starts inside stays inside"
        + (", the transient once over." if v.problem.q_transient is not None else ".")
        if v.curve.invariant
        else "Slip may lead out of such a box: either the coupling is too strong, or its middle is not safe "
        "at every smaller load factor."
    )
    unit = f"{v.curve.unit:.4g} {units_of(v.problem)[1]}".rstrip()
    caption = (
        "First collapse when every other slip keeps within R of the safe slip; R = 1 is the largest safe "
        f"slip, {unit}. {stays}"
    )
    alt = "First collapse λ_1(R) against the radius R of the box of initial states"
    return Picture(caption, (panel(alt, partial(plot.guarantee, v.curve, v.bounds)),))


def _panels(
    v: Verification, what: str, draw: Callable[[Verification, list[Run], Axes], None], lines: int = 2
) -> tuple[Panel, ...]:
    """One panel per load factor, with so many lines of legend below it."""
    panels = []
    for title, runs in _by_load_factor(v.runs):

        def drawn(*, ax: Axes, runs: list[Run] = runs) -> None:
            draw(v, runs, ax)
            _one_entry_per_label(ax)

        size, below = (PANEL[0], PANEL[1] + LINE * lines), LINE * lines
        panels.append(panel(f"{what}, {title}", drawn, name=title, size=size, below=below))
    return tuple(panels)


def _slip_per_cycle(v: Verification, runs: list[Run], axes: Axes) -> None:
    simulations = {run.initial: run.simulation for run in runs}
    none, _ = resolution(v.problem, runs[0].simulation.load_factor)
    plot.slip_per_cycle(simulations, v.problem, styles=_styles(runs), resolution=none, ax=axes)


def _slip_space(v: Verification, runs: list[Run], axes: Axes) -> None:
    paths = {run.initial: run.simulation for run in runs if run.simulation.history is not None}
    plot.slip_space(v.problem, runs[0].simulation.load_factor, paths, styles=_styles(runs), ax=axes)
    axes.set_title("")


def _final_slip(v: Verification, runs: list[Run], axes: Axes) -> None:
    none, _ = resolution(v.problem, runs[0].simulation.load_factor)
    slips = {run.initial: np.array(without_round_off(run.simulation.final_slip, none)) for run in runs}
    plot.slip_along(slips, v.problem, what="final slip", styles=_styles(runs), ax=axes)
    if not any(slip.any() for slip in slips.values()):  # nothing to scale by but what slip would be safe
        safe = float(np.nanmax(np.abs(v.bounds.upper.slip), initial=0.0))
        reach = safe if safe > none else scales(v.problem, runs[0].simulation.load_factor).length
        axes.set_ylim(-reach, reach)


def _by_load_factor(runs: Sequence[Run]) -> list[tuple[str, list[Run]]]:
    groups = groupby(runs, key=lambda run: (run.simulation.load_factor, run.region))
    return [(f"λ = {factor:.5g}, {region}", list(group)) for (factor, region), group in groups]


def _styles(runs: Sequence[Run]) -> dict[str, dict[str, Any]]:
    """One colour per kind of initial state, one dash pattern per state of a kind."""
    styles = {}
    for run in runs:
        word, _, index = run.initial.partition(" ")
        dashes = ["-", "--", ":", "-."][int(index or 0) % 4]
        label = word if word in ("random", "given", "ball") else run.initial
        styles[run.initial] = {"color": COLOURS[word], "ls": dashes, "label": label}
    return styles


def _one_entry_per_label(axes: Axes) -> None:
    """A legend below the axes that names each kind of initial state once."""
    handles, labels = axes.get_legend_handles_labels()
    once = dict(zip(labels, handles, strict=True))
    columns = 3 if max(map(len, once), default=0) < LONG_LABEL else 2
    axes.legend(
        list(once.values()), list(once), loc="upper center", bbox_to_anchor=(0.46, -0.13), ncols=columns,
        frameon=False, fontsize="small",
    )  # fmt: skip
