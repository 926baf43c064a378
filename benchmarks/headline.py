"""The two tables at the head of the page of results: how long what takes, and how far it is off."""

from collections.abc import Callable
from typing import Any

from benchmarks.calculix_contact import is_compared

Rows = Callable[[str], list[dict[str, Any]]]


def table(head: list[str], lines: list[list[str]], other: str = "--:") -> str:
    """A table in Markdown, with the alignment of all columns but the first."""
    written = [head, ["---", *[other] * (len(head) - 1)], *lines]
    return "".join(f"| {' | '.join(line)} |\n" for line in written)


def seconds(rows: Rows) -> str:
    """By joint: each of the bounds alone, and the whole command, with its report."""
    columns = {"λ_max": "λ_max", "λ_E": "λ_E", "λ_U": "λ_U", "verify": "`verify`, report"}
    found: dict[tuple[str, int], dict[str, float]] = {}
    for row in rows("verify_times"):
        if row["what"] in columns:
            found.setdefault((row["joint"], row["pairs"]), {})[row["what"]] = row["clock"]
    lines = [
        [name.split(",")[0], str(pairs), *(_time(times.get(what)) for what in columns)]
        for (name, pairs), times in sorted(found.items(), key=lambda item: item[0][1])
    ]
    return table(["joint in space", "contact pairs", *(f"{words} [s]" for words in columns.values())], lines)


def _time(value: float | None) -> str:
    return "–" if value is None else f"{value:.2g}" if value < 100 else f"{value:.0f}"


def errors(rows: Rows) -> str:
    """By quantity: what it was held against, and the largest difference."""
    floating, hard, paths = rows("floating_joints"), rows("hard_cases"), rows("stability")
    optimum = max(
        row[key] for row in floating for key in ("upper_off_truth", "lower_off_truth") if row[key] is not None
    )
    own = hard[0]["method"]
    bounds = [row["verdict"] for row in hard if row["method"] == own and row["reference"] == "rational"]
    events = [row["verdict"] for row in paths if row["method"] == "event"]
    contact = [row for row in rows("calculix_contact") if is_compared(row)]
    stiffest = max(row["slope"] for row in contact)
    slips = max(row["slip_apart"] for row in contact if row["slope"] == stiffest)
    settled = [row["verdict"] for row in rows("long_term") if row["method"] == "event"]
    followed = sum(word in ("right", "round-off") for word in events)
    right = {
        "limits": f"{bounds.count('right')} of {len(bounds)} right to 1e-9",
        "paths": f"{followed} of {len(events)} right to 1e-9 or to round-off of the data",
        "states": f"{settled.count('right')} of {len(settled)} right",
    }
    lines = [
        ["limits of floating joints", "optimum in fractions", f"{optimum:.0e}", "`floating_joints`"],
        ["limits of hard cases", "enumeration in fractions", right["limits"], "`hard_cases`"],
        ["path from event to event", "path in fractions", right["paths"], "`stability`"],
        ["long-term states near limits", "closed form", right["states"], "`long_term`"],
        ["slips after a cycle", "CalculiX's own contact", f"{100 * slips:.2g} %", "`calculix_contact`"],
        ["proved total slip", "simulations that attack it", _attacked(rows), "`accumulated_adversary`"],
    ]
    return table(["quantity", "held against", "largest difference", "study"], lines, other="---")


def _attacked(rows: Rows) -> str:
    """All runs that were to break a proof of total slip, and those which did."""
    found = rows("accumulated_adversary")
    return f"{sum(row['farther'] for row in found)} of {sum(row['runs'] for row in found):,} fail"
