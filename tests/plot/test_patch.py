"""Pictures of a patch show the numbers of the results, where the nodes are, whichever way tangents are turned."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.collections import EllipseCollection
from matplotlib.quiver import Quiver

import shakedown
from shakedown import plot
from shakedown.joint.constraints import loading
from shakedown.plot.patch_places import places_of

BARE = shakedown.example("four-node-3d")
CORNERS = np.array([[0.0, 0.0, 5.0], [2.0, 0.0, 5.0], [2.0, 1.0, 5.0], [0.0, 1.0, 5.0]])
UP, ALONG = np.tile([0.0, 0.0, 1.0], (4, 1)), np.tile(np.eye(3)[:2], (4, 1, 1))
JOINT = replace(
    BARE, coordinates=CORNERS, normal=UP, tangents=ALONG, units="N, mm", node_area=np.full(4, 2.0)
)


@pytest.fixture(scope="module")
def cyclic():
    return shakedown.long_term_state(JOINT, 1.4)


def arrows(axes):
    """Feet, vectors of all arrows, in the order of their feet."""
    found = [c for c in axes.collections if isinstance(c, Quiver)]
    rows = np.concatenate([np.column_stack([c.XY, c.U, c.V]) for c in found])
    return rows[np.lexsort(rows.T[:2])]


def test_arrows_are_the_use_of_friction_in_the_model_and_none_leaves_its_disc(cyclic):
    time = cyclic.history.cycle[0] + 0.3
    now = cyclic.history.at(np.array([time]))
    q, limit = JOINT.layout.by_node(now.q)[0], JOINT.law.limit(now.p)[0]
    axes = plot.friction_use_at(cyclic, JOINT, time)
    drawn, order = arrows(axes), np.lexsort(CORNERS.T[:2])
    np.testing.assert_allclose(drawn[:, :2], CORNERS[order, :2])
    (discs,) = [c for c in axes.collections if isinstance(c, EllipseCollection)]
    radius = float(discs._widths[0])  # of an ellipse it keeps half the width
    np.testing.assert_allclose(discs._widths, radius)
    np.testing.assert_allclose(drawn[:, 2:] / radius, (q / limit[:, None])[order], atol=1e-12)
    assert np.linalg.norm(drawn[:, 2:], axis=1).max() <= (1 + 1e-7) * radius


def test_turned_tangents_change_no_arrow():
    turn = np.array([[0.6, 0.8], [-0.8, 0.6]])
    whole = np.kron(np.eye(4), turn)
    other = replace(
        JOINT, A=whole @ JOINT.A @ whole.T, B=JOINT.B @ whole.T, q_w=JOINT.q_w @ whole.T,
        q_mean=None if JOINT.q_mean is None else JOINT.q_mean @ whole.T,
        q_transient=None, p_transient=None, initial_slip=None,
        tangents=np.tile(turn @ np.eye(3)[:2], (4, 1, 1)),
    )  # fmt: skip
    states = (shakedown.long_term_state(joint, 1.4) for joint in (JOINT, other))
    one, same = (
        arrows(plot.friction_use_at(state, state.problem, float(state.history.cycle[0]) + 0.3))
        for state in states
    )
    np.testing.assert_allclose(same, one, atol=1e-6)


def test_orbits_stay_within_the_limit_and_say_the_work_of_node_results(cyclic):
    nodes = shakedown.node_results(cyclic)
    axes = plot.reaction_orbits(cyclic, JOINT, nodes=range(4))
    for line, work in zip(axes.lines[1:], nodes.work, strict=True):
        farthest = np.linalg.norm(line.get_xydata(), axis=1).max()
        assert farthest < 1.0 + 1e-6
        assert farthest > 1.0 - 1e-6 or work == 0.0
    worst = int(nodes.work.argmax())
    axes = plot.slip_orbits(cyclic, JOINT, nodes=[worst])
    (text,) = axes.get_legend().get_texts()
    assert text.get_text() == f"node {worst}: {cyclic.period * nodes.work[worst]:.4g} [N mm]"
    way = axes.lines[0].get_xydata()
    np.testing.assert_allclose(np.ptp(way, axis=0), nodes.slip_range_of_directions[worst], rtol=1e-12)
    assert axes.get_xlabel() == "slip v_x − middle [mm]"


def test_without_places_numbers_stand_over_those_of_the_nodes(cyclic):
    time = float(cyclic.history.cycle[3])
    axes = plot.pressure_over_patch(cyclic, BARE, time)
    (line,) = axes.lines
    np.testing.assert_array_equal(line.get_xdata(), np.arange(4))
    np.testing.assert_array_equal(line.get_ydata(), cyclic.history.at(np.array([time])).p[0])
    axes = plot.pressure_over_patch(cyclic, JOINT, time)
    assert not axes.lines
    assert axes.figure.axes[-1].get_ylabel() == "pressure [MPa]"


def grid(n: int, m: int) -> np.ndarray:
    return np.stack(np.meshgrid(np.arange(float(n)), np.arange(float(m))), axis=-1).reshape(-1, 2)


def placed(x: np.ndarray) -> shakedown.Problem:
    n = len(x)
    return shakedown.Problem(
        A=np.eye(2 * n), B=np.zeros((n, 2 * n)), f=0.5, q_w=np.zeros((2, 2 * n)), p_w=np.ones((2, n)), x=x
    )


def test_no_triangle_lies_across_a_hole_or_between_two_patches():
    whole = grid(12, 12)
    hole = whole[np.linalg.norm(whole - 5.5, axis=1) > 3.2]
    apart = np.concatenate([grid(5, 5), grid(5, 5) + np.array([20.0, 0.0])])
    for x, count in ((hole, 1), (apart, 2)):
        assert plot.patch_count(placed(x)) == count
        places = [places_of(placed(x), k) for k in range(count)]
        middle = np.concatenate([each.points[each.triangles.triangles].mean(axis=1) for each in places])
        assert len(middle) > 20
        assert np.linalg.norm(middle[:, None] - x, axis=2).min(axis=1).max() < 1.0
    angle = 2 * np.pi * np.arange(24) / 24
    ring = np.concatenate([r * np.stack([np.cos(angle), np.sin(angle)], axis=1) for r in (8.0, 10.0, 12.0)])
    assert len(places_of(placed(ring)).triangles.triangles) == 2 * 2 * 24
    coarse = shakedown.example("bolted-flange")  # so coarse a ring that its hole is no larger than a triangle
    drawn = places_of(coarse).triangles
    assert np.hypot(*coarse.x[drawn.triangles].mean(axis=1).T).min() > 13.0 * np.cos(np.pi / 8) - 1e-9
    assert len(drawn.triangles) == 2 * 2 * 8
    facing = replace(
        placed(grid(6, 6)), coordinates=np.column_stack([grid(6, 6), np.zeros(36)]), tangents=None,
        normal=np.where(grid(6, 6)[:, :1] < 2.5, 1.0, -1.0) * np.array([0.8, 0.0, 0.6]) + [0.0, 0.0, 0.0],
    )  # fmt: skip
    assert [len(places_of(facing, k).triangles.triangles) for k in range(plot.patch_count(facing))] == [
        2 * 2 * 5
    ] * 2
    assert places_of(placed(grid(5, 1))).triangles is None
    assert len(places_of(placed(grid(2, 2) + 1e9)).triangles.triangles) == 2


def test_loads_of_nodes_with_tangents_of_their_own_are_summed_along_the_axes():
    faces = ALONG.copy()
    faces[2:] = [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]
    joint = replace(JOINT, tangents=faces, normal=np.cross(faces[:, 0], faces[:, 1]))
    q, p = loading(joint).at(1.0)
    lines = plot.loads_in_time(joint).lines
    assert [line.get_label() for line in lines] == [f"Σ along {axis}, all nodes" for axis in "xyz"]
    x = q[:, [0, 2, 5, 7]].sum(axis=1)
    np.testing.assert_allclose(lines[0].get_ydata()[:-1], x)
    np.testing.assert_allclose(lines[2].get_ydata()[:-1], p[:, :2].sum(axis=1) - p[:, 2:].sum(axis=1))
    assert plot.loads_in_time(JOINT).lines[1].get_label() == "Σ q_w in x"
