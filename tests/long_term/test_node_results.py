"""What nodes go through, in the plane and in space: against the path itself, exact numbers and closed forms.

Files for ParaView: faces and directions in space, names of nodes, the path at the times of a series.
"""

import csv
from dataclasses import replace
from fractions import Fraction
from xml.etree import ElementTree

import meshlane
import numpy as np
import pandas
import pytest
from command import run
from joints import FAMILY, any_joint, joint_of_kind, member
from joints_in_space import embedded
from partly_open import SOME, partly_open
from scipy.spatial.distance import pdist, squareform

import shakedown
from shakedown import Problem, UsageError, node_results
from shakedown.joint.places import corners_of_hull
from shakedown.long_term.node_results import farthest_apart, save_node_instants
from shakedown.motion.evolution import evolve
from shakedown.report.data_facts import node_columns

WEAR = 2.0e-8
JUMP = shakedown.example("jump")
FIELDS = ["slip_range", "accumulated_slip", "p_min", "p_max", "q_max", "work", "wear_volume"]


def walking(shift=0):
    """A floating joint that ratchets, and goes back and forth beside it; its load steps may be rotated."""
    joint = joint_of_kind(np.random.default_rng(6), "floating")
    loads = {word: np.roll(getattr(joint, word), shift, axis=0) for word in ("q_w", "p_w")}
    return replace(joint, **loads, q_mean=joint.q_w.mean(axis=0), p_mean=joint.p_w.mean(axis=0))


def of_family(k):
    a, fB, impulses, load_factor, start = FAMILY[k][:5]
    return member(a, fB, impulses), load_factor, start


def given(problem):
    return None if problem.initial_slip is None else problem.initial_slip[0]


CASES = {
    "two-node": lambda: (shakedown.example("two-node"), 0.9, None),
    "three-node": lambda: (shakedown.example("three-node"), 2.6, given(shakedown.example("three-node"))),
    "block-9": lambda: (shakedown.example("block-9"), 5.0, None),
    "press-fit": lambda: (shakedown.example("press-fit"), 2.0, None),
    "period 2": lambda: of_family(0),
    "period 2 again": lambda: of_family(1),
    "walks": lambda: (walking(), 1.0, None),
    "jumps": lambda: (joint_of_kind(np.random.default_rng(15), "above thresholds"), 1.0, None),
    "jumps once": lambda: (any_joint(np.random.default_rng(43)), 1.0, None),
    "partly open": lambda: (partly_open(SOME[0]), 2.0, None),
    "stays open": lambda: (JUMP, 1.0, given(JUMP)),
    "at rest": lambda: (shakedown.example("two-node"), 0.5, None),
    **{f"any {k}": lambda k=k: (any_joint(np.random.default_rng(k)), 1.0, None) for k in range(6)},
}


@pytest.fixture(scope="module", params=CASES)
def settled(request):
    problem, load_factor, start = CASES[request.param]()
    state = shakedown.long_term_state(problem, load_factor, start, max_cycles=60)
    return problem, state, node_results(state, wear_coefficient=WEAR)


def test_works_add_up_to_the_dissipation_and_slips_are_those_of_the_state(settled):
    problem, state, nodes = settled
    total = state.friction_dissipation_per_cycle
    assert nodes.work.sum() == pytest.approx(total, rel=1e-13, abs=1e-300)
    assert (nodes.work >= -1e-12 * abs(total)).all()
    worn = pytest.approx(WEAR * nodes.work, rel=1e-9, abs=1e-12 * WEAR * total)
    assert problem.f * nodes.wear_volume == worn
    assert state.period * nodes.accumulated_slip == pytest.approx(state.slip_per_cycle, rel=1e-15)


