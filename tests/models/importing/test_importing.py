"""Import: the CalculiX reference to round-off, every route to one problem, and one thing wrong at a time."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
import writers
from bodies import pair
from model_files import BLOCK
from scipy import sparse
from scipy.linalg import block_diag

import shakedown
from shakedown import LoadCase, ProblemError, condense, import_model
from shakedown.fem import ElasticBody, Material, Support, block_mesh
from shakedown.models.condensation.condense import condensed_stiffness
from shakedown.models.importing.import_model import import_problem
from shakedown.models.importing.load_section import time_function
from shakedown.models.readers.text import InputFiles
from shakedown.models.readers.toml_table import TomlTable


def test_the_calculix_reference_comes_back_to_round_off():
    problem, reference = import_problem(BLOCK / "import.toml"), shakedown.load_problem(BLOCK / "block.npz")
    for field in fields(reference):
        found, expected = getattr(problem, field.name), getattr(reference, field.name)
        if isinstance(expected, np.ndarray):
            scale = np.abs(expected).max()
            np.testing.assert_allclose(found, expected, rtol=0, atol=4 * np.finfo(float).eps * scale)
        elif expected:  # the reference says nothing of where it comes from
            assert found == expected


def test_the_reference_carries_its_evidence():
    made = import_model(BLOCK / "import.toml")
    assert made.format == "reactions to unit displacements"
    assert 1e-9 < made.static_run < 2e-6  # another run, printed with seven digits
    assert made.condensation.zero_modes == 0
    assert made.notes == ()


def test_the_reference_has_the_known_load_factors():
    """Known for this block: 4.715032 at f = 0.5; 1.730955 and 1.219830 at f = 0.2."""
    problem = import_problem(BLOCK / "import.toml")
    assert shakedown.upper_bound(problem).load_factor == pytest.approx(4.715032, abs=1e-6)
    smooth = replace(problem, f=np.array(0.2))
    assert shakedown.upper_bound(smooth).load_factor == pytest.approx(1.730955, abs=1e-6)
    assert shakedown.lower_bound(smooth).load_factor == pytest.approx(1.219830, abs=1e-6)


# One small model, written in every format: two contact nodes, two interior nodes, one held node.
DOFS = [(node, d) for node in (11, 12, 21, 22, 31) for d in (1, 2)]
K = writers.symmetric_matrix(10, seed=3)
FORCE = [[21, 1, 3.0], [22, 2, -7.0]]
HEAD = "friction = 0.4\nsteps = 4\n"
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


ROUTES = {
    "abaqus": ('file = "k"', {"k": writers.abaqus_matrix(K, DOFS)}, 1e-14),
    "substructure": ('file = "k"', {"k": writers.abaqus_substructure(K, DOFS)}, 1e-12),
    "sti": (
        'file = "k.sti"',
        dict(zip(("k__sti", "k__dof"), writers.calculix_storage(K, DOFS), strict=True)),
        1e-12,
    ),
    "matrix market": (
        'file = "k"\nmap = "rows"',
        {"k": writers.matrix_market(K), "rows": writers.dof_map(DOFS)},
        1e-15,
    ),
    "dmig": ('file = "k"\nmatrix = "KAAX"', {"k": writers.nastran_dmig(K, DOFS)}, 1e-8),
    "op4": ('file = "k"\nmap = "rows"', {"k": writers.nastran_op4(K), "rows": writers.dof_map(DOFS)}, 1e-15),
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


def test_clamped_reactions_and_forces_are_the_same_load(tmp_path):
    """A static run with the contact clamped gives what the force itself gives."""
    rows = [i for i, (node, _) in enumerate(DOFS) if node in (21, 22)]
    force = np.array([3.0, 0.0, 0.0, -7.0])
    u = np.linalg.solve(K[np.ix_(rows, rows)], force)
    reaction = (K[:4][:, rows] @ u).reshape(2, 2)
    tail = TAIL.replace("forces = [[21, 1, 3.0], [22, 2, -7.0]]", f"reactions = {reaction.tolist()}")
    found = import_problem(configured(tmp_path, 'file = "k"', tail, k=writers.abaqus_matrix(K, DOFS)))
    np.testing.assert_allclose(found.p_w, expected_problem().p_w, atol=1e-12)


def test_forces_come_from_an_abaqus_load_file(tmp_path):
    tail = TAIL.replace("[[21, 1, 3.0], [22, 2, -7.0]]", '{ file = "load" }')
    load = "** Assembled nodal loads\n*CLOAD, REAL\n21,1, 3.0\n22,2, -7.0\n"
    path = configured(tmp_path, 'file = "k"', tail, k=writers.abaqus_matrix(K, DOFS), load=load)
    np.testing.assert_allclose(import_problem(path).q_w, expected_problem().q_w, atol=1e-13)


def test_a_prescribed_displacement_of_zero_holds_its_row(tmp_path):
    tail = TAIL.replace("[supports]\nfixed = [[31, 1], [31, 2]]\n", "").replace(
        "[[load]]", "[[load]]\ndisplacements = [[31, 1, 0.0], [31, 2, 0.0]]"
    )
    found = import_model(configured(tmp_path, 'file = "k"', tail, k=writers.abaqus_matrix(K, DOFS)))
    assert found.condensation.held == 2
    np.testing.assert_allclose(found.problem.q_w, expected_problem().q_w, atol=1e-13)


def test_two_bodies_by_pairs(tmp_path):
    both = block_diag(K, 2 * K)
    dofs = [*DOFS, *((node + 100, d) for node, d in DOFS)]
    tail = TAIL.replace("nodes = [11, 12]", "pairs = [[11, 111], [12, 112]]")
    found = import_problem(configured(tmp_path, 'file = "k"', tail, k=writers.abaqus_matrix(both, dofs)))
    first = condensed_stiffness(K, DOFS, [11, 12], [0, 1], fixed=[8, 9]).stiffness
    second = condensed_stiffness(2 * K, DOFS, [11, 12], [0, 1]).stiffness
    expected = np.linalg.inv(np.linalg.inv(first) + np.linalg.inv(second))
    np.testing.assert_allclose(found.kappa, expected, atol=1e-10 * np.abs(expected).max())


def test_two_bodies_out_of_one_abaqus_matrix(tmp_path):
    """Two blocks as Abaqus writes them, 1e36 on held rows, against the same blocks in scikit-fem."""
    steel = Material(200e3, 0.3)
    upper = ElasticBody(block_mesh(2.0, 1.0, 8, 4), steel)
    lower = ElasticBody(block_mesh(2.0, 1.0, 8, 2, origin=(0.0, -1.0)), steel, supports=[Support("bottom")])
    both = sparse.block_diag([upper.stiffness, lower.stiffness]).toarray()
    dofs = np.vstack([upper.dofs + np.array([1, 0]), lower.dofs + np.array([1001, 0])])
    first = len(upper.dofs)
    held = first + lower.held_rows()
    both[held, held] = 1e36
    top = upper.dofs[upper.rows_on("top", 1), 0] + 1
    pairs = np.column_stack([upper.normals_on("bottom")[0] + 1, lower.normals_on("top")[0][::-1] + 1001])
    moved = {axis: [[int(n), 1, 2e-4 * (axis == 1)] for n in top] for axis in (1, 2)}
    moved = {axis: [*rows, *([r[0], 2, -1e-3 * (axis == 2)] for r in rows)] for axis, rows in moved.items()}
    config = f"""friction = 0.3
