"""A bracket bolted to a plate, both meshed apart, in CalculiX with contact of its own, and here."""

import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from skfem import MeshHex

import shakedown
from benchmarks import calculix_peer
from benchmarks.unlike_blocks import at_contact, deck, displacements
from shakedown import Import, LoadCase
from shakedown.fem import Bolt, ElasticBody, Material
from shakedown.ground.constants import FloatArray
from shakedown.motion.evolution import evolve

FOOT, WIDTH, PLATE, DEPTH, HEIGHT = 40.0, 24.0, (72.0, 36.0), 10.0, 36.0  # mm
THICK, WEB, WASHER = 6.0, 8.0, (10.5, 8.0)  # of the foot; of the web; half widths of what head and nut press
PRELOAD, SHANK, PUSH, FRICTION = 8000.0, 58.0 * 210e3 / 16.0, 10.0, 0.2  # N, N/mm; at each node of the tip
QUARTERS = ((0.0, 1.0), (1.0, 0.0), (0.0, -1.0))  # of a cycle: shares of the pushes along x and y
CONTACT = """*SURFACE INTERACTION, NAME=I
*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR
{slope:g}{tension}
*FRICTION
{friction}, {stick:g}
*CONTACT PAIR, INTERACTION=I, TYPE={kind}
UPPER, LOWER"""
CONFIGURATION = f"""friction = {FRICTION}
units = "N, mm"
[model]
file = "job.inp"
[stiffness]
file = "job.sti"
[contact]
surfaces = ["UPPER", "LOWER"]
[[bolt]]
preload = {PRELOAD}
head = "HEAD"
nut = "NUT"
stiffness = {SHANK}
transient = [0.0, 1.0]
[[load]]
forces = [["TIP", 1, {PUSH}]]
history = [0.0, 1.0, 0.0, -1.0]
transient = [0.0, 0.0]
[[load]]
forces = [["TIP", 2, {PUSH}]]
history = [1.0, 0.0, -1.0, 0.0]
transient = [0.0, 0.0]
"""


