"""A sector of a bolted flange: what is proved of it, and what it dissipates above that.

Two flanges touch on a ring around the hole of their bolt; the pipe's wall is pulled and sheared, a quarter of
a period apart. On some meshes: λ_max, λ_E and λ_U, and the friction work of a cycle over the amplitude.
"""

from functools import partial

from matplotlib.figure import Figure

from benchmarks.bodies.bolted_flange import bolted_flange
from benchmarks.friction_work import measured, work_picture, work_table

TITLE = "A sector of a bolted flange: limits, and friction work over the amplitude"
MESHES = (
    (8, 2, 2),
    (16, 4, 3),
    (24, 6, 5),
    (32, 8, 6),
)  # around the hole, across the ring, over the thickness
LOADS = (4.0, 5.0, 6.0, 7.0, 8.0, 10.0)  # amplitude of the shear [kN], on all meshes
SHEAR = 4.0  # amplitude along the circumference at λ = 1 [kN]
CYCLES = 6


def cases(short: bool) -> list[dict]:
    return [{"elements": list(mesh)} for mesh in (MESHES[:1] if short else MESHES)]


def measure(case: dict) -> dict:
    return measured(partial(bolted_flange, tuple(case["elements"])), [load / SHEAR for load in LOADS], CYCLES)


def tables(rows: list[dict]) -> str:
    return work_table(rows, LOADS, SHEAR, "kN")


def figures(rows: list[dict]) -> dict[str, Figure]:
    label = "shear force amplitude [kN]"
    return {"bolted_flange": work_picture(rows, LOADS, SHEAR, label)}
