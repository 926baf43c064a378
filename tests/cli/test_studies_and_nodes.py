"""`map`, `sweep`, `nodes`, `damping`: what they say, write and draw, for spreadsheets, pandas and ParaView; slips below a length."""

import csv
import json
import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import joints
import meshlane
import numpy as np
import pandas
import pytest
from command import document, refused, run
from joints import creeping

import shakedown
from shakedown import Problem, damping, long_term_state, save_problem
from shakedown.assessment.transient_limit import slip_limit
from shakedown.long_term.conjugate_displacement import load_loops
from shakedown.models.importing.import_model import import_problem
from shakedown.models.importing.templates import write_import_example
from shakedown.studies.design_point import with_parameter

MAP = ["map", "two-node", "--load-factor", "0.7"]


def test_the_document_is_the_one_promised():
    found = document(*MAP, "--states", "64")
    assert found["states"] == 64
    assert found["shakedown_fraction"] == found["outcomes"]["shakedown"] / 64
    assert found["named"] == {"zero": "shakedown", "given": None, "critical": "cyclic-slip"}
    low, high = found["interval"]
    assert low < found["shakedown_fraction"] < high
    (cycle,) = found["limit_cycles"]
    assert (cycle["count"], cycle["period"], cycle["slipping_nodes"]) == (
        found["outcomes"]["cyclic-slip"],
        1,
        [1],
    )
    assert cycle["dissipation"][0] < cycle["dissipation"][1]
    assert found["unique"] is False
    assert document(*MAP)["states"] == 1024
    assert document(*MAP, "--states", "1")["states"] == 1


def test_people_read_the_share_then_what_becomes_of_slip_zero_and_the_critical_state():
    code, out, err = run(*MAP, "--states", "64")
    assert (code, err) == (0, "")
    assert max(map(len, out.splitlines())) <= 80
    text = " ".join(out.split())  # no-break spaces too
    share = text.index(
        "of 64 initial states in a box about the safe slip 84.4 % shake down (95 %: 73.6–91.3 %)"
    )
    named = text.index(
        "from zero slip shakedown from the critical state cyclic-slip dissipation 181.8 per cycle"
    )
    assert share < named
    assert "The share is that of these states" in text
    assert "same final state no" in text
    assert "type (ii)" in text


def test_a_grid_in_two_coordinates(tmp_path):
    found = document(*MAP, "--states", "30", "--grid", "1", "0", "-o", str(tmp_path / "m.npz"))
    assert (found["states"], found["sampler"], found["interval"]) == (25, "grid", [None, None])
    with np.load(tmp_path / "m.npz") as file:
        assert len(np.unique(file["initial_slip"][2:7, 1])) == 5
        assert len(np.unique(file["initial_slip"][2:7, 0])) == 1


def test_a_picture_is_drawn(tmp_path):
    path = tmp_path / "basin.svg"
    assert run(*MAP, "--states", "16", "--grid", "0", "1", "--picture", str(path))[0] == 0
    assert ET.parse(path).getroot().tag.endswith("svg")


def test_undecided_states_are_said_and_counted():
    words = [*MAP, "--states", "16", "--cycles", "1"]
    found = document(*words, code=1)
    assert found["outcomes"]["undecided"] > 0
    assert f"undecided {found['outcomes']['undecided']} is undecided" in " ".join(run(*words)[1].split())


def test_what_slides_away_is_said_without_advice_that_cannot_help(tmp_path):
    shakedown.save_problem(tmp_path / "sliding.npz", joints.sliding())
    code, out, err = run("map", str(tmp_path / "sliding.npz"), "--load-factor", "1", "--states", "16")
    text = " ".join(out.split())
    assert (code, err) == (1, "")
    assert "none is decided" in text
    assert "undecided 16" in text
    for misleading in ("--cycles", "0.0 %", "the others agree"):
        assert misleading not in text


FAST = ("--bounds", "lower,energy,upper")


def test_the_table_says_where_the_nominal_load_is_proved():
    code, out, err = run("sweep", "two-node", "--vary", "f=0.2:0.8:4", *FAST)
    assert (code, err) == (0, "")
    said = " ".join(out.split())
    assert "f at λ = 1 λ_1 this state impossible 0.2 impossible" in said
    assert "0.6 this state" in said
    assert "Limits are proved at the values given, not between them." in said
    assert max(map(len, out.splitlines())) <= 80


