"""Chapter III of the thesis reproduced: the receding contact of a block on a rigid plane.

A block h × 4h is pressed on a rigid plane by a pressure on the central strip 2h of its top, f = 0.35,
ν = 0.3; the pressure rises to p_max, then cycles between p_max and p_max/3. The right half is followed from
event to event, so neither the path nor the dissipation −∫ q dv depends on a load step. The thesis states
neither its mesh nor which plane it means: plane strain is our choice.

A cycle leads from p_max to p_max, so the first loading is no part of the first. The increment of cycle N
is the largest change of any node's slip from its start to its end. On a mesh the power law of the increments
must end: as soon as the sequence of contact states repeats, the map from cycle to cycle is affine and they
fall geometrically. The finer the mesh, the later that happens; the exponent is read off before it does.

What the thesis draws of zones are numbers here:

- fig. 3.2, first loading: zones of stick, slip and separation do not change;
- fig. 3.3, unloading to zero: stick at the edges of the contact at once; the contact area falls
  monotonically; at zero load all slip reverts and all gaps close;
- fig. 3.5, ninth cycle: three stick regions (of the whole contact) separated by small slip regions during
  unloading, which stay stuck during reloading (here the outermost of their nodes slip again in its last
  hundredths);
- fig. 3.7, steady state: points that reach |q| = f p but do not slip.
"""

from dataclasses import replace
from itertools import groupby

import numpy as np
from matplotlib.figure import Figure

import shakedown
from benchmarks.bodies.blocks import receding_block
from benchmarks.display import listed, panels
from shakedown import Problem, plot
from shakedown.ground.constants import FloatArray, Mask
from shakedown.ground.status import SLIP
from shakedown.motion.event_history import EventHistory
from shakedown.motion.evolution import evolve

TITLE = "Chapter III: receding contact under cyclic loading"
THESIS_EXPONENT, THESIS_RATIO = -3.1, 0.56
WINDOWS = ((5, 20), (10, 40), (20, 80))  # of N, in which exponents are fitted
FLOOR = 1e-7  # increments below this share of the first are left out
P_MAX, THIRD, NINTH = -0.5, 0.0, 7.5  # times in cycles: p_max, p_max/3 in the first cycle, p_max again
NEARLY_ALL = 0.9  # how much of an unloading or reloading counts as its main part
SOON = 1e-3  # of a cycle: "at once"
AT_THE_LIMIT = 1e-9  # as the marks of plot.zones
LETTERS = {0: "s", 1: "-", -1: "+", 2: "o"}  # stick, slip inwards and outwards, open
DRAWN = 12  # finest refinement of which zones are counted and drawn


def cases(short: bool) -> list[dict]:
    """Finer and finer meshes."""
    return [{"refinement": r} for r in ((2, 4) if short else (2, 4, 6, 8, 12, 16, 24))]


def measure(case: dict) -> dict:
    refinement = case["refinement"]
    return cycles(refinement) | (zones(refinement) if refinement <= DRAWN else {})


def cycles(refinement: int) -> dict:
    """Slip increments and dissipation cycle by cycle."""
    block = right_half(refinement)
    run = shakedown.simulate(block, 1.0, cycles=1000, record=True)
    path, ends = run.history, np.arange(run.cycles_simulated + 1) - 0.5
    assert path is not None
    last = np.searchsorted(path.cycle, ends + 1e-9, side="right") - 1  # rows at p_max
    work = -(0.5 * (path.q[1:] + path.q[:-1]) * np.diff(path.v, axis=0)).sum(axis=1)
    dissipation = np.diff(np.append(0.0, np.cumsum(work))[last])
    increment = np.abs(np.diff(path.v[last], axis=0)).max(axis=1)
    return {
        "nodes": block.n,
        "cycles": run.cycles_simulated,
        "dissipation": dissipation.tolist(),
        "dissipation_ratio": float(run.dissipation_per_cycle / dissipation[0]),
        "increment": increment.tolist(),
        "exponents": _exponents(increment),
    }


def _exponents(increment: FloatArray) -> dict[str, float]:
    """Slope of log increment over log N in windows of N, as far as the increments are above the floor."""
    N, slopes = np.arange(1, len(increment) + 1), {}
    for low, high in WINDOWS:
        inside = (increment > FLOOR * increment[0]) & (low <= N) & (high >= N)
        if inside.sum() == high - low + 1:
            slope = np.polyfit(np.log(N[inside]), np.log(increment[inside]), 1)[0]
            slopes[f"{low}-{high}"] = round(float(slope), 3)
    return slopes


