"""Damaged files, numbers from the ends of what floats hold, all kinds of joints in space: an answer, a status or one line."""

import dataclasses
import warnings
from itertools import pairwise

import numpy as np
import pytest
from hostile.campaign import CONTROL, LONGEST_LINE, judge, named, numbers
from hostile.damaged_npz import HEADERS, damaged_bytes, damaged_npz, npy, with_header

import shakedown
from shakedown import Problem, ProblemError, UsageError
from shakedown.joint.constraints import loading, with_initial_gap
from shakedown.motion.evolution import evolve

FEW = 40


JOINTS = ("two-node", "two-node-3d")


def arrays(number: int = 0) -> dict[str, np.ndarray]:
    """Two nodes with every optional key, in the plane and in space by turns."""
    problem = shakedown.example(JOINTS[number % 2])
    keys, slips = ("A", "B", "C", "f", "q_w", "p_w"), 2 * problem.directions
    more = {"q_mean": np.ones(slips), "p_mean": np.ones(2), "x": np.arange(2.0)}
    more |= {"initial_slip": np.zeros((2, slips))}
    more |= {"tangents": np.tile(np.eye(3)[:2], (2, 1, 1))} if problem.directions > 1 else {}
    normal = np.eye(3)[[2, 2]]
    places = {"coordinates": np.ones((2, 3)), "normal": normal, "node_area": np.ones(2)}
    texts = {"name": np.array("joint"), "units": np.array("N, mm"), "schema": np.array("shakedown/1")}
    names = {"label": np.array(["7/8", "9/10"]), "load_names": np.array(["top"]), "source": np.array("{}")}
    loads = {"load_mean": np.ones(1), "load_amplitude": np.ones(1), "load_units": np.array(["kN"])}
    return {key: getattr(problem, key) for key in keys} | more | places | texts | names | loads


def read(load, path):
    """What a reader makes of a file, or the one line with which it refuses it."""
    try:
        return load(path)
    except ProblemError as error:
        line = str(error)
    assert "\n" not in line
    assert not CONTROL.search(line)
    assert len(line) <= LONGEST_LINE
    return line


def test_damaged_problem_files(tmp_path):
    path = tmp_path / "p.npz"
    loaded = 0
    for number in numbers(FEW):
        rng = np.random.default_rng([1, number])
        path.write_bytes(damaged_npz(arrays(number), rng))
        with named(number, "damaged_npz"):
            loaded += isinstance(read(shakedown.load_problem, path), Problem)
    assert loaded, "every file was refused: the damage is too coarse to test what is behind the border"


def test_damaged_initial_states(tmp_path):
    path = tmp_path / "v.npy"
    for number in numbers(FEW):
        rng = np.random.default_rng([2, number])
        whole = npy(rng.normal(size=2))
        if rng.random() < 0.4:
            path.write_bytes(with_header(HEADERS[rng.integers(len(HEADERS))], whole[128:]))
        else:
            path.write_bytes(damaged_bytes(whole, rng))
        with named(number, "damaged_bytes"):
            read(shakedown.load_initial_slip, path)


def test_what_headers_say_is_no_warning(tmp_path):
    """Outside of pytest, where a warning is no error that would refuse the file."""
    path, data = tmp_path / "slip.npy", np.ones((2, 2)).tobytes()
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        for header in HEADERS:
            path.write_bytes(with_header(header, data))
            read(shakedown.load_initial_slip, path)
    assert not told


BEYOND = [5e-324, 1e-310, 1e-200, 1e150, 1e200, 1e300, 1.7e308]
SIZES = [10.0**k for k in (-99, -75, -40, -28, -16, -12, -8, 8, 12, 16, 28, 40, 75, 99)]


