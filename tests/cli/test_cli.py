"""The command: JSON fields, exit codes, labels and units, one line for every error, 80 columns, light imports; what `solve` says."""

import dataclasses
import inspect
import json
import os
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from command import document, refused, run
from partly_open import partly_open

import shakedown
from shakedown.cli.run import shakedown_bounds
from shakedown.report.facts import notes


def test_solve_has_every_field():
    result = document("solve", "two-node")
    assert result["problem"] == {"name": "two-node system (5.3.1)", "n": 2, "m": 50}
    lower, upper = result["lower"], result["upper"]
    assert lower["load_factor"] == pytest.approx(0.6573734697246544, abs=1e-12)
    assert lower["slip"] == pytest.approx([1.53656435, 1.59365716], abs=1e-7)
    assert (lower["node"], lower["kind"], lower["guarantee"]) == (1, "first-collapse", "proved")
    assert {"reason", "coupling_ratio"} <= set(lower)
    assert lower["single_node_bound"] is result["box"] is result["core"] is result["closing_box"] is None
    assert upper["load_factor"] == pytest.approx(0.7391455673806329, abs=1e-12)
    assert upper["slip"] == pytest.approx([-0.15634934, 1.28772669], abs=1e-7)
    assert upper["status"] == "optimal"
    assert sorted(upper["active"]) == [[0, -1], [1, -1], [1, 1]]
    assert {"certified"} <= set(upper)
    assert result["friction"]["single_node"] == pytest.approx([0.760824, 2.022474], abs=1e-6)
    assert {"uniqueness_in_contact", "uniqueness", "wedging"} <= set(result["friction"])
    energy = result["energy"]
    assert energy["load_factor"] == pytest.approx(0.6619611189, abs=1e-9)
    assert (energy["status"], energy["distance"], len(energy["slip"])) == ("optimal", 0.0, 2)
    assert energy["radius"] > 0
    assert {"load_factor", "status"} <= set(result["accumulated"])
    words = {"status": "optimal", "node": 1, "argument": "first collapse"}
    assert result["universal"] == {"load_factor": pytest.approx(0.65737347)} | words
    assert "followed" not in result
    assert {"edge_share", "coarser", "warning"} <= set(result["mesh"])


def test_critical_has_every_field():
    result = document("critical", "two-node", "--all")
    assert (result["total"], result["regular"], result["degenerate"]) == (4, 4, 0)
    assert result["smallest_positive"]["load_factor"] == pytest.approx(0.6573734697246544, abs=1e-12)
    assert sorted(result["smallest_positive"]["rows"]) == [[0, 1], [1, -1], [1, 1]]
    expected = [0.6573734697246544, 0.7391455673806329, 1.05252030036052, 2.9348503882950054]
    assert result["load_factors"] == pytest.approx(expected, abs=1e-9)
    assert "load_factors" not in document("critical", "two-node")


def test_simulate_has_every_field():
    result = document("simulate", "two-node", "--load-factor", "0.7", "--initial", "witness")
    assert result["outcome"] == "cyclic-slip"
    assert result["period"] == 1
    assert len(result["final_slip"]) == len(result["slip_per_cycle"]) == 2
    keys = {"load_factor", "dissipation_per_cycle", "cycles_simulated", "method", "events", "open_nodes"}
    keys |= {"proved", "energy_margin", "jumps_per_cycle"}
    assert keys <= set(result)
    parts = result["friction_dissipation_per_cycle"], result["jump_dissipation_per_cycle"]
    assert sum(parts) == pytest.approx(result["dissipation_per_cycle"]) != 0
    short = document("simulate", "two-node", "--load-factor", "0.8", "--cycles", "1", code=1)
    assert short["outcome"] == "undecided"


@pytest.mark.parametrize(("name", "jumps"), [("one-node-cyclic", True), ("one-node", False)])
def test_jumps_are_told_where_there_are_some(name, jumps):
    _, out, _ = run("simulate", name, "--load-factor", "1")
    assert ("jumps per cycle" in out) == ("by damping in jumps" in out) == jumps


def test_a_table_with_slips_after_the_transient_has_80_columns(tmp_path):
    two = shakedown.example("two-node")
    destroyed = replace(two, q_transient=[[-1293.0, -1382.0]], p_transient=[[790.0, 2417.0]], units="N, mm")
    shakedown.save_problem(tmp_path / "t.npz", destroyed)
    _, out, _ = run("verify", "t.npz", "--random", "0", "--details", cwd=tmp_path)
    assert out.count("(after)") > 1
    assert "(after): the state locked in when the transient load steps are over." in out
    assert max(map(len, out.splitlines())) <= 80


