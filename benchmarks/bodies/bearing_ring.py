"""The outer ring of a rolling bearing in a rigid housing: rolling elements run round in it."""

from shakedown import Problem
from shakedown.fem import ElasticBody, Material, RollingLoad, contact_problem, ring_mesh


def bearing_ring(
    around: int = 32,  # elements round the ring, with two contact nodes each
    *,
    interference: float = 1e-3,  # radial; negative is clearance [mm]
    f: float = 0.2,  # friction coefficient of the seat [–]
    steps: int = 24,  # load steps while each ball takes the place of the one in front of it
) -> Problem:
    """Outer ring of radii 35 and 40 mm, 18 mm wide, under eight balls; plane stress, quadratic elements.

    The ball in the middle of the load zone, below the centre, carries 3 kN.

    Examples
    --------
    >>> bearing_ring(16, steps=8).n
    32
    """
    balls = RollingLoad("inside", force=3e3, elements=8, half_width=0.3)
    steel = Material(206e3, 0.3)
    ring = ElasticBody(
        ring_mesh(35.0, 40.0, around, 3), steel, plane="stress", thickness=18.0, order=2, loads=[balls]
    )
    return contact_problem(
        ring, "outside", f, gap=-interference, steps=steps, name="bearing ring in a housing", units="N, mm"
    )