def bracket(along: int) -> ElasticBody:
    """An L of bricks about the axis of its bolt, with so many elements along its foot."""
    across, through = round(0.6 * along), max(along // 5, 2)
    heights = np.append(np.linspace(0.0, THICK, through + 1), np.linspace(THICK, HEIGHT, along // 2 + 1)[1:])
    mesh = MeshHex.init_tensor(
        np.linspace(-FOOT / 2, FOOT / 2, along + 1), np.linspace(-WIDTH / 2, WIDTH / 2, across + 1), heights
    )
    middles = mesh.p[:, mesh.t].mean(axis=1)
    mesh = mesh.remove_elements(np.flatnonzero((middles[2] > THICK) & (middles[0] > WEB - FOOT / 2)))
    named = {
        "bottom": lambda x: x[2] < 1e-9,
        "head": lambda x: (np.abs(x[2] - THICK) < 1e-9) & _under(x),
        "tip": lambda x: x[2] > HEIGHT - 1e-9,
    }
    return ElasticBody(mesh.with_boundaries(named), Material(210e3, 0.3))


def plate(along: int) -> ElasticBody:
    """What it stands on, with so many elements along it."""
    across, through = round(0.6 * along), max(along // 5, 2)
    mesh = MeshHex.init_tensor(
        np.linspace(-PLATE[0] / 2, PLATE[0] / 2, along + 1),
        np.linspace(-PLATE[1] / 2, PLATE[1] / 2, across + 1),
        np.linspace(-DEPTH, 0.0, through + 1),
    )
    named = {
        "top": lambda x: x[2] > -1e-9,
        "nut": lambda x: (x[2] < 1e-9 - DEPTH) & _under(x),
        "ends": lambda x: np.abs(x[0]) > PLATE[0] / 2 - 1e-9,
    }
    return ElasticBody(mesh.with_boundaries(named), Material(210e3, 0.3))


def _under(x: FloatArray) -> FloatArray:
    return (np.abs(x[0]) < WASHER[0]) & (np.abs(x[1]) < WASHER[1])


def followed(
    folder: Path, upper: int, lower: int, *, kind: str, slope: float, stick: float, increment: float
) -> dict:
    """Tightened and pushed for half a cycle in CalculiX and here: the largest differences."""
    bodies = bracket(upper), plate(lower)
    sets = {"HEAD": (bodies[0], "head"), "NUT": (bodies[1], "nut")}
    sets |= {"TIP": (bodies[0], "tip"), "ENDS": (bodies[1], "ends")}
    lines, _ = deck(*bodies, sets)
    lines += ["*BOUNDARY", "ENDS, 1, 3"]
    calculix_peer.run(folder, "job", [*lines, "*STEP", "*FREQUENCY, SOLVER=MATRIXSTORAGE", "1", "*END STEP"])
    (folder / "import.toml").write_text(CONFIGURATION)
    made = shakedown.import_model(folder / "import.toml")
    pull = _pull(bodies)
    before = _before_it_gives_way(made, pull)
    tension = "" if kind == "MORTAR" else ", 1e-6, 1e-3"
    contact = CONTACT.format(slope=slope, tension=tension, friction=FRICTION, stick=stick, kind=kind)
    begin = time.perf_counter()
    calculix_peer.run(folder, "con", [*lines, *_shank(pull), contact, *_steps(pull, before, increment)])
    seconds = time.perf_counter() - begin
    tables = displacements(folder / "con.dat")[1:]  # those of the assembly first
    return {"n": made.problem.n, "seconds": seconds} | _apart(made, tables, pull, before)


def _apart(
    made: Import, tables: list[dict[int, FloatArray]], pull: dict[tuple[int, int], float], before: float
) -> dict:
    split, history = 2 * made.problem.n, evolve(made.problem, 1.0).history
    own = history.at(np.arange(len(tables)) / 4)
    found: dict[str, list[float]] = {"pressure": [], "shear": [], "slip": [], "bolt": [], "open": []}
    for k, moved in enumerate(tables):
        _, opening, forces = at_contact(made, moved)
        closed = own.p[k] > 1e-9 * own.p[k].max()
        slips = np.abs(opening[:split] - own.v[k]).reshape(-1, 2)[closed]
        found["slip"].append(float(slips.max() / np.abs(own.v[k].reshape(-1, 2)[closed]).max()))
        found["shear"].append(float(np.abs(forces[:split] - own.q[k]).max() / np.abs(own.q[k]).max()))
        found["pressure"].append(float(np.abs(forces[split:] - own.p[k]).max() / own.p[k].max()))
        shortened = sum(part * moved[node][direction - 1] for (node, direction), part in pull.items())
        bolt = before - SHANK * shortened
        found["bolt"].append(abs(float(bolt / own.p[k].sum()) - 1.0))
        found["open"].append(float((forces[split:] <= 1e-3 * own.p[k].max()).sum() - (~closed).sum()))
    return {name: max(values, key=abs) for name, values in found.items()}


def _pull(bodies: tuple[ElasticBody, ElasticBody]) -> dict[tuple[int, int], float]:
    """e of the shortening e · u of the shank, by node and direction."""
    upper, lower = bodies
    e = Bolt(head="head", nut="nut", preload=1.0).shortening(
        bodies, (0, upper.basis.N), upper.basis.N + lower.basis.N
    )
    above = np.array([1, 0])  # nodes of decks from 1
    keys = np.vstack([upper.dofs + above, lower.dofs + above * (upper.dofs[:, 0].max() + 2)])
    return {(int(keys[i, 0]), int(keys[i, 1])): float(e[i]) for i in np.flatnonzero(np.abs(e) > 1e-12)}


def _before_it_gives_way(made: Import, pull: dict[tuple[int, int], float]) -> float:
    """The force in the shank of which the preload is left once the closed contact has given way."""
    force = np.zeros(len(made.stiffness.dofs))
    force[made.stiffness.rows(list(pull))] = list(pull.values())
    welded = made.condensation.welded(LoadCase(history=1.0, force=force))
    return PRELOAD / (1.0 - SHANK * welded.conjugate(welded))


def _shank(pull: dict[tuple[int, int], float]) -> Iterator[str]:
    """A spring between two nodes that move as head and nut do on average."""
    yield from ("*NODE", "90001, 0., 0., 6.", "90002, 0., 0., -10.", "*ELEMENT, TYPE=SPRING2, ELSET=SHANK")
    yield from ("99001, 90001, 90002", "*SPRING, ELSET=SHANK", "3, 3", f"{SHANK:.10g}.,0.")
    yield from ("*BOUNDARY", "90001, 1, 2", "90002, 1, 2")
    for label, sign in ((90001, -1.0), (90002, 1.0)):
        terms = [(node, 3, sign * part) for (node, _), part in pull.items() if sign * part > 0]
        terms = [(label, 3, -1.0), *terms]
        yield from ("*EQUATION", str(len(terms)))
        for k in range(0, len(terms), 4):
            yield ", ".join(f"{node}, {direction}, {part:.14g}" for node, direction, part in terms[k : k + 4])


def _steps(pull: dict[tuple[int, int], float], before: float, increment: float) -> Iterator[str]:
    """Tightening, then a step per quarter of a cycle, in equal increments."""
    tightening = [f"{node}, {direction}, {before * part:.14g}" for (node, direction), part in pull.items()]
    for loads in [tightening] + [[f"TIP, 1, {PUSH * x}", f"TIP, 2, {PUSH * y}"] for x, y in QUARTERS]:
        yield from ("*STEP, INC=100000", "*STATIC", f"{increment}, 1., 1e-9, {increment}", "*CLOAD", *loads)
        yield from ("*NODE PRINT, NSET=ALL, FREQUENCY=100000", "U", "*END STEP")
