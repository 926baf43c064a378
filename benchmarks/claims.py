"""The tables of the page of results, and the caption of the README, from the stored results.

Written by ``python -m benchmarks.claims``.
"""

import json
import statistics
import sys
import textwrap
from math import ceil, floor, isfinite
from pathlib import Path
from typing import Any

from benchmarks import bolted_flange, damping, refinement, space_classical
from benchmarks.calculix_contact import is_compared, verdict
from benchmarks.runner import RESULTS
from benchmarks.space_peers import times
from shakedown.files.atomic_write import atomic_write
from shakedown.ground.constants import SIX_DIGITS

PAGE = Path(__file__).parents[1] / "docs" / "results.md"
README = PAGE.parents[1] / "README.md"

Figures = list[tuple[str, str]]  # what was measured, and the figure


def rows(study: str) -> list[dict[str, Any]]:
    """The stored rows of a study."""
    return json.loads((RESULTS / f"{study}.json").read_text())["rows"]


def markdown(head: list[str], lines: list[list[str]], other: str) -> str:
    """A table, with an alignment of all columns but the first."""
    written = [head, ["---", *[other] * (len(head) - 1)], *lines]
    return "".join(f"| {' | '.join(line)} |\n" for line in written)


def seconds() -> str:
    """By joint: each of the bounds alone, and the whole command, with its report."""
    columns = {"λ_max": "λ_max", "λ_E": "λ_E", "λ_U": "λ_U", "verify": "`verify`, report"}
    found: dict[tuple[str, int], dict[str, float]] = {}
    for row in rows("verify_times"):
        if row["what"] in columns:
            found.setdefault((row["joint"], row["pairs"]), {})[row["what"]] = row["clock"]
    lines = [
        [name.split(",")[0], str(pairs), *(_time(clocks.get(what)) for what in columns)]
        for (name, pairs), clocks in sorted(found.items(), key=lambda item: item[0][1])
    ]
    head = ["3-D joint", "contact pairs", *(f"{words} [s]" for words in columns.values())]
    return markdown(head, lines, "--:")


def _time(value: float | None) -> str:
    return "–" if value is None else f"{value:.2g}" if value < 100 else f"{value:.0f}"


def _range(values: list[float], digits: str = ".2g") -> str:
    return f"{min(values):{digits}} to {max(values):{digits}}"


def _variant(method: str) -> str:
    """A method, with what follows its comma in brackets: others are listed beside it."""
    name, comma, variant = method.partition(", ")
    return f"{name} ({variant})" if comma else name


def _hard_cases() -> Figures:
    verdicts: dict[str, list[str]] = {}
    for row in rows("hard_cases"):
        if row["reference"] == "rational":
            verdicts.setdefault(row["method"], []).append(row["verdict"])
    own, *peers = ((method, found.count("right")) for method, found in verdicts.items())
    others = "; ".join(f"{_variant(method)} {count}" for method, count in peers)
    total = len(verdicts[own[0]])
    return [
        (f"limits of {total} ill-conditioned cases, correct to 1e-9", f"{own[1]}"),
        ("the same by other means", others),
    ]


def _stability() -> Figures:
    verdicts: dict[str, list[str]] = {}
    for row in rows("stability"):
        verdicts.setdefault(row["method"], []).append(row["verdict"])
    right = {
        method: f"{sum(word in ('right', 'round-off') for word in found)} ({found.count('off')})"
        for method, found in verdicts.items()
    }
    event, scenes = right.pop("event"), len(verdicts["event"])
    names = {"GS": "Gauss–Seidel to", "nsgs": "Siconos NSGS", "lemke": "Siconos Lemke"}
    others = "; ".join(
        f"{' '.join(names.get(word, word) for word in method.split())}: {figure}"
        for method, figure in right.items()
    )
    return [
        (
            f"paths of {scenes} ill-conditioned cases, correct to 1e-9 or round-off (wrong without notice)",
            event,
        ),
        ("the same in fixed steps", others),
    ]


def _long_term() -> Figures:
    found = rows("long_term")
    event = [row for row in found if row["method"] == "event"]
    right, median = (
        sum(row["verdict"] == "right" for row in event),
        statistics.median(row["cycles"] for row in event),
    )
    others = []
    for method in dict.fromkeys(row["method"] for row in found if row["method"] != "event"):
        words = [row["verdict"] for row in found if row["method"] == method]
        others.append(f"{method}: {words.count('false')} wrong, {words.count('undecided')} undecided")
    return [
        (f"long-term states near limits, after {median:.0f} cycles (median)",
         f"{right} of {len(event)} correct"),
        ("the same by plain cycling", "; ".join(others)),
    ]  # fmt: skip


