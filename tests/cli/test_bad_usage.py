"""Words that no command can take, files that would be written over: one line that says why, and nothing written."""

import os
import shlex

import numpy as np
import pytest
from command import refused, run
from model_files import BLOCK

import shakedown

MAP, SPACE = "map two-node --load-factor 0.7 --states 8", "map two-node-3d --load-factor 0.5 --states 4"
NODES, SWEEP = "nodes press-fit --load-factor 2", "sweep two-node --vary f=0.3"
SIMULATE, THREE = "simulate two-node --load-factor 1", "simulate three-node --load-factor 1"
VARY = "--vary: expected NAME= and LOW:HIGH:COUNT or VALUE,VALUE,…, rising, at most 1,000,000, found '"
AMPLITUDES, ODD_STATE = "--amplitudes: expected LOW:HIGH:COUNT", "--initial: expected zero, given, given:K"
TWICE = "--grid: expected NODE:x or NODE:y twice, as the joint has two directions, found"

BAD = [
    ("dissolve", "No such command 'dissolve'"),
    ("example five-node", "no built-in problem 'five-node'"),
    # one joint
    ("solve nothing.npz", "no such file"),
    ("solve nothing", "no built-in problem"),
    ("solve two-node --fast", "No such option"),
    ("solve two-node --require proved=1", "--require: expected proved-from-state=X or proved-from-every-state=X"),
    ("solve two-node --require proved-from-state=nan", "with X > 0, found 'proved-from-state=nan'"),
    ("solve two-node --require proved-from-state", "with X > 0, found 'proved-from-state'"),
    ("solve two-node --distance -1", "distance: expected a number >= 0, found -1"),
    ("solve two-node --distance nan", "distance: expected a number >= 0, found nan"),
    ("solve two-node --initial safe", "expected zero, given, given:K or PATH.npy"),
    ("solve two-node --initial none.npy", "found none.npy, which is no file"),
    ("solve two-node --initial given", "found given, of a problem with 0 given states"),
    ("solve receding-block --open=0,x", "--open: expected auto, none or node numbers like 0,3,7, found '0,x'"),
    ("solve receding-block --open=", "expected auto, none or node numbers"),
    ("solve receding-block --open=-1", "expected auto, none or node numbers"),
    ("solve receding-block --open=1234567890", "expected auto, none or node numbers"),
    ("solve receding-block --open=99", "open nodes: expected node numbers from 0 to 32, found 99"),
    (f"solve receding-block --open={','.join(map(str, range(33)))}", "found all 33 open"),
    ("solve one-node-3d --initial given", "found given, of a problem with 0 given states"),
    ("solve one-node-3d --open 0", "open"),
    ("critical one-node-3d", "critical load factors: expected one tangential direction, found two"),
    # its motion
    ("simulate two-node --load-factor big", "not a valid float"),
    ("simulate two-node --load-factor -1", "expected a finite number >= 0, found -1"),
    ("simulate two-node-3d --load-factor 0.5 --initial witness", "expected one tangential direction, found two"),
    (f"{SIMULATE} --initial given", "found given, of a problem with 0 given states"),
    (f"{SIMULATE} --initial safe", "does not exist"),
    (f"{THREE} --initial given:7", "found given:7, of a problem with 1 given states"),
    *((f"{THREE} --initial given:{odd}", ODD_STATE) for odd in ("7" * 5000, "-1", "1.5", "²")),
    (f"{THREE} --initial witness:3x", ODD_STATE),
    (f"{NODES} -o nodes.txt", "expected a name that ends in .csv, .vtu or .vtp"),
    (f"{NODES} --wear-coefficient -1", "wear coefficient: expected a number ≥ 0, found -1.0"),
    (f"{NODES} --initial elsewhere", "found elsewhere"),
    ("nodes two-node --wear-coefficient 1e-8 -o n.csv", "expected a joint with areas of its nodes, found none"),
    ("verify one-node -o x.pdf", "the name of an HTML file (.html)"),
    ("verify one-node -o r.json", "the JSON goes beside it"),
    ("verify one-node -o none/r.html", "cannot be written"),
    # damping
    ("damping two-node --amplitudes 1,2", "key 'load_reactions': needed"),
    ("damping press-fit --amplitudes 1:2", AMPLITUDES),
    ("damping press-fit --amplitudes 1:2:inf", AMPLITUDES),
    ("damping press-fit --amplitudes=-1e308:1e308:3", AMPLITUDES),
    ("damping press-fit --amplitudes 1,x", AMPLITUDES),
    ("damping press-fit --amplitudes 2,1", "amplitudes: expected numbers >= 0 that rise, at least one, found [2, 1]"),
    ("damping press-fit --amplitudes 1,2 --load pull", "load: expected one of 0 to 0, 'traction', found 'pull'"),
    ("damping press-fit --amplitudes 1,2 --initial safe", "--initial: expected zero, given"),
    # maps
    (f"{MAP} --load-factor a", "'a' is not a valid float"),
    (f"{MAP} --load-factor 1e400", "load factor: expected a finite number"),
    (f"{MAP} --grid 0 5", "two different nodes from 0 to 1"),
    (f"{MAP} --grid 0:x 1:x", "--grid: expected two node numbers, found 0:x 1:x"),
    (f"{SPACE} --grid 0 1", f"{TWICE} 0 1"),
    (f"{SPACE} --grid 0:z 1:x", f"{TWICE} 0:z 1:x"),
    (f"{SPACE} --grid 0:x 9:x", "expected two different slips (x0, y0, x1, y1, …) from 0 to 3, found (0, 18)"),
    (f"{MAP} --resume", "--resume: expected -o FILE"),
    (f"{MAP} --picture basin.gif", "expected a name that ends in .png, .svg or .pdf"),
    (f"{MAP} --sampler ball --load-factor 0.8", "expected a finite energy ball"),
    (f"{MAP} -o /missing/map.npz", "cannot be written"),
    (f"{MAP} --states 0", "0 is not in the range"),
    (f"{MAP} --states 10000000000", "states: expected a whole number from 1 to 10,000,000, found"),
    (f"{MAP} --reach 1e308", "reach: expected slips in the range of numbers"),
    # sweeps
    ("sweep two-node", "Missing option '--vary'"),
    *((f"sweep two-node --vary f{values}", VARY) for values in ("", "=0.1:0.2", "=0.1:0.2:999999999", "=0.2:0.1:3")),
    *((f"sweep two-node --vary f={values}", VARY) for values in ("nan:1:3", "0.1,x")),
    ("sweep two-node --vary f=1 --vary f=2", "expected each parameter once, found f twice"),
    ("sweep two-node --vary mean=1 --vary mean.factor=2", "found mean twice"),
    (f"{SWEEP} --initial three.npy", "initial slip: expected shape (2,), found (3,)"),
    (f"{SWEEP} --resume", "--resume: expected -o FILE"),
    (f"{SWEEP} -o table.xlsx", "ends in .csv or .parquet"),
    (f"{SWEEP} --picture a.txt", "ends in .png, .svg or .pdf"),
    ("sweep two-node --vary f=-0.3,-0.2", "--vary: no value makes a joint: key 'f': expected friction"),
    ("sweep two-node --vary f=0.1,0.3 --vary mean=1 --picture a.png", "expected two values or more"),
    # meshes
    ("refine two-node", "FILE FILE …: expected several meshes of one joint, found one file"),
    ("refine three-node four-node-3d", "found [3, 4] contact nodes in the plane and in space"),
    ("refine block-33 block-9", "meshes: expected one joint, the coarsest first, found [33, 9] contact nodes"),
    # imports
    ("import absent.toml -o b.npz", "absent.toml: no such file"),
    ("import /dev/zero -o b.npz", "expected a regular file"),
    (f"import {BLOCK}/block.npz -o b.npz", "expected a TOML file"),
    (f"import {BLOCK}/import.toml", "Missing option '-o'"),
    ("import", "Missing argument 'CONFIG.toml'"),
    ("import --template example", "expected -o FOLDER"),
    ("import c.toml --template abaqus", "expected no CONFIG.toml"),
    ("import --template abaqus -o no/such/c.toml", "cannot be written"),
    (f"import {BLOCK}/import.toml --check --picture p.png", "expected coordinates"),
    (f"import {BLOCK}/import.toml -o no/such/folder/b.npz", "cannot be written"),
]  # fmt: skip


