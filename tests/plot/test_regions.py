"""Pictures of maps and design diagrams: what is drawn is what the map or the sweep says."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

import shakedown
from shakedown import plot

TWO = shakedown.example("two-node")


@pytest.fixture(scope="module")
def grid():
    return shakedown.initial_state_map(TWO, 0.7, states=400, sampler="grid")


def names(axes):
    """Texts of the legend and in the areas, in one line each."""
    return {" ".join(text.get_text().split()) for text in [*axes.get_legend().get_texts(), *axes.texts]}


def test_cells_have_the_dissipation_of_their_states(grid):
    axes = plot.basin(grid)
    resting, *_, moving = axes.collections
    cycling, rows = grid.outcome == "cyclic-slip", np.arange(len(grid)) >= len(grid.sampling.named)
    np.testing.assert_array_equal(moving.get_array().compressed(), grid.dissipation[cycling & rows])
    assert resting.get_array().count() == grid.outcomes["shakedown"]


def test_states_anywhere_are_dots():
    found = shakedown.initial_state_map(TWO, 0.7, states=200, sampler="ball", reach=3.0)
    axes = plot.basin(found)
    drawn = sum(len(collection.get_offsets()) for collection in axes.collections)
    assert drawn == 200


def test_separation_has_a_colour_of_its_own():
    """Of nodes that do not feel each other node 0 opens and closes, node 1 stays where it is put."""
    p_w = np.column_stack([[1.0, -1.0, -2.0, -1.0], np.ones(4)])
    apart = shakedown.Problem(
        A=np.eye(2), B=np.zeros((2, 2)), C=np.eye(2), f=0.5, q_w=np.zeros((4, 2)), p_w=p_w
    )
    found = shakedown.initial_state_map(apart, 1.0, states=36, sampler="grid")
    assert found.outcomes == {"separation": 36}
    axes = plot.basin(found)
    assert "separation: opens and closes, no slip in contact" in names(axes)
    assert len(axes.figure.axes) == 1  # no colour bar of dissipations
    (drawn,) = [image for image in axes.collections if image.get_array().count()]
    assert drawn.get_array().count() == 36


def colours_at(axes, places):
    """The colours of the areas at some points, as they are rendered."""
    canvas = FigureCanvasAgg(axes.figure)
    canvas.draw()
    image = np.asarray(canvas.buffer_rgba())
    points = np.rint(axes.transData.transform(places)).astype(int)
    return [tuple(image[len(image) - 1 - row, column, :3].tolist()) for column, row in points]


def test_over_one_parameter_every_region_is_drawn_and_named():
    found = shakedown.sweep(TWO, {"f": np.linspace(0.1, 0.7, 7)}, quick=True)
    axes = plot.regions(found)
    expected = {"proved from every state", "proved from this state", "never, in contact"}
    assert names(axes) >= expected | {"undecided", "λ_max, impossible above"}
    colours = colours_at(axes, [(0.35, 0.13), (0.65, 0.33), (0.695, 1.37), (0.3, 1.43)])
    assert len(set(colours)) == 4
    assert "between them interpolated, nothing is proved there" in axes.get_legend().get_title().get_text()


@pytest.mark.parametrize(
    "vary",
    [
        {"f": [0.3]},
        {"f": [-0.2, -0.1]},
        {"f": [-0.1, 0.0, 0.3]},
        {"amplitude": [0.0, 1.0]},
        {"f": [-0.1, 0.3], "mean": [-1.0, 1.0]},
        {"f": [-0.2, -0.1], "mean": [1.0, 2.0]},
        {"amplitude": [0.0, 1.0], "mean": [0.0, 1.0]},
    ],
)
def test_points_without_numbers_are_drawn_without_complaint(vary):
    found = shakedown.sweep(TWO, vary, bounds=["universal", "upper"])
    plot.regions(found, load_factor=0.0)
    plot.regions(found, load_factor=0.5).figure.savefig("/dev/null", format="png", dpi=20)
