"""The units of a problem, as far as its text names them."""

from shakedown.joint.arguments import checked
from shakedown.joint.problem import Problem

FORCES = frozenset(["N", "mN", "kN", "MN", "GN", "daN", "kgf", "lbf", "kip"])
LENGTHS = frozenset(["m", "mm", "cm", "µm", "um", "km", "in", "ft"])
PASCALS = {
    ("N", "m"): "Pa",
    ("kN", "m"): "kPa",
    ("MN", "m"): "MPa",
    ("GN", "m"): "GPa",
    ("N", "mm"): "MPa",
    ("kN", "mm"): "GPa",
}


@checked
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


def stress_unit(force: str, length: str) -> str:
    """The unit of a traction: a pascal with its prefix where it has one, else force per area.

    Examples
    --------
    >>> stress_unit("N", "mm"), stress_unit("kN", "m"), stress_unit("lbf", "in"), stress_unit("", "mm")
    ('MPa', 'kPa', 'lbf/in²', '')
    """
    if not (force and length):
        return ""
    return PASCALS.get((force, length), f"{force}/{length}²")


@checked
def work_unit(force: str, length: str) -> str:
    """The unit of a dissipation, empty where force or length has none.

    Examples
    --------
    >>> work_unit("N", "mm"), work_unit("", "mm")
    ('N mm', '')
    """
    return f"{force} {length}" if force and length else ""
