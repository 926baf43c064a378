"""What is said twice is the same: versions, dependencies, commands."""

import re
import tomllib
from pathlib import Path

import shakedown

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
RECIPE = (ROOT / ".conda" / "recipe.yaml").read_text(encoding="utf-8")
WORKFLOW = (ROOT / ".github" / "workflows" / "tests.yml").read_text(encoding="utf-8")
CONDA = {"matplotlib": "matplotlib-base"}  # where conda-forge has a leaner package


def listed(recipe, heading):
    """The items below a heading of the recipe."""
    block = re.search(rf"^  {heading}:\n((?:    - .+\n)+)", recipe, re.M)
    return re.findall(r"^    - (.+)$", block[1], re.M)


def test_one_version():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    found = {
        PROJECT["version"],
        shakedown.__version__,
        re.search(r"^version: (.+)$", citation, re.M)[1],
        re.search(r'^  version: "(.+)"$', RECIPE, re.M)[1],
        re.search(r"^## ([\d.]+)", changelog, re.M)[1],
        re.search(r"version ([\d.]+\d)", (ROOT / "docs" / "howto" / "cite.md").read_text(encoding="utf-8"))[
            1
        ],
    }
    assert len(found) == 1, found


def test_the_recipe_has_the_dependencies_of_the_package():
    split = [re.fullmatch(r"([\w-]+)(>=.+)", dependency).groups() for dependency in PROJECT["dependencies"]]
    expected = [f"{CONDA.get(name, name)} {bound}" for name, bound in split]
    assert listed(RECIPE, "run") == ["python >=${{ python_min }}", *expected]
    assert re.search(r'^  python_min: "(.+)"$', RECIPE, re.M)[1] == PROJECT["requires-python"].removeprefix(
        ">="
    )
    script = PROJECT["scripts"]["shakedown-bounds"]
    assert f"- shakedown-bounds = {script}" in RECIPE


def test_the_workflow_calls_commands_that_are_there():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    windows = re.search(r"```bat\n(.*?)```", readme, re.S)[1].splitlines()
    assert all(f"          {line}\n" in WORKFLOW for line in windows)
    commands = [
        *re.findall(r"bash \.ci/(\w+)", WORKFLOW),
        *re.search(r"command: \[(.+)\]", WORKFLOW)[1].split(", "),
    ]
    assert all((ROOT / ".ci" / command.split()[0]).is_file() for command in commands)
    assert f'["{PROJECT["requires-python"].removeprefix(">=")}", ' in WORKFLOW


def test_the_paper_cites_what_is_listed_and_claims_what_was_measured():
    folder = ROOT / "docs" / "paper"
    paper = (folder / "paper.md").read_text(encoding="utf-8")
    keys = re.findall(r"^@\w+\{(\w+),", (folder / "paper.bib").read_text(encoding="utf-8"), re.M)
    assert set(re.findall(r"@(\w+\d{4})", paper)) == set(keys)
    assert len(keys) == len(set(keys))
    figures = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", paper)
    assert figures
    assert all((folder / figure).is_file() for figure in figures)
    pages = (ROOT / "docs" / "results.md", ROOT / "docs" / "explanation" / "archive.md")
    results = "".join(page.read_text(encoding="utf-8") for page in pages)
    assert all(number in results for number in re.findall(r"\b\d+(?:,\d{3})+\b", paper))
