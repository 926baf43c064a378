"""A sphere rolled to and fro under a tangential force: what friction holds in the end, its creep above that.

Wetter and Popov's formula against two methods on finer and finer squares, both with pressures from the normal
problem of the mesh itself, whose squares open and close. *Bound*: once nothing slips the tractions do not
change, so that only the least pressure of every square counts (B = 0); λ_max of the joint under these is
the tangential force that can be held. *Motion*: above that the sphere creeps by about as much as the force is
too large; its creep per period, at two forces, leads back to the force at which it ends.
"""

import time
from dataclasses import dataclass

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

import shakedown
from benchmarks.bodies.sphere import SKEW, rolling_limit, rolling_sphere
from shakedown import Problem
from shakedown.ground.float_array import FloatArray
from shakedown.motion.fixed_steps import FixedSteps
from shakedown.report.text_table import table

TITLE = "A sphere rolled to and fro: tangential force that friction holds"
FRICTION = 0.5
AMPLITUDES, SIZES = (0.1, 0.3, 0.5, 0.7), (0.4, 0.3, 0.2, 0.15, 0.12)
FOLLOWED = 0.2  # smallest squares whose motion is followed
DIRECTIONS, TURNED = (0.0, 23.0, 90.0), (0.3, 0.2)  # degrees from rolling; amplitude and size in all of them
BELOW, ABOVE = 0.98, (1.02, 1.04)  # of the bound of the mesh
MOST, SETTLED = 200, 150  # cycles followed at most below it, and above it
TOUCH = 1e-9  # of the normal force: what is not round-off
EVENTS = {"amplitude": 0.3, "size": 0.4, "direction": 23.0, "method": "events"}
SLIPS = 1e-6  # of the first period's slip: what counts as slip


def cases(short: bool) -> list[dict]:
    amplitudes, sizes = ((0.3,), (0.5, 0.4)) if short else (AMPLITUDES, SIZES)
    found = [{"amplitude": w, "size": size, "direction": 23.0} for w in amplitudes for size in sizes]
    turned = [{"amplitude": TURNED[0], "size": TURNED[1], "direction": angle} for angle in DIRECTIONS]
    return found + ([] if short else [case for case in turned if case not in found] + [EVENTS])


@dataclass(frozen=True)
class Rolling:
    """What becomes of the sphere at one tangential force.

    Attributes
    ----------
    cycles
        Followed.
    creep
        Its displacement along the force, and aside, in the last period [contact radius].
    shift
        The same in all.
    slip
        Largest way in contact of a square in the last period, over that in the first [–].
    held : (n,)
        Tangential forces at the end [N].
    """

    cycles: int
    creep: tuple[float, float]
    shift: tuple[float, float]
    slip: float
    held: FloatArray


def measure(case: dict) -> dict:
    chosen = case["amplitude"], case["size"], case["direction"]
    return _by_events(*chosen) if "method" in case else _measured(*chosen)


def _measured(*chosen: float) -> dict:
    """The limit by the bound, and by the motion in load steps."""
    began, (amplitude, size, _) = time.process_time(), chosen
    joint = _joint(*chosen, 0.0)
    least, ever = _pressures(joint)
    bound = _bound(_joint(*chosen, 1.0), least)
    found = {
        "n": joint.n,
        "touch": int((ever > TOUCH).sum()),
        "formula": rolling_limit(amplitude),
        "bound": bound,
    }
    if size >= FOLLOWED:
        found |= _by_load_steps(bound, *chosen)
    if amplitude == TURNED[0]:
        found |= {"x": np.round(joint.x, 5).tolist(), "least": np.round(least, 7).tolist()}
    return found | {"seconds": time.process_time() - began}


def _by_load_steps(bound: float, *chosen: float) -> dict:
    """Creep at two forces above the bound, the force at which it ends; rest at one below."""
    direction = chosen[2]
    below = rolled(_joint(*chosen, BELOW * bound), direction, MOST)
    above = [rolled(_joint(*chosen, share * bound), direction, SETTLED) for share in ABOVE]
    creep = [run.creep[0] for run in above]
    back = ABOVE[0] - creep[0] * (ABOVE[1] - ABOVE[0]) / (creep[1] - creep[0])
    return {
        "motion": back * bound,
        "below": {"cycles": below.cycles, "slip": below.slip, "shift": list(below.shift)},
        "creep": [list(run.creep) for run in above],
        "held": np.round(below.held, 7).tolist(),
    }


