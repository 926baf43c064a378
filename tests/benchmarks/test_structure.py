"""The package gets no larger: what its subpackages may have of code lines only falls."""

import json
from pathlib import Path

from benchmarks.structure import CODE_LINES, lines_by_subpackage

ROOT = Path(__file__).parents[2]


def exceeded(lines: dict[str, int], at_most: dict[str, int]) -> list[str]:
    most = dict.fromkeys(lines, 0) | at_most
    return [f"{name}: {count} > {most[name]}" for name, count in lines.items() if count > most[name]]


def test_no_subpackage_has_more_code_than_is_allowed() -> None:
    """A landing lowers the figures (``python -m benchmarks.structure --lower``); code that moves takes its own along."""
    at_most = json.loads(CODE_LINES.read_text(encoding="utf-8"))["at_most"]
    assert exceeded(lines_by_subpackage(ROOT), at_most) == []
    assert exceeded({"bounds": at_most["bounds"] + 1, "new": 1}, at_most) == [
        f"bounds: {at_most['bounds'] + 1} > {at_most['bounds']}",
        "new: 1 > 0",
    ]
