"""Pictures of the joint as it is given: its nodes, the loads on them, the loads over the period."""

from functools import partial

import numpy as np

from shakedown import plot
from shakedown.ground.shown_values import at_lambda
from shakedown.ground.size_limits import EACH_SHOWN
from shakedown.joint.problem import Problem
from shakedown.long_term.conjugate_displacement import load_loops
from shakedown.long_term.state import LongTermState
from shakedown.plot.inline_svg import MARGINS, PANEL, SCALE, SIDE_BY_SIDE, SMALL, Drawing, Picture, picture
from shakedown.plot.over_amplitude import load_title
from shakedown.plot.patch_arrows import MOST_DISCS
from shakedown.plot.patch_places import patch_count, places_of

HALF, THIRD = PANEL[0], SMALL[0]  # inches: widths of two or three pictures that fill a page
LEAST = 2.0  # inches: least height of a picture of a patch, which is no higher than a small one is wide
SIDES = (  # of a patch: description, drawing function, whether it has a colour bar
    (
        "Tangential welded reactions over the patch: the mean as an arrow, the path of its tip over a period",
        plot.loads_over_patch,
        False,
    ),
    ("Mean normal welded reactions over the patch", plot.welded_pressure_over_patch, True),
)
WELDED = "Welded reactions are those with every contact displacement held."


def problem_pictures(problem: Problem) -> list[Picture]:
    """Nodes, normals and loads; the loads in the limits of a few nodes or of all; their sums."""
    draw = _loads_along if problem.directions == 1 else _loads_over_patches
    time = Drawing("Sums of the welded reactions over one period", partial(plot.loads_in_time, problem))
    caption, drawings = draw(problem, problem.n <= SIDE_BY_SIDE)
    if len(drawings) == len(SIDES):
        return [picture(f"{caption}; the sums of all nodes over the period. {WELDED}", *drawings, time)]
    return [
        picture(f"{caption}.{left_out(problem)} {WELDED}", *drawings),
        picture("The sums of the welded reactions of all nodes over the period.", time),
    ]


def load_loops_pictures(state: LongTermState, which: str) -> list[Picture]:
    """Loops of the loads that vary most, where the joint knows how far its loads move."""
    problem = state.problem
    if problem.load_compliance is None or problem.load_history is None:
        return []
    areas = np.abs(load_loops(problem, state).areas)
    varying = np.flatnonzero(np.ptp(problem.load_history, axis=0) > 0)
    chosen = varying[np.argsort(-areas[varying], kind="stable")][:SIDE_BY_SIDE].tolist()
    drawings = []
    for j in chosen:
        alt = f"{load_title(problem, j)} against the displacement conjugate to it"
        drawings.append(Drawing(alt, partial(plot.loop, state, load=j), at_lambda(state.load_factor)))
    caption = (
        f"Loops of the loads over one period: {which}. A load against the displacement that it works along; "
        "the areas of all of them are together what friction (and the damping of jumps) dissipates."
    )
    return [picture(caption, *drawings)] if drawings else []


def _loads_along(problem: Problem, few: bool) -> tuple[str, list[Drawing]]:
    """Caption, nodes with arrows, and loads in the plane of their reactions or along the contact."""
    where = "as they are in the model" if problem.coordinates is not None else "side by side"
    nodes = Drawing(
        f"{problem.n} contact nodes, {where}, with their normals and arrows for the loads on them",
        partial(plot.contact, problem),
    )
    alt = "Mean and range of the normal and tangential welded reactions along the contact"
    loads = Drawing(alt, partial(plot.loads_along, problem))
    if few:
        alt = "Loading of each node in the plane of its reactions, with the friction cone"
        loads = Drawing(alt, partial(plot.load_loop, problem, range(problem.n)))
    caption = (
        f"Contact nodes {where}, the normals into the (first) body, and the welded reactions on it at λ = 1 "
        "(an arrow for the mean, a line for the path of its tail over a period)"
        + ("; the path of each node's reactions in the friction cone" if few else "; mean and range along")
    )
    return caption, [nodes, loads]


def _loads_over_patches(problem: Problem, few: bool) -> tuple[str, list[Drawing]]:
    """Caption, loads over each patch, and these within the limits of nodes or the mean pressure."""
    found, patches = list[Drawing](), drawn_patches(problem)
    three = len(patches) % 2 == 1  # with the sums beside them, or two pictures of each of three patches
    for patch in patches:
        for alt, draw, numbers in SIDES:
            size = patch_size(problem, patch, numbers=numbers, three=three)
            found.append(Drawing(alt, partial(draw, problem, patch=patch), size=size))
    if few:
        alt = "Loading of each node within its limit, q_w over f p_w in x and y"
        found[1:2] = [Drawing(alt, partial(plot.load_orbits, problem, range(problem.n)))]
    some = f" (of {MOST_DISCS} nodes)" if problem.n > MOST_DISCS else ""
    caption = (
        f"{_where(problem)} The tangential welded reactions at λ = 1: an arrow for a mean that is not zero, "
        f"a line for the path of its tip over a period{some}; "
        + ("the path of q_w within its limit f p_w" if few else "the mean normal welded reactions")
    )
    return caption, found


def _where(problem: Problem) -> str:
    """Where the nodes of the pictures are."""
    if not places_of(problem).in_a_row:
        return f"{problem.n} contact nodes where they are in the model."
    if problem.n == 1:
        return "The one contact node."
    where = "side by side: the problem does not say where they are" if problem.x is None else "along x"
    return f"{problem.n} contact nodes, {where}."


def drawn_patches(problem: Problem) -> range:
    """The patches of a joint in space that have pictures, by their numbers."""
    return range(min(patch_count(problem), EACH_SHOWN))


def left_out(problem: Problem) -> str:
    """A sentence on patches that are not drawn."""
    count = patch_count(problem)
    return f" The {EACH_SHOWN} patches with the most nodes, of {count}." * (count > EACH_SHOWN)


def patch_size(
    problem: Problem, patch: int = 0, *, numbers: bool = False, three: bool = False
) -> tuple[float, float] | None:
    """The size of a picture of a patch, as high as the patch needs; None for numbers over a row of nodes."""
    places, width = places_of(problem, patch), THIRD if three else HALF
    if places.in_a_row:
        return None if numbers else (width, LEAST)
    wide, high = np.ptp(places.points, axis=0) + places.spacing
    left, below, right, above = MARGINS
    tall = (width - left - right - SCALE) * high / wide + below + above
    return width, float(np.clip(tall, LEAST, THIRD))
