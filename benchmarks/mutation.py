"""Who tests the tests: one operator, comparison, sign or constant of the package changed at a time.

All tests run once, while pytest-cov (``pip install pytest-cov``) notes which of them run which lines. Each
place drawn is changed in a copy of the repository, where the tests run that run its line. Which run what
Numba compiles is unknown: there those of its subpackage run, and of the one that uses it. A change that no
test notices survives: a test is missing, or nothing needs the code, or both mean the same.

``python -m benchmarks.mutation`` goes on where it stopped; what is measured by then is a sample of them all.
"""

import ast
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

from benchmarks.runner import run_study
from shakedown.report.facts import table

TITLE = "Changes of the source that no test notices"
ROOT = Path(__file__).parents[1]
DECIDE = ("joint", "programs", "bounds", "motion", "long_term", "models/importing", "assessment")
FOLDERS = (*(f"shakedown/{name}" for name in (*DECIDE, "studies", "report")), "cli")
USED_BY = {"motion": ["long_term"]}  # whose tests say more
PLACES = 200
SEED = 2  # another one draws a fresh sample
SECONDS = 900  # of tests that do not end: the change is noticed
CODE_CACHE = "shakedown/ground/code_cache.py"
COMPILED = re.compile(rb"\bnamed_state\b|\bnumba\b")  # a module with functions that Numba compiles
PAIRS = (  # operators that stand for each other
    (ast.Lt, "<", ast.LtE, "<="),
    (ast.Gt, ">", ast.GtE, ">="),
    (ast.Eq, "==", ast.NotEq, "!="),
    (ast.Add, "+", ast.Sub, "-"),
    (ast.Mult, "*", ast.Div, "/"),
    (ast.And, "and", ast.Or, "or"),
)
CHANGED = {kind: (a, b) for x, a, y, b in PAIRS for kind, a, b in ((x, a, b), (y, b, a))}


class Place(NamedTuple):
    """A piece of a line of a file, and what stands there instead."""

    path: str
    line: int
    column: int
    found: str
    changed: str


def places(path: Path) -> Iterator[Place]:
    """Whatever can be changed in a file; annotations and docstrings are left alone."""
    lines, name = path.read_bytes().splitlines(), str(path.relative_to(ROOT))

    def between(before: ast.expr, after: ast.expr, found: str, changed: str) -> Iterator[Place]:
        line, start = before.end_lineno or 0, before.end_col_offset or 0
        while line <= after.lineno:
            end = after.col_offset if line == after.lineno else len(lines[line - 1])
            column = lines[line - 1].find(found.encode(), start, end)
            if column >= 0:
                yield Place(name, line, column, found, changed)
                return
            line, start = line + 1, 0

    for node in _calculated(ast.parse(path.read_bytes())):
        if isinstance(node, ast.Compare):
            for before, operator, after in zip(
                [node.left, *node.comparators], node.ops, node.comparators, strict=False
            ):
                if type(operator) in CHANGED:
                    yield from between(before, after, *CHANGED[type(operator)])
        elif isinstance(node, ast.BinOp) and type(node.op) in CHANGED:
            yield from between(node.left, node.right, *CHANGED[type(node.op)])
        elif isinstance(node, ast.BoolOp):
            yield from between(node.values[0], node.values[1], *CHANGED[type(node.op)])
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            yield Place(name, node.lineno, node.col_offset, "-", "")
        elif isinstance(node, ast.Constant) and type(node.value) in (int, float):
            found = lines[node.lineno - 1][node.col_offset : node.end_col_offset].decode()
            yield Place(name, node.lineno, node.col_offset, found, str(2 * node.value or 1))