def zones(refinement: int) -> dict:
    """What the thesis says in words about figs 3.2, 3.3, 3.5 and 3.7, as numbers."""
    loading, down = first_loading(refinement), unloading(refinement)
    first, ninth = cycle(refinement, 0), cycle(refinement, 8)
    steady = shakedown.long_term_state(right_half(refinement), 1.0).history
    assert steady is not None
    half = ninth.cycle < NINTH + 0.5 - 1e-9
    early = ninth.cycle < NINTH + 0.5 + 0.5 * NEARLY_ALL  # nine tenths of the reloading
    inner = (ninth.state[half] == -1).any(axis=0)  # slips outwards while the pressure falls
    block = right_half(refinement)
    return {
        "first_loading_changes": int((loading.state != loading.state[0]).sum(axis=1).max()),
        "slip_left": _left(down.v),
        "gap_left": _left(down.w),
        "sticks_at_once": int((down.at(np.array([P_MAX + SOON])).state[0] == 0).sum()),
        "in_contact_at_p_max": int((down.state[0] != 2).sum()),
        "contact_grows": int((np.diff((down.state[:-1] != 2).sum(axis=1)) > 0).sum()),
        "unloading_zones": pattern(down, P_MAX + 0.5 * NEARLY_ALL),
        "ninth_zones": pattern(ninth, NINTH + 0.5 * NEARLY_ALL),
        "ninth_inner": int(inner.sum()),
        "ninth_inner_slipping_again": int((slips(ninth.rows(~half), block) & inner).sum()),
        "ninth_inner_slipping_early": int((slips(ninth.rows(~half & early), block) & inner).sum()),
        "steady_zones": pattern(steady, steady.cycle[0] + 0.5 * NEARLY_ALL),
        "steady_slipping": int(slips(steady, block).sum()),
        "first_slipping": int(slips(first, block).sum()),
        "steady_at_limit": limit_reached(steady, block),
    }


def right_half(refinement: int) -> Problem:
    return receding_block(refinement, symmetric=True)


def first_loading(refinement: int) -> EventHistory:
    """From where the pressure is a fiftieth of p_max up to p_max; the states along it."""
    path = evolve(right_half(refinement), 1.0, cycles=1).history
    return path.at(np.linspace(P_MAX - 0.49, P_MAX - 0.01, 25))


def unloading(refinement: int) -> EventHistory:
    """The path from p_max to no load."""
    block = receding_block(refinement, symmetric=True, unloading=0.0)
    return between(evolve(block, 1.0, cycles=1).history, P_MAX, 0.0)


def cycle(refinement: int, number: int) -> EventHistory:
    """The path p_max → p_max/3 → p_max of a cycle after the first loading."""
    path = evolve(right_half(refinement), 1.0, cycles=number + 1).history
    return between(path, P_MAX + number, P_MAX + number + 1)


def between(path: EventHistory, begin: float, end: float) -> EventHistory:
    """The rows of a path from one load step to another; of several at the beginning the last."""
    first = int(np.searchsorted(path.cycle, begin + 1e-9, side="right")) - 1
    last = int(np.searchsorted(path.cycle, end - 1e-9))
    return path.rows(np.arange(first, last + 1))


def pattern(path: EventHistory, time: float) -> str:
    """Zones from the middle outwards, one letter each."""
    states = path.state[np.searchsorted(path.cycle, time, side="right") - 1]
    return "".join(letter for letter, _ in groupby(LETTERS[int(state)] for state in states))


def slips(path: EventHistory, problem: Problem) -> Mask:
    """Which nodes slip by more than round-off."""
    return (np.abs(path.without_round_off(problem).state) == SLIP).any(axis=0)


def limit_reached(path: EventHistory, problem: Problem) -> int:
    """How many nodes reach |q| = f p, but never slip or open; the middle, with q = 0, aside."""
    limit = problem.f * path.p
    noise = AT_THE_LIMIT * float(limit.max())
    reached = ((np.abs(path.q) >= limit - noise) & (limit > noise)).any(axis=0)
    return int((reached & ~slips(path, problem) & (path.state != 2).all(axis=0)).sum())


def _left(values: FloatArray) -> float:
    """What is left at the end, of the largest before."""
    return float(np.abs(values[-1]).max() / np.abs(values).max())


def tables(rows: list[dict]) -> str:
    slopes = {
        f"slope {low}-{high}": lambda row, key=f"{low}-{high}": f"{row['exponents'].get(key, np.nan):.2f}"
        for low, high in WINDOWS
    }
    paths = {"nodes": "{nodes}", "cycles": "{cycles}"} | slopes
    drawn = {
        "nodes": "{nodes}", "zones change": "{first_loading_changes}", "slip left": "{slip_left:.0e}",
        "gap left": "{gap_left:.0e}", "stick at once": "{sticks_at_once} of {in_contact_at_p_max}",
        "contact grows": "{contact_grows} times", "unloading": "{unloading_zones}",
        "ninth cycle": "{ninth_zones}",
        "of its inner nodes slip again, early / ever": (
            "{ninth_inner_slipping_early} / {ninth_inner_slipping_again} of {ninth_inner}"
        ),
        "steady": "{steady_zones}", "slipping, first / steady": "{first_slipping} / {steady_slipping}",
        "at the limit only": "{steady_at_limit}",
    }  # fmt: skip
    text = listed(rows, paths | {"dissipation, last/first": "{dissipation_ratio:.4f}"})
    text += f"\nthesis: slope {THESIS_EXPONENT}, dissipation {THESIS_RATIO}\n\n"
    return text + listed([row for row in rows if "steady_zones" in row], drawn)