def test_what_is_proved_is_rounded_down_and_the_upper_bound_up():
    words = ("--vary", "friction=0.5:1.5:3")
    found = document("sweep", "two-node", *words)["points"]
    lines = run("sweep", "two-node", *words)[1].splitlines()
    (start,) = (k for k, line in enumerate(lines) if "every state  " in line)
    head = re.split("  +", lines[start].strip())[2:]  # after the parameter and the region
    assert head == ["λ_1", "every state", "this state", "λ_T", "impossible"]
    for point, line in zip(found, lines[start + 1 : start + 4], strict=True):
        lower, every, here, transient, above = map(float, line.split()[-5:])
        this = max(point[name]["load_factor"] for name in ("energy", "accumulated"))
        exact = [point[name]["load_factor"] for name in ("lower", "universal", "transient")]
        for value, shown in zip([*exact, this], [lower, every, transient, here], strict=True):
            assert 0 <= value - shown <= 1e-4 * value
        value = point["upper"]["load_factor"]
        assert 0 <= above - value <= 1e-4 * value


def test_friction_that_may_mean_two_things_is_refused(tmp_path):
    write_import_example(tmp_path / "punch")
    config = str(tmp_path / "punch" / "import.toml")
    said = "f (the friction coefficient) or friction.factor (a factor on it), found 'friction'"
    refused("sweep", config, "--vary", "friction=0.2,0.4", message=said)
    coefficient = import_problem(config).f[0]
    ways = "friction.factor=0.5", f"f={float(coefficient) / 2!r}"
    half, same = (document("sweep", config, "--vary", way, "--bounds", "upper")["points"][0] for way in ways)
    assert half["upper"] == same["upper"]
    assert "friction ×" in run("sweep", config, "--vary", "friction.factor=0.5", "--bounds", "upper")[1]


def test_json_and_csv_are_the_librarys(tmp_path):
    words = ("--vary", "f=0.1:0.4:4", *FAST, "-o", str(tmp_path / "f.csv"))
    result = document("sweep", "two-node", *words)
    two, f = shakedown.example("two-node"), np.linspace(0.1, 0.4, 4)
    found = shakedown.sweep(two, {"f": f}, bounds=("lower", "energy", "upper"))
    assert [point["upper"]["load_factor"] for point in result["points"]] == found.upper.tolist()
    with open(tmp_path / "f.csv", newline="", encoding="utf-8") as file:
        assert [float(row["lambda_1 [1]"]) for row in csv.DictReader(file)] == found.lower.tolist()
    assert [path.name for path in tmp_path.iterdir()] == ["f.csv"]


@pytest.mark.parametrize("vary", [("f=0.1:0.6:5",), ("f=0.1:0.6:3", "mean=1,2")])
def test_pictures_are_written(tmp_path, vary):
    words, name = [word for each in vary for word in ("--vary", each)], ("a.png", "b.svg")[len(vary) - 1]
    assert run("sweep", "two-node", *words, *FAST, "--picture", str(tmp_path / name))[0] == 0
    assert (tmp_path / name).stat().st_size > 1000


def test_numbers_of_a_configuration_are_parameters(tmp_path):
    write_import_example(tmp_path / "punch")
    config = str(tmp_path / "punch" / "import.toml")
    force = "load.2.forces.1.3"
    result = document("sweep", config, "--vary", f"{force}=5,10", "--bounds", "upper")
    first, second = (point["upper"]["load_factor"] for point in result["points"])
    as_given = shakedown.upper_bound(import_problem(config)).load_factor
    assert second == pytest.approx(as_given, rel=1e-9)
    assert first > second
    assert max(map(len, run("sweep", config, "--vary", f"{force}=5,10", "--quick")[1].splitlines())) <= 80
    pressed = document("sweep", config, "--vary", "load.1.history=1,2", "--bounds", "upper")
    assert pressed["points"][0]["upper"]["load_factor"] == pytest.approx(as_given, rel=1e-9)
    said = "load.9.history: expected a number from 1 to 3, found '9'"
    refused("sweep", config, "--vary", "load.9.history=1", cwd=tmp_path, message=said)
    assert run("sweep", config, "--vary", "f=0.3", "-o", config.replace("toml", "csv"))[0] == 0


