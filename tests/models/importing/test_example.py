"""The example, the tutorial and CalculiX's block, imported and by the command: all numbers, what problems keep, loads in words."""

import hashlib
import json
import re
import shutil
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
import writers
from calculix import ccx, needs_ccx
from command import document, refused, run
from model_files import BLOCK

import shakedown
from shakedown import LoadCase, ProblemError, UsageError
from shakedown.fem import ElasticBody, Material, Support, block_mesh, contact_condensation
from shakedown.joint.units import loads_in_words
from shakedown.models.condensation.condense import condensed_stiffness
from shakedown.models.condensation.load_case import histories, stated_loads
from shakedown.models.importing.import_model import import_problem
from shakedown.models.importing.templates import import_template, write_import_example
from shakedown.models.readers.formats import read_any_mesh, read_stiffness


@pytest.fixture
def example(tmp_path):
    write_import_example(tmp_path)
    return tmp_path / "import.toml"


def test_the_example_says_where_it_comes_from(example):
    problem = shakedown.import_model(example, command="shakedown-bounds import import.toml").problem
    assert problem.label[:2] == ("1/1073", "2/1074")
    assert problem.load_names == ("pressed down", "pushed to and fro", "pressed more and less")
    assert problem.node_area.sum() == pytest.approx(np.ptp(problem.coordinates[:, 0]))
    assert problem.node_area[[0, -1]] == pytest.approx(0.5 * problem.node_area[1])
    assert problem.normal.tolist() == [[0.0, 1.0, 0.0]] * 9
    source = json.loads(problem.source)
    assert source["command"] == "shakedown-bounds import import.toml"
    assert source["configuration"] == {"name": "import.toml", "text": example.read_text()}
    for file in source["files"]:
        assert file["sha256"] == hashlib.sha256((example.parent / file["name"]).read_bytes()).hexdigest()
    names = {file["name"] for file in source["files"]}
    assert names == {"import.toml", "punch.inp", "punch.sti", "punch.dof"}


def test_the_same_import_twice_gives_the_same_bytes(example, tmp_path):
    for name in "ab":
        shakedown.save_problem(tmp_path / name, import_problem(example))
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    assert import_problem(example) == shakedown.load_problem(tmp_path / "a")


def test_an_archive_of_ansys_gives_the_normals_and_areas_of_the_deck(example, tmp_path):
    of_deck, mesh = import_problem(example), read_any_mesh(tmp_path / "punch.inp")
    cells = {label: (1, list(nodes)) for label, (_, nodes) in mesh.elements.items()}
    sets = {name: ("NODE", own.tolist()) for name, own in mesh.node_sets.items()}
    (tmp_path / "punch.cdb").write_text(writers.ansys_archive(mesh.places, cells, sets))
    example.write_text(example.read_text().replace('"punch.inp"', '"punch.cdb"'))
    made = import_problem(example)
    for key in ("A", "B", "C", "q_w", "p_w", "normal", "node_area", "coordinates"):
        np.testing.assert_array_equal(getattr(made, key), getattr(of_deck, key))


HISTORIES = ("history = 1.0 ", "history = { harmonics = [{ order = 1, sin = 1.0 }] }")


@pytest.fixture
def stated(example):
    """The example, its loads with units: the first is constant, the second a wave, the third plain."""
    text = example.read_text().replace(HISTORIES[0], f'unit = "kN"\nvalue = 0.7\n{HISTORIES[0]}')
    example.write_text(text.replace(HISTORIES[1], f'unit = "N"\nvalue = -70\nmean = 0.5\n{HISTORIES[1]}'))
    return example


def test_units_and_values_become_means_and_amplitudes(stated, tmp_path):
    problem = import_problem(stated)
    assert [load.unit for load in problem.loads] == ["kN", "N", ""]
    np.testing.assert_allclose(problem.load_mean, [0.7, -35.0, 0.0], rtol=1e-15, atol=0)
    np.testing.assert_allclose(problem.load_amplitude, [0.0, 105.0, 1.0], rtol=1e-15)
    words = "pushed to and fro -35 ± 210 N; pressed more and less ± 2; pressed down 0.7 kN, unchanged"
    assert loads_in_words(problem, 2.0) == words
    shakedown.save_problem(tmp_path / "p.npz", problem)
    assert shakedown.load_problem(tmp_path / "p.npz").loads == problem.loads


