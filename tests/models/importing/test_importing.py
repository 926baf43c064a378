"""Import: the CalculiX reference to round-off, every route to one problem, files of the codes, one thing wrong at a time."""

import re
import tomllib
from dataclasses import fields
from pathlib import Path
from shutil import copytree

import numpy as np
import pytest
import writers
from model_files import BLOCK, changed, refused_with
from scipy.linalg import block_diag

import shakedown
from shakedown import LoadCase, ProblemError, UsageError, condense, import_model
from shakedown.joint.constraints import with_initial_gap
from shakedown.models.importing.import_model import import_problem
from shakedown.models.importing.load_section import time_function
from shakedown.models.importing.templates import import_template, import_template_names, write_import_example
from shakedown.models.readers.nastran import pyyeti_module
from shakedown.models.readers.parsing import InputFiles
from shakedown.models.readers.toml_table import TomlTable


def test_the_calculix_reference_comes_back_to_round_off():
    made, reference = import_model(BLOCK / "import.toml"), shakedown.load_problem(BLOCK / "block.npz")
    assert made.format == "reactions to unit displacements"
    assert 1e-9 < made.static_run < 2e-6  # another run, printed with seven digits
    assert (made.condensation.zero_modes, made.notes) == (0, ())
    for field in fields(reference):
        found, expected = getattr(made.problem, field.name), getattr(reference, field.name)
        if isinstance(expected, np.ndarray):
            scale = np.abs(expected).max()
            np.testing.assert_allclose(found, expected, rtol=0, atol=4 * np.finfo(float).eps * scale)
        elif expected:  # the reference says nothing of where it comes from
            assert found == expected


# One small model, written in every format: two contact nodes, two interior nodes, one held node.
DOFS = [(node, d) for node in (11, 12, 21, 22, 31) for d in (1, 2)]
K = writers.symmetric_matrix(10, seed=3)
FORCE = [[21, 1, 3.0], [22, 2, -7.0]]
HEAD, HELD = "friction = 0.4\nsteps = 4\n", "[supports]\nfixed = [[31, 1], [31, 2]]\n"
TAIL = """
[contact]
nodes = [11, 12]
normal = [0.0, 1.0]
[supports]
fixed = [[31, 1], [31, 2]]
[[load]]
forces = [[21, 1, 3.0], [22, 2, -7.0]]
history = { constant = 1.0, harmonics = [{ order = 1, cos = 0.5 }, { order = 2, sin = 0.25 }] }
"""


def expected_problem():
    force = np.zeros(10)
    for node, direction, value in FORCE:
        force[DOFS.index((node, direction))] = value
    t = np.arange(4) / 4
    history = 1.0 + 0.5 * np.cos(2 * np.pi * t) + 0.25 * np.sin(4 * np.pi * t)
    return condense(K, DOFS, [11, 12], [0, 1], [LoadCase(history=history, force=force)], 0.4, fixed=[8, 9])


def write(folder, **files):
    for name, text in files.items():
        (folder / name.replace("__", ".")).write_text(text)
    return folder / "c.toml"


def configured(folder, stiffness, tail=TAIL, **files):
    return write(folder, c__toml=f"{HEAD}[stiffness]\n{stiffness}\n{tail}", **files)


STORED, ROWS = writers.calculix_storage(K, DOFS), writers.dof_map(DOFS)
ROUTES = {
    "abaqus": ('file = "k"', {"k": writers.abaqus_matrix(K, DOFS)}, 1e-14),
    "substructure": ('file = "k"', {"k": writers.abaqus_substructure(K, DOFS)}, 1e-12),
    "sti": ('file = "k.sti"', {"k__sti": STORED[0], "k__dof": STORED[1]}, 1e-12),
    "matrix market": ('file = "k"\nmap = "rows"', {"k": writers.matrix_market(K), "rows": ROWS}, 1e-15),
    "dmig": ('file = "k"\nmatrix = "KAAX"', {"k": writers.nastran_dmig(K, DOFS)}, 1e-8),
    "op4": ('file = "k"\nmap = "rows"', {"k": writers.nastran_op4(K), "rows": ROWS}, 1e-15),
    "scaled": ('file = "k"\nscale = 0.5', {"k": writers.abaqus_matrix(2 * K, DOFS)}, 1e-14),
}