@pytest.mark.slow
def test_verify_says_up_to_where_slips_stay_below_a_length(tmp_path, undrawn):
    page = tmp_path / "page.html"
    arguments = ("verify", "press-fit", "--random", "0", "--load-factor", "1")
    strict = document(*arguments)
    _, out, _ = run(*arguments, "--slip-below", "1e-3", "-o", str(page))
    found = json.loads(page.with_suffix(".json").read_text())
    criterion, _ = found.pop("slip_criterion"), found.pop("report")
    assert criterion["below"] == 1e-3
    assert criterion["load_factor"] == pytest.approx(1.3214, abs=1e-3)
    assert 0.999e-3 < criterion["largest"] < 1e-3
    for one in (strict, found):
        for each in one["runs"]:
            del each["seconds"]
    assert found == strict
    assert "slips below 0.001 mm" in page.read_text()
    assert "Largest slip range of a node" in page.read_text()
    assert "slips below 0.001 mm up to λ = 1.321" in " ".join(out.split())


def test_a_map_says_from_how_many_states_it_holds(tmp_path):
    arguments = ("map", "two-node", "--load-factor", "0.7", "--states", "64")
    strict = document(*arguments)
    path = tmp_path / "map.npz"
    found = document(*arguments, "--slip-below", "0.1", "-o", str(path))
    criterion = found.pop("slip_criterion")
    assert found == strict
    joint = shakedown.example("two-node")
    with np.load(path) as file:
        starts, ranges = file["initial_slip"], file["slip_range"]
    expected = [shakedown.simulate(joint, 0.7, start, slip_below=0.1).slip_criterion for start in starts]
    assert ranges.tolist() == [one.largest for one in expected]
    assert criterion == {
        "below": 0.1, "met": False, "largest": ranges.max(), "met_fraction": np.mean([one.met for one in expected[2:]]),
    }  # fmt: skip
    assert 0 < criterion["met_fraction"] < 1
    again = document(
        *arguments, "--slip-below", "1", "-o", str(path), "--resume"
    )  # another length, the same map
    assert again["slip_criterion"]["met"] is True
    code, out, _ = run(*arguments, "--slip-below", "0.1")
    assert code == 0
    assert f"slips below 0.1 from {100 * criterion['met_fraction']:.1f} % of the states" in " ".join(
        out.split()
    )


def test_a_sweep_says_at_every_point_up_to_where(tmp_path):
    path = tmp_path / "sweep.csv"
    arguments = ("sweep", "press-fit", "--vary", "f=0.15,0.2", "--bounds", "upper")
    strict = document(*arguments)
    found = document(*arguments, "--slip-below", "1e-3", "-o", str(path))
    joint = shakedown.example("press-fit")
    expected = [slip_limit(with_parameter(joint, "f", f), 1e-3) for f in (0.15, 0.2)]
    criteria = [point.pop("slip_criterion") for point in found["points"]]
    assert found == strict
    assert criteria == [{"below": 1e-3, "load_factor": x.load_factor, "largest": x.largest} for x in expected]
    table = pandas.read_csv(path, dtype=str)  # some versions of pandas round numbers in the last digit
    assert table["lambda_slip [1]"].map(float).tolist() == [x.load_factor for x in expected]
    assert table["largest_slip_range"].map(float).tolist() == [x.largest for x in expected]
    code, out, _ = run(*arguments, "--slip-below", "1e-3")
    assert code == 0
    assert "slips below 0.001 mm up to" in " ".join(out.split())
    assert max(map(len, out.splitlines())) <= 80
    again = document(*arguments, "--slip-below", "1e-3", "-o", str(path), "--resume")
    assert [point["slip_criterion"] for point in again["points"]] == criteria


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
    table = pandas.read_csv(path, dtype=str)
    assert list(table.columns) == MILLIMETRES
    for heading in MILLIMETRES:
        word = heading.partition(" [")[0]
        if word in ("x", "y", "z"):
            expected = [place["xyz".index(word)] for place in found["coordinates"]]
        else:
            expected = found[word]
        column = table[heading] if word in ("label", "status") else table[heading].map(float)
        assert known(column) == expected, word


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
    near = 5e-2 if method == "gauss-seidel" else 1e-8
    assert criterion["largest"] == pytest.approx(0.00181423102, rel=near)
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
