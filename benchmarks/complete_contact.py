"""A complete contact under a thousand transient loads: what final state follows from each?

The question of Flicek, Hills, Barber and Dini (2015), on a joint in their spirit: a square block on a
large elastic body of the same material. A rigid platen that is bonded to the block presses it down and
is moved to and fro; the body below is pulled and pushed a quarter of a period later. Every transient is
one to three random loads and a return to the mean load, from slip zero; the same states are then followed
at every load factor.

What was found, with 250 contact nodes and f = 0.3.

- Between 0.5 and 0.99 λ_max the state decides. Of 1,024 states that strong transients leave behind,
  three times the loop at λ_max, all shake down at 0.5 λ_max, 94.9 % at 0.6, 35.4 % at 0.9, none at 0.99
  and above. λ_U, up to which every state is proved to shake down, is 0.139 λ_max; λ_T, from no slip,
  0.987 λ_max.
- The limit cycle is not unique. At 1.2 λ_max the largest dissipation is 1.99 times the smallest, with
  713 different ones; at 0.99 λ_max, where all states slip as well, 62 times. The period is always one.
- Transients within the loads of the loop at λ_max leave little behind: all of 256 states shake down at
  0.9 λ_max, and at 1.2 λ_max they dissipate the same to 0.4 %. It takes an overload to change the end.
- A safe slip exists at 0.99 λ_max, but no transient found it.
- It took six and a half minutes of CPU time: 51 s for the transients, 8 s for the mesh and the bounds,
  333 s for 12,032 long-term states (10 ms each at 0.3 λ_max, 56 ms at 1.5).

λ_max is that of this mesh: with so little friction the corners slip at any load in the limit of fine
meshes (``benchmarks/refinement.py``).
"""

import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import cache
from multiprocessing import get_context

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.stats import binomtest
from skfem import MeshQuad

import shakedown
from shakedown import Outcome, Problem
from shakedown.bounds.uniqueness.in_contact import unique_in_contact
from shakedown.fem import Displacement, ElasticBody, Material, Support, Traction, contact_problem
from shakedown.ground.float_array import FloatArray
from shakedown.motion.checked_law import scales
from shakedown.motion.evolve import evolve
from shakedown.report.text_table import table

TITLE = "Complete contact: final states that follow from random transients"
FRICTION = 0.3
STEPS = 24
# The platen goes down by 1, and sideways by cos; the body is pulled by sin: factors of the three loads.
PRESSED = np.array([1.0, 0.0, 0.0])
PHASE = 2 * np.pi * np.arange(STEPS) / STEPS
MOVED = np.column_stack([np.zeros(STEPS), np.cos(PHASE), np.sin(PHASE)])

ABOVE = (0.3, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99, 1.05, 1.2, 1.5)  # load factors over λ_max
MILD, STRONG = 1.0, 3.0  # largest load of a transient, over that of the loop at λ_max
LONGEST_TRANSIENT = 3  # random loads, before all return to their means
SEED = 0
PIECE = 16  # transients done by one process at a time; the numbers of states are multiples of it
SAME = 1e-6  # dissipations nearer than this, relative to the largest, count as one


def cases(short: bool) -> list[dict]:
    elements, processes = (16, 1) if short else (249, 2)
    joint = {"elements": elements, "processes": processes}
    strong = {"kind": "map", "transients": STRONG, "states": 48 if short else 1024}
    mild = {"kind": "map", "transients": MILD, "states": 16 if short else 256}
    return [
        joint | {"kind": "bounds"},
        *(joint | strong | {"above": above} for above in ((0.3, 0.9, 1.2) if short else ABOVE)),
        *(joint | mild | {"above": above} for above in ((1.2,) if short else (0.9, 0.99, 1.2))),
        joint | strong | {"kind": "one by one", "above": 0.9, "compared": 8 if short else 24},
    ]


@cache
def unit_loads(elements: int) -> Problem:
    """The joint with a loop of three load steps, each of which is one of the loads at factor 1."""
    pressing, moving, pulling = np.eye(3)
    material = Material(young=1.0, poisson=0.3)
    block = ElasticBody(
        block_above(elements),
        material,
        loads=[
            Displacement("top", x=0.0, y=-1.0, history=pressing),
            Displacement("top", x=1.0, y=0.0, history=moving),
        ],
    )
    body = ElasticBody(
        body_below(elements),
        material,
        supports=[Support("bottom")],
        loads=[
            Traction("left", (-1.0, 0.0), history=pulling),
            Traction("right", (1.0, 0.0), history=pulling),
        ],
    )
    made = contact_problem(block, "contact", FRICTION, against=(body, "contact"), steps=3)
    return replace(made, load_reactions=None, load_history=None, load_compliance=None)  # loops of others


