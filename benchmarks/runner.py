"""One study from its cases to its stored rows, tables and figures."""

import importlib
import json
import os
import platform
import sys
import time
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from shakedown.files.atomic_write import atomic_write

RESULTS = Path(__file__).parent / "results"
PACKAGES = ["numpy", "scipy", "highspy", "clarabel", "cvxpy", "numba", "scikit-fem", "python-flint"]


def run_study(name: str, *, short: bool, fresh: bool) -> None:
    """Measure what is not stored yet, then write results, tables and figures."""
    study = importlib.import_module(f"benchmarks.{name}")
    form = "short" if short else "full"
    partial = RESULTS / f".{name}.{form}.jsonl"
    RESULTS.mkdir(exist_ok=True)
    if fresh:
        partial.unlink(missing_ok=True)
    cases = list(study.cases(short))
    rows = _measured(study, cases, partial)
    document = {"study": name, "title": study.TITLE, "form": form, "machine": machine(), "rows": rows}
    target = RESULTS / (f"{name}.short.json" if short else f"{name}.json")
    with atomic_write(target) as file:
        file.write((json.dumps(document, indent=1, allow_nan=False) + "\n").encode())
    print(f"\n{study.TITLE}\n\n{study.tables(rows)}\n\n({document['machine']['processor']}) -> {target}")
    drawn = study.figures(rows) if hasattr(study, "figures") else {}  # where a page shows one
    for label, figure in drawn.items():
        suffix = ".short.png" if short else ".png"
        with atomic_write(RESULTS / f"{label}{suffix}") as file:
            figure.savefig(file, format="png", dpi=110)
    partial.unlink(missing_ok=True)


def _measured(study, cases: list[dict], partial: Path) -> list[dict]:
    """The rows of all cases, taken from the partial file where they are there already."""
    stored = {}
    if partial.exists():
        for line in partial.read_text().splitlines():
            record = json.loads(line)
            stored[json.dumps(record["case"], sort_keys=True)] = record["row"]
    rows = []
    for number, case in enumerate(cases, 1):
        key = json.dumps(case, sort_keys=True)
        if key not in stored:
            _say(f"{study.__name__.rpartition('.')[2]} {number}/{len(cases)} {case}")
            stored[key] = case | study.measure(case)
            with partial.open("a") as file:
                file.write(json.dumps({"case": case, "row": stored[key]}, allow_nan=False) + "\n")
        rows.append(stored[key])
    return rows


def _say(text: str) -> None:
    if sys.stderr.isatty():
        print(f"\r\033[K{text[:100]}", end="", file=sys.stderr, flush=True)


def machine() -> dict[str, str]:
    """What the figures were measured on."""
    versions = {}
    for package in PACKAGES:
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            continue
    return {
        "processor": _processor(),
        "cores": str(os.cpu_count()),
        "load_average": _load_average(),
        "system": platform.system(),
        "python": platform.python_version(),
        "date": time.strftime("%Y-%m-%d"),
        **versions,
    }


def _load_average() -> str:
    """Processes that wanted a core in the last quarter of an hour, where the system says so."""
    try:
        return f"{os.getloadavg()[2]:.1f}"
    except (AttributeError, OSError):
        return "unknown"


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:  # not Linux
        pass
    return platform.processor() or platform.machine()