def test_an_import_knows_what_a_unit_of_every_load_does(stated):
    """Reactions, histories, a compliance that is symmetric and positive for forces; of a mode its frequency."""
    stated.write_text(stated.read_text().replace(HISTORIES[1], f"frequency = 3.5\n{HISTORIES[1]}"))
    problem = import_problem(stated)
    welded = problem.layout.joined(problem.q_w, problem.p_w)
    np.testing.assert_allclose(
        problem.load_history @ problem.load_reactions, welded, atol=1e-12 * np.abs(welded).max()
    )
    np.testing.assert_allclose(problem.load_frequency, [np.nan, 3.5, np.nan])
    assert np.linalg.eigvalsh(problem.load_compliance)[0] > -1e-12 * np.abs(problem.load_compliance).max()
    stated.write_text(stated.read_text().replace("frequency = 3.5", "frequency = -1.0"))
    with pytest.raises(ProblemError, match="frequency: expected a number > 0, found -1"):
        import_problem(stated)


def test_the_mean_of_a_sampled_wave_is_zero_and_not_round_off():
    wave = LoadCase(history=np.cos(2 * np.pi * np.arange(48) / 48), force=[1.0], unit="N")
    assert np.cos(2 * np.pi * np.arange(48) / 48).mean() != 0
    assert stated_loads([wave], histories([wave]))["load_mean"] == [0.0]
    assert stated_loads([wave], histories([wave]))["load_amplitude"] == [1.0]


NAN, NUMBER = "'value': expected a finite number, found nan", "'unit': expected text, found 20"


@pytest.mark.parametrize(("line", "message"), [("value = nan", NAN), ("unit = 20", NUMBER)])
def test_what_is_no_unit_or_value_is_said(stated, line, message):
    stated.write_text(stated.read_text().replace('unit = "kN"', line).replace("value = 0.7\n", ""))
    with pytest.raises(ProblemError, match=message):
        import_problem(stated)


def test_a_sweep_says_which_names_it_cannot_take(stated):
    problem = import_problem(stated)
    with pytest.raises(UsageError, match=r"vary: expected one of f, .*, found 'pressed down'"):
        shakedown.sweep(problem, {"pressed down": [1.0]})


@pytest.fixture(scope="module")
def config(tmp_path_factory):
    folder = tmp_path_factory.mktemp("import") / "punch"
    write_import_example(folder)
    return folder / "import.toml"


@pytest.fixture(scope="module")
def as_given(config):
    return shakedown.import_model(config)


EDITS = [
    ({"friction": 0.5}, "friction = 0.3", "friction = 0.5"),
    ({"steps": 96.0}, "steps = 48", "steps = 96"),
    ({"load.2.forces.1.3": 7.5}, '"PUNCH_TOP", 1, 10.0', '"PUNCH_TOP", 1, 7.5'),
    ({"load.2.history.harmonics.1.sin": 2.0}, "sin = 1.0", "sin = 2.0"),
    ({"load.1.history": 3}, "history = 1.0 ", "history = 3 "),
    ({"contact.gap": -1e-4}, "[contact]", "[contact]\ngap = -1e-4"),
    ({"stiffness.scale": 2.0}, "[stiffness]", "[stiffness]\nscale = 2.0"),
]