@pytest.mark.parametrize("route", ROUTES)
def test_every_route_leads_to_the_same_problem(tmp_path, route):
    stiffness, files, digits = ROUTES[route]
    found, expected = import_problem(configured(tmp_path, stiffness, **files)), expected_problem()
    for key in ("A", "B", "C", "q_w", "p_w", "f"):
        scale = np.abs(getattr(expected, key)).max()
        np.testing.assert_allclose(
            getattr(found, key), getattr(expected, key), rtol=0, atol=20 * digits * scale
        )


def clamped_reactions():
    """What a static run with the contact clamped prints under the forces."""
    rows = [i for i, (node, _) in enumerate(DOFS) if node in (21, 22)]
    u = np.linalg.solve(K[np.ix_(rows, rows)], [3.0, 0.0, 0.0, -7.0])
    return (K[:4][:, rows] @ u).reshape(2, 2).tolist()


SAME_LOADS = {
    "clamped reactions": (f"forces = {FORCE}", f"reactions = {clamped_reactions()}"),
    "an Abaqus load file": (f"forces = {FORCE}", 'forces = { file = "load" }'),
    "zero displacements": (f"{HELD}[[load]]", "[[load]]\ndisplacements = [[31, 1, 0.0], [31, 2, 0.0]]"),
}


@pytest.mark.parametrize(("old", "new"), SAME_LOADS.values(), ids=SAME_LOADS)
def test_every_way_to_say_a_load_is_the_same_load(tmp_path, old, new):
    assert old in TAIL
    load = "** Assembled nodal loads\n*CLOAD, REAL\n21,1, 3.0\n22,2, -7.0\n"
    path = configured(
        tmp_path, 'file = "k"', TAIL.replace(old, new), k=writers.abaqus_matrix(K, DOFS), load=load
    )
    path.write_text(
        path.read_text().replace("friction = 0.4\n", "").replace("[contact]", "[contact]\nfriction = 0.4")
    )
    found = import_model(path)
    assert found.condensation.held == 2
    for key in ("q_w", "p_w", "f"):
        expected = getattr(expected_problem(), key)
        np.testing.assert_allclose(getattr(found.problem, key), expected, atol=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("friction = 0.4", "friction = -0.4", "key 'friction': expected coefficients >= 0, found -0.4"),
        ("steps = 4", "steps = 99999999999999", "expected 'steps' from 1"),
        ("normal = [0.0, 1.0]", "", "one of 'normal' and 'normals'"),
        ("normal = [0.0, 1.0]", "normal = [0.0, 1.0]\naxes = [1, 1]", "two of 1, 2, 3"),
        ("normal = [0.0, 1.0]", "normals = [[0.0, 1.0], [0.0, 1.0, 0.0]]", "a list of n x 2 numbers"),
        ("normal =", "directions = 1\nnormals = [[0,1,0],[0,1,0.5]]\n#", r"3 is 0 .*found \[0.0, 1.0, 0.5]"),
        ("normal = [0.0, 1.0]", "normal = [0, 1]\nsurface = 'S'", "found 'normal' and 'surface'"),
        ("[contact]", "[contact]\nthickness = 0", "'thickness': expected a number > 0 .*found 0$"),
        ("[[31, 1], [31, 2]]", "[[31, 7]]", "key 'fixed': expected a row for direction 7 of node 31"),
        ("[21, 1, 3.0]", "[99, 1, 3.0]", "key 'forces': expected a row for direction 1 of node 99"),
        ("[21, 1, 3.0]", "[21, 1, 1e308]", r"load \d: force: expected numbers below 1e\+150, found 1e"),
        ('file = "k"', 'file = "k"\nscale = -1', "'scale': expected a number > 0, found -1"),
        ("[stiffness]", "[stifness]", "expected the key 'stiffness' .*, found the unknown key 'stifness'"),
        ("[[load]]", "[load]", "key 'load': expected a list of tables"),
        ("history =", "histories =", "expected the key 'history'"),
        ("steps = 4", "steps = ", "expected a TOML file"),
    ],
)
def test_one_thing_wrong_in_the_configuration_is_named(tmp_path, old, new, message):
    path = configured(tmp_path, 'file = "k"', k=writers.abaqus_matrix(K, DOFS))
    refused_with(path, old, new, message)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("step = 2 }", "step = 3 }", "key 'step': expected 1 to 2, found 3"),
        ("[5, 2, ", "[4, 2, ", r"expected every \(node, direction\) once, found \(4, 2\) twice"),
        ('"check.dat"', '"stiffness.dat"', "a run of its own, found the file that the stiffness was"),
        ('"check.dat" }', '"check.dat", scale = -1.0 }', r"factor -1 \(wrong sign\)"),
        ("[5, 2, 0", "[50, 2, 0", "found node 50, direction 2"),
        ('reactions = { file = "check.dat" }', "", "expected the keys 'displacements' and 'reactions'"),
        ("nodes = [1, ", "nodes = [nan, ", "whole numbers"),
        ("nodes = [1, ", f"nodes = [{'9' * 400}, ", "whole numbers"),
        ("[1, 1, -0.05]", "[nan, 1, -0.05]", "expected a node"),
        ("[1, 1, -0.05]", "[1, 2.7, -0.05]", "whole direction"),
        ("[1, 1, -0.05]", f"[1, 1, {'9' * 400}]", "finite number"),
        ("order = 1, cos", "order = 1.5, cos", "key 'order': expected a whole number"),
        ("order = 1, cos", "order = -1, cos", "key 'order': expected a whole number"),
        ("normal = [0.0, 1.0]", "normal = [0.0, inf]", "key 'normal'"),
    ],
)
def test_one_thing_wrong_in_the_reference_is_named(tmp_path, old, new, message):
    refused_with(copytree(BLOCK, tmp_path / "block") / "import.toml", old, new, message)