def joint_arrays(rng: np.random.Generator, directions: int = 1) -> dict[str, np.ndarray]:
    """A joint of one to three nodes: κ positive definite, singular, sparse, of whole numbers or zero."""
    n, m = int(rng.integers(1, 4)), int(rng.integers(1, 6))
    slips, size = directions * n, (directions + 1) * n
    kind = rng.integers(5)
    root = rng.normal(size=(size, size)) if kind < 3 else rng.integers(-2, 3, (size, size)).astype(float)
    if kind == 1:
        root[:, rng.integers(size)] = 0.0
        root[rng.random((size, size)) < 0.4] = 0.0
    kappa = root @ root.T
    if kind == 2:  # rank one
        kappa = np.outer(root[0], root[0])
    if kind == 4 and rng.random() < 0.5:
        kappa = np.zeros((size, size))
    arrays = {
        "A": kappa[:slips, :slips],
        "B": kappa[slips:, :slips],
        "C": kappa[slips:, slips:],
        "f": rng.choice([0.0, 0.3, 2.0, 50.0], n),
        "q_w": rng.normal(size=(m, slips)),
        "p_w": rng.normal(size=(m, n)) + 3.0,
        "initial_slip": rng.normal(size=slips),
    }
    if rng.random() < 0.2:
        del arrays["C"]
    if rng.random() < 0.3:
        del arrays["initial_slip"]
    return arrays


def extreme(arrays: dict[str, np.ndarray], rng: np.random.Generator) -> dict[str, np.ndarray]:
    """The same with one to three of its arrays, or single entries, scaled or replaced by extremes."""
    arrays = {key: value.copy() for key, value in arrays.items()}
    for _ in range(rng.integers(1, 4)):
        sizes = BEYOND if rng.random() < 0.1 else SIZES
        size = sizes[rng.integers(len(sizes))]
        kind = rng.integers(5)
        with np.errstate(all="ignore"):
            if kind == 0:
                for key in ("A", "B", "C"):
                    if key in arrays:
                        arrays[key] = arrays[key] * size
            elif kind == 1:
                for key in ("q_w", "p_w"):
                    arrays[key] = arrays[key] * size
            elif kind == 2:
                key = rng.choice(list(arrays))
                arrays[key] = arrays[key] * size
            elif kind == 3:
                key = rng.choice(["f", "q_w", "p_w", *(["initial_slip"] if "initial_slip" in arrays else [])])
                arrays[key].flat[rng.integers(arrays[key].size)] = size
            else:  # one node in units of its own
                j, n = rng.integers(len(arrays["f"])), len(arrays["f"])
                slips = np.arange(len(arrays["A"])) * n // len(arrays["A"]) == j
                units = {"A": np.where(slips, size, 1.0), "C": np.where(np.arange(n) == j, size, 1.0)}
                for key, rows, columns in (("A", "A", "A"), ("B", "C", "A"), ("C", "C", "C")):
                    if key in arrays:
                        arrays[key] *= units[rows][:, None]
                        arrays[key] *= units[columns]
    return arrays


TOO_LARGE = {  # (largest size of every array that is read, message)
    "stiffness denormal": (("A", "B", "C"), 5e-324, "largest magnitude"),
    "stiffness huge": (("A", "B", "C"), 1e300, "largest magnitude"),
    "stiffness beyond": (("A", "B", "C"), 1e308, "found inf"),
    "loads denormal": (("q_w", "p_w"), 1e-310, "largest magnitude"),
    "loads huge": (("q_w", "p_w"), 1e200, "largest magnitude"),
    "loads tiny for the stiffness": (
        ("q_w", "p_w"),
        1e-90,
        "forces over stiffness between 1e-75 and 1e\\+75, found 1.98921e-90",
    ),
    "friction": (("f",), 1e300, "largest magnitude"),
    "friction beyond its limit": (("f",), 1e20, "friction coefficients up to"),
}