@pytest.mark.parametrize(("changes", "old", "new"), EDITS, ids=[next(iter(edit[0])) for edit in EDITS])
def test_a_changed_number_is_an_edited_file(config, as_given, changes, old, new):
    text = config.read_text()
    assert text.count(old) == 1
    edited = config.with_name("edited.toml")
    edited.write_text(text.replace(old, new))
    expected = import_problem(edited)
    for before in (None, as_given):
        made = shakedown.import_model(config, changes=changes, before=before)
        for key in ("A", "B", "C", "f", "q_w", "p_w"):
            assert np.array_equal(getattr(made.problem, key), getattr(expected, key)), key
        again = before is None or changes.keys() & {"stiffness.scale"}
        assert (made.condensation is as_given.condensation) == (not again)
        assert made.sources == as_given.sources
        assert next(iter(changes)) in made.problem.source


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("load.x.history", "expected a number from 1 to 3, found 'x'"),
        ("lod.1", "expected one of 'name', .* found 'lod'"),
        ("friction.2", "expected a table or a list before '2', found 0.3"),
        ("load.1.forces", "expected the key of a number, found"),
        ("load.1.hystory", "unknown key 'hystory'"),
    ],
)
def test_a_key_without_a_number_is_said(config, as_given, key, message):
    with pytest.raises(ProblemError, match=message) as caught:
        shakedown.import_model(config, changes={key: 1.0}, before=as_given)
    assert "\n" not in str(caught.value)


TUTORIAL = (Path(__file__).parents[3] / "docs" / "tutorial-calculix.md").read_text(encoding="utf-8")
EXAMPLE = files("shakedown.models.importing") / "example"


def block(language, word):
    """The one fenced block of a language that holds a word."""
    found = [b for b in re.findall(rf"```{language}\n(.*?)```", TUTORIAL, re.DOTALL) if word in b]
    assert len(found) == 1, (language, word)
    return found[0]


@pytest.fixture
def folder(tmp_path):
    """What the reader of the tutorial has, but for what CalculiX writes."""
    (tmp_path / "punch.inp").write_text(EXAMPLE.joinpath("punch.inp").read_text())
    (tmp_path / "import.toml").write_text(block("toml", "[contact]"))
    return tmp_path


def test_the_deck_of_the_tutorial_is_the_shipped_one():
    shipped = iter(EXAMPLE.joinpath("punch.inp").read_text().splitlines())
    assert all(line in shipped for line in block("text", "*STEP").splitlines())  # in this order


@needs_ccx
@pytest.mark.usefixtures("undrawn")
def test_the_tutorial_with_calculix(folder):
    """Every command in its order, the simulations cut to a few; with the shipped output the site runs them."""
    ccx(folder, "punch")
    for line in re.findall(r"^(?:\$ )?shakedown-bounds (.*)$", TUTORIAL, re.MULTILINE):
        words = line.split()
        if words[0] == "verify":
            words += ["--random", "0", "--load-factor", "1.2"]
        code, _, err = run(*words, cwd=folder)
        assert (code, err) == (0, ""), (line, err)
    made = shakedown.load_problem(folder / "punch.npz")
    limits = shakedown.lower_bound(made).load_factor, shakedown.upper_bound(made).load_factor
    for name, found in zip(("proved from every state", "impossible above"), limits, strict=True):
        shown = re.search(rf"{name} +([0-9.]+)", TUTORIAL)
        assert found == pytest.approx(float(shown[1]), rel=1e-3)
    assert (folder / "punch.html").stat().st_size > 10_000
    shipped = np.loadtxt(str(EXAMPLE.joinpath("punch.sti")))
    np.testing.assert_allclose(
        np.loadtxt(folder / "punch.sti"), shipped, rtol=1e-6, atol=1e-6 * shipped[:, 2].max()
    )


def printed(folder, digits, scale, more=""):
    """The matrix of the tutorial as a file with so many digits, and its configuration."""
    i, j, value = np.loadtxt(EXAMPLE / "punch.sti", unpack=True)
    rows = (EXAMPLE / "punch.dof").read_text().split()
    size = f"{len(rows)} {len(rows)} {len(value)}"
    low, high = np.minimum(i, j), np.maximum(i, j)
    entries = zip(high.astype(int), low.astype(int), scale * value, strict=True)
    lines = [f"{a} {b} {v:.{digits - 1}e}" for a, b, v in entries]
    text = "\n".join(["%%MatrixMarket matrix coordinate real symmetric", size, *lines, ""])
    (folder / "punch.mtx").write_text(text)
    for name in ("punch.inp", "punch.dof"):
        (folder / name).write_text((EXAMPLE / name).read_text())
    config = (EXAMPLE / "import.toml").read_text()
    assert 'file = "punch.sti"' in config
    config = config.replace('file = "punch.sti"', f'file = "punch.mtx"\nmap = "punch.dof"{more}')
    (folder / "import.toml").write_text(config)
    return folder / "import.toml"