def test_a_dense_path_shows_the_same(settled):
    _, state, nodes = settled
    path = state.history.at(np.linspace(state.history.cycle[0], state.history.cycle[-1], 40_001))
    slip, force = np.abs(path.v).max() + 1e-300, np.abs(path.p).max()
    assert nodes.p_min == pytest.approx(path.p.min(axis=0), abs=2e-3 * force)
    assert nodes.p_max == pytest.approx(path.p.max(axis=0), abs=2e-3 * force)
    assert nodes.q_max == pytest.approx(np.abs(path.q).max(axis=0), abs=2e-3 * force)
    if state.jumps_per_cycle > 0:
        return  # what slips in a jump slips in no time
    held = (path.state[:-1] != 2) & (path.state[1:] != 2)
    steps = np.where(held, np.diff(path.v, axis=0), 0.0)
    assert nodes.accumulated_slip * state.period == pytest.approx(np.abs(steps).sum(axis=0), abs=2e-3 * slip)
    pressed = (0.5 * (path.p[1:] + path.p[:-1]) * np.abs(steps)).sum(axis=0) / state.period
    assert nodes.wear_volume == pytest.approx(WEAR * pressed, abs=2e-3 * WEAR * slip * force)
    if state.outcome != "ratchetting":
        closed = path.w <= 1e-9 * slip
        span = np.where(closed, path.v, -np.inf).max(axis=0) - np.where(closed, path.v, np.inf).min(axis=0)
        assert nodes.slip_range == pytest.approx(np.where(closed.any(axis=0), span, 0.0), abs=2e-3 * slip)


@pytest.mark.parametrize("d", [1, 2])
def test_nodes_that_stay_open_carry_nothing(d):
    """Not even the round-off of their reactions; and setting down is no slip."""
    state = shakedown.long_term_state(problem := partly_open(2, 4, d=d), 0.1)
    nodes, away, path = node_results(state), list(state.open_nodes), state.history
    assert np.abs(path.p[:, away]).max() > 0 == (nodes.p_max + nodes.q_max)[away].max()
    small = replace(nodes, p_min=1e-3 * nodes.p_min)  # of closed nodes it is no round-off
    assert node_columns(small, problem)["p_min"].tolist() == small.p_min.tolist()
    once = replace(path, v=0 * path.v, state=np.where(np.arange(len(path))[:, None] < 2, 2, 1))
    assert not once.without_round_off(problem).state[2:].any()
    assert (np.delete(nodes.p_max, away) > 0).all()


@pytest.mark.parametrize("seed", range(6))
def test_one_node_in_rational_numbers(seed):
    rng = np.random.default_rng(seed)
    A, B, f = 1.0, rng.integers(-8, 9) / 16, rng.integers(2, 12) / 16
    q_w, p_w = rng.integers(-24, 25, 7) / 16, rng.integers(24, 48, 7) / 16
    problem = Problem(A=[[A]], B=[[B]], f=f, q_w=q_w[:, None], p_w=p_w[:, None])
    nodes = node_results(shakedown.long_term_state(problem, 1.0))
    exact = rational_period(*map(Fraction, (A, B, f)), list(map(Fraction, q_w)), list(map(Fraction, p_w)))
    for word, value in exact.items():
        assert getattr(nodes, word)[0] == pytest.approx(float(value), rel=1e-13, abs=1e-14), word


def rational_period(A, B, f, q_w, p_w):
    """The steady cycle of one closed node, exactly: within a load step it sticks, and then slips one way."""
    v, loads = Fraction(0), list(zip(q_w, p_w, strict=True))
    for _ in range(6):
        rows, slip, work = [], Fraction(0), Fraction(0)
        for (q0, p0), (q1, p1) in zip([loads[-1], *loads[:-1]], loads, strict=True):
            before, after = (q0 + A * v, p0 + B * v), (q1 + A * v, p1 + B * v)
            rows.append((v, *before))
            for side in (1, -1):
                if side * after[0] > f * after[1]:
                    gap = [f * p - side * q for q, p in (before, after)]
                    share = gap[0] / (gap[0] - gap[1])
                    start = [a + share * (b - a) for a, b in zip(before, after, strict=True)]
                    end = (f * p1 - side * q1) / (side * A - f * B)
                    q = q1 + A * end
                    rows += [(v, *start), (end, q, p1 + B * end)]
                    slip, work = slip + abs(end - v), work - (end - v) * (start[0] + q) / 2
                    v = end
                    break
    slips, q, p = zip(*rows, strict=True)
    return {
        "slip_range": max(slips) - min(slips), "accumulated_slip": slip, "work": work,
        "p_min": min(p), "p_max": max(p), "q_max": max(map(abs, q)),
    }  # fmt: skip


