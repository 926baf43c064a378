"""What a user should know about the data: load domains, likely mistakes, what slips are relative to."""

from __future__ import annotations

from typing import TYPE_CHECKING

from shakedown.joint.doubtful_data import doubtful_data
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.report.node_words import pinned_in_words

if TYPE_CHECKING:
    from shakedown.joint.problem import Problem

LOAD_DOMAIN = (
    "The load steps are the corners of a load domain. What is proved, and λ_max, is about every path of the "
    "loads inside it, in whatever order; what is simulated, λ_T too, follows the corners in the order "
    "given: one path of many."
)
ONE_PATH = (
    "The load steps are the corners of a load domain, followed here in the order given: one path of many."
)


def simulated_path_in_words(problem: Problem) -> list[str]:
    """What is simulated: a stiffness in doubt, or one of the many paths of a load domain; else nothing."""
    return [*last_digit_in_words(problem), *([ONE_PATH] if problem.is_domain else [])]


def last_digit_in_words(problem: Problem) -> list[str]:
    """A warning where it is not clear whether the joint can move as a whole; otherwise nothing."""
    doubt = rigid_slips(problem).doubt
    return [f"All of this is in doubt: {doubt}."] if doubt else []


def doubts_in_words(problem: Problem) -> list[str]:
    """What is doubtful of the model that a problem was made from, and in its data."""
    return [*problem.warnings, *doubtful_data(problem)]


def relative_in_words(problem: Problem, open_nodes: tuple[int, ...] = ()) -> str:
    """What slips are relative to; empty where the joint is held, or where the sentences on a zone say it."""
    return "" if open_nodes else pinned_in_words(rigid_slips(problem).pinned, problem)