@pytest.mark.parametrize(("digits", "scale"), [(8, 0.7), (6, 1 / 3)])
def test_a_floating_body_keeps_its_rigid_motions_in_few_digits(tmp_path, digits, scale):
    """Of its own rounding the printed matrix resists them; the limits would be others, or refused."""
    whole = shakedown.import_model(EXAMPLE / "import.toml").problem
    made = shakedown.import_model(printed(tmp_path, digits, scale))
    assert made.condensation.zero_modes == 3
    assert made.problem.stiffness_accuracy == pytest.approx(10.0**-digits)
    expected = shakedown.upper_bound(whole).load_factor
    found = shakedown.upper_bound(made.problem).load_factor
    assert found == pytest.approx(expected, rel=10.0 ** (4 - digits))
    eigenvalues = np.linalg.eigvalsh(made.problem.kappa)
    assert (np.abs(eigenvalues) < 1e-12 * eigenvalues[-1]).sum() == 3


MATRIX_STORAGE = """*INCLUDE,INPUT=dense.inc
*INCLUDE,INPUT=tie.inc
*BOUNDARY
NTOP,1,2
*STEP
*FREQUENCY,SOLVER=MATRIXSTORAGE
*END STEP
"""


def same_block():
    """The mesh of the deck in scikit-fem: bilinear, plane strain, 0.25 deep."""
    mesh, material = block_mesh(2.0, 1.0, 8, 6), Material(200e3, 0.3)
    body = ElasticBody(mesh, material, thickness=0.25, supports=[Support("top")])
    return contact_condensation(body, "bottom")


@needs_ccx
def test_calculix_and_scikit_fem_agree_on_a_b_c(tmp_path):
    deck = Path(shutil.copytree(BLOCK, tmp_path, dirs_exist_ok=True))
    (deck / "dense.inc").write_text(
        (deck / "mesh.inc").read_text().replace("*SOLID SECTION", "*DENSITY\n1.\n*SOLID SECTION")
    )
    (deck / "storage.inp").write_text(MATRIX_STORAGE)
    ccx(deck, "storage")
    stored = read_stiffness(deck / "storage.sti")
    found = condensed_stiffness(stored.K, stored.dofs, range(1, 10), [0, 1])
    expected = same_block()
    scale = np.abs(expected.stiffness).max()
    np.testing.assert_allclose(found.stiffness, expected.stiffness, rtol=0, atol=1e-6 * scale)
    printed = shakedown.load_problem(BLOCK / "block.npz").kappa
    np.testing.assert_allclose(found.stiffness, printed, rtol=0, atol=1e-6 * np.abs(printed).max())


def test_forces_on_tied_nodes_are_added(tmp_path):
    """Both layers are printed: with the tied nodes the stiffness is that of the full depth, without, of half."""
    shutil.copytree(BLOCK, tmp_path, dirs_exist_ok=True)
    expected = same_block().stiffness
    scale = np.abs(expected).max()
    tied = import_problem(tmp_path / "import.toml").kappa
    np.testing.assert_allclose(tied, expected, rtol=0, atol=1e-6 * scale)
    config = (tmp_path / "import.toml").read_text()
    (tmp_path / "import.toml").write_text(re.sub("\ntied = .*", "", config.split("[check]")[0]))
    alone = import_problem(tmp_path / "import.toml").kappa
    np.testing.assert_allclose(alone, expected / 2, rtol=0, atol=1e-6 * scale)