@pytest.mark.usefixtures("undrawn")
def test_verify_has_every_run(tmp_path):
    result = document("verify", "two-node", "-o", "r.html", cwd=tmp_path)
    assert result["agrees"] is True
    assert result["disagreements"] == []
    assert (
        len(result["runs"]) == 2 * 8 + 6 + 2
    )  # no energy ball above λ_max; λ = 1 and below λ_S from slip zero
    stored = json.loads((tmp_path / "r.json").read_text())
    assert stored["upper"] == result["upper"]
    page = (tmp_path / "r.html").read_text()
    assert "<svg" in page
    assert not re.search(r'(src|href)="(?!#|data:image/png)', page), "the page loads something"


@pytest.mark.usefixtures("undrawn")
def test_disagreement_is_exit_code_1_and_stands_below_the_answer(tmp_path):
    code, out, err = run("verify", "three-node", "-o", "r.html", cwd=tmp_path)
    assert (code, err) == (1, "")
    assert out.splitlines()[2].startswith("At the nominal load (λ = 1) the joint shakes down")
    assert out.index("\nDISAGREEMENT: ") < out.index("\n\n")
    page = (tmp_path / "r.html").read_text()
    assert page.index("DISAGREE") < page.index("<h2")
    assert json.loads((tmp_path / "r.json").read_text())["agrees"] is False


def test_example_lists_and_writes(tmp_path):
    assert {e["example"] for e in document("example")["examples"]} == set(shakedown.example_names())
    assert run("example", "two-node", "-o", "p.npz", cwd=tmp_path)[0] == 0
    assert shakedown.load_problem(tmp_path / "p.npz") == shakedown.example("two-node")
    assert run("example", "two-node", cwd=tmp_path)[0] == 0
    assert (tmp_path / "two-node.npz").exists()
    assert run("example", "two-node", cwd=tmp_path)[0] == 2  # never overwritten without being named


def test_a_file_wins_over_a_built_in_name(tmp_path):
    shakedown.save_problem(tmp_path / "two-node", shakedown.example("one-node"))
    assert document("solve", "two-node", cwd=tmp_path)["problem"]["n"] == 1


def test_a_budget_refuses_before_the_work_starts():
    code, out, err = run("critical", "block-9", "--budget", "1000")
    assert (code, out) == (1, "")
    assert "43,758" in err


GIVEN = [2.60902, -0.60226, -0.36541]


@pytest.mark.parametrize(
    ("joint", "initial", "expected"),
    [
        ("three-node", ["--initial", "zero"], [0.0, 0.0, 0.0]),
        ("three-node", ["--initial", "given"], GIVEN),
        ("three-node", ["--initial", "given:0"], GIVEN),
        ("three-node", [], GIVEN),
        ("two-node", [], [0.0, 0.0]),
    ],
)
def test_initial_states(joint, initial, expected):
    found = document("simulate", joint, "--load-factor", "0.5", *initial)
    assert found["initial_slip"] == expected


def test_the_safe_slip_is_that_of_the_load_factor_be_it_zero():
    """At λ = 1 there is none."""
    found = document("simulate", "two-node", "--load-factor", "0", "--initial", "safe")
    assert found["initial_slip"] == shakedown.safe_slip(shakedown.example("two-node"), 0.0).slip.tolist()


def test_initial_state_from_a_file_and_history_to_a_file(tmp_path):
    np.save(tmp_path / "v.npy", np.array([0.5, 0.25]))
    words = ("simulate", "two-node", "--load-factor", "0.7", "--initial", "v.npy", "-o", "h.npz")
    result = document(*words, cwd=tmp_path)
    assert result["initial_slip"] == [0.5, 0.25]
    with np.load(tmp_path / "h.npz", allow_pickle=False) as history:
        assert history["v"].shape == history["q"].shape == history["w"].shape
        assert history["v"][-1].tolist() == result["final_slip"]


def test_infinite_and_undefined_numbers_are_written_as_agreed(tmp_path):
    still = shakedown.Problem(A=[[1.0]], B=[[0.0]], f=0.5, q_w=[[0.1], [0.1]], p_w=[[1.0], [1.0]])
    shakedown.save_problem(tmp_path / "still.npz", still)
    result = document("solve", "still.npz", cwd=tmp_path)
    assert (result["upper"]["status"], result["upper"]["load_factor"]) == ("unbounded", "inf")
    assert result["upper"]["slip"] == [None]
    assert result["friction"]["single_node"] == ["inf"]


@pytest.mark.parametrize("name", ["three-node", "receding-block", "jump", "four-node-3d"])
def test_output_fits_80_columns(name):  # of solve: test_proved.py
    _, out, _ = run("simulate", name, "--load-factor", "1")
    assert max(map(len, out.splitlines()), default=0) <= 80