@pytest.mark.parametrize("case", TOO_LARGE)
def test_what_cannot_be_calculated_with_is_refused_in_one_line(case):
    keys, size, message = TOO_LARGE[case]
    problem = shakedown.example("two-node")
    with np.errstate(over="ignore"):
        changes = {key: size * getattr(problem, key) for key in keys}
    with pytest.raises(ProblemError, match=message) as caught:
        dataclasses.replace(problem, **changes)
    assert "\n" not in str(caught.value)


def test_negligible_entries_are_zero():
    A = np.array([[2.0, 5e-324], [5e-324, 1.0]])
    problem = Problem(
        A=A, B=1e-300 * np.eye(2) + np.eye(2)[::-1], f=0.3, q_w=[[1.0, 1e-310]], p_w=[[2.0, 2.0]]
    )
    assert problem.A.tolist() == [[2.0, 0.0], [0.0, 1.0]]
    assert problem.B.tolist() == [[0.0, 1.0], [1.0, 0.0]]
    assert problem.q_w.tolist() == [[1.0, 0.0]]


@pytest.mark.parametrize("slip", [1e200, -1e300])
def test_an_initial_slip_without_reactions_is_refused(slip):
    problem = shakedown.example("two-node")
    for call in (shakedown.simulate, shakedown.long_term_state, evolve):
        with pytest.raises(UsageError, match="initial slip"):
            call(problem, 0.5, [slip, 0.0])


def test_extreme_joints_in_space_at_the_command_line(tmp_path):
    for number in numbers(3):
        rng = np.random.default_rng([6, number])
        np.savez(tmp_path / "p.npz", **extreme(joint_arrays(rng, 2), rng))
        judge(
            number, ["solve", "p.npz", *rng.choice(["--json", "--details", "-q"], 1).tolist()], str(tmp_path)
        )


def test_extreme_joints_at_the_command_line(tmp_path):
    for number in numbers(8):
        rng = np.random.default_rng([5, number])
        arrays = extreme(joint_arrays(rng), rng)
        np.savez(tmp_path / "p.npz", **arrays)
        judge(number, ["critical", "p.npz", "-q"], str(tmp_path))
        if np.any(arrays["A"]):  # zero stiffness has no rates of its own
            words = [
                "simulate",
                "p.npz",
                "--load-factor",
                str(rng.choice([0.0, 0.5, 1.0, 1e6, 1e300])),
                "--cycles",
                "20",
            ]
            judge(number, words, str(tmp_path))


SPACE = (
    "regular", "singular", "floating", "whole", "uncoupled", "high friction", "frictionless", "transient",
    "domain", "gap", "open", "still", "line", "means",
)  # fmt: skip


