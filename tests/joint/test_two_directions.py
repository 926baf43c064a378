"""Joints with two tangential directions: what is accepted, their constraints, and what the plane alone has."""

from dataclasses import replace
from inspect import isfunction, signature

import numpy as np
import pytest
from joints_in_space import random_joint
from public_names import public

import shakedown
from shakedown import Problem, ProblemError, UsageError, load_problem, plot, save_problem
from shakedown.joint.constraints import constraints, loading, through_transient
from shakedown.joint.law import Law
from shakedown.joint.places import split_face
from shakedown.motion.evolution import evolve
from shakedown.studies.design_point import with_parameter


def arrays(n: int = 3, m: int = 24, seed: int = 0) -> dict:
    """The arrays of a joint with two directions, loaded out of phase in space, with every optional key."""
    rng = np.random.default_rng(seed)
    base = random_joint(rng, n, pressure=5.0, m=m)
    first = rng.normal(size=(n, 3))
    tangents = np.stack([np.linalg.qr(np.c_[v, rng.normal(size=(3, 2))])[0].T[1:] for v in first])
    return {key: getattr(base, key) for key in ("A", "B", "C", "f", "q_w", "p_w")} | {
        "q_transient": rng.normal(size=(5, 2 * n)),
        "p_transient": rng.uniform(3.0, 6.0, (5, n)),
        "initial_slip": 0.1 * rng.normal(size=(2, 2 * n)),
        "x": rng.normal(size=(n, 3)),
        "tangents": tangents,
        "normal": np.cross(tangents[:, 0], tangents[:, 1]),
    }


def joint(**changes) -> Problem:
    return Problem(**(arrays() | changes))


def test_the_shapes_tell_the_directions(tmp_path):
    problem = joint()
    assert (problem.n, problem.m, problem.directions) == (3, 24, 2)
    assert problem.kappa.shape == (9, 9)
    assert problem.layout.size == 9
    assert problem.to_dict()["directions"] == 2
    assert "directions=2" in repr(problem)
    assert "directions" not in shakedown.example("two-node").to_dict()
    save_problem(tmp_path / "joint.npz", problem)
    assert load_problem(tmp_path / "joint.npz") == problem
    for x in (np.zeros(3), np.zeros((3, 2))):
        assert joint(x=x).x.shape == x.shape
    assert joint(initial_slip=np.zeros(6)).initial_slip.shape == (1, 6)
    assert problem.node_data([2])["tangents"].shape == (1, 2, 3)


def test_faces_are_kept_in_files_and_go_with_their_nodes(tmp_path):
    faces = [[0, 1, 2, -1]]
    problem = joint(faces=faces)
    save_problem(tmp_path / "joint.npz", problem)
    assert load_problem(tmp_path / "joint.npz").faces.tolist() == faces
    assert problem.node_data([2, 0, 1])["faces"].tolist() == [[1, 2, 0, -1]]
    assert problem.node_data([0, 1])["faces"] is None
    assert joint(faces=np.zeros((0, 4))).faces is None


@pytest.mark.parametrize(("corners", "middle"), [(3, 0), (3, 1), (4, 0), (4, 1)])
def test_a_face_with_nodes_on_its_sides_is_covered_once_by_its_parts(corners, middle):
    angle = 2 * np.pi * (np.arange(corners) + 0.3) / corners
    tips = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    sides = ((tips + np.roll(tips, -1, axis=0)) / 2)[::-1]  # in any order
    places = np.vstack([tips, sides, tips[:1] * 0.0][: 2 + middle])
    parts = split_face(range(corners), range(corners, len(places)), places)

    def area(nodes):  # positive where they go around as the corners do
        x, y, _ = places[[node for node in nodes if node >= 0]].T
        return 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))

    assert min(map(area, parts)) > 0
    assert sum(map(area, parts)) == pytest.approx(area(range(corners)), rel=1e-12)
    assert {node for part in parts for node in part} - {-1} == set(range(len(places)))