def _calculix() -> Figures:
    found = rows("calculix_contact")
    compared = [row for row in found if is_compared(row)]
    stiffest = max(row["slope"] for row in compared)
    apart = {
        key: max(100 * row[key] for row in compared if row["slope"] == stiffest)
        for key in ("slip_apart", "pressure_apart", "range_apart")
    }
    bracket = {
        word: [row["relative"] for row in found if not is_compared(row) and verdict(row) == word]
        for word in ("no slip", "slips in every cycle")
    }
    return [
        ("slip after a cycle, difference from CalculiX's contact", f"{apart['slip_apart']:.2g} %"),
        ("pressure; steady slip range", f"{apart['pressure_apart']:.2g} %; {apart['range_apart']:.2g} %"),
        ("load relative to λ_T at which CalculiX finds no slip, slip in every cycle",
         f"{max(bracket['no slip'])}, {min(bracket['slips in every cycle'])}"),
    ]  # fmt: skip


def _creep() -> Figures:
    found = rows("creep")
    attacks, stepped = ([row for row in found if (row["kind"] == "steps") == one] for one in (False, True))
    sums = {key: sum(row[key] for row in attacks) for key in attacks[0] if key not in ("kind", "seed")}
    closed, few = sums["runs"] - sums["opened"], SIX_DIGITS
    seen = sum(row["below"] <= few < row["above"] for row in stepped)
    return [
        ("simulations (all nodes closed) below the load proved free of creep that drift all the same (control: at "
         "1.3 times that load)",
         f"{sums['drifting']} of {closed:,} ({sums['controls_drifting']:,} of {sums['controls']:,})"),
        ("fixed load steps find no drift 1 % below [λ_c](creep.md) and drift 1 % above", f"{seen} of {len(stepped)}"),
    ]  # fmt: skip


def _damping() -> Figures:
    found = rows("damping")
    bar = damping.of_part(found, "bar")[-1]
    (row,), (rule,) = (damping.of_part(found, part) for part in ("row", "rule"))
    wrong = [100 * (masing / exact - 1) for masing, exact in zip(rule["masing"], rule["exact"], strict=True)]
    return [
        (f"dissipation of a row of {row['n']} Jenkins elements, error", f"{max(row['errors']):.0e}"),
        (f"of a bar on a frictional foundation, {bar['n']} elements", f"{bar['errors'][1]:.0e}"),
        ("overestimate by Masing's rule where slip changes pressure", f"{_range(wrong, ',.0f')} %"),
    ]  # fmt: skip


def _space_classical() -> Figures:
    exact = rows("space_classical")
    errors = (
        f"{space_classical.mean(exact[-1], key):.0e} ({space_classical.order(exact, key):.2f})"
        for key in ("displacement", "dissipation", "stick")
    )
    what = "error (order) of displacement, dissipation, radius of the stick zone"
    return [(f"sphere on a flat (Cattaneo, Mindlin), {exact[-1]['n']} patches: {what}", ", ".join(errors))]


def _refinement() -> Figures:
    found = refinement.refinements(rows("refinement")).values()
    figures = []
    for name in ("work", "slip_limit", "averaged_impossible_above", "impossible_above"):
        verdicts = [each.verdict[name] for each in found if isfinite(each.numbers[name][-1])]
        kinds = {word: verdicts.count(word) for word in sorted(set(verdicts)) if word != "converges"}
        others = ", ".join(f"{number} {word.replace('falls', 'fall')}" for word, number in kinds.items())
        figures.append(f"{verdicts.count('converges')} of {len(verdicts)}{f' ({others})' if others else ''}")
    what = "converge with the mesh: friction work, λ_X, λ_max averaged over a length, λ_max"
    return [(f"joints in which these {what}", "; ".join(figures))]


def _bolted_flange() -> Figures:
    found, loads = rows("bolted_flange"), bolted_flange.LOADS
    works = ", ".join(f"{row['work'][-1]:.3g}" for row in found)
    pairs = ", ".join(str(row["n"]) for row in found)
    return [(f"friction work of a flange at {loads[-1]:g} kN with {pairs} pairs", f"{works} N mm")]


def _bounds() -> Figures:
    found = {
        (row["bound"], row["method"]): row
        for row in rows("bounds")
        if row["n"] == 250 and row["bound"] in ("lower", "upper")
    }
    lower, upper = (found[bound, "shakedown"]["seconds"] for bound in ("lower", "upper"))
    node, whole = found["lower", "highspy"]["relative"], found["upper", "highspy"]["relative"]
    return [
        (
            "λ_1 of 250 nodes; by one HiGHS program per node (extrapolated)",
            f"{lower:.2g} s; HiGHS takes {node:,.0f} times as long",
        ),
        (
            "λ_max of 250 nodes; by HiGHS called directly",
            f"{upper:.2g} s; HiGHS takes {whole:.2f} times as long",
        ),
    ]


def _large_joints() -> Figures:
    found = rows("large_joints")
    largest = max(row["n"] for row in found)
    names = ("λ_max", "λ_1", "λ_E")
    seconds = (_range([row[name]["seconds"] for row in found if row["n"] == largest]) for name in names)
    return [(f"{', '.join(names)} of {largest} nodes (random, chain, block)", f"{', '.join(seconds)} s")]