def test_the_range_of_a_walk_does_not_depend_on_where_its_period_begins():
    ranges = [node_results(shakedown.long_term_state(walking(shift), 1.0)).slip_range for shift in range(5)]
    state = shakedown.long_term_state(walking(), 1.0)
    assert state.outcome == "ratchetting"
    assert (ranges[0] > np.abs(state.drift) * (1 + 1e-6)).any()  # it goes back and forth beside the drift
    in_space = node_results(shakedown.long_term_state(embedded(walking()), 1.0)).slip_range
    for one, near in *((one, 1e-9) for one in ranges[1:]), (in_space, 1e-6):
        assert one == pytest.approx(ranges[0], rel=near)
    path = evolve(walking(), 1.0, cycles=12).history.at(np.linspace(8.0, 11.5, 7001))
    window = 2000
    spans = [np.ptp(path.v[k : k + window + 1], axis=0) for k in range(0, 5000, 10)]
    assert ranges[0] == pytest.approx(np.max(spans, axis=0), rel=2e-3)


@pytest.mark.parametrize(("name", "load_factor"), [("two-node", 0.8), ("four-node-3d", 1.2)])
def test_without_a_long_term_state_there_are_no_numbers(name, load_factor):
    problem = shakedown.example(name)
    nodes = node_results(shakedown.long_term_state(problem, load_factor, max_cycles=1))
    assert (nodes.outcome, nodes.status) == ("undecided", ("undecided",) * problem.n)
    for word in (*FIELDS, "tau_delta", "wear_depth"):
        assert np.isnan(getattr(nodes, word)).all(), word
    assert nodes.to_dict()["slip_range"] == [None] * problem.n


def test_labels_places_and_areas_are_those_of_the_joint():
    problem = shakedown.example("press-fit")
    nodes = node_results(shakedown.long_term_state(problem, 1.0))
    assert nodes.label == problem.label
    assert np.array_equal(nodes.coordinates, problem.coordinates)
    assert np.array_equal(nodes.pressure_max, nodes.p_max / problem.node_area)
    table = nodes.to_frame()
    assert isinstance(table, pandas.DataFrame)
    assert list(table.columns[:7]) == ["label", "x", "y", "z", "area", "status", "slip_range"]
    bare = replace(problem, label=None, coordinates=None, normal=None, tangent=None, node_area=None)
    nodes = node_results(shakedown.long_term_state(bare, 1.0))
    assert nodes.label == tuple(map(str, range(9)))
    assert np.array_equal(nodes.x, bare.x)
    assert np.isnan(nodes.tau_delta).all()


def circling(radius: float = 1.3, limit: float = 0.5) -> Problem:
    """One node whose welded reaction goes round a circle, fp = ``limit``, A = 2 I."""
    t = 2 * np.pi * np.arange(720)[:, None] / 720
    q_w = radius * np.hstack([np.cos(t), np.sin(t)])
    return Problem(A=2 * np.eye(2), B=np.zeros((1, 2)), f=limit, q_w=q_w, p_w=np.ones((720, 1)))


def test_a_node_that_goes_round_a_circle():
    """It slips on a circle of radius √(Q² − (fp)²)/A."""
    Q, limit = 1.3, 0.5
    nodes = shakedown.node_results(shakedown.long_term_state(circling(Q, limit), 1.0))
    radius = np.sqrt(Q**2 - limit**2) / 2
    assert nodes.status == ("slip",)
    assert nodes.slip_range[0] == pytest.approx(2 * radius, rel=1e-4)
    np.testing.assert_allclose(nodes.to_dict()["slip_range_x"], 2 * radius, rtol=1e-4)
    np.testing.assert_allclose(nodes.slip_range_of_directions, 2 * radius, rtol=1e-4)
    assert nodes.accumulated_slip[0] == pytest.approx(2 * np.pi * radius, rel=1e-4)
    assert nodes.work[0] == pytest.approx(2 * np.pi * radius * limit, rel=1e-4)
    assert nodes.q_max[0] == pytest.approx(limit, rel=1e-9)


