"""Damaged files: a problem, or one line; never a traceback, never a warning."""

import warnings

import numpy as np
from hostile.campaign import CONTROL, LONGEST_LINE, named, numbers
from hostile.damaged_npz import HEADERS, damaged_bytes, damaged_npz, npy, with_header

import shakedown
from shakedown import Problem, ProblemError

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