steps = 12
[stiffness]
file = "job_STIF2.mtx"
[contact]
pairs = {pairs.tolist()}
normal = [0, 1]
[[load]]
displacements = {moved[2]}
history = 1
[[load]]
displacements = {moved[1]}
history = {{ harmonics = [{{ sin = 1.0 }}] }}
"""
    made = import_model(write(tmp_path, c__toml=config, job_STIF2__mtx=writers.abaqus_matrix(both, dofs)))
    expected = pair(4)
    for key in ("A", "B", "C", "q_w", "p_w"):
        scale = np.abs(expected.kappa).max() if key in "ABC" else np.abs(expected.p_w).max()
        np.testing.assert_allclose(getattr(made.problem, key), getattr(expected, key), atol=1e-11 * scale)
    assert "18 rows carry 1e36" in made.notes[0]


def test_a_load_that_opens_the_contact_is_noted(tmp_path):
    path = configured(
        tmp_path, 'file = "k"', TAIL.replace("[0.0, 1.0]", "[0.0, -1.0]"), k=writers.abaqus_matrix(K, DOFS)
    )
    down = import_model(path)
    up = import_model(configured(tmp_path, 'file = "k"'))
    assert ["no mean load presses" in " ".join(made.warnings) for made in (down, up)] == [
        False,
        True,
    ]
    assert up.problem.warnings == up.warnings


def solid(tmp_path, **more):
    """The two contact nodes as those of a solid model, whose slip is along x and whose normal is z."""
    dofs = [(node, d) for node in (11, 12, 21) for d in (1, 2, 3)]
    matrix = writers.abaqus_matrix(writers.symmetric_matrix(9, seed=3), dofs)
    text = TAIL.replace("[0.0, 1.0]", "[0.0, 0.0, 1.0]\naxes = [1, 3]")
    text = text.replace("[[31, 1], [31, 2]]", "[[11, 2], [12, 2]]").replace(", [22, 2, -7.0]", "")
    for old, new in more.items():
        assert old in text
        text = text.replace(old, new)
    return configured(tmp_path, 'file = "k"', text, k=matrix)


def test_friction_across_the_plane_is_said_to_be_left_out(tmp_path):
    left_out = "friction across the plane of slip and normal is left out"
    held = import_model(solid(tmp_path))
    assert f"direction 2 of the contact nodes is held: {left_out}" in held.notes
    np.testing.assert_array_equal(held.problem.normal, [[0.0, 0.0, 1.0]] * 2)
    free = import_model(
        solid(
            tmp_path,
            **{"axes = [1, 3]": "axes = [1, 3]\nfree_out_of_plane = true", "[11, 2], [12, 2]": "[21, 2]"},
        )
    )
    assert f"direction 2 of the contact nodes moves without friction: {left_out}" in free.notes
    plane = import_model(configured(tmp_path, 'file = "k"', k=writers.abaqus_matrix(K, DOFS)))
    assert not any("left out" in note for note in plane.notes)


def test_a_solid_whose_deck_holds_the_third_direction_says_so_too(tmp_path):
    """The matrix then has no rows across the plane, but the deck has solids at the contact."""
    nodes = [(11, 0, 0, 0), (12, 1, 0, 0), (21, 0, 1, 0), (22, 1, 1, 0)]
    nodes += [(31 if label == 11 else label + 50, x, y, 1) for label, x, y, _ in nodes]
    listed = "".join(f"{n}, {x}, {y}, {z}\n" for n, x, y, z in nodes)
    element = "*ELEMENT, TYPE=C3D8\n1, 11, 12, 22, 21, 31, 62, 72, 71\n"
    matrix = writers.abaqus_matrix(K, DOFS)
    for kind, expected in (("C3D8", True), ("CPE8", False)):
        deck = f"*NODE\n{listed}{element.replace('C3D8', kind)}"
        tail = TAIL + '[model]\nfile = "deck"\n'
        notes = import_model(configured(tmp_path, 'file = "k"', tail, k=matrix, deck=deck)).notes
        assert (
            any("direction 3 of the contact nodes has no rows in the matrix" in n for n in notes) == expected
        )


@pytest.mark.parametrize("kept", [0.97, 0.8, 0.5])
@pytest.mark.parametrize("kind", ["abaqus", "sti", "dmig"])
def test_a_matrix_that_was_cut_off_is_refused(tmp_path, kind, kept):
    """Of formats that do not say how many entries they have; whole lines are missing at the end."""
    texts = {
        "abaqus": ("k", writers.abaqus_matrix(K, DOFS)),
        "sti": ("k.sti", writers.calculix_storage(K, DOFS)[0]),
        "dmig": ("k", writers.nastran_dmig(K, DOFS)),
    }
    name, text = texts[kind]
    lines = text.splitlines(keepends=True)
    (tmp_path / "k.dof").write_text(writers.calculix_storage(K, DOFS)[1])
    (tmp_path / name).write_text(text)
    path = configured(tmp_path, f'file = "{name}"')
    import_model(path)
    (tmp_path / name).write_text("".join(lines[: int(kept * len(lines))]))
    with pytest.raises(
        ProblemError,
        match=r"on the diagonal of every row, found none .* is the file cut off|expected a row for",
    ):
        import_model(path)


def test_an_interior_that_can_move_is_named_with_its_motion(tmp_path):
    """Without its support the model floats in both directions; places tell turning."""
    chain = np.zeros((10, 10))
    for a, b in ((0, 4), (2, 6)):  # contact nodes on springs to nodes 21 and 22; node 31 held by nothing
        for d in (0, 1):
            chain[np.ix_([a + d, b + d], [a + d, b + d])] += [[1, -1], [-1, 1]]
    chain[8, 8] = chain[9, 9] = 0.0
    chain[8:, 8:] = [[1.0, 1.0], [1.0, 1.0]]
    tail = TAIL.replace("[supports]\nfixed = [[31, 1], [31, 2]]\n", "")
    path = configured(tmp_path, 'file = "k"', tail, k=writers.abaqus_matrix(chain, DOFS))
    with pytest.raises(
        ProblemError, match=r"c.toml: K: .* can move: node 31 in 1 other way.*node 31 in direction"
    ):
        import_model(path)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("friction = 0.4", "", "expected the key 'friction'"),
        ("friction = 0.4", "friction = 'rough'", "key 'friction': expected a finite number, found 'rough'"),
        ("friction = 0.4", "friction = inf", "key 'friction': expected a finite number, found inf"),
        ("friction = 0.4", "friction = [0.4]", "key 'friction': expected one for each of 2 nodes, found 1"),
        ("friction = 0.4", "friction = -0.4", "key 'friction': expected coefficients >= 0, found -0.4"),
        ("steps = 4", "", "expected 'steps' from 1 to 1000000 .* found none"),
        ("steps = 4", "steps = 99999999999999", "expected 'steps' from 1"),
        ("steps = 4", "step = 4", "unknown key 'step'; expected keys are .*steps"),
        ("[0.0, 1.0]", "[0.0, 0.0]", "length > 0"),
        ("normal = [0.0, 1.0]", "normal = [0, 0, 0]", r"length > 0 and < inf, found \[0.0, 0.0, 0.0\]"),
        ("[0.0, 1.0]", "[1e308, 1e308]", "length > 0"),
        ("nodes = [11, 12]", "nodes = [11, 13]", r"found none for 2 of 4, first .* \(13, 1\)"),
        ("nodes = [11, 12]", "nodes = [11, 12.5]", "key 'nodes': expected a list of n whole numbers"),
        ("nodes = [11, 12]", "", "one of the keys 'nodes', 'pairs' and 'surfaces', found neither"),
        ("normal = [0.0, 1.0]", "", "one of 'normal' and 'normals'"),
        ("normal = [0.0, 1.0]", "normal = [0.0, 1.0]\naxes = [1, 1]", "two of 1, 2, 3"),
        (
            "normal = [0.0, 1.0]",
            "normal = [0.0, 0.0, 1.0]",
            r"a row for every contact node in directions 1, 2 and 3, found none for 2 of 6, first \(node, "
            r"direction\) \(11, 3\), .* of a plane problem the normals have two components",
        ),
        (
            "normal = [0.0, 1.0]",
            "directions = 1\nnormal = [0.0, 0.0, 1.0]",
            r"2 numbers, along directions 1 and 2, or 3 of which that in direction 3 is 0, found \[0.0, 0.0, 1.0\]; "
            r"of a solid model, 'axes' names .* third one is held \(\[supports\] fixed\)",
        ),
        ("normal = [0.0, 1.0]", "normals = [[0.0, 1.0], [0.0, 1.0, 0.0]]", "a list of n x 2 numbers"),
        ("normal = [0.0, 1.0]", "normal = [0, 1]\nsurface = 'S'", "found 'normal' and 'surface'"),
        (
            "nodes = [11, 12]",
            "nodes = [11, 12]\npairs = [[11, 12]]",
            "'nodes', 'pairs' and 'surfaces', found both",
        ),
        (
            "nodes = [11, 12]",
            "nodes = 'CONTACT'",
            r"a deck that names sets, found 'CONTACT' and no \[model\]",
        ),
        (
            "fixed = [[31, 1], [31, 2]]",
            "fixed = [[31, 1], [31, 2], [11, 2]]",
            r"c.toml: contact: expected free contact nodes, found direction 2 of node 11 held",
        ),
        (
            "fixed = [[31, 1], [31, 2]]",
            "fixed = [[31, 7]]",
            "key 'fixed': expected a row for direction 7 of node 31",
        ),
        ("[21, 1, 3.0]", "[99, 1, 3.0]", "key 'forces': expected a row for direction 1 of node 99"),
        (
            "[21, 1, 3.0]",
            "[21, 1, 1e308]",
            r"c.toml: load \d: key 'forces': expected numbers below 1e\+150, found 1e\+308",
        ),
        ("harmonics", "harmonic", "expected one of harmonics, points and file"),
        ('file = "k"', 'file = "absent"', "absent: no such file"),
        ('file = "k"', 'file = "k"\nscale = -1', "'scale' > 0 .* found 'scale' = -1"),
        ('file = "k"', 'file = "k"\nmap = "k"', "expected no map file"),
        ('file = "k"', 'file = "k"\nmatrix = "KAAX"', "expected no matrix name"),
        ("[stiffness]", "[stifness]", "expected the key 'stiffness' .*, found the unknown key 'stifness'"),
        (
            "friction = 0.4",
            "frictoin = 0.4",
            "expected the key 'friction' .*, found the unknown key 'frictoin'",
        ),
        ("[[load]]", "[load]", "key 'load': expected a list of tables"),
        ("history =", "histories =", "expected the key 'history'"),
        ("steps = 4", "steps = ", "expected a TOML file"),
        (
            "steps = 4",
            "steps 4",
            r"expected a TOML file, found Expected '=' after a key .* \(at line \d+, column \d+\)",
        ),
    ],
)
def test_one_thing_wrong_in_the_configuration_is_named(tmp_path, old, new, message):
    path = configured(tmp_path, 'file = "k"', k=writers.abaqus_matrix(K, DOFS))
    text = path.read_text()
    assert text.count(old) >= 1
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(ProblemError, match=message):
        import_problem(path)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"node-by-node"', '"direction-by-direction"', "the steps go the other way"),
        ('"node-by-node"', '"sideways"', "expected 'node-by-node' or"),
        ("nodes = [1, 2, 3, 4, 5, 6, 7, 8, 9]", "nodes = [1, 2, 3, 4, 5, 6, 7, 8]", "expected 16 steps"),
        ("nodes = [1, 2, 3, 4, 5, 6, 7, 8, 9]", "nodes = [1, 2, 3, 4, 5, 6, 7, 8, 10]", "contact node 10"),
        ("step = 2 }", "step = 3 }", "key 'step': expected 1 to 2, found 3"),
        ("[5, 2, ", "[4, 2, ", r"expected every \(node, direction\) once, found \(4, 2\) twice"),
        ("[5, 2, 0.4375]", "[5, 2, 0.3]", "expected the reactions of the condensed stiffness"),
        (
            '"check.dat"',
            '"stiffness.dat"',
            "a run of its own, found the file that the stiffness was made from",
        ),
        ('"check.dat" }', '"check.dat", scale = -1.0 }', r"factor -1 \(wrong sign\)"),
        ("[5, 2, 0", "[50, 2, 0", "found node 50, direction 2"),
        ("friction", "forces = 3\nfriction", "unknown key 'forces'"),
        ('file = "stiffness.dat"', 'file = "mesh.inc"', "expected a stiffness matrix"),
    ],
)
def test_one_thing_wrong_in_the_reference_is_named(tmp_path, old, new, message):
    for file in BLOCK.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    path = tmp_path / "import.toml"
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(ProblemError, match=message):
        import_problem(path)


def test_a_sub_block_written_as_a_superelement_is_found(tmp_path):
    """What CalculiX 2.20 writes for *SUBSTRUCTURE GENERATE: rows and columns of the full matrix."""
    chain = np.kron(2 * np.eye(5) - np.eye(5, k=1) - np.eye(5, k=-1), np.diag([1.0, 2.0]))
    dofs = [(node, d) for node in range(1, 6) for d in (1, 2)]
    tail = """
