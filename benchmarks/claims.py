"""The figures of the page of results, written from the stored results: ``python -m benchmarks.claims``."""

import json
import statistics
import sys
from collections.abc import Sequence
from math import isfinite
from pathlib import Path

from benchmarks import (
    bolted_flange,
    damping,
    headline,
    lap_joint,
    refinement,
    space_classical,
)
from benchmarks.calculix_contact import is_compared, verdict
from benchmarks.friction_work import exponent
from benchmarks.runner import RESULTS
from benchmarks.space_peers import best_of_siconos, times
from shakedown.files.atomic_write import atomic_write

PAGE = Path(__file__).parents[1] / "docs" / "results.md"
BEGIN, END = "<!-- figures: python -m benchmarks.claims -->\n", "<!-- end of figures -->"
HEADING = "\n## Every figure\n"


def lines() -> list[str]:
    """One sentence per claim, each with the study that it comes from."""
    return [
        *_lower_bound(),
        *_upper_bound(),
        *_large_joints(),
        *_enumeration(),
        *_hard_cases(),
        *_floating_joints(),
        *_peers(),
        *_peers_in_space(),
        *_calculix(),
        *_lap_joint(),
        *_bolted_flange(),
        *_refinement(),
        *_space_classical(),
        *_damping(),
        *_long_term(),
        *_stability(),
    ]


def rows(study: str) -> list[dict]:
    return json.loads((RESULTS / f"{study}.json").read_text())["rows"]


def _methods(bound: str, n: int) -> dict[str, dict]:
    return {row["method"]: row for row in rows("bounds") if (row["bound"], row["n"]) == (bound, n)}


def _lower_bound() -> list[str]:
    small, large = _methods("lower", 30), _methods("lower", 250)
    own, peers = large["shakedown"]["seconds"], ("scipy linprog", "highspy")
    timed = max(row["programs_timed"] for row in rows("bounds") if row["method"] in peers and row["n"] == 250)
    at_large, at_small = (
        " and ".join(f"{_ratio(methods[peer]['relative'])} times that with {peer}" for peer in peers)
        for methods in (large, small)
    )
    return [
        f"The lower bound of a joint with 250 nodes takes {own:.2g} s in floats; one program per node costs "
        f"{at_large}. With 30 nodes it takes {small['shakedown']['seconds']:.2g} s, certified in exact "
        f"arithmetic {small['shakedown, certified']['seconds']:.2g} s; one program per node costs {at_small}. The peers were timed on "
        f"up to {timed} of the n programs and scaled up (`bounds`)."
    ]


def _ratio(value: float) -> str:
    return f"{value:.0f}" if value >= 10 else f"{value:.2f}"


def _upper_bound() -> list[str]:
    methods = _methods("upper", 250)
    return [
        f"The upper bound of the same joint takes {methods['shakedown']['seconds']:.2g} s: "
        f"{1 / methods['highspy']['relative']:.2f} of the time of HiGHS called directly, "
        f"{1 / methods['scipy linprog']['relative']:.2f} of scipy's, "
        f"{1 / methods['cvxpy + Clarabel']['relative']:.2f} of cvxpy's with Clarabel (`bounds`)."
    ]


def _large_joints() -> list[str]:
    found = rows("large_joints")
    largest = max(row["n"] for row in found)
    own = {
        name: [row[name]["seconds"] for row in found if row["n"] == largest]
        for name in ("λ_max", "λ_1", "λ_E")
    }
    times = ", ".join(f"{name} {min(taken):.2g} to {max(taken):.2g} s" for name, taken in own.items())
    ratios = {
        row["joint"]: row["HiGHS, λ_max"]["seconds"] / row["λ_max"]["seconds"]
        for row in found
        if row["n"] >= 250 and "HiGHS, λ_max" in row  # the last size of each joint stays
    }
    beside = ", ".join(f"{_ratio(ratio)} ({joint})" for joint, ratio in ratios.items())
    return [
        f"Joints of {largest} nodes: {times}, one core. HiGHS, given the whole program of λ_max of the largest "
        f"joint of each kind, takes {beside} times as long; below some 50 nodes the bare solvers are quicker, by a "
        "millisecond (`large_joints`)."
    ]


def _enumeration() -> list[str]:
    largest = max(row["n"] for row in rows("enumeration"))
    found = {row["method"]: row for row in rows("enumeration") if row["n"] == largest}
    tree, batches = found["tree, one core"], found["numpy batches"]
    return [
        f"All {tree['total']:,} critical load factors of a joint with {largest} nodes: "
        f"{tree['nanoseconds']:.0f} ns each on one core, {batches['nanoseconds'] / tree['nanoseconds']:.0f} "
        "times less than batched `numpy.linalg.solve` (`enumeration`)."
    ]