CORNERS = "expected numbers of nodes from 0 to 2 (−1 as the last of a triangle), found"


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("B", np.zeros((6, 3)), "expected shape (6, 6) or (3, 6), found (6, 3)"),
        ("A", np.eye(6) + np.eye(6, k=1), "expected a symmetric matrix, found A[0,1] = 1 but A[1,0] = 0"),
        ("faces", [[0, 1, 2, -1], [0, 1, 3, -1]], f"{CORNERS} 3 at faces[1][2]"),
        ("faces", [[0, 1, 2, -1], [0, 1, -1, -1]], f"{CORNERS} -1 at faces[1][2]"),
        ("faces", [[0, 1, 2, -1], [0.5, 1, 2, -1]], f"{CORNERS} 0.5 at faces[1][0]"),
        ("faces", [[0, 1, 1, 2]], "expected corners that differ, found [0, 1, 1, 2] as face 0"),
        ("faces", [[0, 1, 2]], "expected shape (e, 4), found (1, 3)"),
        ("tangents", np.ones((3, 2, 3)), "expected vectors of length 1, found the length 1.73205081 at node 0"),
        ("tangents", np.tile([[0.0, 0.6, 0.8], [0.0, 0.8, 0.6]], (3, 1, 1)), "expected directions at right angles to each other and to 'normal', found the scalar product 0.96 at node 0"),
        ("tangent", np.tile([1.0, 0.0, 0.0], (3, 1)), "expected only with one tangential direction, found 2"),
    ],
)  # fmt: skip
def test_refused(key, value, message):
    with pytest.raises(ProblemError) as error:
        joint(**{key: value}, normal=None)
    assert str(error.value) == f"key '{key}': {message}"


def test_a_pair_of_tangents_means_nothing_in_the_plane():
    with pytest.raises(ProblemError, match="'tangents': expected only with two tangential directions"):
        replace(shakedown.example("two-node"), tangents=np.tile(np.eye(3)[:2], (2, 1, 1)))


def margins(problem: Problem, slip: np.ndarray, load_factor: float) -> np.ndarray:
    """Distance to the limit at every load step, (m, n): f p − |q|."""
    loop = loading(problem)
    q = loop.q0 + load_factor * loop.q1 + problem.A @ slip
    p = loop.p0 + load_factor * loop.p1 + problem.B @ slip
    parts = q.reshape(len(q), -1, 2)
    return problem.f * p - np.sqrt(parts[..., 0] ** 2 + parts[..., 1] ** 2)


LOOPS = {
    "space": lambda rng, t, n: np.cos(t + rng.normal(size=n)) + 0.3 * np.sin(3 * t) * rng.normal(size=n),
    "plane": lambda rng, t, n: rng.normal(size=n) * np.cos(t) + rng.normal(size=n) * np.sin(t),
    "plane but for round-off": lambda rng, t, n: (
        LOOPS["plane"](rng, t, n) + 3e-13 * np.cos(3 * t + 0.5) * rng.normal(size=n)
    ),
    "line": lambda rng, t, n: rng.normal(size=n) * np.cos(t),
    "still": lambda rng, t, n: np.zeros((len(t), n)),
    "random": lambda rng, t, n: rng.normal(size=(len(t), n)),
    "corners": lambda rng, t, n: rng.integers(-1, 2, (len(t), n)).astype(float),
}


@pytest.mark.parametrize("loop", LOOPS)
@pytest.mark.parametrize("seed", range(2))
def test_the_extreme_load_steps_suffice(loop, seed):
    rng = np.random.default_rng(seed)
    t = 2 * np.pi * np.arange(40)[:, None] / 40
    parts = LOOPS[loop](rng, t, 9)
    problem = joint(q_w=parts[:, :6], p_w=6.0 + parts[:, 6:], f=np.array([0.0, 0.3, 0.9]))
    rows = constraints(problem)
    node = rows.node[rows.heads]
    for _ in range(50):
        slip, load_factor = rng.normal(size=6) * rng.choice([0.01, 0.3, 3.0]), 3.0 * rng.random()
        every = -margins(problem, slip, load_factor).min(axis=0)
        # without friction
        every[0] = max(every[0], -(problem.B @ slip + loading(problem).at(load_factor)[1])[:, 0].min())
        found = rows.excess(slip, load_factor)
        largest = np.array([found[node == i].max() for i in range(3)])
        np.testing.assert_allclose(largest, every, atol=1e-12, rtol=1e-12)
    assert len(node) <= 3 * 40 + 1
    law, loop = Law(problem.f, 2), loading(problem)
    for size in (1.0, 2.0**-60, 2.0**60):
        of, step = law.extreme_steps(size * loop.q1, size * loop.p1)
        assert (of.tolist(), step.tolist()) == (node[:-1].tolist(), rows.step[rows.heads][:-1].tolist())