@pytest.mark.parametrize(("words", "message"), BAD, ids=[words[:60] for words, _ in BAD])
def test_bad_usage_is_one_line(tmp_path, words, message):
    np.save(tmp_path / "three.npy", np.zeros(3))
    for word in ("safe", "given"):  # a word is never the file of that name
        (tmp_path / word).touch()
    refused(*shlex.split(words), cwd=tmp_path, message=message)


@pytest.fixture
def folder(tmp_path):
    """A joint, a slip and a configuration, with other ways to spell them."""
    for name in ("p.npz", "p.npz.partial", "p.npz.parts", "s.html.partial", "r.json"):
        shakedown.save_problem(tmp_path / name, shakedown.example("two-node"))
    for name in ("v.npy", "v.csv"):
        with open(tmp_path / name, "wb") as file:
            np.save(file, np.zeros(2))
    (tmp_path / "joint.toml").write_text('[model]\nstiffness = "K.mtx"\n')
    for name, target in (("link", "p.npz"), ("link.png", "same.png"), ("here", ".")):
        (tmp_path / name).symlink_to(target)
    return tmp_path


def contents(folder):
    return {name: (folder / name).read_bytes() for name in os.listdir(folder) if (folder / name).is_file()}


MAPPED = "map --load-factor 0.7 --states 8"
CLAIMED = [
    (f"{MAPPED} p.npz -o same.png --picture same.png", "--picture: expected another file than -o"),
    (f"{MAPPED} p.npz -o same.png --picture link.png", "--picture: expected another file than -o"),
    (f"{MAPPED} p.npz -o link", "-o: expected another file than FILE"),
    (f"{MAPPED} p.npz -o ../{{name}}/p.npz", "-o: expected another file than FILE"),
    (f"{MAPPED} p.npz.parts -o p.npz", "the pieces of -o: expected another file than FILE"),
    ("sweep p.npz --vary f=0.3,0.4 -o v.csv --initial v.csv", "-o: expected another file than --initial"),
    ("simulate p.npz --initial v.npy -o here/v.npy", "-o: expected another file than --initial"),
    ("verify r.json -o r.html", "r.json: the JSON of the report r.html goes there"),
    ("import joint.toml -o joint.toml", "-o: expected another file than CONFIG.toml"),
]


@pytest.mark.parametrize(("words", "said"), CLAIMED, ids=[words for words, _ in CLAIMED])
def test_a_file_has_one_part_in_a_call(folder, words, said):
    before = contents(folder)
    refused(*words.format(name=folder.name).split(), cwd=folder, message=said)
    assert contents(folder) == before


def test_files_that_an_import_reads_are_not_written_over(tmp_path):
    """Not the configuration alone: every file that it names."""
    code, _, err = run("import", "--template", "example", "-o", "e", cwd=tmp_path)
    assert (code, err) == (0, "")
    config = next((tmp_path / "e").glob("*.toml"))
    sources = sorted(shakedown.import_model(config).sources)
    assert len(sources) > 1
    before = contents(tmp_path / "e")
    for source in sources:
        words = ("import", str(config), "-o", str(tmp_path / "e" / source))
        refused(*words, message="-o: expected another file than")
    assert contents(tmp_path / "e") == before


def test_two_files_are_two_files(folder):
    words = *MAPPED.split(), "p.npz", "-o", "map.npz", "--picture", "map.png"
    assert run(*words, cwd=folder)[0] == run(*words, "--resume", cwd=folder)[0] == 0