def test_a_row_without_its_diagonal_is_named(tmp_path):
    torn = writers.abaqus_matrix(K * (1 - np.diag(np.eye(10)[4])), DOFS)
    with pytest.raises(ProblemError, match=r"none in 1 of 10 rows, first \(21, 1\); is the file cut off"):
        import_model(configured(tmp_path, 'file = "k"', k=torn))


def history_of(value, folder=Path()):
    return time_function(TomlTable({"history": value}, "load 1"), 4, InputFiles(folder))[0]


def test_time_functions(tmp_path):
    table = "# t, factor\n0, 1.0\n0.5, -2.0D0\n"
    assert history_of(2).tolist() == 2.0
    steady = TomlTable({"history": {"constant": 3.0, "harmonics": []}}, "load 1")
    assert time_function(steady, 1, InputFiles(tmp_path)) == ([3.0], ())
    assert history_of([1, 2.5]).tolist() == [1.0, 2.5]
    assert history_of({"points": [[0, 0], [0.5, 1], [1, 0]]}).tolist() == [0.0, 0.5, 1.0, 0.5]
    assert history_of({"points": [[0.25, 1], [0.75, 3]]}).tolist() == [2.0, 1.0, 2.0, 3.0]
    assert history_of({"points": [[0, 0], [1, 2]]}).tolist() == [0.0, 0.5, 1.0, 1.5]  # falls back at the end
    assert sampled(tmp_path, table, column=2).tolist() == [1.0, -2.0]
    for wrong, message in (
        ({"points": [[0.5, 1], [0.2, 0]]}, "in ascending order"),
        ({"points": [[0.5, 1, 2]]}, "n x 2 numbers"),
        ({"harmonics": [], "points": []}, "found 2"),
        ({"harmonics": [{"order": 1, "tan": 1}]}, "unknown key 'tan'"),
        ({"harmonics": [{"cos": True}]}, "expected a finite number, found True"),
        ("wave", "expected a finite number, found 'wave'"),
    ):
        with pytest.raises(ProblemError, match=message):
            history_of(wrong)


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
        f"gap = {gap.tolist()}\nx = {(plain.x + 7.0).tolist()}": (pairs,),
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
        np.testing.assert_allclose(found.x, plain.x + 7.0 * ("x = " in text), rtol=1e-14)
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
        ('gap = { nodes = [[1, 0.1]], file = "gap.csv" }', "one of the keys 'nodes' and 'file', found both"),
    ):
        with pytest.raises(ProblemError, match=message):
            import_problem(changed(punch, ("[contact]\n", f"[contact]\n{text}\n")))


