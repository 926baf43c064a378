"""A problem is accepted as it should be, or refused with one line that says what, where, expected, found."""

import copy
import dataclasses
import io
import os
import pickle
import zipfile

import numpy as np
import pytest
from hostile.damaged_npz import with_header

import shakedown
from shakedown import Problem, ProblemError, load_problem, save_problem
from shakedown.joint.arguments import check_load_factor
from shakedown.joint.fields import in_range, printed_error
from shakedown.joint.problem import AXES


def valid() -> dict:
    """The arrays of a valid problem with every optional key."""
    return {
        "A": np.array([[3.0, 1.0], [1.0, 2.0]]),
        "B": np.array([[0.5, 0.2], [-0.1, 0.4]]),
        "C": np.array([[4.0, 0.5], [0.5, 3.0]]),
        "f": np.array([0.3, 0.4]),
        "q_w": np.arange(6.0).reshape(3, 2),
        "p_w": np.arange(6.0).reshape(3, 2) + 10,
        "q_mean": np.array([1.0, 2.0]),
        "p_mean": np.array([11.0, 12.0]),
        "q_transient": np.zeros((4, 2)),
        "p_transient": np.ones((4, 2)),
        "initial_slip": np.array([[0.1, 0.2], [0.3, 0.4], [0.5, 0.6]]),
        "x": np.array([0.0, 1.0]),
        "name": np.array("joint"),
        "units": np.array("N, mm"),
        "label": ("4711/12", "7" * 200),
        "coordinates": np.arange(6.0).reshape(2, 3),
        "normal": np.array([[0.0, 1.0, 0.0], [0.6, 0.8, 0.0]]),
        "node_area": np.array([0.5, 0.0]),
        "load_names": ("bolt", "traction"),
        "load_mean": np.array([12.0, 20.0]),
        "load_amplitude": np.array([0.0, 20.0]),
        "load_units": ("kN", "MPa"),
        "source": '{"files": [{"name": "k.mtx", "sha256": "0"}]}',
        "load_path": "domain",
    }


def written(path, **changes):
    """An NPZ file of the valid arrays with some replaced, or removed by None."""
    arrays = {key: value for key, value in {**valid(), **changes}.items() if value is not None}
    np.savez(path, **arrays)
    return path


def test_every_key_survives_the_round_trip(tmp_path):
    problem = load_problem(written(tmp_path / "in.npz"))
    save_problem(tmp_path / "out.npz", problem)
    again = load_problem(tmp_path / "out.npz")
    assert again == problem
    for key, value in valid().items():
        assert np.array_equal(getattr(again, key), value), key
    with np.load(tmp_path / "out.npz", allow_pickle=False) as file:
        assert str(file["schema"]) == "shakedown/1"


@pytest.mark.parametrize(
    "changes",
    [
        {"f": np.array(0.3)},
        {"C": None},
        {"q_w": np.ones((1, 2)), "p_w": np.ones((1, 2))},
        {"q_mean": None, "p_mean": None},
        {"q_mean": None},
        {"initial_slip": np.array([0.1, 0.2])},
        {"A": np.array([[3, 1], [1, 2]])},
        {"A": np.array([[3.0, 1.0], [1.0, 2.0]], dtype=np.float32)},
        {"A": np.array([[3.0, 1.0 + 1e-9], [1.0, 2.0]])},
        {"name": None, "units": None, "x": None},
        {"q_transient": None, "p_transient": None},
        {"A": np.ones((2, 2)), "B": np.zeros((2, 2)), "C": np.ones((2, 2))},  # floating
        {"f": np.zeros(2)},
    ],
    ids=str,
)
def test_accepted(tmp_path, changes):
    problem = load_problem(written(tmp_path / "p.npz", **changes))
    assert problem.f.shape == (2,)
    assert np.array_equal(problem.A, problem.A.T)
    assert problem.initial_slip is None or problem.initial_slip.ndim == 2


