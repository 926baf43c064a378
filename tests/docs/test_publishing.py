"""What is said twice is the same: versions, dependencies, commands, figures; the example of the README is run.

Its commands are run by `.ci/bare rest`, in one fresh shell.
"""

import doctest
import re
import tomllib
from pathlib import Path

import pytest

import shakedown
from benchmarks import claims

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
RECIPE = (ROOT / ".conda" / "recipe.yaml").read_text(encoding="utf-8")
WORKFLOW = (ROOT / ".github" / "workflows" / "tests.yml").read_text(encoding="utf-8")
README = (ROOT / "README.md").read_text(encoding="utf-8")
CONDA = {"matplotlib": "matplotlib-base"}  # where conda-forge has a leaner package


def test_one_version():
    said = {
        "CITATION.cff": r"^version: (.+)$",
        ".conda/recipe.yaml": r'^  version: "(.+)"$',
        "CHANGELOG.md": r"^## ([\d.]+)",
        "docs/howto/cite.md": r"version ([\d.]+\d)",
    }
    found = {
        file: re.search(pattern, (ROOT / file).read_text(encoding="utf-8"), re.M)[1]
        for file, pattern in said.items()
    }
    assert {*found.values(), PROJECT["version"]} == {shakedown.__version__}, found


def test_the_recipe_has_the_dependencies_of_the_package():
    split = [re.fullmatch(r"([\w-]+)(>=.+)", dependency).groups() for dependency in PROJECT["dependencies"]]
    expected = [f"{CONDA.get(name, name)} {bound}" for name, bound in split]
    listed = re.search(r"^  run:\n((?:    - .+\n)+)", RECIPE, re.M)[1]
    assert re.findall(r"^    - (.+)$", listed, re.M) == ["python >=${{ python_min }}", *expected]
    assert f'  python_min: "{PROJECT["requires-python"].removeprefix(">=")}"\n' in RECIPE
    script = PROJECT["scripts"]["shakedown-bounds"]
    assert f"- shakedown-bounds = {script}" in RECIPE


def test_the_workflow_calls_commands_that_are_there():
    assert all(f"          {line}\n" in WORKFLOW for line in blocks("bat")[0].splitlines())
    commands = re.search(r"command: \[(.+)\]", WORKFLOW)[1].split(", ")
    commands += re.findall(r"bash \.ci/(\w+)", WORKFLOW)
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


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


def test_the_library_example_gives_what_it_shows():
    result = doctest.testfile(str(ROOT / "README.md"), module_relative=False)
    assert (result.attempted > 0, result.failed) == (True, 0)


def test_it_is_read_in_five_minutes():
    assert len(README.split()) <= 800


def test_the_answer_is_the_one_on_the_front_page():
    """Where it is run (tests/docs)."""
    assert blocks("console")[0] in (ROOT / "docs" / "index.md").read_text(encoding="utf-8")


def test_windows_has_the_same_two_lines():
    lines = blocks("bat")[0].splitlines()
    posix = re.findall(r"<!-- (?:run|test) command -->\n```sh\n(.*?)\n```", README, re.DOTALL)
    for windows, line in zip(lines, posix, strict=True):
        words = line.replace("python3", "py").replace("/bin/", "/Scripts/").replace("'", '"')
        assert windows.replace("\\", "/") == words


@pytest.mark.parametrize("word", claims.WRITTEN)
def test_the_figures_are_those_of_the_stored_results(word):
    assert claims.split(word)[1] == claims.WRITTEN[word][1]()