def test_loads_with_a_range_make_a_domain(punch):
    wave, both = "history = {{ harmonics = [{{ order = 1, {} = 1.0 }}] }}", "range = [-1.0, 1.0]"
    found = import_problem(changed(punch, *((wave.format(name), both) for name in ("sin", "cos"))))
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


BOTH = [(node, d) for node in (1, 2, 3, 4, 101, 102, 103) for d in (1, 2)]


PAIRS = "[[1, 101], [2, 102]]"
TOUCHING = "1, 0, 0\n2, 1, 0\n3, 0, 7\n4, 1, 1\n101, 0, 0\n102, 1, 0\n103, 0, 7\n"


def of_blocks(folder, blocks, contact=f"pairs = {PAIRS}", nodes=""):
    """The import of a matrix of some blocks, each of a body; a deck of the nodes alone, or none."""
    model, K = '[model]\nfile = "deck"\n' * bool(nodes), block_diag(*blocks)
    tail = TAIL.replace(HELD, model).replace(str(FORCE), "[[3, 1, -2]]")
    files = {"k": writers.matrix_market(K), "rows": writers.dof_map(BOTH), "deck": f"*NODE\n{nodes}"}
    tail = tail.replace("nodes = [11, 12]", contact)
    return import_model(configured(folder, 'file = "k"\nmap = "rows"', tail, **files))


@pytest.mark.parametrize("nodes", ["", TOUCHING])
def test_nodes_of_two_bodies_at_one_place_are_named_where_places_are_known(tmp_path, nodes):
    """A body without a load of its own is not said to bear one, whether its moment is known or not."""
    made = of_blocks(tmp_path, (FIRST, SECOND), nodes=nodes)
    whats = "applied, first body", "contact, first body", "supports, first body", "supports, second body"
    assert tuple(part.what for part in made.loads[0].parts) == whats
    said = [text for text in made.warnings if "load" not in text]
    assert ["(1 times, first 3 and 103)" in text for text in said] == [True] * bool(nodes)


@pytest.mark.parametrize(
    ("sizes", "contact", "bodies"),
    [
        ((14,), f"pairs = {PAIRS}", {"body": 4}),
        ((8, 6), f"pairs = {PAIRS}", {"first body": 2, "second body": 2}),
        ((8, 6), "nodes = [1, 101]", {"body 1": 1, "body 2": 1}),
        ((8, 4, 2), f"pairs = {PAIRS}", {"body 1": 2, "body 2": 2, "body 3": 0}),
    ],
)
def test_bodies_are_called_by_how_many_there_are(tmp_path, sizes, contact, bodies):
    made = of_blocks(tmp_path, [writers.symmetric_matrix(size, seed=size) for size in sizes], contact)
    assert {body.name: body.contact_nodes for body in made.evidence.bodies} == bodies
    assert not any("body 3" in part.what for part in made.loads[0].parts)  # nothing acts on it


@pytest.mark.parametrize(("kind", "digits"), [("dat", 2e-6), ("csv", 1e-12)])
def test_two_bodies_by_reactions_equal_their_matrix(tmp_path, kind, digits):
    K, dofs = block_diag(FIRST, SECOND), BOTH
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


