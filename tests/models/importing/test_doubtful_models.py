"""Models that are subtly wrong: each is refused in one line, or warned of wherever its numbers are shown."""

import re
from importlib.resources import files

import pytest
from command import document, run

import shakedown
from shakedown import ProblemError, import_model
from shakedown.models.importing.templates import write_import_example

EXAMPLE = files("shakedown.models.importing") / "example"
UP = "normals = [[0, 1], [0, 1], [0, 1], [0, 1], [0, 1], [0, 1], [0, 1], [0, 1], [0, 1]]"
SETS = '"PUNCH_FOOT", "BLOCK_TOP"'


@pytest.fixture(scope="module")
def example(tmp_path_factory):
    """The text of the example's configuration and of its deck, and a folder for changed ones."""
    folder = tmp_path_factory.mktemp("punch")
    write_import_example(folder)
    return folder, (folder / "import.toml").read_text(), (folder / "punch.inp").read_text()


def labels(first=range(1, 10), second=range(1073, 1082)):
    return str([list(pair) for pair in zip(first, second, strict=True)])


def moved(deck, change, nodes):
    """A deck with other places of some nodes."""

    def line(match):
        label, x, y = int(match[1]), float(match[2]), float(match[3])
        return f"{label}, " + ", ".join(map(repr, change(x, y) if label in nodes else (x, y))) + "\n"

    found = re.sub(r"^(\d+), ([-\d.]+), ([-\d.]+)\n", line, deck, flags=re.MULTILINE)
    assert found != deck
    return found


BLOCK = range(1001, 2000)
WAVE = "harmonics = [{ order = 1, sin = 1.0 }]"


def changed(*words):
    """The configuration with the first of every two words replaced by the second."""

    def change(text, deck):
        for old, new in zip(words[::2], words[1::2], strict=True):
            text = text.replace(old, new, 1)
        return text, deck

    return change


def push(history):
    return changed(WAVE, history)


def listed(*factors, steps=""):
    """The configuration with a list of factors, and with or without the number of load steps."""
    constant = ("{ harmonics = [{ order = 1, cos = 1.0 }] }", "1.0")
    return changed("steps = 48", steps, f"{{ {WAVE} }}", str([*factors]), *constant)


def contact(lines):
    return changed(f"pairs = [{SETS}]", lines)


def placed(change, nodes=BLOCK, more=""):
    return lambda text, deck: (text.replace("[contact]\n", f"[contact]\n{more}"), moved(deck, change, nodes))


def rows_of_another_run(text, deck):
    """The map of a run with another numbering."""
    rows = [f"{node}.{direction}" for node in (*range(2, 46), 1) for direction in (1, 2)]
    rows += [f"{node}.{direction}" for node in range(1018, 1086) for direction in (1, 2)]
    return text, deck, ("changed.dof", "\n".join(rows) + "\n")


def rows_of_another_mesh(text, deck):
    """The map of a run with the same contact and other nodes inside the block."""
    nodes = (*range(1, 46), *range(11018, 11073), *range(1073, 1086))
    rows = [f"{node}.{direction}" for node in nodes for direction in (1, 2)]
    return text, deck, ("changed.dof", "\n".join(rows) + "\n")


def slower_clock(text, deck):
    """A record in milliseconds, its period in seconds."""
    rows = "".join(f"{k / 10},{(-1) ** (k // 5)}\n" for k in range(20))
    file = 'file = "h.csv", column = "f", time = "t", period = 0.002'
    return text.replace(WAVE, file.replace("0.002", "1e3"), 1), deck, ("h.csv", f"t,f\n{rows}")


def one_entry_damaged(text, deck):
    """A diagonal entry in the middle of the block is twice as large."""
    rows = [line.split() for line in EXAMPLE.joinpath("punch.sti").read_text().splitlines()]
    rows = [(i, j, 2 * float(value) if i == j == "150" else value) for i, j, value in rows]
    return text, deck, ("changed.sti", "".join("{} {} {}\n".format(*row) for row in rows))


