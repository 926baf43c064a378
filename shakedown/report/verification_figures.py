"""Pictures of a verification: the limits on one scale, and one panel of runs per load factor."""

from collections.abc import Callable, Sequence
from functools import partial
from itertools import groupby, product
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes

from shakedown import plot
from shakedown.assessment.runs import Run
from shakedown.assessment.verify import Verification
from shakedown.ground.errors import present
from shakedown.ground.float_array import FloatArray
from shakedown.ground.shown_values import DIGITS, at_lambda, few
from shakedown.plot.inline_svg import SIDE_BY_SIDE, Drawing, Picture, picture
from shakedown.plot.style import BLACK, BLUE, GREEN, MANY, ORANGE, PURPLE, RED
from shakedown.report.load_figures import drawn_patches, left_out, patch_size
from shakedown.report.node_words import open_in_words, resolution, without_round_off
from shakedown.report.page_tables import limits_on_page, transient_is_proved
from shakedown.studies.refined import Refinement

COLOURS = {"zero": BLACK, "safe": GREEN, "witness": RED, "given": PURPLE, "random": BLUE, "ball": ORANGE}
DASHES = ("-", "--", ":", "-.")
SLIP_PER_CYCLE = (
    "Slip per cycle of the node that slips most, against the cycle number. Slips too small to count "
    "are drawn on the floor, “no slip”. A line that falls to it has shaken down, or is separation: "
    "nodes open and close in every cycle, without slip in contact. One that ends on its way down was "
    "followed no further: shakedown was proved there, or the run is undecided. A level line above "
    "the floor is cyclic slip or ratchetting."
)
SLIP_SPACE = (
    "Slip space: the limits of both nodes at their extreme load steps, the safe region between "
    "them, and the paths from the initial states (circle: start, square: end)."
)
ALONE = ", of the one that slips farthest"
AT_THE_END = "at the end of each run, at the load factors at which a node has slipped"
WIDE, NARROW = (8.0, 1.8), (3.4, 2.6)  # of the scale of load factors [inch]


def scale_picture(v: Verification) -> Picture:
    """Every limit of the load factor on one scale, with λ = 1."""
    upper = v.limits.upper
    marks = limits_on_page(v)
    known = v.limits.from_state
    both = known.load_factor, v.limits.universal.load_factor
    here, everywhere = (np.nan_to_num(x, posinf=np.inf) for x in both)
    proved = (0.0, everywhere) if everywhere >= here else (known.least_load_factor, here)
    bands = {"proved": proved}
    if np.isfinite(marks["λ_max"]) and not upper.open_nodes:
        bands["excluded"] = (marks["λ_max"], np.inf)
    shown = ", ".join(f"{name} = {few(value, DIGITS)}" for name, value in marks.items() if np.isfinite(value))
    alt = f"Scale of the load factor with {shown or 'no limit'} and λ = 1, the nominal load"
    state = (
        f"with {open_in_words(upper.open_nodes, v.problem)} open" if upper.open_nodes else "from this state"
    )
    proved_there, zone = (
        " (proved there)" * transient_is_proved(v),
        " of the zone" * bool(upper.open_nodes),
    )

    def drawn(name: str) -> bool:
        return bool(np.isfinite(marks.get(name, np.nan)))

    caption = (
        (
            f"Green: proved to shake down, {state} ({known.symbol}) or from every state (λ_U). "
            if proved[1] > 0
            else ""
        )
        + ("Red: shakedown is impossible while all nodes stay in contact. " if "excluded" in bands else "")
        + "λ_1: first collapse. " * drawn("λ_1")
        + f"λ_T: largest load factor at which the simulation shakes down{proved_there}. " * drawn("λ_T")
        + f"λ_max: largest load factor with a safe state{zone}." * drawn("λ_max")
    ).strip()
    draw = partial(plot.load_factor_scale, marks, bands=bands)
    narrow = Drawing(f"{alt}, for a narrow screen", partial(draw, short=True), size=NARROW)
    return picture(caption, Drawing(alt, draw, size=WIDE), narrow)  # the style sheet shows one of them