def sampled(folder, text, **words):
    """A history out of a file."""
    (folder / "h.csv").write_text(text)
    return history_of({"file": "h.csv", **words}, folder)


def test_a_history_with_times_is_resampled(tmp_path):
    text = "time;force\n10;0.0\n10.5;2.0\n11.5;-2.0\n12;0.0\n"
    for columns in ({"column": "force", "time": "time"}, {"time": "time"}, {"column": 2, "time": 1}):
        assert sampled(tmp_path, text, period=2.0, **columns).tolist() == [0.0, 2.0, 0.0, -2.0]
    open_loop = "t,f\n0,1\n1,3\n"  # closed from the last row to the first
    assert sampled(tmp_path, open_loop, time="t", period=2.0).tolist() == [1.0, 2.0, 3.0, 2.0]
    assert sampled(tmp_path, "1\n2\n3\n").tolist() == [1.0, 2.0, 3.0]


@pytest.mark.parametrize("period", [2.0, 0.5])
@pytest.mark.parametrize("eighths", [range(9), (0, 4, 4, 8), range(7)], ids=["whole", "a jump", "open"])
def test_a_record_is_the_points_of_its_period(tmp_path, period, eighths):
    points = [[k / 8, (-1.0) ** n * (n + 1)] for n, k in enumerate(eighths)]
    (tmp_path / "h.csv").write_text("t,f\n" + "".join(f"{7 + period * t},{f}\n" for t, f in points))
    histories = {"file": "h.csv", "column": "f", "time": "t", "period": period}, {"points": points}
    tables = [TomlTable({"history": history}, "load 1") for history in histories]
    (values, doubts), (known, doubted) = (time_function(table, 4, InputFiles(tmp_path)) for table in tables)
    assert (values.tolist(), doubts) == (known.tolist(), doubted)


@pytest.mark.parametrize(
    ("text", "words", "message"),
    [
        ("t,a,b\n0,1,2\n", {"time": "t", "period": 1.0}, "expected the key 'column' \\(one of t, a, b\\)"),
        ("t,a\n0,1\n", {"column": "c"}, "one column 'c', found 0"),
        ("t,a\n0,1\n", {"column": -1}, "found -1"),
        ("t,a\n0,1\n", {"column": 3}, "expected a column from 1 to 2, found 3"),
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
    K, P = writers.symmetric_matrix(6), np.arange(12.0).reshape(6, 2)
    op4 = pyyeti_module("op4", "the test").OP4()
    op4.write((tmp_path / "job.op4").as_posix(), {"kxx": K, "mxx": 2 * K, "one": P[:, :1], "px": P})
    (tmp_path / "job.pch").write_text(
        "EXTRN          3      12       9      12     101       0     102       0\n"
    )
    (tmp_path / "import.toml").write_text("""friction = 0.3
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
    for words, force in (('"PX", column = 2', P[:, 1]), ('"PX", column = 1', P[:, 0]), ('"ONE"', P[:, 0])):
        expected = condense(K, dofs, [3, 9], [0, 1], [LoadCase(history=1.0, force=2 * force)], 0.3)
        made = import_model(changed(tmp_path, ('"PX", column = 2', words)))
        np.testing.assert_array_equal(made.problem.p_w, expected.p_w)
        np.testing.assert_array_equal(made.problem.kappa, expected.kappa)
        assert set(made.sources) == {"changed.toml", "job.op4", "job.pch"}
    for old, new, message in (
        (", column = 2", "", "key 'column': expected 1 to 2, found none"),
        ("column = 2", "column = 3", "expected 1 to 2, found 3"),
        ("column = 2", "column = 0", "expected 1 to 2, found 0"),
        ('"PX"', '"PY"', "expected one matrix 'PY', found KXX, MXX, ONE, PX"),
    ):
        with pytest.raises(ProblemError, match=message):
            import_model(changed(tmp_path, (old, new)))