def test_the_works_add_up_and_files_have_the_components(tmp_path):
    problem = shakedown.example("four-node-3d")
    state = shakedown.long_term_state(problem, 1.5)
    nodes = shakedown.node_results(state, wear_coefficient=1.0)
    assert nodes.work.sum() == pytest.approx(state.dissipation_per_cycle, rel=1e-9)
    assert problem.f * nodes.wear_volume == pytest.approx(nodes.work, rel=1e-9)
    assert np.all(nodes.slip_range >= nodes.slip_range_of_directions.max(axis=1) * (1 - 1e-12))
    assert np.all(2 * nodes.slip_range <= nodes.accumulated_slip * (1 + 1e-9) + 1e-6)
    nodes.save(tmp_path / "nodes.csv")
    with open(tmp_path / "nodes.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    across = [float(row["slip_range_y"]) for row in rows]
    np.testing.assert_allclose(across, nodes.slip_range_of_directions[:, 1])
    assert [row["status"] for row in rows] == list(nodes.status)


def test_a_limit_on_the_slip():
    problem = shakedown.example("two-node-3d")
    run = shakedown.simulate(problem, 1.0, slip_below=1e-3)
    assert run.slip_criterion.met is False
    assert run.slip_criterion.largest == pytest.approx(shakedown.node_results(run).slip_range.max())


def test_a_node_that_stays_open():
    """It does not slip in contact, and the others are as without it."""
    alone = circling()
    q_w, p_w = np.hstack([alone.q_w, 0.1 * alone.q_w]), np.hstack([alone.p_w, -alone.p_w])
    problem = Problem(A=2 * np.eye(4), B=np.zeros((2, 4)), C=np.eye(2), f=0.5, q_w=q_w, p_w=p_w)
    nodes = shakedown.node_results(shakedown.long_term_state(problem, 1.0))
    assert nodes.status == ("slip", "open")
    assert nodes.slip_range[0] == pytest.approx(np.sqrt(1.3**2 - 0.5**2), rel=1e-4)
    assert (nodes.slip_range[1], nodes.accumulated_slip[1], nodes.work[1]) == (0, 0, 0)


PATHS = {
    "cloud": lambda rng, s: rng.normal(size=(s, 2)),
    "walk": lambda rng, s: np.cumsum(rng.normal(size=(s, 2)), axis=0),
    "line": lambda rng, s: np.outer(rng.normal(size=s), [0.3, -0.7]),
    "ellipse": lambda rng, s: np.column_stack([np.cos(np.arange(s)), 1e-3 * np.sin(np.arange(s))]),
    "few": lambda rng, s: rng.normal(size=(3, 2))[rng.integers(3, size=s)],
}


@pytest.mark.parametrize("kind", PATHS)
def test_diameters_are_those_of_all_pairs(kind):
    rng = np.random.default_rng(0)
    for s, size in ((1, 1.0), (2, 1e-90), (7, 1e80), (300, 1.0), (500, 1e-6)):
        places, time = size * PATHS[kind](rng, s), np.cumsum(rng.integers(1, 4, size=s))
        apart = squareform(pdist(places)) if s > 1 else np.zeros((1, 1))
        corners = corners_of_hull(places)
        whole = farthest_apart(corners, np.full(len(corners), len(corners)))
        assert np.hypot(*whole) == pytest.approx(apart.max(), rel=1e-12, abs=0)
        for window in (1, 5, 200, 5000):
            near = apart[np.abs(time[:, None] - time) < window].max()
            found = farthest_apart(places, np.searchsorted(time, time + window))
            assert np.hypot(*found) == pytest.approx(near, rel=1e-12, abs=1e-15 * apart.max())


@pytest.fixture(scope="module")
def flange():
    """Turned so that no direction of it is an axis; the first five faces only, one of them a triangle."""
    joint = shakedown.example("bolted-flange")
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    faces = joint.faces.copy()
    faces[0, 3] = -1
    placed = {key: getattr(joint, key) @ turn for key in ("coordinates", "normal", "tangents")}
    return replace(joint, faces=faces[:5], **placed)


@pytest.fixture(scope="module")
def state(flange):
    return shakedown.long_term_state(flange, 1.2 * shakedown.upper_bound(flange).load_factor)


def test_the_faces_are_cells_and_the_other_nodes_vertices(flange, state, tmp_path):
    shakedown.node_results(state).save(tmp_path / "n.vtu")
    mesh = meshlane.read(tmp_path / "n.vtu")
    cells = {block.type: block.data for block in mesh.cells}
    assert np.sort(cells["triangle"]).tolist() == np.sort(flange.faces[:1, :3]).tolist()
    assert np.sort(cells["quad"]).tolist() == np.sort(flange.faces[1:]).tolist()
    for corners in cells["triangle"], cells["quad"]:  # counter-clockwise, seen against the normals
        at = mesh.points[corners]
        across = np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 1])
        assert ((across * flange.normal[0]).sum(axis=1) > 0).all()
    assert sorted([*cells["vertex"].ravel(), *{*flange.faces.ravel()} - {-1}]) == list(range(flange.n))
    labels = [f"{a}/{b}" for a, b in zip(mesh.point_data["node_1"], mesh.point_data["node_2"], strict=True)]
    assert labels == list(flange.label)


