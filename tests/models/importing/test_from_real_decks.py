"""Imports that take rows, sets, normals and histories from the codes' own files, and their evidence."""

import re
import tomllib

import numpy as np
import pytest
import writers
from model_files import changed
from scipy.linalg import block_diag

from shakedown import LoadCase, ProblemError, UsageError, condense, import_model
from shakedown.joint.constraints import with_initial_gap
from shakedown.models.importing.import_model import import_problem
from shakedown.models.importing.load_section import time_function
from shakedown.models.importing.templates import (
    import_template,
    import_template_names,
    write_import_example,
)
from shakedown.models.readers.parsing import InputFiles
from shakedown.models.readers.toml_table import TomlTable


@pytest.fixture
def punch(tmp_path):
    write_import_example(tmp_path)
    return tmp_path


def test_a_gap_and_an_interference(punch):
    plain = import_problem(punch / "import.toml")
    gap = 1e-3 * (plain.x - 2.0) ** 2 - 2e-4
    (punch / "gap.csv").write_text(
        "x;gap\n" + "".join(f"{x:.17g};{g:.17g}\n" for x, g in zip(plain.x, gap, strict=True))
    )
    pairs = ('pairs = ["PUNCH_FOOT", "BLOCK_TOP"]', f"pairs = {[[k, 1072 + k] for k in range(1, 10)]}")
    kinds = {
        f"gap = {gap.tolist()}": (pairs,),
        'gap = { file = "gap.csv", column = "gap" }': (pairs,),
        f"gap = {{ nodes = {[[1 + k, float(g)] for k, g in enumerate(gap)]} }}": (),
        f'gap = {{ nodes = [["PUNCH_FOOT", {gap[0]}]] }}': "even",
        'gap = "coordinates"\nnormal = [0, 2]': "moved",
    }
    moved = (punch / "punch.inp").read_text()
    for k, g in enumerate(gap):
        line = f"\n{k + 1}, {1.0 + 0.25 * k}, 1.0\n"
        assert line in moved
        moved = moved.replace(line, line.replace(", 1.0\n", f", {1.0 + float(g)!r}\n"))
    (punch / "moved.inp").write_text(moved)
    for text, kind in kinds.items():
        more = {"even": (), "moved": (('file = "punch.inp"', 'file = "moved.inp"'),)}.get(kind, kind)
        expected = with_initial_gap(plain, gap[0] if kind == "even" else gap)
        found = import_problem(changed(punch, *more, ("[contact]\n", f"[contact]\n{text}\n")))
        np.testing.assert_allclose(found.p_w, expected.p_w, rtol=0, atol=1e-9 * np.abs(expected.p_w).max())
        np.testing.assert_allclose(found.q_w, expected.q_w, rtol=0, atol=1e-9 * np.abs(expected.p_w).max())
    for text, message in (
        ("gap = [0.1]", "key 'gap': expected no list beside sets of nodes, .* found one of length 1"),
        ("gap = nan", "a finite number, found nan"),
        ('gap = "deck"', "key 'gap': expected 'coordinates', a number, a list or a table, found 'deck'"),
        ("gap = { nodes = [[17, 0.1]] }", "key 'gap': expected contact nodes, found node 17"),
        ('gap = { nodes = [["FOOT", 0.1]] }', "key 'nodes': .*FOOT"),
        ("gap = { nodes = [[1, 0.1], [1, 0.2]] }", "expected every node once, found node 1 twice"),
        ('gap = { nodes = [[1, "0.1"]] }', r"expected a finite number, found \[1, '0.1'\]"),
        ("gap = { nodes = [[1.5, 0.1]] }", r"or the name of a set., found 1.5"),
        (
            'gap = { nodes = [[1, 0.1]], file = "gap.csv" }',
            "expected one of the keys 'nodes' and 'file', found both",
        ),
    ):
        with pytest.raises(ProblemError, match=message):
            import_problem(changed(punch, ("[contact]\n", f"[contact]\n{text}\n")))


def test_loads_with_a_range_make_a_domain(punch):
    path = changed(
        punch,
        ("history = { harmonics = [{ order = 1, sin = 1.0 }] }", "range = [-1.0, 1.0]"),
        ("history = { harmonics = [{ order = 1, cos = 1.0 }] }", "range = [-1.0, 1.0]"),
    )
    found = import_problem(path)
    assert (found.m, found.load_path) == (4, "domain")


