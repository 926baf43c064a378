"""Numbers rounded to the safe side, texts as wide as a terminal, notes that are sentences."""

import re
from pathlib import Path

import numpy as np
import pytest

from shakedown.ground.shown_values import down, up
from shakedown.report import facts
from shakedown.report.facts import Fact, Section, Sheet, Table, limits_as_text, margin, sheet_as_text


def is_safe(text, value, rounding):
    """Whether a number as it is shown lies on the side of the exact one that keeps the statement true."""
    return float(text) <= value if rounding == "down" else float(text) >= value


@pytest.mark.parametrize("value", [1.3276878539, 0.65, 1.9, 1e-7, 123456.7891])
def test_a_rounded_limit_is_never_on_the_wrong_side(value):
    assert float(down(value)) <= value <= float(up(value))
    assert float(up(value)) - float(down(value)) <= 1.0001e-6 * value
    for digits in (2, 4, 7, 12):
        low, high = limits_as_text([(value, "down"), (value, "up")], digits)
        assert float(low) <= value <= float(high)


@pytest.mark.parametrize(
    ("value", "rounding"), [(1.00004, "down"), (0.99996, "up"), (1.0, "down"), (1e-9, "up")]
)
def test_a_rounded_load_factor_stays_on_its_side_of_one(value, rounding):
    (text,) = limits_as_text([(value, rounding)])
    assert np.sign(float(text) - 1) == np.sign(value - 1)
    assert is_safe(text, value, rounding)


def test_limits_that_differ_look_different():
    rng = np.random.default_rng(0)
    for _ in range(100):
        first = rng.uniform(0.1, 20.0)
        limits = [(first, "down"), (first * (1 + 10 ** rng.uniform(-5.5, -1)), "down"), (2 * first, "up")]
        texts = limits_as_text(limits)
        assert len(set(texts)) == 3
        assert all(is_safe(text, *limit) for text, limit in zip(texts, limits, strict=True))


def test_a_margin_is_rounded_to_the_safe_side():
    for value in np.random.default_rng(1).uniform(0.0, 12.0, 200):
        for rounding in ("down", "up"):
            shown = float(margin(value, rounding).removesuffix(" %").replace("−", "-"))
            exact, slack = 100 * (value - 1), 1e-9
            assert is_safe(shown, exact + (slack if rounding == "down" else -slack), rounding)
            assert shown == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize("width", [40, 60, 80, 120])
def test_no_line_is_wider_than_the_terminal_and_no_cell_is_lost(width):
    rows = [
        [f"name {k}", *(f"{k}{j}.125" for j in range(9)), "some words that say what it is"] for k in range(5)
    ]
    head = ["row", *(f"column {j}" for j in range(9)), "remark"]
    told = [Fact("a label", 1.23456, "mm", note="a note of several words " * 5), Fact("b", "word " * 30)]
    sections = [Section("Title", (), [Table(head, rows, (0, 10))])]
    text = sheet_as_text(Sheet(["headline"], ["The answer."], None, told, sections), width)
    assert max(map(len, text.splitlines())) <= width
    for cell in (cell for row in rows for cell in row[1:10]):
        assert cell in text
    assert text.count("some") == 5


def test_a_long_table_shows_its_first_and_last_rows_and_leaves_out_no_single_one():
    rows = [[f"row{k}"] for k in range(49)]
    assert facts.table_as_text(Table(["x"], rows)).count("row") == 49
    cut = facts.table_as_text(Table(["x"], [*rows, ["row49"]]))
    assert "row0\n" in cut
    assert "row49" in cut
    assert "10 more rows" in cut


def test_characters_that_a_terminal_obeys_are_shown():
    text = sheet_as_text(Sheet(["a\x1b[2J"], ["b\u202e"], None, [Fact("c", "d\x07", note="e\x1b")]))
    assert not re.search("[\x00-\x09\x0b-\x1f\u202e]", text)


def test_every_note_is_a_sentence_that_some_sheet_has():
    sources = "".join(path.read_text() for path in Path(facts.__file__).parent.glob("*.py"))
    assert set(re.findall(r"(?<![\w./])notes\.(\w+)", sources)) == set(vars(facts.notes))
    assert all(text[-1] in ".?)" and len(text.split()) <= 60 for text in vars(facts.notes).values())