REFUSED = {
    "a missing file": (changed('"punch.sti"', '"none.sti"'), r"stiffness: key 'file': .*none\.sti: no such file"),
    "a history and a range": (changed("history = 1.0", "range = [0, 1]\nhistory = 1.0"), r"load \d: expected one of the keys 'history' and"),
    "partners in the opposite order": (contact(f"pairs = {labels(second=range(1081, 1072, -1))}"), "found 1/1081 2 apart along the surface"),
    "sets of other sizes": (changed("BLOCK_TOP", "BLOCK_FOOT"), "equally many nodes, found 9 and 17, node 1001 farthest from a partner"),
    "one normal out of the body": (contact(f"pairs = {labels()}\n{UP.replace('[0, 1]', '[0, -1]', 1)}"), r"found \[0, -1, 0\] at 1/1073, .* \(1 of 9 do"),
    "partners a layer below": (contact(f"pairs = {labels(second=range(1056, 1065))}"), "0.25 apart across it; say 'gap' where they are meant"),
    "a list of another length than is stated": (listed(0.0, 1.0, 0.0, -1.0, steps="steps = 8"), "to and fro: history: expected 8 factors, .* found 4"),
    "a normal along the surface": (contact(f"pairs = [{SETS}]\nnormal = [1, 0]"), r"where its faces have \[0, 1, 0\] \(9 of 9 do not"),
    "friction of nodes in no known order": (changed("friction = 0.3", f"friction = {[0.1, 0.5, 0.9] * 3}"), "no list beside sets of nodes, whose order"),
    "one pair on which the body turns": (contact("pairs = [[5, 1077]]\nnormal = [0, 1]"), "the welded contact hold, found that it can move"),
    "a load that stands for nothing": (changed("history = 1.0", "history = 1.0\nvalue = 0"), "not 0, found 0"),
    "a node tied to each first one of a pair": (changed("[contact]", f"[contact]\ntied = {[*range(1073, 1082)]}"), r"contact\]?: expected no key 'tied' beside 'pairs', .* found both"),
    "a normal of no length": (contact(f"pairs = {labels()}\nnormal = [0, 0]"), "'normal': expected vectors of length"),
    "bodies into each other": (placed(lambda x, y: (x, 2 - y)), "faces of the second body that look at those of the first"),
}  # fmt: skip