def block_above(elements: int) -> MeshQuad:
    """A unit square whose elements are square at the contact and grow away from it."""
    mesh = MeshQuad.init_tensor(
        np.linspace(0.0, 1.0, elements + 1), np.append(0.0, growing(1 / elements, 1.0))
    )
    return mesh.with_boundaries({"contact": lambda p: p[1] < 1e-9, "top": lambda p: p[1] > 1 - 1e-9})


def body_below(elements: int) -> MeshQuad:
    """Six times as wide as the block and three times as high; its elements match those of the block."""
    beside, down = growing(1 / elements, 2.5), growing(1 / elements, 3.0)
    across = np.concatenate([-beside[::-1], np.linspace(0.0, 1.0, elements + 1), 1 + beside])
    mesh = MeshQuad.init_tensor(across, np.append(-down[::-1], 0.0))
    return mesh.with_boundaries(
        {
            "contact": lambda p: (p[1] > -1e-9) & (p[0] > 0) & (p[0] < 1),
            "bottom": lambda p: p[1] < -3 + 1e-9,
            "left": lambda p: p[0] < -2.5 + 1e-9,
            "right": lambda p: p[0] > 3.5 - 1e-9,
        }
    )


def growing(first: float, length: float, growth: float = 1.2) -> FloatArray:
    """Ends of elements that fill a length, each larger than the last, the first of about the given size."""
    count = int(np.ceil(np.log1p(length / first * (growth - 1)) / np.log(growth)))
    ends = np.cumsum(growth ** np.arange(count))
    return np.asarray(ends * length / ends[-1])


def loaded(unit: Problem, factors: FloatArray, mean: FloatArray) -> Problem:
    """The joint under a loop of loads given by the factors of the three, (m, 3), and of their means."""
    q_w, p_w = factors @ unit.q_w, factors @ unit.p_w
    return replace(unit, q_w=q_w, p_w=p_w, q_mean=mean @ unit.q_w, p_mean=mean @ unit.p_w)


@cache
def joint_of(elements: int) -> tuple[Problem, float]:
    """The joint and its λ_max."""
    problem = loaded(unit_loads(elements), PRESSED + MOVED, PRESSED)
    return problem, shakedown.upper_bound(problem, certify=False).load_factor


@dataclass(frozen=True)
class Transients:
    """What random loads leave behind: one to three, and a return to the mean load, from slip zero.

    Every load is independent and uniform: pressing from 1 to ``largest`` times its mean, the two
    others up to ``largest`` times their size at λ_max to either side.
    """

    unit: Problem
    limit: float
    largest: float

    def __call__(self, number: int) -> tuple[FloatArray, float]:
        """A piece of the states, (PIECE, n), and the CPU time of each."""
        generator, began = np.random.default_rng([SEED, number]), time.process_time()
        slips = [self.left_behind(generator) for _ in range(PIECE)]
        return np.array(slips), (time.process_time() - began) / PIECE

    def left_behind(self, generator: np.random.Generator) -> FloatArray:
        count = generator.integers(1, LONGEST_TRANSIENT + 1)
        side = self.largest * self.limit
        passed = generator.uniform((1.0, -side, -side), (self.largest, side, side), (count, 3))
        still = loaded(self.unit, PRESSED[None], PRESSED)
        still = replace(still, q_transient=passed @ self.unit.q_w, p_transient=passed @ self.unit.p_w)
        return evolve(still, 0.0).history.v[-1]