def figures(rows: list[dict]) -> dict[str, Figure]:
    refinement = min(DRAWN, max(row["refinement"] for row in rows))
    return {
        "receding-cycles": cycle_figure(rows),
        "receding-histories": zone_figure(refinement),
        "receding-unloaded": traction_figure(refinement),
    }


def cycle_figure(rows: list[dict]) -> Figure:
    """Slip increments (fig. 3.6) and dissipation (fig. 3.8) of the cycles."""
    figure, (left, right) = panels(2, 2, (5.6, 4.6))
    for row in rows:
        increment, dissipation = np.array(row["increment"]), np.array(row["dissipation"][:20])
        kept = increment > FLOOR * increment[0]
        N, label = np.arange(1, len(increment) + 1), f"{row['nodes']} nodes"
        left.loglog(N[kept], increment[kept] / increment[0], ".-", label=label)
        right.plot(N[: len(dissipation)], dissipation / dissipation[0], ".-", label=label)
    N = np.array([3.0, 60.0])
    left.loglog(N, 0.12 * (N / 3) ** THESIS_EXPONENT, "k--", label=f"thesis: N^{THESIS_EXPONENT}")
    right.axhline(THESIS_RATIO, color="black", linestyle="--", label="thesis: about 56 %")
    left.set(xlabel="cycle N", title="largest slip increment / that of the first cycle (thesis fig. 3.6)")
    right.set(xlabel="cycle N", title="dissipation / that of the first cycle (fig. 3.8)", ylim=(0.5, 1.02))
    for axes in (left, right):
        axes.legend(frameon=False, fontsize="small")
        axes.title.set_fontsize("medium")
    return figure


def zone_figure(refinement: int) -> Figure:
    """Zones over position and time in the first loading, at full unloading, in the ninth and steady cycle."""
    block = right_half(refinement)
    loading = between(evolve(block, 1.0, cycles=1).history, P_MAX - 0.5, P_MAX)
    steady = shakedown.long_term_state(block, 1.0).history
    assert steady is not None
    figure, drawn = panels(4, 4, (3.4, 5.4))
    paths = {
        "first loading (thesis fig. 3.2)": (loading, ("0", "p_max")),
        "unloading to zero (fig. 3.3)": (unloading(refinement), ("p_max", "0")),
        "ninth cycle (fig. 3.5)": (cycle(refinement, 8), ("p_max", "p_max/3", "p_max")),
        "steady state (fig. 3.7)": (steady, ("p_max/3", "p_max", "p_max/3")),
    }
    for axes, (title, (path, pressures)) in zip(drawn, paths.items(), strict=True):
        plot.zones(path, block, ax=axes, marks=path is steady)
        axes.set_title(title, fontsize="medium")
        axes.set(xlabel="distance from the middle [h]", ylabel="")
        axes.set_yticks(np.linspace(*path.cycle[[0, -1]], len(pressures)), pressures)
        legend = axes.get_legend()
        assert legend is not None
        legend.remove()  # one for all: the last one has every entry
    texts = [text.get_text() for text in legend.get_texts()]
    figure.legend(legend.legend_handles, texts, loc="outside lower center", ncols=5, frameon=False)
    figure.suptitle(f"Receding contact, {block.n} nodes on the half, plane strain")
    return figure


def traction_figure(refinement: int) -> Figure:
    """Tractions at p_max and p_max/3 of the first unloading (fig. 3.4), and the use of friction."""
    path, block = cycle(refinement, 0), right_half(refinement)
    area = np.full(block.n, 0.25 / refinement)
    area[[0, -1]] /= 2
    figure, (left, right) = panels(2, 2, (5.6, 4.4))
    plot.pressure(path, replace(block, node_area=area), cycles=[P_MAX, THIRD], ax=left)
    plot.friction_use(path, block, cycles=[P_MAX, THIRD], ax=right)
    left.set_ylabel("pressure [p_max]")
    for axes in (left, right):
        for line, label in zip(axes.get_lines(), ("p_max", "p_max/3, unloading"), strict=False):
            line.set_label(label)
        axes.legend(fontsize="small")
        axes.set_xlabel("distance from the middle [h]")
    figure.suptitle(f"First unloading of the receding contact (thesis fig. 3.4), {block.n} nodes on the half")
    return figure
