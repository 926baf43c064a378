"""What holds of the pages without building them: links lead somewhere, every page is listed, questions are answered.

Every key that the package reads is a key that the reference explains. What is said twice is the same: versions,
dependencies, commands, figures. The example of the README is run; its commands are run by `.ci/bare rest`, in one
fresh shell. ``help`` opens with names and arguments, not with the inside of NumPy's types.
"""

import ast
import doctest
import inspect
import pydoc
import re
import runpy
import tomllib
from pathlib import Path

import pytest

import shakedown
from benchmarks import claims
from shakedown import fem, plot
from shakedown.files.npz import KEYS
from shakedown.models.readers.toml_table import TomlTable

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(page for page in DOCS.rglob("*.md") if not {"_build", "paper"} & set(page.parts))
LINK = re.compile(r"(?<!!)\[[^\]]*\]\(([^)\s]+)\)")
MADE = "_gallery"  # by sphinx-gallery, from docs/gallery
TAKING = {
    name
    for name, method in inspect.getmembers(TomlTable, inspect.isfunction)
    if "key" in inspect.signature(method).parameters
}


def prose(page):
    """A page without its code."""
    return re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)


def anchors(page):
    """The anchors of its headings, as GitHub and MyST make them."""
    headings = re.findall(r"^#+ (.+)$", prose(page), re.M)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-") for heading in headings}


def source(page, link):
    """The file that a link leads to: of a page of the gallery, its script."""
    path = (page.parent / link).resolve()
    if MADE not in path.parts:
        return path
    gallery = DOCS / "gallery"
    return gallery / ("GALLERY_HEADER.rst" if path.stem == "index" else f"{path.stem}.py")


@pytest.mark.parametrize(
    "page",
    [*PAGES, ROOT / "README.md", ROOT / "CONTRIBUTING.md"],
    ids=lambda p: p.relative_to(ROOT).as_posix(),
)
def test_links_within_the_documentation_lead_somewhere(page):
    for link in LINK.findall(prose(page)):
        if "://" in link:
            continue
        path, _, anchor = link.partition("#")
        target = source(page, path) if path else page
        assert target.exists(), link
        if anchor:
            assert anchor in anchors(target), link


def test_every_page_is_listed_once():
    listed = []
    for page in PAGES:
        for tree in re.findall(r"^```\{toctree\}\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S):
            names = [line for line in tree.splitlines() if line and not line.startswith(":")]
            listed += [(page.parent / f"{name}.md").resolve() for name in names if MADE not in name]
    assert sorted(listed) == sorted(page for page in PAGES if page.name != "index.md" or page.parent != DOCS)


def test_twenty_questions_are_answered_in_two_clicks():
    """The front page leads to the list, the list to the answers; that these exist says the test of links."""
    assert "questions.md" in LINK.findall(prose(DOCS / "index.md"))
    questions = re.findall(r"^(\d+)\. (.+(?:\n   .+)*)", prose(DOCS / "questions.md"), re.M)
    assert [int(number) for number, _ in questions] == list(range(1, len(questions) + 1))
    assert len(questions) >= 20
    assert all(LINK.search(question) for _, question in questions)


def test_the_page_on_architecture_names_every_subpackage():
    named = code("explanation/architecture.md").split()
    assert {path.parent.name for path in (ROOT / "shakedown").glob("*/__init__.py")} <= set(named)


def keys_of_import_files():
    """The keys that the sections of an import file take, read from their sources."""
    found = set()
    for module in (ROOT / "shakedown" / "models" / "importing").rglob("*.py"):
        for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
            match node:
                case ast.Call(func=ast.Attribute(attr=name), args=[ast.Constant(value=str(key)), *_]) if (
                    name in TAKING
                ):
                    found.add(key)
    return found


def code(page):
    """What stands in backticks on a page, its blocks included."""
    return " ".join(re.findall(r"`+([^`]+)`+", (ROOT / "docs" / page).read_text(encoding="utf-8")))


@pytest.mark.parametrize(
    ("page", "keys"), [("import.md", keys_of_import_files()), ("reference/problem-file.md", set(KEYS))]
)
def test_every_key_is_explained(page, keys):
    assert len(keys) > 20
    assert [key for key in sorted(keys) if not re.search(rf"\b{key}\b", code(page))] == []


@pytest.mark.parametrize("page", ["library.md", "pictures-and-bodies.md"])
def test_the_lists_of_names_are_those_of_the_package(page):
    """Written by python docs/_extensions/api_pages.py."""
    written = runpy.run_path(str(ROOT / "docs" / "_extensions" / "api_pages.py"))["written"](page)
    assert written == (ROOT / "docs" / "reference" / page).read_text(encoding="utf-8")


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


CALLABLE = {
    f"{module.__name__}.{name}": getattr(module, name)
    for module in (shakedown, fem, plot)
    for name in dir(module)
    if not name.startswith("_")
}
FUNCTIONS = {name: thing for name, thing in CALLABLE.items() if inspect.isfunction(thing)}
CONSTRUCTED = {  # what users construct
    "Problem": shakedown.Problem,
    "LoadCase": shakedown.LoadCase,
    "Tolerances": shakedown.Tolerances,
    **{name: vars(fem)[name] for name in sorted(vars(fem)) if inspect.isclass(vars(fem)[name])},
}
INTERNAL = ("_typing", "numpy.ndarray", "Union[", "ForwardRef")


def opening(thing) -> str:
    """The line of ``help`` with the arguments."""
    lines = pydoc.plain(pydoc.render_doc(thing)).splitlines()
    return next(line for line in lines[2:] if "(" in line and not line.startswith("class "))


@pytest.mark.parametrize("name", FUNCTIONS)
def test_help_of_a_function_opens_with_its_name_and_arguments(name):
    line = opening(FUNCTIONS[name])
    assert line.startswith(f"{name.rpartition('.')[2]}(")
    assert not [word for word in INTERNAL if word in line]
    assert len(line) < 300


@pytest.mark.parametrize("name", CONSTRUCTED)
def test_help_of_a_class_shows_no_internals_of_numpy(name):
    line = opening(CONSTRUCTED[name])
    assert not [word for word in INTERNAL if word in line]


def test_the_types_stay_for_type_checkers_and_tools():
    function = inspect.unwrap(shakedown.simulate)
    assert inspect.get_annotations(shakedown.simulate) == function.__annotations__ != {}