def _by_events(*chosen: float) -> dict:
    """What the motion from event to event settles into, below and above the bound."""
    least, _ = _pressures(_joint(*chosen, 0.0))
    bound = _bound(_joint(*chosen, 1.0), least)
    runs = [
        shakedown.simulate(_joint(*chosen, share * bound), 1.0, cycles=MOST) for share in (BELOW, ABOVE[0])
    ]
    return {"outcomes": [str(run.outcome) for run in runs], "cycles": [run.cycles_simulated for run in runs]}


def _joint(amplitude: float, size: float, direction: float, shear: float) -> Problem:
    return rolling_sphere(size, amplitude=amplitude, shear=shear, direction=np.deg2rad(direction), f=FRICTION)


def _pressures(joint: Problem) -> tuple[FloatArray, FloatArray]:
    """Least and largest normal force of every square over a period; nothing moves it along the flat."""
    path = FixedSteps(joint, 1.0)
    path.cycle(record=True)
    pressed = np.maximum(path.history.p, 0.0)
    return pressed.min(axis=0), pressed.max(axis=0)


def _bound(joint: Problem, least: FloatArray) -> float:
    """λ_max of the joint under these pressures and λ times its tangential force."""
    held = Problem(
        A=joint.A, B=joint.B, f=joint.f, q_w=joint.q_w[:1], p_w=least[None], q_mean=np.zeros(2 * joint.n)
    )
    return float(shakedown.upper_bound(held).load_factor)


def rolled(joint: Problem, direction: float, cycles: int) -> Rolling:
    """Roll until nothing slips, or for so many periods."""
    path, slips = FixedSteps(joint, 1.0), []
    angle = np.deg2rad(direction)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    before = after = start = path.state.u[: 2 * joint.n]
    while len(slips) < cycles and not (slips and slips[-1] <= SLIPS * slips[0]):
        record = path.cycle()
        if record is None:
            raise RuntimeError(f"cycle {len(slips)}: {path.stop}")
        before, after = after, record.end_slip
        slips.append(float(record.slip.max()))
    creep, shift = (turn @ (after - other).reshape(-1, 2).mean(axis=0) for other in (before, start))
    return Rolling(
        len(slips),
        (float(creep[0]), float(creep[1])),
        (float(shift[0]), float(shift[1])),
        slips[-1] / slips[0],
        -(joint.q_w[0] + joint.A @ after),
    )


def followed(rows: list[dict]) -> list[dict]:
    return [row for row in rows if "bound" in row]


def tables(rows: list[dict]) -> str:
    lines = [
        [f"{row['amplitude']:g}", f"{row['size']:g}", f"{row['direction']:g}°",
         f"{row['touch']} of {row['n']}", f"{row['formula']:.4f}", f"{row['bound']:.4f}",
         f"{row['bound'] - row['formula']:+.1e}",
         *_moved(row), f"{row['seconds']:.0f}"]
        for row in followed(rows)
    ]  # fmt: skip
    heads = [
        "w/a", "h/a", "direction", "touch", "formula", "bound", "bound off", "motion off", "periods",
        f"shift, {BELOW:g}", f"creep, {ABOVE[0]:g}", "s",
    ]  # fmt: skip
    text = (
        "F/f N that is held; periods until nothing slips and displacement by then, just below; creep per "
        f"period just above [contact radius]\n{table(heads, lines)}"
    )
    for row in (row for row in rows if "outcomes" in row):
        ends = [
            f"{share:g} of the bound: {word} ({count} periods)"
            for share, word, count in zip((BELOW, ABOVE[0]), row["outcomes"], row["cycles"], strict=True)
        ]
        text += f"\n\nw/a {row['amplitude']:g}, h/a {row['size']:g}, from event to event: {', '.join(ends)}"
    return text


def _moved(row: dict) -> list[str]:
    """What its motion says, in words."""
    if "motion" not in row:
        return ["-"] * 4
    return [
        f"{row['motion'] - row['formula']:+.1e}",
        str(row["below"]["cycles"]),
        f"{row['below']['shift'][0]:.4f}",
        f"{row['creep'][0][0]:.5f}",
    ]