def space_joint(rng: np.random.Generator, kind: str, most: int = 8) -> Problem:
    """One to ``most`` nodes with two tangential directions, κ positive semi-definite."""
    n, m = int(rng.integers(1, most + 1)), int(rng.integers(2, 9))
    size, whole = 3 * n, kind == "whole"
    root = rng.normal(size=(size, size)) / np.sqrt(size)
    if kind == "singular":
        root[:, : int(rng.integers(1, size))] = 0.0
    if whole:
        root = rng.integers(-2, 3, (size, size)).astype(float)
    kappa = root @ root.T
    if kind not in ("singular", "whole"):
        kappa += np.eye(size)
    if kind == "uncoupled":
        kappa[: 2 * n, 2 * n :] = kappa[2 * n :, : 2 * n] = 0.0
    if kind == "floating":  # in both directions, as a rigid body that is moved along its plane
        away = np.zeros((size, 2))
        away[: 2 * n] = np.tile(np.eye(2), (n, 1)) / np.sqrt(n)
        hold = np.eye(size) - away @ away.T
        kappa = hold @ kappa @ hold
        kappa = (kappa + kappa.T) / 2
    f = {"high friction": rng.uniform(2.0, 20.0, n), "frictionless": rng.choice([0.0, 0.5], n)}.get(
        kind, rng.uniform(0.1, 0.9, n)
    )
    q, p = rng.normal(size=(m, 2 * n)), rng.normal(size=(m, n)) + 4.0
    if kind == "still":
        q, p = np.repeat(q[:1], m, axis=0), np.repeat(p[:1], m, axis=0)
    if kind == "line":
        q = rng.normal(size=2 * n) * np.cos(2 * np.pi * np.arange(m)[:, None] / m)
    if kind == "open":
        p[:, rng.integers(n)] -= 6.0
    if whole:
        q, p = np.round(4 * q) / 4, np.round(4 * p) / 4
    more = {}
    if kind in ("means", "whole"):
        more = {"q_mean": q[0] / 4, "p_mean": np.full(n, 4.0)}
    if kind == "transient":
        k = int(rng.integers(1, 4))
        more = {"q_transient": rng.normal(size=(k, 2 * n)), "p_transient": rng.normal(size=(k, n)) + 4.0}
    if kind == "domain":
        more = {"load_path": "domain"}
    C = None if kind not in ("open", "gap") and rng.random() < 0.2 else kappa[2 * n :, 2 * n :]
    problem = Problem(
        A=kappa[: 2 * n, : 2 * n], B=kappa[2 * n :, : 2 * n], C=C, f=f, q_w=q, p_w=p, **more,
        initial_slip=0.1 * rng.normal(size=2 * n),
    )  # fmt: skip
    return with_initial_gap(problem, rng.uniform(-1.0, 0.5)) if kind == "gap" else problem


ROUND_OFF = 1e-6  # a joint whose κ is singular to rounding may have a condition of 1e8
SAFE = 1e-8
NUMBERS = ("proved_from_every_state", "proved_from_this_state", "impossible_above")


def excess(problem: Problem, slip: np.ndarray, load_factor: float) -> float:
    """By how much |q| exceeds f p anywhere in the loop, relative to the largest reaction of the node."""
    loop = loading(problem)
    q = (loop.q0 + load_factor * loop.q1 + problem.A @ slip).reshape(problem.m, -1, 2)
    p = loop.p0 + load_factor * loop.p1 + problem.B @ slip
    over = np.hypot(q[..., 0], q[..., 1]) - problem.f * p
    size = np.abs(problem.A) @ np.abs(slip) + np.abs(load_factor * loop.q1) + np.abs(loop.q0)
    return float((over / size.max()).max()) if size.any() else float(over.max())


def test_numbers_are_consistent_and_the_safe_slip_is_safe():
    for number in numbers(len(SPACE) // 4):
        kind = SPACE[2 * number % len(SPACE)]
        problem = space_joint(np.random.default_rng([31, number]), kind)
        with named(number, kind):
            found = shakedown.assess(problem, problem.initial_slip[0])
            found.to_dict()
            upper, energy = found.details.upper, found.details.energy
            for name in NUMBERS[:2]:
                proved = getattr(found, name)
                assert np.isnan(proved) or 0.0 <= proved <= found.impossible_above * (1 + ROUND_OFF)
            if not upper.open_nodes and upper.status == "optimal":
                assert excess(problem, upper.slip, upper.load_factor) <= SAFE
                chain = (upper.certified or (upper.load_factor,) * 2)[0], upper.load_factor
                assert all(low <= high * (1 + ROUND_OFF) for low, high in pairwise((*chain, chain[-1])))
                assert not energy.load_factor > upper.load_factor * (1 + ROUND_OFF)


def test_a_node_that_no_leaning_disc_holds_has_an_answer():
    steep = Problem(
        A=[[8.0, -2.0], [-2.0, 5.0]],
        B=[[0.0, 3.0]],
        f=50.0,
        q_w=[[0.1, -1.0], [0.2, 0.5]],
        p_w=[[3.0], [3.0]],
    )
    found = shakedown.universal_bound(steep)
    assert (found.load_factor, found.limited_by) == (0.0, "uniqueness")
