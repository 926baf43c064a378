"""Pictures carry units, tell flanks apart, show the numbers of their results, and reach files whole or not at all.

Of maps and design diagrams, too, what is drawn is what the map or the sweep says. In a page nothing of them is cut off, legends hide nothing, panels that are compared look alike.
"""

import re
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import shakedown
from shakedown import UsageError, plot
from shakedown.joint.constraints import constraints
from shakedown.motion.evolution import evolve
from shakedown.plot.inline_svg import Drawing, picture
from shakedown.plot.planes import loads_felt, stick_sector
from shakedown.programs import simplex

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


def texts(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


def test_reaction_space_shows_states_and_sectors():
    problem = shakedown.example("one-node-separation")
    run = evolve(problem, 1.0, problem.initial_slip[0], cycles=3)
    shown = texts(plot.reaction_space(run, problem))
    assert {"stick", "open"} <= set(shown)
    assert "v = -1" in shown
    assert "backward slip" not in shown


@pytest.mark.parametrize("load_factor", [0.0, 0.3, 0.6573, 0.7, 0.73])
def test_the_safe_polygon_is_the_safe_region(load_factor):
    """Its corners are on two rows each and inside the others; random points agree with the rows."""
    rows = constraints(TWO)
    corners = simplex.corners(rows.G, rows.g - load_factor * rows.d)
    excess = corners @ rows.G.T + load_factor * rows.d - rows.g
    size = np.abs(rows.g).max()
    assert (np.sort(np.abs(excess), axis=1)[:, :2] < 1e-10 * size).all()
    assert (excess < 1e-10 * size).all()
    low, high = corners.min(axis=0), corners.max(axis=0)
    points = np.random.default_rng(0).uniform(low, high, (200, 2))
    (x, y), away = (np.roll(corners, -1, axis=0) - corners).T, points[:, None] - corners
    left = x * away[..., 1] - y * away[..., 0]
    inside = (points @ rows.G.T + load_factor * rows.d <= rows.g).all(axis=1)
    assert np.array_equal((left >= 0).all(axis=1), inside)


@pytest.mark.parametrize("factor", [1.0, 1.3, 3.0])
def test_above_the_last_safe_slip_the_window_has_that_slip(factor):
    """Paths may end far away: the thesis draws the limits about the safe slip, figure 5.4 (d)."""
    last = shakedown.upper_bound(TWO)
    load_factor = factor * last.load_factor * (1 + 1e-9)
    run = evolve(TWO, load_factor, [3.0, 6.0], cycles=1)
    for results in ({}, {"path": run}):
        axes = plot.slip_space(TWO, load_factor, results)
        for (low, high), slip in zip((axes.get_xlim(), axes.get_ylim()), last.slip, strict=True):
            assert low < slip < high
        assert "safe slip at λ_max" in texts(axes)
    below = plot.slip_space(TWO, 0.7)
    assert "safe slip at λ_max" not in texts(below)


def test_the_load_is_on_the_edge_of_its_sector_where_the_node_slips():
    path = evolve(TWO, 0.72, [1.5, 1.5]).history
    felt = loads_felt(TWO, path, 1)
    for (tangential, normal), v, state in zip(felt, path.v[:, 1], path.state[:, 1], strict=True):
        apex = stick_sector(TWO, 1, v, 1.0)[0]
        use = (tangential - apex[0]) / (TWO.f[1] * (normal - apex[1]))
        assert abs(use) <= 1 + 1e-9
        assert not state or use == pytest.approx(state, abs=1e-9)
    assert path.state[:, 1].any()


@pytest.mark.parametrize(("ending", "start"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_the_ending_decides_the_format_and_the_same_picture_has_the_same_bytes(tmp_path, ending, start):
    paths = [tmp_path / f"{k}.{ending}" for k in range(2)]
    for path in paths:
        plot.save(plot.load_loop(TWO, 0), path)
    first, second = (path.read_bytes() for path in paths)
    assert first == second
    assert first.startswith(start)
    assert b"Date" not in first
    assert b"dc:date" not in first


def test_an_unknown_ending_is_refused(tmp_path):
    axes = plot.load_loop(TWO, 0)
    with pytest.raises(UsageError, match=r"loop\.doc: expected a name that ends in"):
        plot.save(axes, tmp_path / "loop.doc")


def test_a_picture_that_fails_leaves_the_old_file(tmp_path):
    path = tmp_path / "old.png"
    path.write_bytes(b"old")
    axes = Figure().subplots()
    axes.plot(np.arange(3.0), label="$\\notamacro{$")
    axes.legend()
    with pytest.raises(ValueError, match="notamacro"):
        plot.save(axes, path)
    assert path.read_bytes() == b"old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["old.png"]


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
