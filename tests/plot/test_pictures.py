"""Pictures carry units, tell flanks apart and show the numbers of the results they are drawn from."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown import UsageError, plot

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


def test_zones_show_each_state_where_it_was():
    state = shakedown.long_term_state(BLOCK, 5.0)
    axes = plot.zones(state, BLOCK)
    shown = {text.get_text() for text in axes.get_legend().get_texts()}
    assert {"stick", "forward slip", "backward slip", "open"} <= shown
    image = axes.collections[0].get_array()
    assert image.shape[1] == BLOCK.n
    assert (image == 3).any() == (state.history.state == 2).any()


def test_zones_of_two_flanks_leave_the_gap_between_them_free():
    apart = replace(BLOCK, x=np.concatenate([np.arange(5.0), 30 + np.arange(4.0)]))
    axes = plot.zones(shakedown.long_term_state(apart, 5.0), apart)
    assert [mesh.get_array().shape[1] for mesh in axes.collections] == [5, 4]
    (gap,) = axes.patches
    assert (gap.get_x(), gap.get_x() + gap.get_width()) == (4.5, 29.5)


def test_tractions_are_drawn_where_the_areas_of_nodes_are_known():
    known = replace(BLOCK, node_area=np.full(9, 2.0), label=[f"{4000 + k}" for k in range(9)])
    state = shakedown.long_term_state(known, 5.0)
    bare, areal = plot.pressure(state, BLOCK), plot.pressure(state, known)
    assert areal.get_ylabel() == "pressure [MPa]"
    assert np.allclose(2 * areal.lines[0].get_ydata(), bare.lines[0].get_ydata())
    assert plot.dissipation_along(state, known).get_ylabel() == "friction work per area [N/mm]"
    assert "(FE 400" in plot.hysteresis(state, known).get_legend().get_texts()[0].get_text()


def test_reactions_on_two_faces_are_summed_along_the_axes_of_the_model():
    """A lap joint in small: its faces have opposite directions, so Σ q would be 0 under any pull."""
    faces = {"normal": [[0, 1, 0], [0, -1, 0]], "tangent": [[1, 0, 0], [-1, 0, 0]]}
    pulled = shakedown.Problem(
        A=np.eye(2), B=np.zeros((2, 2)), f=0.5, q_w=[[3, -3], [-3, 3]], p_w=[[7.0, 9.0]] * 2, **faces
    )
    drawn = {line.get_label(): line.get_ydata().tolist() for line in plot.loads_in_time(pulled).lines}
    assert drawn == {"Σ along x, all nodes": [6, -6, 6], "Σ along y, all nodes": [-2, -2, -2]}
    one_face = replace(pulled, normal=[[0, 1, 0]] * 2, tangent=[[1, 0, 0]] * 2)
    assert plot.loads_in_time(one_face).lines[1].get_label() == "Σ q_w, all nodes"


@pytest.mark.parametrize(
    ("name", "load_factor"),
    [("block-9", 5.0), ("press-fit", 2.0), ("four-node-3d", 1.4), ("two-node-3d", 1.2)],
)
def test_the_work_that_is_drawn_is_that_of_the_results_per_node(name, load_factor):
    """Along a contact and over a patch: of each node, and of all of them the dissipation of the state."""
    joint = replace(shakedown.example(name), node_area=None)
    state = shakedown.long_term_state(joint, load_factor)
    draw = plot.dissipation_along if joint.directions == 1 else plot.work_over_patch
    drawn = np.concatenate([line.get_ydata() for line in draw(state, joint).lines])
    places = np.arange(joint.n) if joint.x is None else np.argsort(joint.x, kind="stable")
    work = state.period * shakedown.node_results(state).work
    np.testing.assert_allclose(drawn, work[places], rtol=1e-9, atol=1e-12 * work.max())
    assert drawn.sum() == pytest.approx(state.friction_dissipation_per_cycle * state.period, rel=1e-9)


def test_texts_on_the_scale_do_not_lie_on_each_other():
    marks = {"λ_1": 0.646, "λ_U": 0.657, "λ_E": 0.662, "λ_T": 0.732, "λ_max": 0.739, "none": np.inf}
    axes = plot.load_factor_scale(marks)
    places = [(text.get_position(), text.get_text()) for text in axes.texts]
    assert len({height for (_, height), _ in places}) == 5  # only the last two are far enough apart
    assert all("none" not in text for _, text in places)


def test_slip_below_the_resolution_is_drawn_on_the_floor():
    run = shakedown.simulate(TWO, 0.5)
    cycles = tuple(replace(cycle, slip=np.full(2, 1e-13)) for cycle in run.cycles.records)
    tiny = replace(run, followed=replace(run.cycles, records=cycles))
    axes = plot.slip_per_cycle(tiny, TWO, resolution=1e-10)
    assert axes.lines[0].get_ydata() == pytest.approx(1e-10)
    low, high = axes.get_ylim()
    assert np.log(1e-10 / low) < 0.3 * np.log(high / low)  # near the lower end of the axis
    assert any("1e-10" in text.get_text() for text in axes.texts)


def test_bars_are_the_elasticities_of_the_nodes_that_count():
    limits = shakedown.assess(BLOCK).details
    found = limits.sensitivities["upper"]
    axes = plot.sensitivity(found, BLOCK)
    nodes = [int(text.get_text().split()[1]) for text in axes.get_yticklabels()]
    widths = np.array([bar.get_width() for bar in axes.patches]).reshape(3, -1)
    assert 1 <= len(nodes) <= 4
    for drawn, kind in zip(widths, ("friction", "constant", "amplitude"), strict=True):
        assert drawn == pytest.approx(getattr(found, kind).elasticity[nodes])
    nothing = shakedown.example("one-node-separation")
    with pytest.raises(UsageError, match="expected a bound with derivatives"):
        plot.sensitivity(shakedown.assess(nothing).details.sensitivities["energy"])


def test_a_straight_contact_along_an_axis_is_drawn_at_its_coordinates():
    places = np.column_stack([np.full(9, 4.0), 7.0 + np.arange(9.0), np.zeros(9)])
    axes = plot.slip_along({"safe": np.zeros(9)}, replace(BLOCK, coordinates=places))
    assert axes.get_xlabel() == "y [mm]"
    assert np.array_equal(axes.lines[0].get_xdata(), places[:, 1])
    bent = replace(
        BLOCK, coordinates=places * [1.0, 1.0, 0.0] + np.outer(np.arange(9.0) ** 2, [1.0, 0.0, 0.0])
    )
    assert plot.slip_along({"safe": np.zeros(9)}, bent).get_xlabel() == "position along the contact [mm]"