def figures(rows: list[dict]) -> dict[str, Figure]:
    figure = Figure(figsize=(8.6, 6.4), layout="constrained")
    (curve, error), (pressure, traction) = figure.subplots(2, 2)
    found = [row for row in followed(rows) if row["direction"] == DIRECTIONS[1]]
    _curve(curve, found)
    _errors(error, found)
    shown = min((row for row in found if "held" in row and "x" in row), key=lambda row: row["size"])
    held = np.array(shown["held"]).reshape(-1, 2) / shown["size"] ** 2
    _patch(pressure, shown, np.array(shown["least"]) / shown["size"] ** 2, "least pressure over a period")
    _patch(traction, shown, np.hypot(*held.T), f"tractions at the end, {BELOW:g} of the bound")
    felt = np.hypot(*held.T) > 0.02 * np.hypot(*held.T).max()
    traction.quiver(*np.array(shown["x"])[felt].T, *held[felt].T, color="w", pivot="mid", width=0.004)
    for axes in (curve, error):
        axes.legend(fontsize=7)
        axes.grid(alpha=0.3)
    return {"rolled_sphere": figure}


def _curve(axes, found: list[dict]) -> None:
    """The formula, the bound on the coarsest and the finest squares, and the motion on its finest."""
    amplitude = np.linspace(0, 1, 101)
    axes.plot(amplitude, [rolling_limit(w) for w in amplitude], "k-", lw=1, label="1 − 3w/2a + w³/2a³")
    sizes = sorted({row["size"] for row in found})
    moved = min(row["size"] for row in found if "motion" in row)
    for size, key, mark in ((sizes[-1], "bound", "^"), (sizes[0], "bound", "o"), (moved, "motion", "x")):
        mine = [(row["amplitude"], row[key]) for row in found if row["size"] == size]
        axes.plot(*zip(*mine, strict=True), mark, ms=6, mfc="none", label=f"{key}, h = {size:g} a")
    axes.set(xlabel="w / a", ylabel="tangential force held / f N")


def _errors(axes, found: list[dict]) -> None:
    """Of the bound over the mesh, for every amplitude and in the mean."""
    sizes = sorted({row["size"] for row in found})
    for w in sorted({row["amplitude"] for row in found}):
        mine = sorted((row["size"], off(row, "bound")) for row in found if row["amplitude"] == w)
        axes.loglog(*zip(*mine, strict=True), "o-", ms=3, lw=0.7, label=f"w = {w:g} a")
    axes.loglog(sizes, [mean_off(found, size) for size in sizes], "k-", lw=2, label="root mean square")
    axes.loglog(sizes, 0.1 * np.square(sizes), "k:", lw=1, label="second order")
    axes.set_xticks(sizes, [f"{size:g}" for size in sizes], minor=False)
    axes.xaxis.set_minor_formatter("")
    axes.set(xlabel="edge of a square / a", ylabel="|bound − formula|")


def off(row: dict, key: str) -> float:
    """How far from the formula."""
    return float(abs(row[key] - row["formula"]))


def mean_off(found: list[dict], size: float) -> float:
    """Root mean square of the bound's error over the amplitudes, on squares of this size."""
    return float(np.sqrt(np.mean([off(row, "bound") ** 2 for row in found if row["size"] == size])))


def order(rows: list[dict]) -> float:
    """Slope of that error over the size of the squares, fitted."""
    found = [row for row in followed(rows) if row["direction"] == DIRECTIONS[1]]
    sizes = sorted({row["size"] for row in found})
    return float(np.polyfit(np.log(sizes), np.log([mean_off(found, size) for size in sizes]), 1)[0])


def _patch(axes, row: dict, values: FloatArray, title: str) -> None:
    """Values on the squares, and the contact at both ends of its way."""
    square = row["size"] / 2 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    turn = np.array([[np.cos(SKEW), np.sin(SKEW)], [-np.sin(SKEW), np.cos(SKEW)]])
    squares = PolyCollection([place + square @ turn for place in np.array(row["x"])], cmap="viridis")
    squares.set(array=values, clim=(0, values.max()))
    axes.add_collection(squares)
    axes.figure.colorbar(squares, ax=axes, label="N / a²", shrink=0.8)
    angle = np.linspace(0, 2 * np.pi, 200)
    for side in (-1, 1):
        axes.plot(side * row["amplitude"] + np.cos(angle), np.sin(angle), "r-", lw=0.8)
    axes.set_title(title, fontsize=10)
    axes.set(xlabel="x / a (rolling)", ylabel="y / a")
    axes.set_aspect("equal")