def run_pictures(v: Verification) -> list[Picture]:
    """Slip per cycle, paths in the slip plane of two nodes, final slips along the contact."""
    groups = _by_load_factor(v.runs)
    several = [group for group in groups if len(group.runs) > 1]
    alone = [group for group in groups if len(group.runs) == 1]
    shown = [*several, *_together(alone)]
    moving = [group for group in shown if _moves(v, group)]
    cycles = _drawings(v, "Slip per cycle against the cycle number", _slip_per_cycle, moving)
    caption = f"{SLIP_PER_CYCLE * bool(cycles)}{_without_slip(v, shown)}".strip()
    pictures = [picture(caption, *cycles, alike=len(cycles), one_legend=True)]
    if v.problem.directions == 2:
        pictures += _final_slips_over_patch(v, shown)
    elif v.problem.n == 2:
        given = [group for group in alone if v.as_given in group.runs.values()]
        what = "Limits, safe region and paths in the plane of both slips"
        planes = _drawings(v, what, _slip_space, [*several, *given])
        pictures.append(picture(SLIP_SPACE, *planes, alike=len(several), one_legend=True))
    elif v.problem.n > 2:
        slipped = [group for group in shown if any(slip.any() for slip in _final_slips(v, group).values())]
        ends = _drawings(v, "Final slip of every run along the contact", _final_slip, slipped)
        pictures += [picture(f"Slip {AT_THE_END}.", *ends, one_legend=True)] if ends else []
    return pictures


def sensitivity_picture(v: Verification) -> Picture | None:
    """What limits the joint: one panel for λ_max and one for λ_E, where they have derivatives."""
    found = [present(each) for each in v.limits.sensitivities.values()]
    panels = [
        Drawing(
            f"Change of {each.symbol} for 1 % more friction, constant load and load amplitude, node by node",
            partial(plot.sensitivity, each, v.problem),
            each.symbol,
        )
        for each in found
        if each is not None and each.ranked().size
    ]
    if not panels:
        return None
    hollow = any(each is not None and not each.smooth for each in found)
    caption = (
        "By how many per cent λ_max and λ_E change with 1 % more friction, constant load or load amplitude "
        "at one node, all else as it is: the nodes that count most. With 1 % more of all constant loads they "
        "are 1 % larger (λ_E starting without slip), with 1 % more of all amplitudes 1 % smaller."
        + " Hollow: what 1 % less does, with its sign turned, where that differs."
        * hollow
    )
    return picture(caption, *panels, one_legend=True)


def refinement_picture(found: Refinement) -> Picture:
    """Every number of a refinement over the nodes of its mesh."""
    caption = (
        "Every number over the contact nodes of its mesh, in shares of that on the finest: what is level has "
        "converged. Dashed: extrapolated limits."
    )
    alt = f"Numbers of the joint on meshes of {found.nodes[0]} to {found.nodes[-1]} contact nodes"
    return picture(caption, Drawing(alt, lambda ax: plot.refinement(found, ax=ax)))


def slip_picture(v: Verification) -> Picture | None:
    """The largest slip range over the load factor, where a limit on it was asked for."""
    if v.slip_limit is None:
        return None
    caption = (
        "Largest slip range of a node in the long run, from this state, at every load factor simulated. "
        "Dotted: slips grow for ever or contact is lost for good."
    )
    alt = "Largest slip range over the load factor, and the length that it is to stay below"
    return picture(caption, Drawing(alt, partial(plot.slip_over_load, v.slip_limit, v.problem)))


class Group(NamedTuple):
    """Runs in one panel, by the names of their lines, and the styles of these."""

    title: str
    runs: dict[str, Run]
    styles: dict[str, dict[str, Any]]


def _by_load_factor(runs: Sequence[Run]) -> list[Group]:
    """One panel per load factor, a colour per kind of initial state, a dash pattern per state of a kind."""
    found = []
    for (factor, region), group in groupby(runs, key=lambda run: (run.simulation.load_factor, run.region)):
        named = {run.initial: run for run in group}
        found.append(Group(f"{at_lambda(factor)}, {region}", named, {name: _style(name) for name in named}))
    return found


def _style(initial: str) -> dict[str, Any]:
    """The line style of an initial state."""
    word, _, index = initial.partition(" ")
    label = word if word in ("random", "given", "ball") else initial
    return {"color": COLOURS[word], "ls": DASHES[int(index or 0) % len(DASHES)], "label": label}


