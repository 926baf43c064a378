"""Design diagrams: areas where the sweep has its regions, over one and two parameters."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

import shakedown
from shakedown import plot

TWO = shakedown.example("two-node")


def names(axes):
    """Texts of the legend and in the areas, in one line each."""
    legend = [text.get_text() for text in axes.get_legend().get_texts()]
    return {" ".join(text.split()) for text in legend + [text.get_text() for text in axes.texts]}


def colours_at(axes, places):
    """The colours of the areas at some points, as they are rendered."""
    canvas = FigureCanvasAgg(axes.figure)
    canvas.draw()
    image = np.asarray(canvas.buffer_rgba())
    found = []
    for column, row in axes.transData.transform(places):
        shade = image[image.shape[0] - 1 - round(row), round(column)]
        found.append(tuple(int(part) for part in shade[:3]))
    return found


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