def test_a_substructure_is_taken_where_that_is_accepted(tmp_path):
    load, words = "[[load]]\nreactions = [[0, 1]]\nhistory = [1, 0.5]\n", "it looks like a sub-block"
    about = f'friction = 0.3\n[stiffness]\nfile = "{BLOCK / "substructure.mtx"}"\n[contact]\n'
    contact = (
        f"nodes = {list(range(1, 10))}\nnormal = [0, 1]\n{load.replace('[0, 1]', ', '.join(['[0, 1]'] * 9))}"
    )
    config = tmp_path / "import.toml"
    config.write_text(about + contact)
    (said,) = shakedown.import_model(config).warnings
    assert words in said
    assert "found 56 of 81 node pairs" in said
    config.write_text(f'accept = ["{words}"]\n{about}{contact}')
    assert shakedown.import_model(config).warnings == ()


def test_import_writes_the_problem_and_says_where_it_came_from(tmp_path):
    code, out, err = run("import", str(BLOCK / "import.toml"), "-o", str(tmp_path / "b.npz"))
    assert (code, err) == (0, "")
    assert "9 nodes, 48 load steps" in out
    assert "read from reactions to unit displacements 0 rows condensed, 0 held" in " ".join(out.split())
    assert "agrees with static run" in out
    made, reference = shakedown.load_problem(tmp_path / "b.npz"), shakedown.load_problem(BLOCK / "block.npz")
    np.testing.assert_allclose(made.p_w, reference.p_w, rtol=1e-14)
    result = document("import", str(BLOCK / "import.toml"), "-o", str(tmp_path / "b.npz"))
    labels = [str(k) for k in range(1, 10)]
    known = {"name": "CalculiX block, 9 contact nodes", "n": 9, "m": 48, "labels": labels, "units": "N, mm"}
    assert result["problem"] == known
    assert result["rows"] == {"contact": 18, "condensed": 0, "held": 0}
    assert (result["zero_modes"], result["notes"]) == (0, [])
    assert result["static_run"] < 2e-6


def test_a_template_is_shown_or_written_once(tmp_path):
    code, out, err = run("import", "--template", "abaqus")
    assert (code, err) == (0, "")
    assert out == import_template("abaqus")
    assert run("import", "--template", "abaqus", "-o", str(tmp_path / "c.toml"))[0] == 0
    assert (tmp_path / "c.toml").read_text() == out
    words = ("import", "--template", "ansys", "-o", "c.toml")
    refused(*words, cwd=tmp_path, message="expected no such file, found one")
    assert (tmp_path / "c.toml").read_text() == out


def test_check_shows_what_is_read_and_writes_nothing(example, tmp_path):
    before, config = sorted(tmp_path.rglob("*")), str(example)
    code, out, err = run("import", config, "--check", "-o", str(tmp_path / "p.npz"))
    assert (code, err) == (0, "")
    assert sorted(tmp_path.rglob("*")) == before
    assert out.splitlines()[1].startswith("GO ON: no warnings.")
    for words in (
        "5/1077",
        "first body 45 nodes 9 in contact; free but for the contact: along x, along y,",
        "second body 68 nodes 9 in contact; held by supports",
        "asymmetry",
        "rigid motions 3 of the contact nodes, without resistance",
        "read punch.sti",
    ):
        assert words in " ".join(out.split())
    lines = [line.split() for line in out.splitlines()]
    for words in (
        "applied, first body 70 0 -70",  # about the middle of the contact, 1 mm below
        "contact, first body -70 0 70",
        "supports, second body -70 0 70",
    ):
        assert words.split() in lines
    assert all(len(line) <= 80 for line in out.splitlines())
    found = document("import", config, "--check")
    assert found["file"] is None
    assert found["nodes"][4] == "5/1077"
    assert found["loads"][0]["applied"] == [0.0, -700.0]
    assert found["normals"] == [[0.0, 1.0]] * 9
    assert len(found["sources"]["punch.sti"]) == 64


def test_a_picture_is_drawn(tmp_path):
    assert run("import", "--template", "example", "-o", "punch", cwd=tmp_path)[0] == 0
    words = ("import", "punch/import.toml", "--check", "--picture")
    assert run(*words, "p.png", cwd=tmp_path)[0] == 0
    assert (tmp_path / "p.png").read_bytes().startswith(b"\x89PNG")
    refused(*words, "p.nonsense", cwd=tmp_path, message="expected a name that ends in .png")
