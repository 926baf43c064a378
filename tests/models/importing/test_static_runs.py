"""Loads by static runs of another code: every node held, the contact held, the contact open."""

import shutil

import numpy as np
import pytest
from model_files import HEAT, RING, changed

from shakedown import ProblemError, import_model

THERMAL = 'thermal = { file = "held.dat", step = 1 }'
CLAMPED = 'reactions = { file = "clamped.dat", step = 1, bodies = "clamped" }'
OPEN = 'open = { file = "open.dat", step = 1 }'


@pytest.fixture
def heat(tmp_path):
    shutil.copytree(HEAT, tmp_path / "heat")
    return tmp_path / "heat"


def made(folder, *pairs):
    """The import with some things of its configuration changed."""
    return import_model(changed(folder, *pairs))


def welded(imported):
    return np.concatenate([imported.problem.q_w[0], imported.problem.p_w[0]])


@pytest.mark.parametrize(
    ("line", "digits"),
    [
        (CLAMPED, 2e-7),
        (OPEN, 1e-5),
        ('open = { file = "open.frd", step = 1 }', 1e-4),
    ],
    ids=["clamped", "open", "open in a result file"],
)
def test_every_way_from_a_temperature_leads_to_the_same_reactions(heat, line, digits):
    expected = welded(made(heat))
    found = welded(made(heat, (THERMAL, line)))
    largest = np.abs(expected).max()
    assert largest > 50
    np.testing.assert_allclose(found, expected, rtol=0, atol=digits * largest)


def test_a_load_case_is_refused_where_its_file_is_not_what_the_key_says(heat):
    refused = {
        'thermal = { file = "clamped.dat", step = 1 }': "expected node 15, found it not printed",
        'thermal = { file = "open.dat", step = 1 }': "expected every node held .*found node 11 displaced by 0.0015",
        'thermal = { file = "open.frd", step = 1 }': r"expected reactions \(\*NODE FILE, RF\), found no block FORC",
        'thermal = { file = "held.dat", step = 2 }': "key 'step': expected 1 to 1, found 2",
        'open = { file = "open.dat" }': "key 'step': expected 1 to 3, found none",
        'open = { file = "open.dat", step = 4 }': "key 'step': expected 1 to 3, found 4",
        'open = { file = "blocks.sti", step = 1 }': "expected the columns step, node, ux, uy and maybe uz",
        'open = { file = "open.dat", step = 1, bodies = "tied" }': "unknown key 'bodies'",
        'open = "open.dat"': "key 'open': expected a table",
        'open = { file = "clamped.dat", step = 1 }': "found contact nodes that do not move apart .held, tied or",
    }
    for line, message in refused.items():
        with pytest.raises(ProblemError, match=message):
            made(heat, (THERMAL, line))


def test_reactions_of_held_nodes_have_no_other_directions(heat):
    deck = (heat / "blocks.inp").read_text()
    turned = "*TRANSFORM, NSET=TOP, TYPE=R\n0., 1., 0., -1., 0., 0.\n"
    (heat / "blocks.inp").write_text(deck.replace("*NSET, NSET=TOP", f"{turned}*NSET, NSET=TOP"))
    with pytest.raises(
        ProblemError, match=r"expected nodes with directions x, y, z, found node \d+ in a \*TRANSFORM"
    ):
        made(heat)


def test_held_runs_have_to_show_that_they_are(heat):
    text = (heat / "held.dat").read_text()
    (heat / "held.dat").write_text(" forces" + text.partition(" forces")[2])
    with pytest.raises(ProblemError, match=r"which show that every node was held \(\*NODE PRINT: U, RF\)"):
        made(heat)
    shifted = text.replace("3.071250E+02", "0.000000E+00")
    zeros = "\n".join(
        line if len(line.split()) != 4 else f"{line.split()[0]:>10}" + 3 * "  0.000000E+00"
        for line in shifted.splitlines()
    )
    (heat / "held.dat").write_text(zeros + "\n")
    assert any("reaches no contact node" in warning for warning in made(heat).warnings)


FIT, INTERFERENCE, EXPANSION = 10.0, 0.01, 1.2e-5
COOLED = """
[[load]]
name = "hub cooled"
unit = "K"
value = -100.0
open = { file = "cooled.dat", step = 1 }
history = 1.0
"""


@pytest.mark.parametrize("file", ["cooled.dat", "cooled.frd"])
def test_a_hub_that_is_cooled_presses_as_one_that_is_too_small(tmp_path, file):
    """100 degrees less take 1.2e-5 * 100 * 10 mm of the hub's bore: an interference; slip is free."""
    shutil.copytree(RING, tmp_path / "ring")
    text = (tmp_path / "ring" / "import.toml").read_text()
    cooled = text.replace("gap = -0.01\n", "") + COOLED.replace("cooled.dat", file)
    (tmp_path / "ring" / "cooled.toml").write_text(cooled)
    problem = import_model(tmp_path / "ring" / "cooled.toml").problem
    fitted = import_model(tmp_path / "ring" / "import.toml").problem
    factor = EXPANSION * 100 * FIT / INTERFERENCE
    pressures = []
    for joint, times in ((problem, 1.0), (fitted, factor)):
        slip = -np.linalg.lstsq(joint.A, joint.q_w.mean(axis=0), rcond=1e-8)[0]
        pressures.append(times * (joint.p_w.mean(axis=0) + joint.B @ slip) / joint.node_area)
    np.testing.assert_allclose(*pressures, rtol=5e-4)  # CalculiX's wedge has straight sides
    (load,) = [load for load in problem.loads if load.name == "hub cooled"]
    assert load == ("hub cooled", -100.0, 0.0, "K")
