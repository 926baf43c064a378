"""Pictures carry units, tell flanks apart and show the numbers of the results they are drawn from."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown import UsageError, plot
from shakedown.model.units import units_of
from shakedown.plot.style import flanks

BLOCK = shakedown.example("block-9")
TWO = shakedown.example("two-node")


@pytest.fixture(scope="module")
def cyclic():
    return shakedown.long_term_state(TWO, 0.9)


def area(x, y):
    return 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))


def test_the_area_of_the_hysteresis_loop_is_the_dissipation(cyclic):
    axes = plot.hysteresis(cyclic, nodes=[1])
    (line,) = axes.lines
    assert area(*line.get_data()) == pytest.approx(cyclic.dissipation_per_cycle, rel=1e-9)
    assert axes.get_legend().get_texts()[0].get_text() == f"node 1: {cyclic.dissipation_per_cycle:.4g}"


@pytest.mark.parametrize(
    ("units", "expected"),
    [
        ("N, mm", ("N", "mm")),
        ("mm, kN", ("kN", "mm")),
        ("h, p_max", ("", "")),
        ("", ("", "")),
        ("SI", ("", "")),
    ],
)
def test_units_are_shown_where_they_are_known(units, expected):
    assert units_of(replace(TWO, units=units)) == expected


def test_axes_carry_units(cyclic):
    joint = replace(TWO, units="N, mm")
    assert plot.hysteresis(cyclic, joint).get_xlabel() == "slip v [mm]"
    assert plot.load_loop(joint).get_ylabel() == "welded reaction p_w [N]"
    assert plot.slip_space(joint, 0.7).get_ylabel() == "slip of node 1 [mm]"
    assert plot.pressure(cyclic, joint, node_area=[2.0, 2.0]).get_ylabel() == "pressure [N/mm²]"


def test_no_line_joins_two_flanks():
    x = np.array([0.0, 1.0, 2.0, 9.0, 10.0, 11.0])
    assert [part.tolist() for part in flanks(x)] == [[0, 1, 2], [3, 4, 5]]
    assert [part.tolist() for part in flanks(x[::-1])] == [[5, 4, 3], [2, 1, 0]]
    apart = replace(BLOCK, x=np.concatenate([np.arange(5.0), 30 + np.arange(4.0)]))
    axes = plot.slip_along({"safe": shakedown.upper_bound(apart).slip}, apart)
    assert [len(line.get_xdata()) for line in axes.lines] == [5, 4]


def test_pressure_shows_the_recorded_reactions():
    state = shakedown.long_term_state(BLOCK, 1.0)
    time = float(state.history.cycle[3])
    (line,) = plot.pressure(state, BLOCK, cycles=[time]).lines
    row = int(np.abs(state.history.cycle - time).argmin())
    assert np.array_equal(line.get_ydata(), state.history.p[row])


def test_zones_show_each_state_where_it_was():
    state = shakedown.long_term_state(BLOCK, 5.0)
    axes = plot.zones(state, BLOCK)
    shown = {text.get_text() for text in axes.get_legend().get_texts()}
    assert {"stick", "forward slip", "backward slip", "open"} <= shown
    image = axes.collections[0].get_array()
    assert image.shape[1] == BLOCK.n
    assert (image == 3).any() == (state.history.state == 2).any()


def test_what_is_not_recorded_cannot_be_drawn():
    run = shakedown.simulate(TWO, 0.7, cycles=5)
    for draw in (plot.hysteresis, plot.zones):
        with pytest.raises(UsageError, match="expected recorded events"):
            draw(run if run.history is None else None)
    with pytest.raises(UsageError, match="from 0 to 1, found 2"):
        plot.load_loop(TWO, 2)
    with pytest.raises(UsageError, match="λ_1: expected 2 load factors, found 1"):
        plot.interaction([0.1, 0.2], {"λ_1": [1.0]})