def test_transient_load_steps_are_cones_without_load_factor():
    problem = joint()
    rows, loop = through_transient(problem), constraints(problem)
    before = rows.step < 0
    np.testing.assert_array_equal(rows.d[before], 0.0)
    np.testing.assert_array_equal(rows.g[~before], loop.g)
    slip = 0.1 * np.random.default_rng(4).normal(size=6)
    q, p = problem.q_transient + problem.A @ slip, problem.p_transient + problem.B @ slip
    worst = problem.law.excess(q, p).max(axis=0)
    found, node = rows.excess(slip, 0.0), rows.node[rows.heads]
    early = rows.step[rows.heads] < 0
    np.testing.assert_allclose([found[early & (node == i)].max() for i in range(3)], worst, rtol=1e-12)


# What answers for two directions. Everything else that takes a problem refuses, in one line.
ANSWERS = {
    "joint, files": "can_drift averaged patch_count pressure constraints loading reactions save_problem scales",
    "words": "loads_in_words units_of units_at",
    "bounds": "conic_upper_bound moved_by_transient named_start safe_slip upper_bound creep_limit",
    "from a given state": "accumulated_bound energy_ball energy_bound total_slip_bound first_slip first_opening",
    "from every state": "least_pressure_bound universal_bound",
    "motion, long term": "evolve long_term_state long_term_states simulate slip_limit transient_limit path_resolution",
    "assessment": "verify assess shakedown_bounds",
    "studies": "sweep conjugate_displacement damping load_loops loop without_loads with_parameter initial_state_map",
    "runs of any joint: units and labels only": "slip_over_load slip_per_cycle sensitivity",
    "pictures over time": "loads_in_time reactions_in_time friction_use_at reaction_orbits slip_orbits zones_at",
    "pictures of a patch": "pressure_over_patch slip_over_patch welded_pressure_over_patch work_over_patch",
}
OTHERS = {  # what else a function needs to be called
    "load_factor": 0.5, "radii": [0.1], "cut": 0.1, "vary": {"f": [0.2, 0.3]}, "initial_slips": np.zeros((2, 6)),
    "q_w": np.zeros((4, 3)), "p_w": np.ones((4, 3)), "sides": (1, 1), "cycle": 1.0, "slip_below": 1.0, "nodes": (0, 1),
    "bound": shakedown.upper_bound(shakedown.example("two-node")),
}  # fmt: skip


def asked_of_problems() -> list[tuple[str, object]]:
    """Every public function that takes a problem to compute something of it, but for those that answer."""
    found, answers = [], " ".join(ANSWERS.values()).split()
    for name, thing in (public() | {name: getattr(plot, name) for name in plot.__all__}).items():
        asked = isfunction(thing) and name not in answers
        if asked and {"problem", "joint"} & set(signature(thing).parameters):
            found.append((name, thing))
    return found


@pytest.mark.parametrize(("name", "function"), asked_of_problems())
def test_what_the_plane_alone_has_is_refused_in_one_line(name, function):
    recorded = evolve(shakedown.example("two-node"), 0.5)
    given = {}
    for key, parameter in signature(function).parameters.items():
        if key in ("problem", "joint"):
            given[key] = joint()
        elif parameter.default is parameter.empty and parameter.kind is not parameter.VAR_KEYWORD:
            if key in ("result", "slips", "results"):
                given[key] = {"run": np.zeros(3)} if key == "slips" else recorded
            else:
                given[key] = OTHERS[key]
    with pytest.raises(UsageError) as error:
        list(function(**given))  # one of them goes through what it finds
    line = str(error.value)
    assert "expected one tangential direction, found two (" in line
    assert "\n" not in line


def test_other_parameters_keep_both_directions():
    problem = joint()
    for name in ("friction", "amplitude", "mean", "phase"):
        assert with_parameter(problem, name, 0.25).directions == 2
    later = with_parameter(problem, "phase", 0.25)
    np.testing.assert_allclose(later.q_w, np.roll(problem.q_w, 6, axis=0), atol=1e-12)