nan, inf = np.nan, np.inf
MALFORMED = {
    "missing A": ({"A": None}, "key 'A': required, found none"),
    "unknown key": ({"mu": np.array(0.3)}, "unknown key 'mu': did you mean 'f'?"),
    "two unknown keys": ({"mu": np.array(0.3), "K": np.eye(2)}, "unknown key 'K'; expected keys are A, B, C, "),
    "wrong schema": ({"schema": np.array("shakedown/99")}, "expected 'shakedown/1', found 'shakedown/99'"),
    "A not square": ({"A": np.ones((2, 3))}, "key 'A': expected a square array (n, n) of at least one contact node, found shape (2, 3)"),
    "C too small": ({"C": np.ones((1, 1))}, "key 'C': expected shape (2, 2)"),
    "q_w transposed": ({"q_w": np.ones((2, 3))}, "key 'q_w': expected shape (m, 2), found (2, 3)"),
    "p_w transposed": ({"p_w": np.ones((2, 3))}, "key 'p_w': expected shape (3, 2), found (2, 3)"),
    "no load step": ({"q_w": np.ones((0, 2)), "p_w": np.ones((0, 2))}, "at least one load step, found m = 0"),
    "no node": (
        {k: np.ones((0, 0)) for k in "ABC"}
        | {"f": np.ones(0), "q_w": np.ones((3, 0)), "p_w": np.ones((3, 0)), "x": None, "initial_slip": None}
        | dict.fromkeys(("q_mean", "p_mean", "q_transient", "p_transient")),
        "at least one contact node",
    ),
    "q_mean wrong length": ({"q_mean": np.ones(3)}, "key 'q_mean': expected shape (2,), found (3,)"),
    "only one transient": ({"p_transient": None}, "key 'p_transient': required because 'q_transient'"),
    "initial_slip wrong length": ({"initial_slip": np.ones(3)}, "key 'initial_slip': expected shape (s, 2) or (2,), found (3,)"),
    "A is text": ({"A": np.array([["3", "1"], ["1", "2"]])}, "key 'A': expected real numbers, found 2 × 2 of <U1"),
    "f is a word": ({"f": np.array("rough")}, "key 'f': expected real numbers, found one of <U5"),
    "A is complex": ({"A": np.eye(2) * 1j}, "found 2 × 2 of complex128"),
    "NaN in A": ({"A": np.array([[3.0, nan], [nan, 2.0]])}, "found nan at A[0][1]"),
    "inf in q_w": ({"q_w": np.array([[0.0, 1], [2, inf], [4, 5]])}, "found inf at q_w[1][1]"),
    "negative f": ({"f": np.array([0.0, -0.2])}, "friction coefficients >= 0, found -0.2 at node 1"),
    "A not symmetric": ({"A": np.array([[3.0, 1.0], [1.1, 2.0]])}, "A[0,1] = 1 but A[1,0] = 1.1"),
    "A indefinite": ({"A": np.diag([4.0, -2.0]), "C": None}, "key 'A': expected a positive semi-definite matrix, found the eigenvalue -2"),
    "kappa indefinite": ({"B": 10 * np.eye(2)}, "positive semi-definite, in one unit, found the eigenvalue"),
    "name a number": ({"name": np.array(3.0)}, "key 'name': expected one text string"),
}  # fmt: skip


def test_a_name_in_ragged_rows_is_no_text():
    with pytest.raises(ProblemError, match="key 'name': expected one text string, found"):
        Problem(A=[[1.0]], B=[[0.0]], f=0.5, q_w=[[0.0]], p_w=[[1.0]], name=[[1], [1, 2]])


def test_a_block_that_is_round_off_of_the_others_is_symmetric():
    """C = 0 by 1e-15: what asymmetry is, is judged by the whole stiffness; what is more than that, is refused."""
    loop = {"q_w": [[1.0, 0.5], [0.0, 0.2]], "p_w": [[3.0, 3.0]] * 2, "f": 0.4}
    A, noise = np.array([[2.0, 0.5], [0.5, 1.0]]), np.array([[1e-15, 3e-15], [-2e-15, 1e-15]])
    problem = Problem(A=A, B=np.zeros((2, 2)), C=noise, **loop)
    assert problem.C.tolist() == problem.C.T.tolist()
    assert Problem(A=1e6 * noise, B=np.zeros((2, 2)), C=1e6 * A, **loop).n == 2
    with pytest.raises(ProblemError, match="key 'C': expected a symmetric matrix"):
        Problem(A=A, B=np.zeros((2, 2)), C=1e5 * noise, **loop)


def test_what_the_digits_of_a_stiffness_leave_open_is_accepted():
    """Entries off by a share of themselves move an eigenvalue by that share of the row sum, here 20."""
    assert printed_error(np.array([[1.2345, 2.3456], [4.5678, 12.3456]])) == pytest.approx(5e-6)
    A, loads = np.ones((20, 20)) - 0.01 * np.eye(20), {"q_w": np.ones((1, 20)), "p_w": np.ones((1, 20))}
    assert Problem(A=A, B=0 * A, f=0.5, **loads, stiffness_accuracy=1e-3).n == 20
    for a, accuracy, found in ((A, 1e-4, -0.01), (-np.eye(1), 1e-4, -1)):
        one = {key: value[:, : len(a)] for key, value in loads.items()}
        with pytest.raises(ProblemError, match=f"semi-definite matrix, found the eigenvalue {found}$"):
            Problem(A=a, B=0 * a, f=0.5, **one, stiffness_accuracy=accuracy)


