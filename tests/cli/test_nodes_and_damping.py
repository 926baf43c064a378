"""`nodes` and `damping`: tables that spreadsheets and pandas read, files of ParaView, JSON, text, pictures."""

import csv
from dataclasses import replace

import meshlane
import numpy as np
import pandas
import pytest
from command import document, run
from joints import creeping

import shakedown
from shakedown import Problem, damping, long_term_state, save_problem
from shakedown.long_term.conjugate_displacement import load_loops

MILLIMETRES = [
    "label", "x [mm]", "y [mm]", "z [mm]", "area [mm^2]", "status", "slip_range [mm]", "accumulated_slip [mm]",
    "p_min [N]", "p_max [N]", "q_max [N]", "work [N mm]", "tau_delta [N/mm]", "total_slip_bound [mm]",
]  # fmt: skip
TRACTIONS = ["pressure_min [MPa]", "pressure_max [MPa]", "shear_max [MPa]", "work_per_area [N/mm]"]
AT_TWO = ("press-fit", "--load-factor", "2")
LABELS = ('bolt, "upper"', "=1+1", "-12", "+cmd|' /C calc'!A0", "@SUM(A1)", "-A1", "PART-1.7", "Δ 8", "9")


@pytest.fixture(scope="module")
def named(tmp_path_factory):
    """A joint whose labels are hard to write."""
    path = tmp_path_factory.mktemp("named") / "joint.npz"
    shakedown.save_problem(path, replace(shakedown.example("press-fit"), label=LABELS))
    return str(path)


def rows(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.reader(file))


def test_the_table_agrees_with_the_json(tmp_path):
    path = tmp_path / "nodes.csv"
    found = document("nodes", *AT_TWO, "-o", str(path))
    table = pandas.read_csv(path)
    assert list(table.columns) == MILLIMETRES
    for heading in MILLIMETRES:
        word = heading.partition(" [")[0]
        if word in ("x", "y", "z"):
            expected = [place["xyz".index(word)] for place in found["coordinates"]]
        else:
            expected = found[word]
        assert known(table[heading]) == expected, word


def known(values):
    """Numbers and texts as JSON has them: None where a number is undefined."""
    return [None if value != value else value for value in np.asarray(values).tolist()]


def test_labels_are_quoted_and_no_spreadsheet_runs_them(named, tmp_path):
    path = tmp_path / "nodes.csv"
    assert run("nodes", named, "--load-factor", "2", "-o", str(path))[0] == 0
    found = [row[0] for row in rows(path)[1:]]
    assert found == [
        'bolt, "upper"', "'=1+1", "-12", "'+cmd|' /C calc'!A0", "'@SUM(A1)", "'-A1", "PART-1.7", "Δ 8", "9",
    ]  # fmt: skip
    assert pandas.read_csv(path)["label"].tolist() == found


def test_meshlane_reads_the_grid(tmp_path):
    path = tmp_path / "nodes.vtu"
    found = document("nodes", *AT_TWO, "-o", str(path))
    mesh = meshlane.read(path)
    assert np.array_equal(mesh.points, found["coordinates"])
    assert [(cells.type, len(cells.data)) for cells in mesh.cells] == [("vertex", 9)]
    for heading in [*(h for h in MILLIMETRES if h not in ("label", "status")), *TRACTIONS]:
        word = heading.partition(" [")[0]
        if word not in ("x", "y", "z"):
            assert known(mesh.point_data[heading]) == found[word], word
    words = ["stick", "slip", "open", "mixed"]
    assert [words[code] for code in mesh.point_data["status"]] == found["status"]
    assert mesh.point_data["node"].tolist() == list(range(9))
    assert "label" not in mesh.point_data  # 36/0 is no number
    assert mesh.point_data["node_1"].tolist() == [int(text.partition("/")[0]) for text in found["label"]]
    joint, slip = shakedown.example("press-fit"), mesh.point_data["slip_range [mm]"]
    np.testing.assert_allclose(mesh.point_data["slip_range_vector [mm]"], slip[:, None] * joint.tangent)
    assert np.array_equal(mesh.point_data["normal"], joint.normal)