def _hard_cases() -> list[str]:
    found = rows("hard_cases")
    checked = [row for row in found if row["reference"] == "rational"]
    methods: dict[str, list[str]] = {}
    for row in checked:
        methods.setdefault(row["method"], []).append(row["verdict"])
    total = len(next(iter(methods.values())))
    counts = {method: verdicts.count("right") for method, verdicts in methods.items()}
    own, *peers = counts.items()
    others = ", ".join(f"{method} {count}" for method, count in peers)
    return [
        f"Of {total} hard cases (parallel rows, conditions up to 1e14, units scaled by 1e±12, wedging, "
        f"infeasible loads), each with an answer enumerated in fractions, {own[1]} come out right to 1e-9 on "
        f"the default method; {others} (`hard_cases`)."
    ]


def _floating_joints() -> list[str]:
    found = rows("floating_joints")

    def most(*keys: str) -> float:
        return max(row[key] for row in found for key in keys if row[key] is not None)

    return [
        f"Both bounds of {sum(row['joints'] for row in found)} joints that only friction holds agree with HiGHS "
        f"to {most('upper_off_highs', 'lower_off_highs'):.0e}, {sum(row['true_known'] for row in found)} of these "
        "numbers with the optimum in fractions before the stiffness was rounded to "
        f"{most('upper_off_truth', 'lower_off_truth'):.0e}, those of copies in other units, orders and scales to "
        f"{most('units', 'forms'):.0e} (`floating_joints`)."
    ]


def _peers() -> list[str]:
    found = rows("evolution")
    exact = max(row["error"] for row in found if row["method"] == "event")

    def against(method: str) -> str:
        chosen = [
            r for r in found if r["method"] == method and r["parts"] == 1 and r["tolerance"] in (1e-13, 1e-12)
        ]
        ratios = [r["relative"] for r in chosen]
        return f"{min(ratios):.1f} to {max(ratios):.1f}"

    text = (
        f"Time per cycle at the given load steps, relative to the event-driven path (which does not change by "
        f"more than {exact:.0e} when every step is split into 7): Gauss–Seidel {against('gauss-seidel')}"
    )
    if any(row["method"] == "nsgs" for row in found):
        text += f", Siconos NSGS {against('nsgs')}, Siconos Lemke {against('lemke')}"
    worst = max(r["error"] for r in found if (r["method"], r["tolerance"]) == ("gauss-seidel", 1e-13))
    return [
        f"{text}. The error of Gauss–Seidel reaches {worst:.0e} at these load steps and falls with order 1 "
        "(`evolution`)."
    ]


def _peers_in_space() -> list[str]:
    measured = [row for row in rows("space_peers") if row["scene"].partition(",")[0].isdigit()]
    steps = [ratio for _, ratio in best_of_siconos(measured).values()]
    told = []
    for error in (1e-4, 1e-6):
        ratios = [others / own for own, others, _ in times(measured, error).values()]
        told.append(f"{min(ratios):,.0f} to {max(ratios):,.0f} times as long for an error of {error:.0e}")
    return [
        f"In space, joints of 25, 100 and 250 nodes, few or most of them slipping, or a third open: a step of the toolkit's own "
        f"implicit method, compiled as it was in d47e2afa, takes {min(steps):.1f} to {max(steps):.0f} times less than the best solver of Siconos at 1e-10, and a cycle "
        f"of such steps {' and '.join(told)} of the slips as the path from event to event (beyond the finest steps by their "
        "first order; `space_peers`)."
    ]


def _calculix() -> list[str]:
    found = rows("calculix_contact")
    compared = [row for row in found if is_compared(row)]
    stiffest = max(row["slope"] for row in compared)
    slip, pressure, reach = (
        max(100 * row[key] for row in compared if row["slope"] == stiffest)
        for key in ("slip_apart", "pressure_apart", "range_apart")
    )
    words = {
        word: [row["relative"] for row in found if not is_compared(row) and verdict(row) == word]
        for word in ("no slip", "slips in every cycle")
    }
    cycles = max(row["cycles"] for row in found)
    return [
        f"CalculiX with contact and friction of its own, on a double lap joint with a free plate and on a shrink "
        f"fit: in cycles {cycles // 2 + 1} to {cycles} no node slips at up to "
        f"{max(words['no slip'])} of the toolkit's λ_T, and some node slips in each from "
        f"{min(words['slips in every cycle'])} on. Largest difference above it, at the highest penalty: slips "
        f"after one cycle {slip:.2g} %, pressures {pressure:.2g} %, steady slip ranges {reach:.2g} % of the "
        "largest (`calculix_contact`)."
    ]