def _enumeration() -> Figures:
    largest = max(row["n"] for row in rows("enumeration"))
    found = {row["method"]: row for row in rows("enumeration") if row["n"] == largest}
    tree, batches = found["tree, one core"], found["numpy batches"]
    ratio = batches["nanoseconds"] / tree["nanoseconds"]
    what = f"each of the {tree['total']:,} critical load factors of {largest} nodes"
    return [
        (
            f"{what}; by `numpy.linalg.solve` in batches",
            f"{tree['nanoseconds']:.0f} ns; NumPy takes {ratio:.0f} times as long",
        )
    ]


def _evolution() -> Figures:
    found = [row for row in rows("evolution") if row["parts"] == 1 and row["tolerance"] in (1e-13, 1e-12)]
    methods = {"gauss-seidel": "Gauss–Seidel", "nsgs": "Siconos NSGS", "lemke": "Siconos Lemke"}
    relative = {name: [row["relative"] for row in found if row["method"] == name] for name in methods}
    timed = {methods[name]: _range(ratios, ".1f") for name, ratios in relative.items() if ratios}
    what = "a cycle in the given load steps, relative to the time of the exact path"
    return [(f"{what}: {', '.join(timed)}", ", ".join(timed.values()))]


def _space_peers() -> Figures:
    measured = rows("space_peers")
    errors = (1e-4, 1e-6)
    ratios = ([others / own for own, others, _ in times(measured, error).values()] for error in errors)
    cycle = f"a cycle of implicit 3-D steps to an error of {', '.join(f'{error:.0e}' for error in errors)}"
    return [
        (f"{cycle}, relative to the path from event to event (steps run at commit d47e2afa)",
         ", ".join(_range(each, ",.0f") for each in ratios)),
    ]  # fmt: skip


def _classical() -> Figures:
    found = [row for row in rows("classical_contacts") if row["contact"] == "P and Q vary"]
    apart = max(row["apart"] for row in found)
    return [("cylinder on a flat, P and Q out of phase: half-width of the permanent stick zone, difference from "
             "half-planes (Barber, Davies and Hills 2011; Andresen and Hills 2019)", f"{apart:.2g} elements at most")]  # fmt: skip


ACCURACY = {
    "hard_cases": _hard_cases,
    "stability": _stability,
    "long_term": _long_term,
    "calculix_contact": _calculix,
    "creep": _creep,
    "damping": _damping,
    "classical_contacts": _classical,
    "space_classical": _space_classical,
    "refinement": _refinement,
    "bolted_flange": _bolted_flange,
}
SPEED = {
    "bounds": _bounds,
    "large_joints": _large_joints,
    "enumeration": _enumeration,
    "evolution": _evolution,
    "space_peers": _space_peers,
}


ROLLED_SPHERE = """\
Wetter and Popov's formula for a rolled sphere is met to 1e-3 on 307 to 491 square surface elements (version 0.2.0).
"""


def section() -> str:
    """The section between the markers of the page."""
    text = f"## Computation time\n\n{seconds()}\n–: not run.\n"
    for heading, studies in {"Accuracy": ACCURACY, "Compared with other methods": SPEED}.items():
        lines = [
            [what, figure, f"`{study}`"] for study, of_study in studies.items() for what, figure in of_study()
        ]
        text += f"\n## {heading}\n\n{markdown(['what', 'figure', 'study'], lines, '---')}"
        text += f"\n{ROLLED_SPHERE}" * (heading == "Accuracy")
    return f"{text}\n"


def caption() -> str:
    """What the README says below its picture: limits and slips of the finest flange, the one that is drawn."""
    row, loads = rows("bolted_flange")[-1], bolted_flange.LOADS
    shear, (first, last) = bolted_flange.SHEAR, row["shown"]
    proved, impossible = (
        floor(1e3 * shear * row["universal"]),
        ceil(1e3 * shear * row["upper"]),
    )  # to the safe side
    slipping = [row["slipping"][loads.index(shear * factor)] for factor in (first, last)]
    text = (
        f"A flange of {row['n']} contact pairs under a cyclic shear: up to an amplitude of {proved / 1e3} kN slip is proved to "
        f"cease on this mesh, however the flange was assembled; above {impossible / 1e3} kN it never does while all pairs stay in contact. "
        f"At {shear * first:g} kN, {slipping[0]} pairs slip in every cycle. At {shear * last:g} kN, {slipping[1]} do, and friction "
        f"dissipates {row['work'][-1]:.1f} N mm per cycle."
    )
    return textwrap.fill(text, 118) + "\n"


WRITTEN = {  # the word of a section's markers: its page, and what writes it
    "figures": (PAGE, section),
    "flange": (README, caption),
}


def split(word: str) -> tuple[str, str, str]:
    """A page before, within and behind the markers of a section."""
    head, mark, rest = (
        WRITTEN[word][0].read_text().partition(f"<!-- {word}: python -m benchmarks.claims -->\n")
    )
    now, end, tail = rest.partition(f"<!-- end of {word} -->")
    return head + mark, now, end + tail


def main() -> int:
    for word, (page, write) in WRITTEN.items():
        head, _, tail = split(word)
        with atomic_write(page) as file:
            file.write((head + write() + tail).encode())
    return 0


if __name__ == "__main__":
    sys.exit(main())
