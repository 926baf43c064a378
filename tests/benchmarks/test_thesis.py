"""The page that holds the thesis against the toolkit: current, without gaps, and with homes that exist."""

import importlib

import pytest

from benchmarks import thesis
from benchmarks.runner import RESULTS
from benchmarks.thesis_entry import entry, markdown, relative_difference, same_digits

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def sections():
    return thesis.sections()


def test_the_page_is_what_the_command_writes(sections, monkeypatch):
    monkeypatch.setattr(thesis, "sections", lambda: sections)
    assert thesis.PAGE.read_text(encoding="utf-8") == thesis.page()


def test_what_is_printed_is_computed(sections):
    """No empty cell but where the thesis prints nothing; a number that cannot be compared says why."""
    printed = [one for entries in sections.values() for one in entries if one.printed]
    assert len(printed) >= 25
    for one in printed:
        assert len(one.computed) == len(one.printed), one
        if not one.note:
            assert relative_difference(one) <= 0.05, one


def test_every_home_exists(sections):
    homes = {home for entries in sections.values() for one in entries for home in one.homes}
    for home in homes:
        assert find(home) is not None
    assert all(one.homes for entries in sections.values() for one in entries)


def find(home):
    """What a dotted name means: the longest part that is a module, then its attributes."""
    parts = home.split(".")
    for k in range(len(parts), 0, -1):
        try:
            found = importlib.import_module(".".join(parts[:k]))
        except ModuleNotFoundError:
            continue
        for part in parts[k:]:
            found = getattr(found, part)
        return found
    return None


def test_every_picture_exists(sections):
    pictures = {one.figure for entries in sections.values() for one in entries if one.figure}
    assert len(pictures) >= 10
    for picture in pictures:
        assert (RESULTS / f"{picture}.png").is_file(), picture


def test_differences_are_those_of_the_number_that_differs_most():
    one = entry("(1)", "two numbers", "shakedown.motion.evolution.evolve", "0.50 -20", [0.51, -20.1])
    assert relative_difference(one) == pytest.approx(0.02)
    assert not same_digits(one)
    assert same_digits(
        entry("(2)", "rounds", "shakedown.motion.evolution.evolve", "0.50 -20", [0.504, -20.4])
    )
    assert relative_difference(entry("(3)", "zero", "shakedown.motion.evolution.evolve", "0", [0.25])) == 0.25
    assert markdown([one]).splitlines()[-1] == (
        "| (1) | two numbers | `shakedown.motion.evolution.evolve` | 0.50, -20 | 0.51, -20.1 | 2.0e-02 |"
    )