WARNED = {
    "shifted along the surface": (placed(lambda x, y: (x + 0.04, y)), "0.04 apart along the surface, 0.16 of the spacing"),
    "drawn apart": (placed(lambda x, y: (x, y - 0.004)), "drawn so that they lie apart by 0.004 across the surface"),
    "drawn into each other": (placed(lambda x, y: (x, y + 0.01)), "drawn so that they overlap by 0.01"),
    "a normal askew": (contact(f"pairs = {labels()}\n{UP.replace('[0, 1], [0, 1], [0, 1]', '[1, 1], [0.3, 1], [0.25, 1]', 1)}"), "turned by 45° from the faces there (2 of 9 by more than 15°)"),
    "a node left out": (
        contact(f"pairs = {labels([1, 2, 3, 5, 6, 7, 8, 9], [1073, 1074, 1075, *range(1077, 1082)])}\nnormal = [0, 1]"),
        "lie at one place and are no pair of the contact (1 times, first 4 and 1076)",
    ),
    "one body for two": (contact('nodes = "PUNCH_FOOT"'), "lie at one place and are no pair of the contact (9 times"),
    "a gap beyond the model": (changed("[contact]", "[contact]\ngap = 0.9"), "the bodies touch nowhere: the least gap is 0.9, 3.6 of the spacing"),
    "too much interference": (placed(lambda x, y: (x, y - 1e-9), more="gap = -1\n"), "up to 1, 4 of the spacing"),
    "rows of another run": (rows_of_another_run, "are matrix, row map and deck of one run?"),
    "rows of another mesh": (rows_of_another_mesh, "110 of 226 rows are of nodes that are none of the deck, first 11018"),
    "another shape": (placed(lambda x, y: (x, 2 * y - 1), range(1, 2000)), "meet resistance at 45 of 96 nodes inside the model, most at 1077: are matrix, row map and deck of one run?"),
    "one entry damaged": (one_entry_damaged, "meet resistance at 1 of 96 nodes inside the model, most at 1047: springs, or damaged entries?"),
    "another unit": (changed('"punch.sti"', '"punch.sti"\nscale = 1000'), "is 'scale' right?"),
    "seconds for milliseconds": (slower_clock, "covers 0.19 % of the period of 1000"),
    "an alias": (push(WAVE.replace("order = 1", "order = 48")), "its 48 load step(s) do not show its harmonic of order 48: more than 96 'steps' do"),
    "an alias as large as the wave": (push(WAVE.replace("order = 1", "order = 49")), "48 load step(s) do not show its harmonic of order 49"),
    "a wave of two steps": (push(WAVE.replace("order = 1", "order = 24")), "its 48 load step(s) miss 50 %"),
    "peaks between the steps": (push("points = [[0, 0], [0.01, 5], [0.02, 0], [0.5, 1], [1, 0]]"), "miss 80 % of its range"),
    "a wave of no size": (push(WAVE.replace("1.0", "0.0")), "'pushed to and fro' does not vary: its factor is the same"),
    "no force": (changed("1, 10.0", "1, 0.0"), "'pushed to and fro' reaches no contact node"),
    "one load step": (changed("steps = 48", "steps = 1"), "no load varies over the 1 load step"),
    "a gap that stays open": (
        changed('forces = [["PUNCH_TOP", 2, -100.0]]', 'displacements = [["PUNCH_TOP", 2, -0.001]]', "[contact]", "[contact]\ngap = 0.01"),
        "'gap' is positive where the bodies lie apart",
    ),
    "a last step that is the first": (
        listed(0.0, 1.0, 0.0, -1.0, 0.0),
        "the last of 5 load steps repeats the first and is left out, because the period closes by itself",
    ),
    "pulled": (changed("-100.0", "100.0"), "no mean load presses the contact together"),
    "forces on what is held": (
        changed('["PUNCH_TOP", 1, 10.0]', "[40, 1, 10.0]", "[contact]", "[supports]\nfixed = [[40, 1]]\n[contact]"),
        "'pushed to and fro' reaches no contact node: the welded contact carries nothing of it",
    ),
}  # fmt: skip


def made(example, change):
    folder, text, deck = example
    toml, inp, *more = change(text, deck)
    (folder / "changed.toml").write_text(toml.replace("punch.", "changed."))
    for name in ("sti", "dof"):
        (folder / f"changed.{name}").write_text((folder / f"punch.{name}").read_text())
    for name, content in {"changed.inp": inp, **dict(more)}.items():
        (folder / name).write_text(content)
    return import_model(folder / "changed.toml")


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_meant_is_refused(example, case):
    change, message = REFUSED[case]
    with pytest.raises(ProblemError, match=message):
        made(example, change)


@pytest.mark.parametrize("case", WARNED)
def test_what_is_doubtful_is_a_warning_that_the_problem_keeps(example, case):
    change, words = WARNED[case]
    found = made(example, change)
    assert any(words in warning for warning in found.warnings), found.warnings
    assert found.problem.warnings == found.warnings
    assert max(map(len, found.warnings)) < 250
    assert (found.evidence.rigid_residual >= 0) == (case != "rows of another mesh")  # else not known