def test_slip_vectors_lie_in_the_surface_and_are_as_long_as_the_range(flange, state):
    found = shakedown.node_results(state)
    assert found.slip_range.max() > 0
    np.testing.assert_allclose(np.linalg.norm(found.slip_range_vector, axis=1), found.slip_range, rtol=1e-12)
    across = np.einsum("nk,nk->n", found.slip_range_vector, flange.normal)
    near = 1e-9 * found.slip_range.max()
    assert np.abs(across).max() <= near
    by_node = state.history.refined().v.reshape(-1, flange.n, 2)
    whole = np.einsum("snd,ndk->snk", by_node, flange.tangents)
    apart = np.linalg.norm(whole[:, None] - whole[None], axis=-1)
    closed = np.isin(found.status, ["stick", "slip"])  # what moves while a node is open is no slip
    assert "slip" in found.status
    np.testing.assert_allclose(apart.max(axis=(0, 1))[closed], found.slip_range[closed], atol=near)


def test_the_normal_follows_from_both_tangents(flange, state):
    without = shakedown.node_results(replace(state, problem=replace(flange, normal=None)))
    np.testing.assert_allclose(without.normal, flange.normal, atol=1e-12)


def test_every_instant_is_a_file_with_the_path_at_its_time(flange, state, tmp_path):
    written = save_node_instants(state, tmp_path / "nodes.vtu", 5)
    assert [path.name for path in written] == ["nodes.pvd", *(f"nodes_{k:03d}.vtu" for k in range(5))]
    assert sorted(written) == sorted(tmp_path.iterdir())
    named = list(ElementTree.parse(written[0]).iter("DataSet"))
    assert [each.get("file") for each in named] == [path.name for path in written[1:]]
    times = np.array([float(each.get("timestep")) for each in named])
    np.testing.assert_array_equal(times, np.linspace(0.0, 1.0, 5))
    begin, end = state.history.cycle[[0, -1]]
    at = state.history.at(begin + times * (end - begin))
    for k, path in enumerate(written[1:]):
        found = meshlane.read(path)
        np.testing.assert_array_equal(found.points, flange.coordinates)
        for word, values in (("v [mm]", at.v), ("q [N]", at.q)):
            there = np.einsum("nd,ndk->nk", values[k].reshape(-1, 2), flange.tangents)
            np.testing.assert_allclose(found.point_data[word], there, rtol=1e-12, atol=0.0)
        np.testing.assert_array_equal(found.point_data["normal"], flange.normal)
        np.testing.assert_array_equal(found.point_data["cycle"], at.cycle[k])
        assert {cells.type for cells in found.cells} == {"vertex", "triangle", "quad"}
        for word, values in (("p [N]", at.p), ("w [mm]", at.w), ("status", at.state)):
            np.testing.assert_array_equal(found.point_data[word], values[k])


def test_without_tangents_vectors_lie_along_the_first_axes(tmp_path):
    joint = replace(shakedown.example("four-node-3d"), coordinates=np.arange(12.0).reshape(4, 3))
    (_, path) = save_node_instants(shakedown.long_term_state(joint, 1.4), tmp_path / "nodes.vtu", 1)
    v = meshlane.read(path).point_data["v"]
    assert (v.shape, v[:, 2].any(), v.any()) == ((4, 3), False, True)


def test_the_command_writes_them_beside_the_table_of_the_period(tmp_path):
    path = tmp_path / "nodes.vtp"
    asked = ("nodes", "two-node", "--load-factor", "0.9", "--instants", "2", "-o")
    assert run(*asked, str(path))[0] == 0
    names = {found.name for found in tmp_path.iterdir()}
    assert names == {"nodes.vtp", "nodes.pvd", "nodes_000.vtp", "nodes_001.vtp"}
    code, _, err = run(*asked, str(tmp_path / "nodes.csv"))
    assert code == 2
    assert "--instants: expected -o with a name that ends in .vtu or .vtp, found" in err
    (tmp_path / "other.pvd").mkdir()
    code, _, err = run(*asked, str(tmp_path / "other.vtp"))
    assert code == 2
    assert "other.pvd: cannot be written" in err
    assert not list(tmp_path.glob("other*.vtp"))


def test_without_a_steady_period_there_is_no_series(tmp_path):
    stepped = shakedown.simulate(shakedown.example("two-node"), 0.5, method="gauss-seidel", cycles=2)
    with pytest.raises(UsageError, match="expected a steady period from event to event, found none"):
        save_node_instants(stepped, tmp_path / "nodes.vtp")
    assert not list(tmp_path.iterdir())