CALLED = {"critical": "critical_load_factors", "map": "initial_state_map", "solve": "energy_bound"}


@pytest.mark.parametrize("name", [*CALLED, "damping", "refine", "simulate", "sweep", "verify"])
def test_numbers_that_are_not_given_are_those_of_the_library(name):
    parameters = inspect.signature(getattr(shakedown, CALLED.get(name, name))).parameters.values()
    theirs = {each.name: each.default for each in parameters if type(each.default) in (int, float)}
    given = {each.name: each.default for each in shakedown_bounds.commands[name].params}
    shared = {key for key in theirs.keys() & given.keys() if type(given[key]) in (int, float)}
    assert shared
    assert {key: given[key] for key in shared} == {key: theirs[key] for key in shared}


def test_help_is_short_and_complete():
    result = CliRunner().invoke(shakedown_bounds, ["--help"])
    assert result.exit_code == 0
    assert "..." not in result.output.partition("Commands:")[2]


HEAVY = {"numba", "cvxpy", "matplotlib", "jinja2"}
SOLVERS = {"scipy", "clarabel", "flint", "highspy"}  # the energy bound is a cone program


def test_light_commands_import_nothing_heavy():
    commands = [["--help"], ["solve", "two-node"], ["solve", "block-3x3"]]
    code = (
        "import sys; from shakedown.cli.main import main\n"
        f"for sys.argv[1:] in {commands!r}:\n"
        "    try: main()\n"
        "    except SystemExit: print('MODULES', *{name.partition('.')[0] for name in sys.modules})\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    told = [line.split() for line in done.stdout.splitlines() if line.startswith("MODULES")]
    assert len(told) == len(commands)
    for loaded, unwanted in zip(told, (HEAVY | SOLVERS, HEAVY, HEAVY), strict=True):
        assert "shakedown" in loaded
        assert not unwanted.intersection(loaded)


def test_a_closed_pipe_ends_quietly():
    read, write = os.pipe()
    os.close(read)
    code = "from shakedown.cli.main import main; main()"
    words = [sys.executable, "-c", code, "example", "--json"]
    done = subprocess.run(words, stdout=write, stderr=subprocess.PIPE, text=True, check=False)
    os.close(write)
    assert (done.returncode, done.stderr) == (1, "")


@pytest.mark.slow
def test_public_names_load_at_once_where_the_environment_asks_for_it():
    """EAGER_IMPORT of scientific-python: nothing that is public needs an extra, or the package half loaded."""
    code = "import shakedown, sys; print('shakedown.assessment.verify' in sys.modules)"
    words, env = [sys.executable, "-c", code], {**os.environ, "EAGER_IMPORT": "1"}
    done = subprocess.run(words, env=env, capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("True\n", "")


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("labels") / "named.npz"
    joint = dataclasses.replace(shakedown.example("two-node"), label=["4711/12", "4712/13"], units="N, mm")
    shakedown.save_problem(path, joint)
    return str(path)


@pytest.mark.parametrize(
    ("words", "shown"),
    [
        (["solve", "--details"], ["4712/13", "safe slip [mm]", "critical slip [mm]", "node 1 (FE 4712/13)"]),
        (["critical"], ["1 (FE 4712/13) backward", "slip there [mm]"]),
        (["simulate", "--load-factor", "0.9"], ["4712/13", "final [mm]", "N mm"]),
        (["verify", "--random", "0", "--details"], ["node 1 (FE 4712/13)", "Σ|Δv| [mm]"]),
    ],
    ids=lambda value: value[0],
)
def test_nodes_have_their_labels_and_numbers_their_units(file, words, shown):
    _, out, _ = run(words[0], file, *words[1:])
    unwrapped = " ".join(out.split())
    for text in shown:
        assert text in unwrapped
    assert max(map(len, out.splitlines())) <= 80


def test_round_off_is_shown_as_zero_and_kept_in_the_json():
    _, out, _ = run("simulate", "jump", "--load-factor", "1")
    lines = out.splitlines()
    assert [line.split()[-1] for line in lines if "dissipation per cycle" in line] == ["0"]
    assert "e-15" not in out
    assert document("simulate", "jump", "--load-factor", "1")["dissipation_per_cycle"] < 1e-12


@pytest.mark.parametrize("command", ["solve", "critical", "simulate", "verify", "import", "example"])
def test_every_command_says_what_its_exit_codes_mean(command):
    _, out, _ = run(command, "--help")
    assert "Exit codes: 0 " in out


A = np.array([[4.0, -1.0, 0.0], [-1.0, 4.0, -1.0], [0.0, -1.0, 4.0]])


@pytest.fixture(scope="module")
def apart(tmp_path_factory):
    path = tmp_path_factory.mktemp("apart") / "apart.npz"
    q_w = 100.0 * np.outer(np.sin(2 * np.pi * np.arange(8) / 8), np.ones(3))
    p_w = np.full((8, 3), -300.0)
    shakedown.save_problem(path, shakedown.Problem(A=A, B=0.3 * np.eye(3), C=A, f=0.4, q_w=q_w, p_w=p_w))
    return str(path)


@pytest.mark.parametrize("words", ["simulate", "nodes"])
def test_the_sign_or_a_gap_is_asked_for_once_before_the_first_sentence(apart, words):
    code, out, _ = run(words, apart, "--load-factor", "1")
    assert code == 0
    before, _, after = out.partition(notes.apart)
    assert "Is its sign right? Or does an initial gap stay open?" in " ".join(before.split())
    assert "Is the sign" not in after


def test_verification_asks_once_for_the_sign_and_says_why(apart):
    code, out, _ = run("verify", apart, "--details")
    assert code == 0
    assert notes.apart in out
    assert " ".join(out.split()).count("Is its sign right?") == 1
    assert "Is the sign" not in out


def test_solve_says_first_what_is_certain():
    lines = [" ".join(line.split()) for line in run("solve", "block-9")[1].splitlines()]
    assert lines[1] == "constant load: mean of steps, assumed (no q_mean, p_mean); λ scales the rest"
    assert "the joint shakes down from zero slip:" in lines[2]
    assert lines[4:8] == [
        "shakedown (slip ceases) load factor margin valid for",
        "proved from every state not proved – full contact",
        "proved from this state 4.663 +366.3 % zero slip (λ_E)",
        "impossible above 4.716 +371.6 % full contact (λ_max)",
    ]
    assert lines[-1].startswith("next shakedown-bounds verify block-9 -o report.html")


def test_details_have_every_limit_once():
    out = run("solve", "block-9", "--details")[1]
    for symbol, name in (
        ("λ_1", "first collapse"),
        ("λ_U", "from every state"),
        ("λ_max", "impossible above"),
    ):
        assert out.count(f"  {symbol} ") == 1
        assert name in out
    assert run("solve", "block-9", "--details", "--digits", "7")[1].count("4.663390") == 2


def test_what_is_proved_by_following_stands_below_the_three_numbers():
    out = run("solve", "two-attractors", "--follow")[1]
    told = document("solve", "two-attractors", "--follow")
    followed, numbers = told["followed"], told["assessment"]
    assert numbers["proved_from_this_state"] < followed["load_factor"] <= numbers["impossible_above"]
    assert (followed["cycles"], followed["proved"]) == (1, True)
    (row,) = (line.split() for line in out.splitlines() if line.startswith("  followed"))
    assert 0 <= followed["load_factor"] - float(row[3]) < 1e-3
    assert " ".join(row[4:]) == "proved for this λ only, after 1 cycle"


def test_initial_state_and_distance_are_the_energy_bounds(tmp_path):
    joint = shakedown.example("three-node")
    given = document("solve", "three-node", "--initial", "given", "--distance", "0.1")["energy"]
    expected = shakedown.energy_bound(joint, joint.initial_slip[0], 0.1)
    assert given["status"] == expected.status
    assert given["distance"] == 0.1
    np.save(tmp_path / "state.npy", [0.1, 0.0, 0.0])
    read = document("solve", "three-node", "--initial", str(tmp_path / "state.npy"))["energy"]
    assert read["load_factor"] == pytest.approx(shakedown.energy_bound(joint, [0.1, 0, 0]).load_factor)


@pytest.mark.parametrize(
    ("required", "code"),
    [
        (["proved-from-state=0.73"], 0),
        (["proved-from-state=0.732"], 1),
        (["proved-from-every-state=0.65", "proved-from-state=0.73"], 0),
        (["proved-from-every-state=0.66", "proved-from-state=0.8"], 1),
    ],
)
def test_what_is_required_is_proved_or_the_exit_code_is_1(required, code):
    options = [word for claim in required for word in ("--require", claim)]
    found, out, err = run("solve", "two-node", "--json", *options)
    assert (found, err.count("\n")) == (code, len(required) * code)
    assert "assessment" in out
    if code:
        name, least = required[-1].split("=")
        assert f"--require {name}={least}: not met, proved is up to λ = 0.7315934\n" in err


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    ("name", "colour", "answer"),
    [
        ("two-node", "slips", "the joint slips in every cycle: simulated."),
        ("block-9", "agree", "the joint shakes down from zero slip: proved."),
    ],
)
def test_the_report_begins_with_the_answer_for_the_loading_as_given(tmp_path, name, colour, answer):
    code, out, _ = run("verify", name, "--random", "0", "--details", "-o", "r.html", cwd=tmp_path)
    assert code == 0
    assert answer in " ".join(out.split())
    page = (tmp_path / "r.html").read_text()
    banner = page[page.index('<div class="verdict') : page.index("<h2")]
    assert f'class="verdict {colour}"' in banner
    assert answer in banner.replace("\N{NO-BREAK SPACE}", " ")


def test_simulate_takes_the_nominal_load():
    assert document("simulate", "two-node") == document("simulate", "two-node", "--load-factor", "1")


def test_the_text_names_the_open_nodes_and_claims_no_upper_bound_of_the_joint():
    text = " ".join(run("solve", "receding-block", "--details")[1].split())
    assert "open nodes nodes 0–4, 28–32 assumed; all others closed safe slip up to 0.2281" in text
    assert "impossible above unknown (10 nodes open)" in text
    for wrong in ("upper bound", "cannot shake down", "λ_max impossible above"):
        assert wrong not in text


@pytest.mark.parametrize("d", [1, 2])
def test_the_table_says_which_nodes_are_open_and_which_gaps_close(d, tmp_path):
    """Open nodes have no friction limit to reach."""
    joint = shakedown.example("receding-block") if d == 1 else partly_open(3, 5, d=2)
    shakedown.save_problem(tmp_path / "joint.npz", joint)
    out = run("solve", str(tmp_path / "joint.npz"), "--details")[1]
    upper = shakedown.upper_bound(joint, open_nodes="auto")
    closing = {node for node, _ in upper.active} & {*upper.open_nodes}
    rows = [line for line in out.partition("reached at λ_max")[2].splitlines() if re.match(r" +\d+ ", line)]
    assert len(rows) == joint.n
    assert {i for i, row in enumerate(rows) if "open" in row} == {*upper.open_nodes}
    assert {i for i, row in enumerate(rows) if "open; gap closes" in row} == closing
    assert "open: throughout; its safe slip is the displacement" in out
    assert closing


def test_nodes_may_be_named_or_none():
    asked = "solve", "receding-block"
    assert document(*asked, "--open", "none")["upper"]["status"] == "infeasible"
    assert document(*asked, "--open", "16", code=1)["upper"]["open_nodes"] == [16]
    text = " ".join(run("solve", "receding-block", "--open", "16")[1].split())
    assert "open nodes node 16 (FE 144) assumed; all others closed safe slip none" in text
    named = ",".join(map(str, [0, 1, 2, 3, 4, 28, 29, 30, 31, 32]))
    found = document(*asked, "--open", named, code=1)["upper"]  # nothing is known of the whole joint
    assert found["load_factor"] == document(*asked, code=1)["upper"]["load_factor"]


def test_simulate_starts_with_open_nodes(tmp_path):
    words = ["simulate", "cylinder-on-flat", "--load-factor", "0.5", "--initial", "safe", "--open"]
    found = [document(*words, nodes, cwd=tmp_path) for nodes in ("auto", "0,1,2,10,11,12")]
    assert found[0] == found[1]
    assert found[0]["outcome"] == "shakedown"
    assert found[0]["proved"]
    assert found[0]["open_nodes"] == [0, 1, 2, 10, 11, 12]
    refused(*words, "13", cwd=tmp_path, message="open nodes: expected")


BLOCK = "block-3x3"


def test_text_begins_with_the_three_numbers_and_ends_with_both_slips_of_every_node():
    code, out, err = run("solve", BLOCK, "--details")
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert max(map(len, lines)) <= 80
    assert lines[0] == "elastic block in space: 9 nodes (3-D), 40 load steps, f = 0.4"
    assert "λ_1, sensitivities and friction thresholds exist for plane joints" in " ".join(out.split())
    (head,) = (k for k, line in enumerate(lines) if "safe slip x  safe slip y  reached at λ_max" in line)
    safe = shakedown.upper_bound(shakedown.example(BLOCK)).slip
    for node, line in enumerate(lines[head + 1 : head + 10]):
        number, x, y, *steps = line.split()
        assert int(number) == node
        np.testing.assert_allclose([float(x), float(y)], safe[2 * node : 2 * node + 2], rtol=1e-6)
        assert all(0 <= int(step) < 40 for run in steps if run != "–" for step in run.rstrip(",").split("–"))
    assert "x, y: the two tangential directions of a node" in out
