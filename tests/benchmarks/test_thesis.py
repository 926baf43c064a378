"""The page that holds the thesis against the toolkit: current, without gaps, and with homes that exist."""

from pkgutil import resolve_name

import numpy as np
import pytest

import shakedown
from benchmarks import receding, thesis, thesis_chapters
from benchmarks.runner import RESULTS
from benchmarks.thesis_entry import relative_difference

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
    assert all(resolve_name(home) is not None for home in homes)
    assert all(one.homes for entries in sections.values() for one in entries)


def test_every_picture_exists(sections):
    pictures = {one.figure for entries in sections.values() for one in entries if one.figure}
    assert len(pictures) >= 9
    for picture in pictures:
        assert (RESULTS / f"{picture}.png").is_file(), picture


def test_reactions_of_the_second_node_follow_from_those_of_the_first():
    """(4.14)–(4.17), at every slip with both nodes closed."""
    joint, slips = shakedown.example("two-node"), np.random.default_rng(1).normal(size=(5, 2))
    q, p = slips @ joint.A.T, slips @ joint.B.T
    first, second = (np.stack([q[:, j], p[:, j]]) for j in (0, 1))
    assert thesis_chapters.reaction_map(joint) @ first == pytest.approx(second)


def test_in_the_tenth_cycle_the_initial_state_decides():
    """Like fig. 5.8: nothing slips from the safe slip, and something does from another start."""
    block = shakedown.example("cantilevered-block")
    safe, critical = shakedown.upper_bound(block).slip, shakedown.lower_bound(block).slip
    assert thesis_chapters.tenth_cycle(block, safe).max() == 0
    assert thesis_chapters.tenth_cycle(block, critical).max() > 1e-4 * np.abs(safe).max()


def test_zones_of_chapter_3_are_those_that_it_describes():
    row = receding.zones(6)
    assert max(row["slip_left"], row["gap_left"]) <= 1e-12  # fig. 3.3
    assert row["contact_grows"] == row["first_loading_changes"] == row["ninth_inner_slipping_early"] == 0
    assert row["sticks_at_once"] > 0.7 * row["in_contact_at_p_max"]
    assert row["unloading_zones"] == row["ninth_zones"] == "s+s-o"
    assert row["ninth_inner"] >= 5  # fig. 3.5
    assert row["ninth_inner_slipping_again"] <= 1
    assert row["steady_slipping"] < 0.7 * row["first_slipping"]  # fig. 3.7
    assert row["steady_at_limit"] >= 5