@cache
def initial_slips(
    elements: int, largest: float, states: int, processes: int
) -> tuple[FloatArray, float, float]:
    """The slips that so many transients leave behind, with CPU and elapsed seconds; the same at every λ."""
    work, began = Transients(unit_loads(elements), joint_of(elements)[1], largest), time.perf_counter()
    numbers = range(states // PIECE)
    if processes == 1:
        pieces = [work(number) for number in numbers]
    else:
        with ProcessPoolExecutor(processes, get_context("spawn")) as pool:
            pieces = list(pool.map(work, numbers))
    slips = np.concatenate([slips for slips, _ in pieces])
    return slips, sum(cpu * PIECE for _, cpu in pieces), time.perf_counter() - began


def measure(case: dict) -> dict:
    if case["kind"] == "bounds":
        return _bounds(case["elements"])
    return _mapped(case) if case["kind"] == "map" else _one_by_one(case)


def _bounds(elements: int) -> dict:
    began, cpu = time.perf_counter(), time.process_time()
    problem, _ = joint_of(elements)
    built = time.process_time() - cpu
    upper = shakedown.upper_bound(problem)
    lower = shakedown.lower_bound(problem, certify=False)
    universal = shakedown.universal_bound(problem, first_collapse=lower)
    energy = shakedown.energy_bound(problem, certify=False)
    history = shakedown.transient_limit(problem, steps=20, accuracy=1e-5)
    return {
        "n": problem.n,
        "unique_in_contact": unique_in_contact(problem).argument,
        "upper": upper.load_factor,
        "upper_certified": None if upper.certified is None else list(upper.certified),
        "lower": lower.load_factor,
        "lower_node": lower.node,
        "guarantee": str(lower.guarantee),
        "universal": universal.load_factor,
        "energy": energy.load_factor,
        "history": [history.proved, history.cycling],
        "build_cpu_s": built,
        "cpu_s": time.process_time() - cpu,
        "elapsed_s": time.perf_counter() - began,
    }


def _mapped(case: dict) -> dict:
    problem, limit = joint_of(case["elements"])
    slips, left_cpu, left_elapsed = initial_slips(
        case["elements"], case["transients"], case["states"], case["processes"]
    )
    load_factor = case["above"] * limit
    shakedown.long_term_states(problem, load_factor, slips[:1])  # compiles
    began, cpu = time.perf_counter(), time.process_time()
    found = shakedown.long_term_states(problem, load_factor, slips, threads=case["processes"])
    seconds, cpu = time.perf_counter() - began, time.process_time() - cpu
    safe = int((found.outcome == Outcome.SHAKEDOWN).sum())
    interval = binomtest(safe, len(slips)).proportion_ci(method="wilson")
    cyclic = found.outcome == Outcome.CYCLIC_SLIP
    slipping = found.slip_per_cycle[cyclic] > 0
    return {
        "load_factor": load_factor,
        "outcomes": {word.value: int((found.outcome == word).sum()) for word in Outcome},
        "share": safe / len(slips),
        "interval": [interval.low, interval.high],
        "dissipation": _quartiles(found.dissipation),
        "dissipation_of_cycles": _quartiles(found.dissipation[cyclic]),
        "different_dissipations": _different(found.dissipation[cyclic]),
        "slipping_sets": len(np.unique(slipping, axis=0)),
        "contact_sequences": len(np.unique(found.signature[cyclic])),
        "periods": sorted({int(period) for period in found.period}),
        "most_cycles": int(found.cycles_simulated.max()),
        "transients_cpu_s": left_cpu,
        "transients_elapsed_s": left_elapsed,
        "cpu_s": cpu,
        "elapsed_s": seconds,
    }


def _one_by_one(case: dict) -> dict:
    """Some states of a map again, each by the single search."""
    problem, limit = joint_of(case["elements"])
    slips, *_ = initial_slips(case["elements"], case["transients"], case["states"], case["processes"])
    slips, load_factor = slips[: case["compared"]], case["above"] * limit
    batch = shakedown.long_term_states(problem, load_factor, slips)
    alone = [shakedown.long_term_state(problem, load_factor, slip) for slip in slips]
    length = scales(problem, load_factor).length
    pairs = list(zip(batch.outcome, batch.period, batch.final_slip, alone, strict=True))
    return {
        "differ": sum((outcome, period) != (one.outcome, one.period) for outcome, period, _, one in pairs),
        "largest_difference": max(float(np.abs(v - one.final_slip).max()) / length for *_, v, one in pairs),
    }


def _quartiles(dissipation: FloatArray) -> list[float]:
    """Minimum, quartiles and maximum; none where nothing is known."""
    known = dissipation[~np.isnan(dissipation)]
    return np.quantile(known, [0.0, 0.25, 0.5, 0.75, 1.0]).tolist() if len(known) else []


def _different(dissipation: FloatArray) -> int:
    """How many dissipations differ by more than a millionth of the largest."""
    if not len(dissipation):
        return 0
    return 1 + int((np.diff(np.sort(dissipation)) > SAME * dissipation.max()).sum())


def tables(rows: list[dict]) -> str:
    bounds, maps = _parted(rows)
    lines = [
        ["λ_max", f"{bounds['upper']:.6f}", "1", f"certified within {bounds['upper_certified']}"],
        ["λ_1", *_relative(bounds["lower"], bounds), f"node {bounds['lower_node']}; {bounds['guarantee']}"],
        ["λ_U", *_relative(bounds["universal"], bounds), "proved from every state"],
        ["λ_E", *_relative(bounds["energy"], bounds), "proved from no slip"],
        ["λ_T", *_relative(bounds["history"][0], bounds), "from no slip"],
    ]
    said = table(["limit", "λ", "λ / λ_max", ""], lines)
    said += f"\n{bounds['n']} nodes, bounds in {bounds['cpu_s']:.0f} s of CPU time"
    if not maps:
        return said
    head = [
        "transients", "λ / λ_max", "states", "shake down", "95 %", "dissipation: min", "median", "max",
        "different", "sequences", "CPU [s]",
    ]  # fmt: skip
    each = table(head, [_line(row) for row in maps])
    first = maps[0]
    left = f"transients: {first['transients_cpu_s']:.0f} s of CPU time"
    left += f", {first['transients_elapsed_s']:.0f} s elapsed"
    said = f"{said}\n\n{each}\n{left}"
    for row in rows:
        if row["kind"] == "one by one":
            said += f"\none by one: {row['differ']} of {row['compared']} end differently"
            said += f"; slips within {row['largest_difference']:.0e} of the length scale"
    return said


def _relative(load_factor: float, bounds: dict) -> list[str]:
    return [f"{load_factor:.6f}", f"{load_factor / bounds['upper']:.4f}"]


def _line(row: dict) -> list[str]:
    low, _, middle, _, high = row["dissipation"]
    return [
        f"{row['transients']:g}", f"{row['above']:g}", str(row["states"]), f"{100 * row['share']:.1f} %",
        f"{100 * row['interval'][0]:.1f}–{100 * row['interval'][1]:.1f} %",
        f"{low:.3g}", f"{middle:.3g}", f"{high:.3g}",
        str(row["different_dissipations"]), str(row["contact_sequences"]), f"{row['cpu_s']:.1f}",
    ]  # fmt: skip


def _parted(rows: list[dict]) -> tuple[dict, list[dict]]:
    return rows[0], [row for row in rows if row["kind"] == "map"]


def figures(rows: list[dict]) -> dict[str, Figure]:
    bounds, maps = _parted(rows)
    figure = Figure(figsize=(11.0, 4.4), layout="constrained")
    left, right = figure.subplots(1, 2, sharex=True)
    for strength, color in ((STRONG, "tab:red"), (MILD, "tab:blue")):
        some = [row for row in maps if row["transients"] == strength]
        said = f"{strength:g} times the loop at λ_max"
        _share(left, some, color, f"transients up to {said}" if strength != 1 else "transients within it")
        name = "within the loop" if strength == 1 else f"up to {strength:g} times"
        _dissipation(right, [row for row in some if row["dissipation_of_cycles"]], color, name)
    left.set(ylabel="share that shakes down, with 95 % interval", ylim=(-0.05, 1.05))
    left.legend(loc="lower left", fontsize=8)
    right.set(ylabel="dissipation per cycle of the states that slip", yscale="log")
    right.legend(loc="upper left", fontsize=8)
    for axes in (left, right):
        axes.set(xlabel="λ / λ_max", xlim=(0, 1.55))
        axes.grid(alpha=0.3)
        _marks(axes, bounds)
    return {"complete-contact": figure}


def _share(axes: Axes, maps: list[dict], color: str, label: str) -> None:
    share = np.array([row["share"] for row in maps])
    ends = np.array([row["interval"] for row in maps]).reshape(-1, 2)
    above = [row["above"] for row in maps]
    axes.errorbar(above, share, np.abs(ends.T - share), fmt="o-", color=color, capsize=3, label=label)


def _dissipation(axes: Axes, maps: list[dict], color: str, name: str) -> None:
    """Range, quartiles and median."""
    if len(maps) == 0:
        return
    above = [row["above"] for row in maps]
    low, first, middle, third, high = np.array([row["dissipation_of_cycles"] for row in maps]).T
    axes.fill_between(above, low, high, color=color, alpha=0.15, label=f"{name}: smallest to largest")
    axes.fill_between(above, first, third, color=color, alpha=0.35, label=f"{name}: middle half")
    axes.plot(above, middle, "o-", color=color, label=f"{name}: median")


def _marks(axes: Axes, bounds: dict) -> None:
    """The bounds as vertical lines, named on top; λ_T and λ_max may be close."""
    marks = {
        "λ_U ": bounds["universal"],
        " λ_1": bounds["lower"],
        "λ_E": bounds["energy"],
        "λ_T ": bounds["history"][0],
        " λ_max": bounds["upper"],
    }
    for name, load_factor in marks.items():
        place = load_factor / bounds["upper"]
        side = "right" if name.endswith(" ") else "left" if name.startswith(" ") else "center"
        axes.axvline(place, color="0.4", linewidth=0.9, linestyle="--", zorder=0)
        axes.text(place, 1.01, name, transform=axes.get_xaxis_transform(), ha=side, fontsize=9, color="0.3")