def _together(alone: Sequence[Group]) -> Sequence[Group]:
    """Load factors at which only one state was followed, in one panel: one line each."""
    if len(alone) < 2:
        return alone
    runs = {group.title: run for group in alone for run in group.runs.values()}
    styles = {
        title: {"color": _style(run.initial)["color"], "ls": DASHES[k % len(DASHES)]}
        for k, (title, run) in enumerate(runs.items())
    }
    return [Group("one line per load factor", runs, styles)]


def _drawings(
    v: Verification, what: str, draw: Callable[[Verification, Group, Axes], None], groups: Sequence[Group]
) -> list[Drawing]:
    """One panel per group."""

    def drawn(group: Group, *, ax: Axes) -> None:
        draw(v, group, ax)

    return [Drawing(f"{what}, {group.title}", partial(drawn, group), group.title) for group in groups]


def _slip_per_cycle(v: Verification, group: Group, axes: Axes) -> None:
    simulations = {name: run.simulation for name, run in group.runs.items()}
    none = _none(v, group)
    plot.slip_per_cycle(simulations, v.problem, styles=group.styles, resolution=none, ax=axes)


def _slip_space(v: Verification, group: Group, axes: Axes) -> None:
    (load_factor, *_) = [run.simulation.load_factor for run in group.runs.values()]
    paths = {name: run.simulation for name, run in group.runs.items() if run.simulation.history is not None}
    plot.slip_space(v.problem, load_factor, paths, styles=group.styles, ax=axes)
    axes.set_title("")


def _final_slips_over_patch(v: Verification, groups: Sequence[Group]) -> list[Picture]:
    """Arrows of all runs of a panel, of one run where nodes are many; no panel where nothing has slipped."""
    found: list[tuple[Group, dict[str, FloatArray]]] = []
    for group in groups:
        slips = _final_slips(v, group)
        farthest = max(slips, key=lambda name: float(np.abs(slips[name]).max()))
        if slips[farthest].any():
            found.append((group, {farthest: slips[farthest]} if v.problem.n > MANY else slips))
    if not found:
        return []
    patches = drawn_patches(v.problem)
    three = len(found) * len(patches) % SIDE_BY_SIDE == 0
    drawn = partial(plot.slips_over_patch, problem=v.problem, what="final slip")
    alt = "Final slip of every run over the patch"
    arrows = [
        Drawing(
            f"{alt}, {group.title}",
            partial(drawn, slips, styles=group.styles, patch=patch),
            group.title,
            patch_size(v.problem, patch, three=three),
        )
        for (group, slips), patch in product(found, patches)
    ]
    of = ALONE * (v.problem.n > MANY)
    caption = f"Slip {AT_THE_END}{of}."
    caption += left_out(v.problem)
    return [picture(caption, *arrows)]


def _final_slip(v: Verification, group: Group, axes: Axes) -> None:
    slips = _final_slips(v, group)
    plot.slip_along(slips, v.problem, what="final slip", styles=group.styles, ax=axes)


def _final_slips(v: Verification, group: Group) -> dict[str, FloatArray]:
    """Slips at the end of the runs of a panel, round-off as zero."""
    none = _none(v, group)
    return {
        name: np.array(without_round_off(run.simulation.final_slip, none)) for name, run in group.runs.items()
    }


def _moves(v: Verification, group: Group) -> bool:
    """Whether a node slips in any run of a panel."""
    none = _none(v, group)
    return any(float(run.simulation.cycles.slip.max(initial=0.0)) > none for run in group.runs.values())


def _without_slip(v: Verification, groups: Sequence[Group]) -> str:
    """The load factors at which nothing is drawn, as no node slips, or no run comes to the end of a cycle."""
    said = {"no node slips in any run": set[float](), "no run comes to the end of a cycle": set[float]()}
    at_rest, stopped = said.values()
    for group in groups:
        if not _moves(v, group):
            runs = [run.simulation for run in group.runs.values()]
            ended = any(len(run.cycles.slip) for run in runs)
            (at_rest if ended else stopped).update(run.load_factor for run in runs)
    return "".join(
        f" At {', '.join(map(at_lambda, sorted(factors)))} {what}."
        for what, factors in said.items()
        if factors
    )


def _none(v: Verification, group: Group) -> float:
    """The slip below which it counts as none in the runs of a panel [length]."""
    return max(
        float(resolution(v.problem, run.simulation.load_factor)[0].max()) for run in group.runs.values()
    )
