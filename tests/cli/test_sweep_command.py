"""`shakedown-bounds sweep`: tables, pictures, what is said of bad words."""

import csv
import re

import numpy as np
import pytest
from command import document, refused, run

import shakedown
from shakedown.models.importing.import_model import import_problem
from shakedown.models.importing.templates import write_import_example

VARY = "--vary: expected NAME= and LOW:HIGH:COUNT or VALUE,VALUE,…, rising, at most 1,000,000, found '"
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
    half = document("sweep", config, "--vary", "friction.factor=0.5", "--bounds", "upper")["points"][0]
    same = document("sweep", config, "--vary", f"f={float(coefficient) / 2!r}", "--bounds", "upper")[
        "points"
    ][0]
    assert half["upper"] == same["upper"]
    assert "friction ×" in run("sweep", config, "--vary", "friction.factor=0.5", "--bounds", "upper")[1]
    code, _, err = run("sweep", "two-node", "--vary", "mean=1", "--vary", "mean.factor=2")
    assert (code, "found mean twice" in err) == (2, True)


def test_json_and_csv_are_the_librarys(tmp_path):
    words = ("--vary", "f=0.1:0.4:4", *FAST, "-o", str(tmp_path / "f.csv"))
    result = document("sweep", "two-node", *words)
    found = shakedown.sweep(
        shakedown.example("two-node"),
        {"f": np.linspace(0.1, 0.4, 4)},
        bounds=("lower", "energy", "upper"),
    )
    assert [point["upper"]["load_factor"] for point in result["points"]] == found.upper.tolist()
    with open(tmp_path / "f.csv", newline="", encoding="utf-8") as file:
        assert [float(row["lambda_1 [1]"]) for row in csv.DictReader(file)] == found.lower.tolist()
    assert [path.name for path in tmp_path.iterdir()] == ["f.csv"]


@pytest.mark.parametrize("vary", [("f=0.1:0.6:5",), ("f=0.1:0.6:3", "mean=1,2")])
def test_pictures_are_written(tmp_path, vary):
    words, name = [word for each in vary for word in ("--vary", each)], ("a.png", "b.svg")[len(vary) - 1]
    assert run("sweep", "two-node", *words, *FAST, "--picture", str(tmp_path / name))[0] == 0
    assert (tmp_path / name).stat().st_size > 1000


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((), "Missing option '--vary'"),
        (("--vary", "f"), VARY),
        (("--vary", "f=0.1:0.2"), VARY),
        (("--vary", "f=0.1:0.2:999999999"), VARY),
        (("--vary", "f=0.2:0.1:3"), VARY),
        (("--vary", "f=nan:1:3"), VARY),
        (("--vary", "f=0.1,x"), VARY),
        (("--vary", "f=1", "--vary", "f=2"), "expected each parameter once, found f twice"),
        (("--vary", "f=0.3", "--initial", "three.npy"), "initial slip: expected shape (2,), found (3,)"),
        (("--vary", "f=0.3", "--resume"), "--resume: expected -o FILE"),
        (("--vary", "f=0.3", "-o", "table.xlsx"), "ends in .csv or .parquet"),
        (("--vary", "f=0.3", "--picture", "a.txt"), "ends in .png, .svg or .pdf"),
        (("--vary", "f=-0.3,-0.2"), "--vary: no value makes a joint: key 'f': expected friction"),
        (("--vary", "f=0.1,0.3", "--vary", "mean=1", "--picture", "a.png"), "expected two values or more"),
    ],
)
def test_bad_words_are_one_line(tmp_path, words, message):
    np.save(tmp_path / "three.npy", np.zeros(3))
    refused("sweep", "two-node", *words, cwd=tmp_path, message=message)


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