@pytest.mark.parametrize("size", [1e-100, 2.0**-40, 1e100])
def test_what_is_negligible_is_a_share_of_the_largest_entry_up_to_the_limits(size):
    found = in_range("A", size * np.array([1.0, -2e-30, 5e-31]))
    assert found.tolist() == [size, size * -2e-30, 0.0]
    for beyond in (0.999e-100, 1.001e100):
        with pytest.raises(ProblemError, match="the largest magnitude to be 0 or between 1e-100"):
            in_range("A", np.array([0.0, -beyond]))


@pytest.mark.parametrize(("key", "most"), [("f", 1e12), ("q_w", 1e75), ("initial_slip", 1e100)])
def test_largest_values_may_be_there_but_no_larger_ones(key, most):
    joint = {"A": np.ones((1, 1)), "B": np.zeros((1, 1)), "q_w": np.zeros((1, 1)), "p_w": np.zeros((1, 1))}
    least = 1e-75 if key == "q_w" else 0.0
    for size in (most, 1.001 * least):
        assert Problem(**{"f": 0.5, **joint, key: np.full((1, 1)[key == "f" :], size)}).n == 1
    for size in (1.001 * most, *[0.999 * least] * (least > 0)):
        with pytest.raises(ProblemError, match=r"expected .* (up to|between|below) "):
            Problem(**{"f": 0.5, **joint, key: np.full((1, 1)[key == "f" :], size)})
    check_load_factor(1e25, Problem(**{"f": 0.5, **joint, "q_w": [[1e75]]}))  # reactions of 1e100, the most


@pytest.mark.parametrize("size", [1e-20, 1.0, 1e20])
def test_a_compliance_is_judged_by_its_own_size(size):
    acting = {"load_reactions": [[1.0, 0.0], [0.0, 0.0]], "load_history": [[1.0, 0.0], [-1.0, 0.0]]}
    joint = {"A": [[2.0]], "B": [[0.0]], "f": 0.5, "q_w": [[1.0], [-1.0]], "p_w": [[3.0], [3.0]]} | acting
    much, more = 1 + 9e-7, 1 + 2e-6  # six printed digits
    for fitting in ([[1, much], [much, 1]], [[-1, much], [much, -1]], np.diag([1.0, -1.0]), np.zeros((2, 2))):
        assert Problem(**joint, load_compliance=size * np.array(fitting)).n == 1
    skew, *less = [[1.0, 0.5], [0.6, 1.0]], [[1.0, more], [more, 1.0]], [[-1.0, more], [more, -1.0]]
    for entries, message in ((skew, "a symmetric"), *((each, "stored energy >= 0") for each in less)):
        with pytest.raises(ProblemError, match=f"key 'load_compliance': expected {message}"):
            Problem(**joint, load_compliance=size * np.array(entries))


def refused_with_its_name(path):
    """The one line that says why."""
    with pytest.raises(ProblemError) as caught:
        load_problem(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize("kind", MALFORMED)
def test_refused(tmp_path, kind):
    changes, message = MALFORMED[kind]
    assert message in refused_with_its_name(written(tmp_path / "bad.npz", **changes))


@pytest.mark.parametrize("value", [nan, inf, -inf])
@pytest.mark.parametrize("key", AXES)
def test_one_number_that_is_none_is_refused_for_every_key(tmp_path, key, value):
    """Without axes, as NumPy stores a single number; the line names the key, or one that it needs."""
    assert f"'{key}'" in refused_with_its_name(written(tmp_path / "bad.npz", **{key: np.array(value)}))


def test_one_friction_coefficient_that_is_no_number_is_named(tmp_path):
    for value in (nan, inf):
        with pytest.raises(ProblemError, match=f"key 'f': expected finite numbers, found {value} at f$"):
            Problem(A=[[2.0]], B=[[0.5]], f=value, q_w=[[1.0]], p_w=[[3.0]])


@pytest.mark.parametrize("text", ["*NODE\n1, 0., 0.\n", "friction = 0.3\n[stiffness]\n"])
def test_a_deck_or_a_configuration_given_for_a_problem_file_leads_to_import(tmp_path, text):
    path = tmp_path / "joint.inp"
    path.write_text(text)
    with pytest.raises(ProblemError, match=r"an NPZ file, found another one .*`shakedown-bounds import "):
        load_problem(path)


def with_array(change):
    """The bytes of a file whose array A is changed, from those of a good one; an empty file without a change."""

    def changed(data):
        buffer = io.BytesIO()
        with zipfile.ZipFile(io.BytesIO(data)) as source, zipfile.ZipFile(buffer, "w") as archive:
            for name in source.namelist() if change else ():
                array = source.read(name)
                archive.writestr(name, change(array) if name == "A.npy" else array)
        return buffer.getvalue()

    return changed


def with_shape(shape):
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}"
    return with_array(lambda array: with_header(header, array[128:]))