[contact]
nodes = [1, 2, 3, 4, 5]
normal = [0, 1]
[[load]]
reactions = [[0, 1], [0, 1], [0, 1], [0, 1], [0, 1]]
history = 1
"""
    path = configured(tmp_path, 'file = "k"', tail, k=writers.abaqus_substructure(chain, dofs))
    with pytest.raises(ProblemError, match=r"k: K: expected a condensed matrix, found 12 of 25"):
        import_problem(path)
    allowed = configured(
        tmp_path, 'file = "k"\nallow_sparse = true', tail, k=writers.abaqus_substructure(chain, dofs)
    )
    assert import_problem(allowed).n == 5


def history_of(value, folder=Path(), steps=4):
    table = TomlTable({"history": value}, "load 1")
    return time_function(table, steps, InputFiles(folder)).factors


def test_time_functions(tmp_path):
    (tmp_path / "h.txt").write_text("# t, factor\n0, 1.0\n0.5, -2.0D0\n")
    assert history_of(2).tolist() == 2.0
    assert history_of([1, 2.5]).tolist() == [1.0, 2.5]
    assert history_of({"points": [[0, 0], [0.5, 1], [1, 0]]}).tolist() == [0.0, 0.5, 1.0, 0.5]
    assert history_of({"points": [[0.25, 1], [0.75, 3]]}).tolist() == [2.0, 1.0, 2.0, 3.0]
    assert history_of({"file": "h.txt", "column": 2}, tmp_path).tolist() == [1.0, -2.0]
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
    with pytest.raises(ProblemError, match="expected a column from 1 to 2, found 3"):
        history_of({"file": "h.txt", "column": 3}, tmp_path)
