"""The dovetail root of a blade: what is proved of it, and what it dissipates above that.

Spun to 1.1 times its speed and back, the root has slipped out along both flanks as far as they let it; then
the blade vibrates, in bending and at twice that frequency in torsion. On some meshes: λ_max, λ_E
from the state after the spin, λ_U, and the friction work of a cycle over the amplitude.
"""

from functools import partial

from matplotlib.figure import Figure

from benchmarks.bodies.blade_root import blade_root
from benchmarks.friction_work import measured, work_picture, work_table

TITLE = "The dovetail root of a blade: limits, and friction work over the amplitude"
MESHES = ((2, 3), (4, 6), (6, 9), (8, 12))  # along a flank, along the slot
LOADS = (250.0, 400.0, 600.0, 1000.0, 1500.0, 2000.0, 2500.0)  # of the force at the tip [N]
BENDING = 200.0  # amplitude of the force at the tip at λ = 1 [N]
CYCLES = 10


def cases(short: bool) -> list[dict]:
    return [{"elements": list(mesh)} for mesh in (MESHES[:1] if short else MESHES)]


def measure(case: dict) -> dict:
    return measured(partial(blade_root, tuple(case["elements"])), [load / BENDING for load in LOADS], CYCLES)


def tables(rows: list[dict]) -> str:
    return work_table(rows, LOADS, BENDING, "N")


def figures(rows: list[dict]) -> dict[str, Figure]:
    label = "amplitude of the force at the tip [N]"
    return {"blade_root": work_picture(rows, LOADS, BENDING, label)}
