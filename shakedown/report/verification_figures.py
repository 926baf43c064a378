"""Pictures of a verification: the limits on one scale, and one panel of runs per load factor."""

from collections.abc import Sequence
from functools import partial
from itertools import cycle, groupby
from typing import Any, NamedTuple

import numpy as np

from shakedown import plot
from shakedown.assessment.verify import Run, Verification
from shakedown.ground.errors import present
from shakedown.ground.shown_values import at_lambda
from shakedown.long_term.simulation import Simulation
from shakedown.plot.inline_svg import Drawing, Picture, picture
from shakedown.plot.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, RED
from shakedown.report.node_names import open_in_words, resolution
from shakedown.report.verification_facts import limits_on_page
from shakedown.studies.refined import Refinement

COLOURS = {"zero": BLACK, "safe": GREEN, "witness": RED, "given": PURPLE, "random": BLUE, "ball": ORANGE}
DASHES = ("-", "--", ":", "-.")
SLIP_PER_CYCLE = (
    "Slip per cycle of the node that slips most. A line that falls to “no slip” has shaken down, or is "
    "separation; one that ends on its way down was followed no further; a level line is cyclic slip or "
    "ratchetting."
)
SLIP_SPACE = "Slip space: the limits of both nodes, the safe region, and the paths (○ start, ■ end)."
WIDE, NARROW = (8.0, 1.8), (3.4, 2.6)  # of the scale of load factors [inch]


def scale_picture(v: Verification) -> Picture:
    """Every limit of the load factor on one scale, with λ = 1."""
    marks, known, opened = limits_on_page(v), v.limits.from_state, v.limits.open_nodes
    here, everywhere = np.nan_to_num([known.load_factor, v.limits.universal.load_factor], posinf=np.inf)
    bands = {"proved": (0.0 if everywhere >= here else known.least_load_factor, max(here, everywhere))}
    if not opened and np.isfinite(marks["λ_max"]):
        bands["impossible"] = (marks["λ_max"], np.inf)
    state = f"with {open_in_words(opened, v.problem)} open" if opened else "from this state"
    caption = f"Green: proved to shake down {state}." * bool(bands["proved"][1] > 0)
    if "impossible" in bands:
        caption += " Orange: shakedown is impossible while all nodes stay in contact. White: not decided."
    alt = "Scale of the load factor with its limits and λ = 1, the nominal load"
    draw = partial(plot.load_factor_scale, marks, bands=bands)
    narrow = Drawing(f"{alt}, for a narrow screen", draw, size=NARROW)
    return picture(caption.strip(), Drawing(alt, draw, size=WIDE), narrow)  # the page shows one


def run_pictures(v: Verification) -> list[Picture]:
    """Slip per cycle of the runs, and of two nodes their paths in the slip plane."""
    groups, pictures = _by_load_factor(v.runs), []
    several = [group for group in groups if len(group.runs) > 1]
    alone = _together([group for group in groups if len(group.runs) == 1])
    for chosen, caption in (several, SLIP_PER_CYCLE), (alone, "The same, one state at each load factor."):
        cycles, resting = [], []
        for group in chosen:
            none = _none(v, group)
            if not any(run.cycles.slip.max(initial=0.0) > none for run in group.runs.values()):
                resting.append(group.title)
                continue
            draw = partial(plot.slip_per_cycle, group.runs, v.problem, styles=group.styles)
            alt = f"Slip per cycle against the cycle number, {group.title}"
            cycles.append(Drawing(alt, partial(draw, resolution=none), group.title))
        still = f"Not drawn, as nothing slips or no cycle ends: {', '.join(resting)}." * bool(resting)
        said = f"{caption * bool(cycles)} {still}".strip()
        if said:
            pictures.append(picture(said, *cycles, alike=len(cycles), one_legend=True))
    if v.problem.layout.slip_size == 2 and v.problem.n == 2:
        given = [group for group in groups if group.load_factor == 1.0 and len(group.runs) == 1]
        drawn = []
        for group in [*several, *given]:
            recorded = {name: run for name, run in group.runs.items() if run.history is not None}
            draw = partial(plot.slip_space, v.problem, group.load_factor, recorded, styles=group.styles)
            drawn.append(Drawing(f"Limits, safe region and paths, {group.title}", draw))
        pictures.append(picture(SLIP_SPACE, *drawn, alike=len(several), one_legend=True))
    return pictures


def sensitivity_picture(v: Verification) -> Picture | None:
    """What limits the joint: one panel for λ_max and one for λ_E, where they have derivatives."""
    found = [each for each in map(present, v.limits.sensitivities.values()) if each is not None]
    panels = [
        Drawing(
            f"Change of {each.symbol}, node by node", partial(plot.sensitivity, each, v.problem), each.symbol
        )
        for each in found
        if each.ranked().size
    ]
    if not panels:
        return None
    caption = "Change of a limit [%] with 1 % more friction, constant load or load amplitude at one node."
    hollow = any(not each.smooth for each in found)
    caption += " Hollow: with 1 % less, its sign turned, where that differs." * hollow
    return picture(caption, *panels, one_legend=True)


def refinement_picture(found: Refinement) -> Picture:
    """Every number of a refinement over the nodes of its mesh."""
    caption = "Every number in shares of that on the finest mesh: a level line has converged. Dashed: limits."
    alt = f"Numbers of the joint on meshes of {found.nodes[0]} to {found.nodes[-1]} contact nodes"
    return picture(caption, Drawing(alt, partial(plot.refinement, found)))


def slip_picture(v: Verification) -> Picture | None:
    """The largest slip range over the load factor, where a limit on it was asked for."""
    if v.slip_limit is None:
        return None
    caption = "Largest slip range of a node in the long run. Dotted: slips grow for ever or contact is lost."
    alt = "Largest slip range over the load factor, and the length that it is to stay below"
    return picture(caption, Drawing(alt, partial(plot.slip_over_load, v.slip_limit, v.problem)))


class Group(NamedTuple):
    """Runs in one panel, by the names of their lines, and the styles of these."""

    title: str
    load_factor: float
    runs: dict[str, Simulation]
    styles: dict[str, dict[str, Any]]


def _by_load_factor(runs: Sequence[Run]) -> list[Group]:
    """One panel per load factor, a colour per kind of initial state, a dash pattern per state of a kind."""
    found = []
    for (factor, region), group in groupby(runs, key=lambda run: (run.simulation.load_factor, run.region)):
        named = {run.initial: run.simulation for run in group}
        styles = {name: _style(name) for name in named}
        found.append(Group(f"{at_lambda(factor)}, {region}", factor, named, styles))
    return found


def _style(initial: str) -> dict[str, Any]:
    """The line style of an initial state, as in ``random 2``."""
    kind, _, index = initial.partition(" ")
    return {"color": COLOURS[kind], "ls": DASHES[int(index or 0) % len(DASHES)], "label": initial}


def _together(alone: Sequence[Group]) -> Sequence[Group]:
    """Load factors at which only one state was followed, in one panel: one line each."""
    if len(alone) < 2:
        return alone
    runs = {group.title: run for group in alone for run in group.runs.values()}
    looks = (look for group in alone for look in group.styles.values())
    named = zip(runs, looks, cycle(DASHES), strict=False)
    styles = {name: look | {"ls": dashes, "label": name} for name, look, dashes in named}
    return [Group("one line per load factor", np.nan, runs, styles)]


def _none(v: Verification, group: Group) -> float:
    """The slip below which it counts as none in the runs of a panel [length]."""
    return max(float(resolution(v.problem, run.load_factor)[0].max()) for run in group.runs.values())