def _calculated(tree: ast.AST) -> Iterator[ast.AST]:
    """The nodes of a syntax tree, without annotations."""
    for field, value in ast.iter_fields(tree):
        if field in ("annotation", "returns"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                yield child
                yield from _calculated(child)


def cases(short: bool) -> list[dict]:
    """Places drawn over all of the modules; the first of Coulomb's law with a test of it, in short."""
    if short:
        first = next(places(ROOT / "shakedown" / "joint" / "law.py"))
        test = "tests/joint/test_two_directions.py::test_the_extreme_load_steps_suffice"
        return [first._asdict() | {"tests": [test]}]
    files = [path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*.py"))]
    found = [place for path in files for place in places(path)]
    return [place._asdict() for place in sorted(found, key=_number)[:PLACES]]


def _number(place: Place) -> bytes:
    """A random number for a place, which stays in the sample whatever else is changed."""
    line = (ROOT / place.path).read_bytes().splitlines()[place.line - 1]
    return sha256(f"{SEED} {place.path} {place.column} {place.found} ".encode() + line.strip()).digest()


def measure(case: dict) -> dict:
    """Whether a test fails with the change, and which."""
    place, copy = Place(*(case[name] for name in Place._fields)), _copied()
    file, cache_of_code = copy / place.path, copy / CODE_CACHE
    original, checked = file.read_bytes(), cache_of_code.read_bytes()
    tests = case.get("tests") or _tests(place)
    lines = original.splitlines(keepends=True)
    line, end = lines[place.line - 1], place.column + len(place.found.encode())
    assert line[place.column : end] == place.found.encode(), "the source changed since the place was drawn"
    lines[place.line - 1] = line[: place.column] + place.changed.encode() + line[end:]
    try:
        if not COMPILED.search(original):  # what is compiled stays as it is on disk
            cache_of_code.write_bytes(checked.replace(b"whole.hexdigest()", b'"of the sources before"'))
        file.write_bytes(b"".join(lines))
        return {"noticed": _failed(copy, tests)}
    finally:
        file.write_bytes(original)
        cache_of_code.write_bytes(checked)


@cache
def _copied() -> Path:
    """A copy of the repository, from which Python reads all modules, those of the command line too."""
    copy = Path(tempfile.mkdtemp(prefix="mutation-"))
    left = shutil.ignore_patterns(".git", ".venv*", "__pycache__", ".coverage*")
    shutil.copytree(ROOT, copy, ignore=left, dirs_exist_ok=True)
    (copy / "shakedown" / "cli").symlink_to(copy / "cli")  # where an installed checkout maps it
    found = _run(copy, "-c", "from shakedown.cli import main; print(main.__file__)").stdout
    assert Path(found).is_relative_to(copy), f"{found} runs in place of the copy"
    return copy


def _tests(place: Place) -> list[str]:
    """The tests that run the statement of a place, or else its module; those of its subpackage first."""
    source, part = (ROOT / place.path).read_bytes(), place.path.removeprefix("shakedown/").split("/")[0]
    if COMPILED.search(source):
        return [place.path, *(f"tests/{name}" for name in (part, *USED_BY.get(part, ())))]
    runs = _runs()[place.path]
    statements = (node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.stmt))
    first = max(each.lineno for each in statements if each.lineno <= place.line <= (each.end_lineno or 0))
    tests = set().union(*(runs.get(line, ()) for line in range(first, place.line + 1)))
    tests = tests or set().union(*runs.values())  # a constant of the module
    return sorted(tests, key=lambda test: (not test.startswith(f"tests/{part}/"), test))


@cache
def _runs() -> dict[str, dict[int, set[str]]]:
    """Of each module the tests that run its lines; those of a whole file where a fixture does."""
    from coverage import CoverageData

    copy = _copied()
    settings = ("-n", "logical", "--cov=shakedown", "--cov-context=test", "--cov-report=")
    done = _run(copy, "-m", "pytest", "-q", *settings)
    assert not done.returncode, done.stdout
    data, found = CoverageData(str(copy / ".coverage")), {}
    data.read()
    for name in data.measured_files():
        path = str(Path(name).relative_to(copy)).replace("shakedown/cli/", "cli/")
        lines = data.contexts_by_lineno(name)
        found[path] = {line: {_test(context) for context in lines[line] if context} for line in lines}
    return found


def _test(context: str) -> str:
    """The test of a context, without its parameters; its whole file where a fixture runs."""
    test, _, when = context.rpartition("|")
    return test.split("::" if when == "setup" else "[")[0]


def _failed(copy: Path, tests: list[str]) -> str:
    """The first of some tests that fails; empty where none does."""
    try:
        done = _run(copy, "-m", "pytest", "-x", "-q", "-n", "0", "-p", "no:cacheprovider", *tests)
    except subprocess.TimeoutExpired:
        return "no end"
    if done.returncode in (0, 5):  # all pass, or all are slow ones
        return ""
    named = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return named[0].split(" - ")[0] if named else "no test can be read"


def _run(copy: Path, *words: str) -> subprocess.CompletedProcess:
    """Python in the copy."""
    command, env = [sys.executable, *words], os.environ | {"PYTHONPATH": str(copy)}
    return subprocess.run(command, cwd=copy, env=env, capture_output=True, text=True, timeout=SECONDS)


def tables(rows: list[dict]) -> str:
    """How many are noticed, and those that are not."""
    survived = [row for row in rows if not row["noticed"]]
    lines = [["{path}:{line}:{column}".format(**row), row["found"], row["changed"]] for row in survived]
    shown = table(["survives", "source", "changed to"], lines)
    return f"{len(rows) - len(survived)} of {len(rows)} noticed\n\n{shown}"


if __name__ == "__main__":
    run_study("mutation", short=False, fresh=False)