# Two bodies without a matrix: reactions of runs in which every contact node of both is held.
FIRST, SECOND = writers.symmetric_matrix(8, seed=1), writers.symmetric_matrix(6, seed=2)


def condensed(K):
    """Stiffness of the first four rows, and what a force on the others adds to their reactions."""
    return K[:4, :4] - K[:4, 4:] @ np.linalg.solve(K[4:, 4:], K[4:, :4]), K[:4, 4:] @ np.linalg.inv(K[4:, 4:])


def two_bodies(folder, kind):
    (k1, s1), (k2, _) = condensed(FIRST), condensed(SECOND)
    force = np.array([1.0, -2.0, 0.5, 3.0])
    held = s1 @ force  # reactions of the first body, its contact nodes held
    whole = block_diag(k1, k2)
    nodes = [1, 2, 101, 102]
    runs = [(nodes, np.column_stack([column.reshape(4, 2), np.zeros(4)])) for column in whole.T]
    load = [(nodes, np.column_stack([np.concatenate([held, np.zeros(4)]).reshape(4, 2), np.zeros(4)]))]
    if kind == "dat":
        (folder / "k").write_text(writers.calculix_reactions(runs))
        (folder / "p").write_text(writers.calculix_reactions(load))
    else:
        for name, steps in (("k", runs), ("p", load)):
            rows = [
                f"{k},{n},{f[0]:.17g},{f[1]:.17g}"
                for k, (labels, forces) in enumerate(steps, start=1)
                for n, f in zip(labels, forces, strict=True)
            ]
            (folder / name).write_text("\n".join(["step,node,fx,fy", *rows, ""]))
    (folder / "c.toml").write_text("""friction = 0.3
[stiffness]
file = "k"
[contact]
pairs = [[1, 101], [2, 102]]
normal = [0, 1]
[[load]]
reactions = { file = "p", step = 1, bodies = "clamped" }
history = 1
""")
    return folder / "c.toml"


@pytest.mark.parametrize(("kind", "digits"), [("dat", 2e-6), ("csv", 1e-12)])
def test_two_bodies_by_reactions_equal_their_matrix(tmp_path, kind, digits):
    K = block_diag(FIRST, SECOND)
    labels = [1, 2, 3, 4, 101, 102, 103]
    dofs = [(node, d) for node in labels for d in (1, 2)]
    force = np.zeros(14)
    force[4:8] = [1.0, -2.0, 0.5, 3.0]
    expected = condense(K, dofs, [[1, 101], [2, 102]], [0, 1], [LoadCase(history=1.0, force=force)], 0.3)
    found = import_problem(two_bodies(tmp_path, kind))
    for key in ("A", "B", "C", "q_w", "p_w"):
        scale = np.abs(expected.kappa).max() if key in "ABC" else np.abs(expected.p_w).max()
        np.testing.assert_allclose(getattr(found, key), getattr(expected, key), rtol=0, atol=digits * scale)


def test_reactions_of_two_bodies_must_say_how_they_were_held(tmp_path):
    path = two_bodies(tmp_path, "csv")
    for word in ("", ', bodies = "free"'):
        path.write_text(re.sub(', bodies = "[a-z]*"', word, path.read_text(), count=1))
        with pytest.raises(ProblemError, match="bodies"):
            import_problem(path)
        two_bodies(tmp_path, "csv")


def sampled(folder, text, steps=4, **words):
    """A history out of a file."""
    (folder / "h.csv").write_text(text)
    table = TomlTable({"history": {"file": "h.csv", **words}}, "load 1")
    return time_function(table, steps, InputFiles(folder))[0]


def test_a_history_with_times_is_resampled(tmp_path):
    text = "time;force\n" + "".join(
        f"{t:g};{v}\n" for t, v in ((10.0, 0.0), (10.5, 2.0), (11.5, -2.0), (12.0, 0.0))
    )
    expected = [0.0, 2.0, 0.0, -2.0]
    assert sampled(tmp_path, text, column="force", time="time", period=2.0).tolist() == expected
    assert sampled(tmp_path, text, time="time", period=2.0).tolist() == expected  # the other column
    whole = TomlTable({"history": {"file": "h.csv", "time": "time", "period": 2.0}}, "load 1")
    assert time_function(whole, 4, InputFiles(tmp_path))[1] == ()  # the record covers its period
    assert sampled(tmp_path, text, column=2, time=1, period=2.0).tolist() == [0.0, 2.0, 0.0, -2.0]
    open_loop = "t,f\n0,1\n1,3\n"  # closed from the last row to the first
    assert sampled(tmp_path, open_loop, time="t", period=2.0).tolist() == [1.0, 2.0, 3.0, 2.0]
    assert sampled(tmp_path, "1\n2\n3\n").tolist() == [1.0, 2.0, 3.0]


