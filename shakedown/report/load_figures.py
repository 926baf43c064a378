"""Pictures of the joint as it is given: its nodes, the loads on them, the loads over the period."""

from functools import partial

import numpy as np

from shakedown import plot
from shakedown.ground.shown_values import at_lambda
from shakedown.ground.size_limits import EACH_SHOWN
from shakedown.joint.problem import Problem
from shakedown.long_term.conjugate_displacement import load_loops
from shakedown.long_term.state import LongTermState
from shakedown.plot.inline_svg import PANEL, SIDE_BY_SIDE, Drawing, Picture, picture
from shakedown.plot.loops import load_title
from shakedown.plot.patch_places import patch_count, places_of

LOADS = (
    "Loads at λ = 1: the welded reactions, those with every slip held. An arrow is a mean, the line at it "
    "the period; beside them the reactions of single nodes, and their sums."
)
PATCHES = (
    ("Tangential welded reactions", plot.loads_over_patch),
    ("Mean normal welded reactions", plot.welded_pressure_over_patch),
)
ABOUT, LEAST = 1.3, 2.1  # inches: room about a patch for labels; least height of a picture of one


def problem_pictures(problem: Problem) -> list[Picture]:
    """Nodes and the loads on them; the loads within the limits of a few nodes, or of all; their sums."""
    plane, drawings = problem.directions == 1, list[Drawing]()
    if plane:
        nodes = partial(plot.contact, problem)
        drawings.append(Drawing("Contact nodes, their normals, and arrows for the loads on them", nodes))
    for patch in range(0 if plane else drawn_patches(problem)):
        for alt, draw in PATCHES if problem.n > SIDE_BY_SIDE else PATCHES[:1]:
            size = patch_size(problem, patch)
            drawings.append(Drawing(f"{alt} over the patch", partial(draw, problem, patch=patch), size=size))
    if problem.n <= SIDE_BY_SIDE:
        each = partial(plot.load_loop if plane else plot.load_orbits, problem, range(problem.n))
        drawings.append(Drawing("Loading of each node within its friction limit", each))
    elif plane:
        drawings.append(Drawing("Welded reactions along the contact", partial(plot.loads_along, problem)))
    sums = partial(plot.loads_in_time, problem)
    drawings.append(Drawing("Sums of the welded reactions over one period", sums))
    return [picture(f"{LOADS}{left_out(problem)}", *drawings)]


def load_loops_pictures(state: LongTermState, which: str) -> list[Picture]:
    """Loops of the loads that vary most, where the joint knows how far its loads move."""
    problem = state.problem
    if problem.load_compliance is None or problem.load_history is None:
        return []
    areas = np.abs(load_loops(problem, state).areas)
    varying = np.flatnonzero(np.ptp(problem.load_history, axis=0) > 0)
    drawings = []
    for j in varying[np.argsort(-areas[varying], kind="stable")][:SIDE_BY_SIDE].tolist():
        alt = f"{load_title(problem, j)} against the displacement conjugate to it"
        drawings.append(Drawing(alt, partial(plot.loop, state, load=j), at_lambda(state.load_factor)))
    caption = f"Loops of the loads, {which}: together their areas are what is dissipated in one period."
    return [picture(caption, *drawings)] if drawings else []


def drawn_patches(problem: Problem) -> int:
    """How many patches of a joint in space have pictures."""
    return min(patch_count(problem), EACH_SHOWN)


def left_out(problem: Problem) -> str:
    """A sentence on patches that are not drawn."""
    count = 0 if problem.directions == 1 else patch_count(problem)
    return f" The {EACH_SHOWN} patches with the most nodes, of {count}." * (count > EACH_SHOWN)


def patch_size(problem: Problem, patch: int) -> tuple[float, float]:
    """The size of a picture of a patch, as high as the patch needs [inch]."""
    places, (width, highest) = places_of(problem, patch), PANEL
    wide, high = np.ptp(places.points, axis=0) + places.spacing
    return width, float(np.clip((width - ABOUT) * high / wide + ABOUT, LEAST, highest))