def _over_meshes(found: list[dict], loads: Sequence[float], load: float) -> str:
    """The friction work at one load, and the pairs, mesh by mesh."""
    k = loads.index(load)
    works = _listed([f"{row['work'][k]:.3g}" for row in found])
    return f"{works} N mm with {_listed([str(row['n']) for row in found])} pairs"


def _listed(words: list[str]) -> str:
    return f"{', '.join(words[:-1])} and {words[-1]}"


def _lap_joint() -> list[str]:
    found, loads = rows("lap_joint"), lap_joint.LOADS
    coarse, fine = found[0], found[-1]
    still = max(load for load, count in zip(loads, fine["slipping"], strict=True) if count == 0)
    return [
        f"A bolted lap joint in space with {fine['n']} pairs, after the Brake–Reuß beam: model, λ_max, λ_E and {len(loads)} loads "
        f"followed over {lap_joint.CYCLES} cycles take {sum(fine['seconds']):.0f} s of one core. λ_E is "
        f"{fine['energy'] / fine['upper']:.4f} of λ_max; at {still:g} N at the tip no pair slips in the end. At 40 N the friction work "
        f"of a cycle is {_over_meshes(found, loads, 40.0)}; from {loads[-2]:g} to {loads[-1]:g} N it grows with the amplitude to "
        f"the power {exponent(fine, loads):.2g}. λ_max is lower on finer meshes, from {10 * coarse['upper']:.0f} N to {10 * fine['upper']:.0f} N: "
        "it is about the first pair at the edge of a pad (`lap_joint`)."
    ]


def _bolted_flange() -> list[str]:
    found, loads, scale = rows("bolted_flange"), bolted_flange.LOADS, bolted_flange.SHEAR
    coarse, *_, before, fine = found
    return [
        f"A sector of a bolted flange, {fine['n']} pairs on a ring around the bolt, pulled and sheared a quarter of a period "
        f"apart: model, limits and {len(loads)} loads followed over {bolted_flange.CYCLES} cycles take "
        f"{sum(fine['seconds']):.0f} s of one core. λ_max is a shear of {scale * fine['upper']:.3g} kN "
        f"({scale * before['upper']:.3g} kN with {before['n']} pairs, {scale * coarse['upper']:.3g} kN with {coarse['n']}), "
        f"λ_E {1 - fine['energy'] / fine['upper']:.0e} below it. At {loads[-1]:g} kN the friction work of a cycle is "
        f"{_over_meshes(found, loads, loads[-1])}, of which {fine['slipping'][-1]} slip; from {loads[-2]:g} kN on it grows with the "
        f"amplitude to the power {exponent(fine, loads):.2g} (`bolted_flange`)."
    ]


def _refinement() -> list[str]:
    found = refinement.refinements(rows("refinement")).values()
    meshes = [len(each.nodes) for each in found]

    def counted(name: str) -> str:
        """Of how many joints a number converges, where they have it on the finest mesh."""
        verdicts = [each.verdict[name] for each in found if isfinite(each.numbers[name][-1])]
        return f"{verdicts.count('converges')} of {len(verdicts)}"

    return [
        f"{len(found)} joints on {min(meshes)} to {max(meshes)} meshes each, in the plane and in space: friction work at one load converges "
        f"on {counted('work')}, the load factor up to which slips stay small on {counted('slip_limit')}, λ_max averaged over a length on {counted('averaged_impossible_above')}, λ_max itself on "
        f"{counted('impossible_above')}, where friction holds the edges of the contact or there are none, and in the lap joint as far as five meshes tell ([what a limit means on a mesh](mesh.md), `refinement`)."
    ]


def _space_classical() -> list[str]:
    exact = space_classical.exact_rows(rows("space_classical"))
    finest = exact[-1]
    orders = {key: space_classical.order(exact, key) for key in space_classical.QUANTITIES}
    apart = max(space_classical.spread(row, key) for row in exact for key in space_classical.QUANTITIES)
    others = [row for row in rows("space_classical") if row["poisson"] > 0]
    moved, work = (
        100
        * max(
            abs(part)
            for row in others
            for part in space_classical.neglected(rows("space_classical"), row, key)
        )
        for key in ("displacement", "dissipation")
    )
    return [
        f"A sphere on a flat, pushed to and fro with 19 amplitudes, against Cattaneo, Mindlin and Deresiewicz on discs of "
        f"{exact[0]['n']} to {finest['n']} patches: the displacement errs by {space_classical.mean(finest, 'displacement'):.0e} at last "
        f"and falls with order {orders['displacement']:.2f}, dissipation per cycle {space_classical.mean(finest, 'dissipation'):.0e}, "
        f"order {orders['dissipation']:.2f}, radius of the stick zone {space_classical.mean(finest, 'stick'):.0e}, order "
        f"{orders['stick']:.2f}, in every direction of the force to {apart:.0e} the same. With Poisson's ratio 0.3, for which the "
        f"classical solution is not exact, displacement and dissipation differ from it by {moved:.1g} and {work:.1g} % more than the mesh "
        f"does, directions by {max(space_classical.spread(others[-1], key) for key in space_classical.QUANTITIES):.0e} on {others[-1]['n']} "
        "patches (`space_classical`)."
    ]


