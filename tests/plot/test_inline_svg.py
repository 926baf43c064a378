"""Pictures inside a page: nothing is cut off, legends hide nothing, panels that are compared look alike."""

import re
from functools import partial

import pytest

from shakedown.plot.inline_svg import Drawing, picture


def shown(svg):
    """Left, top, width and height of what is to be seen."""
    return [float(number) for number in re.search(r'viewBox="([^"]+)"', svg)[1].split()]


def place_of(text, svg):
    """Where a text is anchored."""
    x, y = re.search(rf'x="([\d.-]+)" y="([\d.-]+)"[^>]*>{re.escape(text)}</text>', svg).groups()
    return float(x), float(y)


def line(scale, *, ax):
    ax.plot([0.0, 1.0], [-scale, scale], label="slip")
    ax.ticklabel_format(axis="y", style="plain")
    ax.set(ylabel="sum of welded reactions [N]", xlabel="time")
    ax.legend()


@pytest.mark.parametrize("scale", [1.0, 2e4, 2e7])
def test_labels_beside_long_numbers_are_not_cut_off(scale):
    (panel,) = picture("", Drawing(partial(line, scale))).panels
    left, top, width, tall = shown(panel[1])
    x, y = place_of("sum of welded reactions [N]", panel[1])
    assert x - 7.0 > left  # the letters of the turned label stand left of where it is anchored
    assert top < y < top + tall
    assert left + width == pytest.approx(72 * 4.6, abs=1.0)


def test_a_legend_stands_below_the_axes():
    (panel,) = picture("", Drawing(partial(line, 1.0))).panels
    _, top, _, tall = shown(panel[1])
    (_, y), (_, label) = place_of("slip", panel[1]), place_of("time", panel[1])
    assert label < y < top + tall


def test_panels_that_are_alike_have_the_same_ticks_and_one_legend():
    drawings = [Drawing(partial(line, scale)) for scale in (1.0, 3.0)]
    ticks = []
    for alike in (0, 2):
        made = picture("", *drawings, alike=alike, one_legend=alike == 2)
        ticks.append([re.findall(r">(−?[\d.]+)</text>", panel[1]) for panel in made.panels])
        assert all((">slip</text>" in panel[1]) == (alike == 0) for panel in made.panels)
        assert (made.legend is None) == (alike == 0)
    assert ticks[0][0] != ticks[0][1]
    assert ticks[1][0] == ticks[1][1]
