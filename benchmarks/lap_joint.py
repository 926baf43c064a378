"""A bolted lap joint after the Brake–Reuß beam: what is proved of it, and what it dissipates above that.

Two half beams touch on three pads under their bolts, the load at the tip turns about the beam's axis. On
some meshes: λ_max, λ_E and λ_U, and the friction work of a cycle over the amplitude, after two cycles from
slip zero. Micro-slip has a power law: its exponent is that between the two largest amplitudes.
"""

from functools import partial

from benchmarks.bodies.lap_joint import WIDTH, lap_joint
from benchmarks.friction_work import measured, work_table

TITLE = "A bolted lap joint in space: limits, and friction work over the amplitude"
# Elements along the lap, across it and over half of the height: all sizes fall by one factor.
MESHES = tuple((12 * k, 3 * k, 2 * k) for k in range(1, 5))
WASHER = (10.0, WIDTH / 6)  # half sides [mm]: edges on lines of all meshes
LOADS = (10.0, 15.0, 20.0, 30.0, 40.0, 60.0, 80.0)  # amplitude of the load at the tip [N], on all meshes
TIP = 10.0  # amplitude of the load at λ = 1 [N]
CYCLES = 3  # followed from slip zero


def cases(short: bool) -> list[dict]:
    return [{"elements": list(mesh)} for mesh in (MESHES[:1] if short else MESHES)]


def measure(case: dict) -> dict:
    make = partial(lap_joint, tuple(case["elements"]), washer=WASHER)
    return measured(make, [load / TIP for load in LOADS], CYCLES)


def tables(rows: list[dict]) -> str:
    return work_table(rows, LOADS, TIP, "N")