DAMAGED = {  # the bytes of a file from those of a good one
    "cut in two": lambda data: data[: len(data) // 2],
    "text": lambda _: b"A B C\n1 2 3\n",
    "one array": lambda data: data[data.index(b"\x93NUMPY") :],
    "a wrong checksum": lambda data: bytes(byte ^ 0xFF * (k == 180) for k, byte in enumerate(data)),
    "empty": lambda _: b"",
    "an empty archive": with_array(None),
    "no array": with_array(lambda _: b"not an array"),
    "a claim of terabytes": with_shape((1000000, 1000000)),
    "a negative length": with_shape((-2, 2)),
    "code": with_array(lambda array: with_header("__import__('os').abort()", array[128:])),
    "an array cut short": with_array(lambda array: array[:-8]),
    "an unknown version": with_array(lambda array: array[:6] + b"\x09\x00" + array[8:]),
}


@pytest.mark.parametrize("kind", DAMAGED)
def test_a_damaged_file_is_refused(tmp_path, kind):
    path = written(tmp_path / "bad.npz")
    path.write_bytes(DAMAGED[kind](path.read_bytes()))
    refused_with_its_name(path)


def test_a_key_twice_a_folder_and_nothing_are_refused(tmp_path):
    with zipfile.ZipFile(written(tmp_path / "twice.npz"), "a") as archive:
        archive.writestr("A", archive.read("A.npy"))
    (tmp_path / "folder.npz").mkdir()
    for name in ("twice", "folder", "absent"):
        refused_with_its_name(tmp_path / f"{name}.npz")


def test_an_array_that_memory_cannot_hold_is_refused(tmp_path, monkeypatch):
    path = written(tmp_path / "big.npz", q_w=np.zeros((1000, 2)), p_w=np.zeros((1000, 2)))
    monkeypatch.setattr("shakedown.files.npz.memory", lambda assumed: 100_000)  # q_w alone would pass
    with pytest.raises(ProblemError, match=r"its arrays, .* bytes, are more than this machine can hold"):
        load_problem(path)


def test_pickled_objects_are_never_executed(tmp_path):
    class Bomb:
        def __reduce__(self):
            return os.abort, ()

    path = tmp_path / "bomb.npz"
    np.savez(path, A=np.array([[Bomb()]], dtype=object), B=[[0.0]], f=0.3, q_w=[[1.0]], p_w=[[1.0]])
    with pytest.raises(ProblemError, match="never unpickled"):
        load_problem(path)


def test_writing_where_there_is_no_folder_is_refused(tmp_path):
    with pytest.raises(ProblemError, match="cannot be written"):
        save_problem(tmp_path / "none" / "p.npz", shakedown.example("one-node"))


def test_a_problem_cannot_be_changed():
    problem = Problem(**valid())
    with pytest.raises(dataclasses.FrozenInstanceError):
        problem.f = 0.1
    for one in (problem, copy.copy(problem), copy.deepcopy(problem), pickle.loads(pickle.dumps(problem))):
        assert one == problem
        for array in (one.A, one.f, one.q_w, one.initial_slip, one.kappa):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 1.0


def test_the_caller_keeps_its_arrays():
    arrays = valid()
    Problem(**arrays)
    arrays["A"][0, 0] = 7.0


def test_replace_takes_a_scalar_and_follows_the_mean():
    problem = dataclasses.replace(shakedown.example("two-node"), f=0.2)
    assert problem.f.tolist() == [0.2, 0.2]


@pytest.mark.parametrize("name", shakedown.example_names())
def test_every_example_survives_the_round_trip(tmp_path, name):
    save_problem(tmp_path / "p.npz", shakedown.example(name))
    assert load_problem(tmp_path / "p.npz") == shakedown.example(name)


def test_a_transient_of_no_load_step_is_none():
    joint = shakedown.example("two-node")
    empty = dataclasses.replace(joint, q_transient=np.empty((0, 2)), p_transient=np.empty((0, 2)))
    assert empty.q_transient is None
    assert empty.p_transient is None
    assert empty == joint
    assert shakedown.assess(empty).proved_from_every_state == shakedown.assess(joint).proved_from_every_state


def test_a_tangent_along_the_normal_is_refused():
    up = np.tile([0.0, 0.0, 1.0], (2, 1))
    message = "'tangent': expected directions at right angles to each other and"
    with pytest.raises(ProblemError, match=message):
        dataclasses.replace(shakedown.example("two-node"), normal=up, tangent=up)