def test_nodes_without_a_place_stand_in_a_row_and_whole_labels_are_numbers(tmp_path):
    path = tmp_path / "joint.npz"
    problem = shakedown.example("two-node")
    shakedown.save_problem(path, replace(problem, label=("1007", "12")))
    assert run("nodes", str(path), "--load-factor", "0.9", "-o", str(tmp_path / "n.vtu"))[0] == 0
    mesh = meshlane.read(tmp_path / "n.vtu")
    assert mesh.points.tolist() == [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
    assert mesh.point_data["label"].tolist() == [1007, 12]
    assert np.isnan(mesh.point_data["area"]).all()


def test_the_text_shows_the_worst_nodes_within_80_columns(named):
    for joint in ("block-33", "press-fit", "two-node", named):
        wear = ("--wear-coefficient", "1e-8") if joint == "press-fit" else ()
        code, out, err = run("nodes", joint, "--load-factor", "2", *wear)
        assert (code, err) == (0, "")
        lines = out.splitlines()
        assert max(map(len, lines)) <= 80
        assert "q max" in out
    _, out, _ = run("nodes", *AT_TWO)
    first = next(line for line in out.splitlines() if line.split()[:2] == ["4", "40/4"]).split()
    assert first[:5] == ["4", "40/4", "mixed", "0.00181", "0.00356"]
    assert "5 open at times, 3 slip, 1 stick" in out


def test_undecided_says_so_and_ends_with_one(tmp_path):
    path = tmp_path / "nodes.csv"
    arguments = ("two-node", "--load-factor", "0.8", "--cycles", "1")
    code, out, _ = run("nodes", *arguments, "-o", str(path))
    assert code == 1
    assert "no steady period" in out
    assert [row[5:8] for row in rows(path)[1:]] == [["undecided", "", ""]] * 2
    found = document("nodes", *arguments, code=1)
    assert found["slip_range"] == [None, None]


@pytest.mark.parametrize(("below", "met"), [("1e-3", False), ("2e-3", True)])
@pytest.mark.parametrize("method", ["event", "gauss-seidel"])
def test_simulate_says_whether_slips_stay_below_a_length(below, met, method):
    found = document("simulate", *AT_TWO, "--slip-below", below, "--method", method)
    criterion = found["slip_criterion"]
    assert (criterion["below"], criterion["met"]) == (float(below), met)
    assert criterion["node"] in ((4,) if method == "event" else (4, 5))  # node 4 opens within a load step
    assert criterion["largest"] == pytest.approx(
        0.00181423102, rel=5e-2 if method == "gauss-seidel" else 1e-8
    )
    assert found["outcome"] == "cyclic-slip"  # the strict answer
    _, out, _ = run("simulate", *AT_TWO, "--slip-below", below)
    assert f"below {float(below):.4g} mm" in out
    assert "slip_criterion" not in document("simulate", *AT_TWO)


def test_what_grows_for_ever_is_below_nothing_and_rest_is_below_everything(tmp_path):
    path = tmp_path / "joint.npz"
    shakedown.save_problem(path, creeping())
    found = document("simulate", str(path), "--load-factor", "1", "--slip-below", "1e9")
    assert found["outcome"] == "ratchetting"
    assert found["slip_criterion"] == {"below": 1e9, "met": False, "largest": "inf", "node": -1}
    found = document("simulate", "two-node", "--load-factor", "0.5", "--slip-below", "1e-9")
    assert found["slip_criterion"] == {"below": 1e-9, "met": True, "largest": 0.0, "node": -1}
    found = document(
        "simulate", "two-node", "--load-factor", "0.8", "--cycles", "1", "--slip-below", "1", code=1
    )
    assert found["slip_criterion"] == {"below": 1.0, "met": None, "largest": None, "node": -1}


def test_a_node_that_opens_has_no_smallest_force_and_no_column_has_the_name_of_a_key():
    out = run("nodes", "receding-block")[1]
    lines = [line.split() for line in out.splitlines() if " mixed " in line]
    assert len(lines) == 6
    assert {line[7] for line in lines} == {"0"}
    assert "τ δ" in out
    assert "tau delta" not in out


@pytest.fixture
def joint(tmp_path):
    """A Jenkins element as a file."""
    found = Problem(
        A=[[2.0]], B=[[0.0]], f=0.5, q_w=[[-1.0], [1.0]], p_w=[[2.0], [2.0]], units="N, mm",
        load_reactions=[[-1.0, 0.0]], load_history=[[1.0], [-1.0]], load_compliance=[[0.1]], load_names=["push"],
    )  # fmt: skip
    save_problem(tmp_path / "joint.npz", found)
    return str(tmp_path / "joint.npz"), found


def test_the_document_the_table_and_the_file_tell_the_curve(joint, tmp_path):
    path, problem = joint
    asked = ("damping", path, "--amplitudes", "0.5:2.5:5", "--load", "push")
    found = document(*asked)
    curve = damping(problem, np.linspace(0.5, 2.5, 5))
    assert found["dissipation"] == curve.dissipation.tolist()
    assert found["secant_stiffness"] == curve.secant_stiffness.tolist()
    assert found["frequency"] == [None] * 5
    code, out, err = run(*asked, "-o", str(tmp_path / "x.csv"), "--picture", str(tmp_path / "x.svg"))
    assert (code, err) == (0, "")
    assert "no damping, proved up to 1 from the initial state" in " ".join(out.split())
    assert "at 5 amplitudes" in out
    assert max(map(len, out.splitlines())) <= 80
    rows = list(csv.DictReader((tmp_path / "x.csv").read_text().splitlines()))
    assert [float(row["dissipation"]) for row in rows] == found["dissipation"]
    assert (tmp_path / "x.svg").read_text().startswith("<?xml")


def test_a_loop_is_written(joint, tmp_path):
    path = tmp_path / "loop.csv"
    load_loops(joint[1], long_term_state(joint[1], 2.0)).save(path, joint[1])
    rows = list(csv.DictReader(path.read_text().splitlines()))
    x, c = (np.array([float(row[key]) for row in rows]) for key in ("displacement", "load"))
    assert (0.5 * (c[1:] + c[:-1]) * np.diff(x)).sum() == pytest.approx(2.0, rel=1e-12)
    assert {(row["load_name"], row["load_number"]) for row in rows} == {("push", "0")}
    assert {(row["load_unit"], row["displacement_unit"]) for row in rows} == {("", "N mm per unit of load")}