def test_warnings_are_in_the_first_lines_of_every_command(example, tmp_path):
    folder, _, _ = example
    made(example, WARNED["shifted along the surface"][0])
    made_file = str(tmp_path / "joint.npz")
    code, out, err = run("import", str(folder / "changed.toml"), "-o", made_file)
    assert (code, err) == (0, "")
    for words in (["solve"], ["simulate", "--load-factor", "0.5", "--cycles", "2"]):
        _, out, _ = run(words[0], made_file, *words[1:])
        assert "warning: pairs do not lie on each other" in "\n".join(out.splitlines()[:2])
    warnings = document("solve", made_file)["problem"]["warnings"]
    assert warnings == list(shakedown.load_problem(made_file).warnings)
    found = document("import", str(folder / "changed.toml"), "--check")
    assert found["warnings"] == warnings
    assert found["pairs"]["along_by_spacing"]["largest"] == pytest.approx(0.16)


def test_the_example_and_its_neighbours_are_not_doubted(example):
    """Neither a clearance that is said, nor a shear of the mesh, nor another start of the wave."""
    for change in (
        lambda text, deck: (text, deck),
        placed(lambda x, y: (x, y - 0.004), more="gap = 'coordinates'\n"),
        placed(lambda x, y: (x, y - 0.004), more="gap = 0.0\n"),
        placed(lambda x, y: (x + 1e-4, y)),
        push("harmonics = [{ order = 2, sin = 0.6, cos = -0.8 }]"),
        push("points = [[0, 0], [0.25, 1], [0.75, -1], [1, 0]]"),
    ):
        assert made(example, change).warnings == ()


def test_friction_in_per_cent_stops_the_check(example):
    folder, _, _ = example
    found = made(example, changed("friction = 0.3", "friction = 30"))
    assert found.warnings == ()
    assert not found.ready
    _, out, _ = run("import", str(folder / "changed.toml"), "--check")
    assert "is it in percent?" in "".join(out.splitlines()[1:3])
    assert "STOP: 1 warning to clear up" in out


@pytest.mark.parametrize("case", ["shifted along the surface", "another unit"])
def test_a_warning_that_is_meant_is_accepted_by_its_words(example, case):
    change, words = WARNED[case]
    doubted = made(example, change).warnings

    def accepting(*texts):
        return lambda text, deck: (f"accept = {[*texts]}\n{change(text, deck)[0]}", change(text, deck)[1])

    found = made(example, accepting(words, "what nothing says"))
    assert found.warnings == found.problem.warnings == tuple(each for each in doubted if words not in each)
    assert [note for note in found.notes if words in note]
    assert made(example, accepting(*doubted)).ready
    with pytest.raises(ProblemError, match="key 'accept': expected a list of texts, words of warnings"):
        made(example, lambda text, deck: (f"accept = true\n{text}", deck))


@pytest.mark.parametrize(
    ("sets", "message"),
    [
        ("LEFT = 0.1, BLOCK_TOP = 0.2", "found 1/1073 in 'LEFT' and 'BLOCK_TOP'"),
        ("LEFT = 0.1, NONE = 0.2", "expected the node set or surface 'NONE'"),
        ("LEFT = 0.1, BLOCK_FOOT = 0.2", "expected contact nodes in the set 'BLOCK_FOOT', found none"),
        ("", "a table with a number for each node set, found {}"),
    ],
)
def test_friction_by_node_sets(example, sets, message):
    def named(sets):
        more = "*NSET, NSET=LEFT\n1, 2, 3, 4, 5\n*NSET, NSET=RIGHT\n1078, 1079, 1080, 1081\n*BOUNDARY\n"
        new = f"friction = {{ {sets} }}"
        return lambda text, deck: (text.replace("friction = 0.3", new), deck.replace("*BOUNDARY\n", more, 1))

    if sets.startswith("LEFT = 0.1, BLOCK_TOP"):  # by the first body, or by the second
        found = made(example, named("LEFT = 0.1, RIGHT = 0.4"))
        assert found.problem.f.tolist() == [0.1] * 5 + [0.4] * 4
        folder, _, _ = example
        varied = import_model(folder / "changed.toml", changes={"friction.RIGHT": 0.2}, before=found)
        assert varied.problem.f.tolist() == [0.1] * 5 + [0.2] * 4
        assert varied.condensation is found.condensation
    with pytest.raises(ProblemError, match=message):
        made(example, named(sets))
