"""The units of a problem, as far as its text names them."""

from shakedown.model.problem import Problem

FORCES = frozenset(["N", "mN", "kN", "MN", "GN", "daN", "kgf", "lbf", "kip"])
LENGTHS = frozenset(["m", "mm", "cm", "µm", "um", "km", "in", "ft"])


def units_of(problem: Problem | None) -> tuple[str, str]:
    """Units of force and of length, from texts like "N, mm"; empty where the text names none.

    Examples
    --------
    >>> import shakedown
    >>> units_of(shakedown.example("block-9"))
    ('N', 'mm')
    """
    parts = [] if problem is None else [part.strip() for part in problem.units.split(",")]
    force, length = ([part for part in parts if part in known] for known in (FORCES, LENGTHS))
    return force[0] if force else "", length[0] if length else ""
