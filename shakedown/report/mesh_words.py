"""Meshes of one joint that get finer, in words: which of its numbers converge; averages over a length."""

from __future__ import annotations

from typing import TYPE_CHECKING

from shakedown.ground.shown_values import sized
from shakedown.joint.units import units_of
from shakedown.report.assessment_words import numbers_in_words

if TYPE_CHECKING:  # importing it would load the solvers
    from shakedown.assessment.assess import Assessment
    from shakedown.joint.problem import Problem
    from shakedown.studies.refined import Refinement

MESH_NUMBERS = {  # of a refinement, in a table and in a sentence; first those that converge for most joints
    "work": ("friction work", "the friction work"),
    "largest_slip": ("largest slip", "the largest slip"),
    "slip_limit": ("slips small up to λ", "the load up to which slips stay small"),
    "averaged_impossible_above": ("impossible, averaged", "averaged λ_max"),
    "impossible_above": ("impossible above", "λ_max"),
    "proved_from_this_state": ("proved, this state", "what is proved from this state"),
    "proved_from_every_state": ("proved, every state", "what is proved from every state"),
}
VERDICTS = {  # singular and plural
    "converges": ("converges", "converge"),
    "undecided": ("is left open", "are left open"),
    "falls": ("falls", "fall"),
    "grows": ("grows", "grow"),
    "zero": ("is 0 on these meshes", "are 0 on these meshes"),
}
TREND = (
    "A number converges where a + c h^p fits the last three meshes with p ≥ 0.5: evidence, no proof. What "
    "falls or grows says something about one element, and no mesh gives its value; order is then the power "
    "of the element size."
)


def mesh_warning_in_words(found: Assessment) -> str:
    """That the edge of the mesh determines the limits, where it does; else empty."""
    warning = found.details.mesh.warning
    return f"Mesh warning: {warning}" if warning else ""


def refinement_in_words(found: Refinement) -> str:
    """Which numbers converge with the mesh, in one sentence.

    Examples
    --------
    >>> import shakedown
    >>> joints = {n: shakedown.example(f"block-{n}") for n in (9, 33)}
    >>> print(refinement_in_words(shakedown.refine(joints, [9, 33])))
    With finer meshes (9 to 33 contact nodes) λ_max and what is proved from this state are left open; the
    friction work, the largest slip and what is proved from every state are 0 on these meshes.
    """
    names: dict[str, list[str]] = {}
    for name in told_of_meshes(found):
        names.setdefault(found.verdict[name], []).append(MESH_NUMBERS[name][1])
    said = []
    for verdict, verbs in VERDICTS.items():
        *others, last = names.get(verdict, [""])
        if last:
            said.append(f"{', '.join(others)}{' and ' * bool(others)}{last} {verbs[bool(others)]}")
    return f"With finer meshes ({found.nodes[0]} to {found.nodes[-1]} contact nodes) {'; '.join(said)}."


def told_of_meshes(found: Refinement) -> list[str]:
    """The columns of a refinement that are reported, those most likely to converge first."""
    asked = {"averaged_impossible_above": found.radius, "slip_limit": found.slip_below}
    return [name for name in MESH_NUMBERS if asked.get(name, found.load_factor) is not None]


def refinement_notes(found: Refinement, problem: Problem) -> list[str]:
    """What the numbers of a refinement are, and what their verdicts mean."""
    length = units_of(problem).length
    about = f"Friction work per cycle and slip at λ = {found.load_factor:g}, simulated starting without slip."
    if found.slip_below is not None:
        about += f" Small slips are below {sized(found.slip_below, length)}."
    if found.radius is not None:
        about += f" Averaged over {sized(found.radius, length)}."
    zero = " Zero: no slip, or nothing proved, on these meshes." * ("zero" in found.verdict.values())
    return [about, TREND + zero]


def averaged_in_words(found: Assessment, radius: float) -> str:
    """The three numbers of a joint whose slips and reactions are averaged over a radius, in one sentence."""
    length = units_of(found.problem).length
    about = f"Averaged over {sized(radius, length)} ({found.problem.n} knots; no proof of the joint itself)"
    said = [f"{name} {value}" for name, value, _ in numbers_in_words(found)]
    return f"{about}: {', '.join(said)}."