@pytest.mark.parametrize(
    ("text", "words", "message"),
    [
        ("t,a,b\n0,1,2\n", {"time": "t", "period": 1.0}, "expected the key 'column' \\(one of t, a, b\\)"),
        ("t,a\n0,1\n", {"column": "c"}, "one column 'c', found 0"),
        ("t,a\n0,1\n", {"column": -1}, "found -1"),
        ("t,a\n0,1\n", {"column": "a", "period": 1.0}, "'time' and 'period' together"),
        ("t,a\n1,1\n0,1\n", {"column": "a", "time": "t", "period": 1.0}, "times in ascending order"),
        ("t,a\n0,1\n3,1\n", {"column": "a", "time": "t", "period": 1.0}, "within one period of 1"),
        ("t,a\nnan,1\n3,1\n", {"column": "a", "time": "t", "period": 1.0}, "expected a number, found 'nan'"),
    ],
)
def test_an_unclear_history_is_refused(tmp_path, text, words, message):
    with pytest.raises(ProblemError, match=message):
        sampled(tmp_path, text, **words)


@pytest.mark.parametrize("kind", import_template_names())
def test_every_template_reads_up_to_its_first_file(tmp_path, kind):
    """Nothing in it is unknown: every key is taken before the files are missed, comments included."""
    text = import_template(kind)
    (tmp_path / "c.toml").write_text(text)
    with pytest.raises(ProblemError, match="no such file"):
        import_model(tmp_path / "c.toml")
    for line in text.splitlines():
        assert len(line) < 112
        if match := re.match(r"# (\w+) = ", line):
            tomllib.loads(line[2:])
            assert f"[{match[1]}]" in import_model.__doc__ or f"{match[1]} " in import_model.__doc__


def test_an_unknown_template_is_named():
    with pytest.raises(UsageError, match="expected one of abaqus, ansys, calculix, nastran, reactions"):
        import_template("ideas")


def test_output4_brings_rows_and_loads(tmp_path):
    """The map is found beside the matrix; a load is a column of another matrix of the file."""
    from shakedown.models.readers.nastran import pyyeti_module

    K, P = writers.symmetric_matrix(6), np.arange(12.0).reshape(6, 2)
    op4 = pyyeti_module("op4", "the test").OP4()
    op4.write((tmp_path / "job.op4").as_posix(), {"kxx": K, "mxx": 2 * K, "px": P})
    (tmp_path / "job.pch").write_text(
        "EXTRN          3      12       9      12     101       0     102       0\n"
    )
    (tmp_path / "c.toml").write_text("""friction = 0.3
[stiffness]
file = "job.op4"
[contact]
nodes = [3, 9]
normal = [0, 1]
[[load]]
forces = { file = "job.op4", matrix = "PX", column = 2, scale = 2.0 }
history = 1
""")
    dofs = [(3, 1), (3, 2), (9, 1), (9, 2), (101, 0), (102, 0)]
    expected = condense(K, dofs, [3, 9], [0, 1], [LoadCase(history=1.0, force=2 * P[:, 1])], 0.3)
    made = import_model(tmp_path / "c.toml")
    np.testing.assert_array_equal(made.problem.p_w, expected.p_w)
    np.testing.assert_array_equal(made.problem.kappa, expected.kappa)
    assert set(made.sources) == {"c.toml", "job.op4", "job.pch"}
    for old, new, message in (
        (", column = 2", "", "key 'column': expected 1 to 2, found none"),
        ("column = 2", "column = 3", "expected 1 to 2, found 3"),
        ('"PX"', '"PY"', "expected one matrix 'PY', found KXX, MXX, PX"),
    ):
        text = (tmp_path / "c.toml").read_text()
        (tmp_path / "d.toml").write_text(text.replace(old, new, 1))
        with pytest.raises(ProblemError, match=message):
            import_model(tmp_path / "d.toml")