def _damping() -> list[str]:
    found = rows("damping")
    bar, sphere, areas = (damping.of_part(found, part) for part in ("bar", "sphere", "betti"))
    (row,), (rule,), (cost,) = (damping.of_part(found, part) for part in ("row", "rule", "cost"))
    wrong = [masing / exact - 1 for masing, exact in zip(rule["masing"], rule["exact"], strict=True)]
    steps, fewest = (
        rule["steps"],
        [abs(d / e - 1) for d, e in zip(rule["steps"][0]["dissipation"], rule["exact"], strict=True)],
    )
    return [
        f"Damping over amplitude: a row of {row['n']} Jenkins elements to {max(row['errors']):.0e}, a bar on a frictional foundation "
        f"with D ∝ F^{bar[-1]['power']:.3f} and an error of {bar[-1]['errors'][1]:.0e} with {bar[-1]['n']} elements (order {damping.order(bar, 1):.1f}), "
        f"Cattaneo and Mindlin to {sphere[-1]['errors'][1]:.0e} on {sphere[-1]['patches']} patches; the loops of the loads have the area that "
        f"friction dissipates to {max(r['errors'][0] for r in areas):.0e} on {sum(r['n'] for r in areas)} random joints, in the plane and in space. Where "
        f"slip and pressure are coupled Masing's rule is {100 * min(wrong):.0f} to {100 * max(wrong):,.0f} % too high (a block, from near gross slip down to "
        f"its limit), {steps[0]['parts']} load steps are off by up to {100 * max(fewest):.1f} % in {steps[0]['seconds'] / rule['exact_seconds']:.1f} times the time of "
        f"the exact amplitude. {cost['nodes']} nodes and 20 amplitudes take {cost['curve']:.0f} s (`damping`)."
    ]


def _long_term() -> list[str]:
    found = rows("long_term")
    event = [row for row in found if row["method"] == "event"]
    right = sum(row["verdict"] == "right" for row in event)
    median = statistics.median(row["cycles"] for row in event)
    others = []
    for method in dict.fromkeys(row["method"] for row in found if row["method"] != "event"):
        chosen = [row["verdict"] for row in found if row["method"] == method]
        others.append(f"{method}: {chosen.count('false')} false, {chosen.count('undecided')} undecided")
    return [
        f"Long-term states near proved bounds: {right} of {len(event)} verdicts right in closed form, after "
        f"{median:.0f} cycles in the median; plain cycling with the same number of cases ({'; '.join(others)}) "
        "(`long_term`)."
    ]


def _stability() -> list[str]:
    found = rows("stability")
    parts = []
    for method in dict.fromkeys(row["method"] for row in found):
        verdicts = [row["verdict"] for row in found if row["method"] == method]
        good = sum(verdict in ("right", "round-off") for verdict in verdicts)
        parts.append(f"{method} {good} (silently off: {verdicts.count('off')})")
    scenes = len({row["scene"] for row in found})
    return [
        f"Of {scenes} hard scenes of time integration (limits, corners, apexes, near-threshold friction, grazing "
        f"contact, units, many cycles), followed in rational arithmetic, these paths are right to 1e-9 or to "
        f"the round-off of the data: {', '.join(parts)} (`stability`)."
    ]


def section() -> str:
    """The section between the markers of the page."""
    figures = "".join(f"- {line}\n" for line in lines())
    return f"{headline.seconds(rows)}\n{headline.errors(rows)}\n{HEADING}\n{figures}"


def current() -> str:
    """What the page says now."""
    text = PAGE.read_text()
    return text[text.index(BEGIN) + len(BEGIN) : text.index(END)]


def main() -> int:
    text = PAGE.read_text()
    head, tail = text[: text.index(BEGIN) + len(BEGIN)], text[text.index(END) :]
    with atomic_write(PAGE) as file:
        file.write((head + section() + tail).encode())
    return 0


if __name__ == "__main__":
    sys.exit(main())
