"""Every code block of the site is run: here what is quick, the rest where the site is built (``.ci/site``).

What is offered as a script or notebook of a tutorial is the code of its page.

The blocks of a page are run one after the other in a folder of its own.

What is run: ``pycon`` (and ``python`` with prompts) as a doctest, other ``python`` as a script, ``sh`` and
``console`` by their ``shakedown-bounds`` lines, ``toml`` is parsed. Names and files stay from block to block. Comments
on the line before a block direct it:

``<!-- file: NAME -->``  the block is what the reader saves as that file;
``<!-- folder: MAKER -->``  at the head of a page: which files it takes for granted (``folders``);
``<!-- missing: WHAT -->``  run up to the first command that says that a file is missing, which has to come: WHAT.
``<!-- slow -->``  left to the build of the site;
``<!-- deck -->``  written for another program, which is not at hand.

What a block shows with numbers in it is run: ``not_run`` finds what is neither run nor one of these.
"""

import doctest
import json
import re
import shlex
import sys
import tomllib
from collections.abc import Iterator
from contextlib import chdir, contextmanager
from dataclasses import dataclass
from functools import partial
from importlib.resources import files
from pathlib import Path

import brake_reuss
import pytest
from command import run

import shakedown

BLOCK = re.compile(
    r"(?:^<!-- (?P<mark>[a-z]+)(?:: (?P<value>[^\n]+))? -->\n)?^```(?P<language>[a-z]+)\n(?P<text>.*?)^```$",
    re.M | re.S,
)
FLAGS = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS
OTHER_CODES = {"text"}  # decks of FE codes that are not at hand, and what is shown without numbers
FENCE = re.compile(r"^[ \t]*(?:```|~~~)", re.M)
DIRECTIVE = re.compile(r"^```\{[a-z-]+\}.*?^```$", re.M | re.S)
INDENTED = re.compile(r"(?:^|\n)\n((?: {4,}.*\n?)+)")
NUMBER = re.compile(r"-?\b\d+(?:\.\d+)?(?:e[+-]\d+)?\b")
LAST_DIGIT = 1.001e-6  # of seven, relatively
DECIMAL = re.compile(r"\d\.\d")  # in an indented block, a formula, whole numbers are indices and factors
ELSEWHERE = (  # lines that the continuous integration runs, or that need another program
    "python3 -m venv", "py -m venv", ".venv/bin/", ".venv\\", "bash .ci/", "pip install", "python -m benchmarks",
    "ccx ", "cd ", "dask ", "eval ",
)  # fmt: skip


@dataclass(frozen=True)
class Block:
    """One fenced block and the comment before it."""

    language: str
    text: str
    line: int
    mark: str
    value: str


def blocks(page: Path) -> list[Block]:
    text = page.read_text(encoding="utf-8")
    return [
        Block(**found.groupdict(""), line=text.count("\n", 0, found.start("language")))
        for found in BLOCK.finditer(text)
    ]


def not_run(page: Path) -> list[str]:
    """Where a page shows output with numbers that nobody runs; where a fence is none that is known."""
    others = [block for block in blocks(page) if block.language in OTHER_CODES]
    left = [
        f"line {block.line}: output with numbers that is not run"
        for block in others
        if block.mark not in ("deck", "file") and re.search(r"\d", block.text)
    ]
    prose = BLOCK.sub("", DIRECTIVE.sub("", page.read_text(encoding="utf-8")))
    left += [f"a fence of no language: {prose[at.start() :][:60]!r}" for at in FENCE.finditer(prose)]
    shown = re.findall(r"^> .*λ.*", prose, re.M) + INDENTED.findall(prose)  # quoted or indented
    return left + [f"numbers in {text[:60]!r}" for text in shown if DECIMAL.search(text)]


class Page:
    """What the blocks of one page share: a folder, and the names of its Python."""

    def __init__(self, path: Path, folder: Path):
        self.path, self.folder, self.names = path, folder, {"__name__": "__main__"}

    def run(self, *, slow: bool) -> None:
        """Run the blocks in their order."""
        chosen = [block for block in blocks(self.path) if slow or block.mark != "slow"]
        with chdir(self.folder):
            for block in chosen:
                self._run(block)

    def _run(self, block: Block) -> None:
        where = f"{self.path.name}, line {block.line}"
        if block.mark == "file":
            Path(block.value).write_text(block.text, encoding="utf-8")
        if block.language in ("python", "pycon"):
            self._python(block, where)
        elif block.language in ("sh", "console", "bat"):
            self._shell(block, where)
        elif block.language == "toml":
            tomllib.loads(block.text)
        else:
            known = block.language in OTHER_CODES or block.mark == "file"
            assert known, f"{where}: who runs {block.language}?"

    def _python(self, block: Block, where: str) -> None:
        if ">>> " not in block.text:
            exec(compile(block.text, where, "exec"), self.names)
            return
        test = doctest.DocTestParser().get_doctest(block.text, self.names, where, str(self.path), block.line)
        told: list[str] = []
        runner = doctest.DocTestRunner(optionflags=FLAGS)
        failed = runner.run(test, out=told.append, clear_globs=False).failed
        self.names.update(test.globs)
        assert not failed, "".join(told)

    def _shell(self, block: Block, where: str) -> None:
        for line, expected in commands(block):
            if line.startswith(ELSEWHERE):
                continue
            words = shlex.split(line, comments=True)
            assert words[0] == "shakedown-bounds", f"{where}: who runs {line!r}?"
            with cluster(words) as found:
                code, out, err = run(*found[1:])
            if block.mark == "missing" and "no such file" in err:
                return
            assert code == 0 or expected, f"{where}: {line}\n{err}"
            if expected:
                shown = (out + err).replace("\N{NO-BREAK SPACE}", " ")
                assert same(expected, shown), f"{where}: {line}\n{shown}"
        assert block.mark != "missing", f"{where}: nothing was missing"


def same(expected: str, shown: str) -> bool:
    """Word for word; a limit next to a step of its last digit is rounded to either side, by the kernel of BLAS."""
    if doctest.OutputChecker().check_output(expected, shown, FLAGS):
        return True
    ours, others = (NUMBER.findall(text) for text in (expected, shown))
    words, its = (NUMBER.sub("#", text).split() for text in (expected, shown))
    pairs = zip(ours, others, strict=False)
    return words == its and all(abs(float(a) - float(b)) <= LAST_DIGIT * abs(float(a)) for a, b in pairs)


@contextmanager
def cluster(words: list[str]) -> Iterator[list[str]]:
    """The words of a command; where they name the scheduler of a cluster, there is one."""
    if "--scheduler" not in words:
        yield words
        return
    from distributed import LocalCluster

    with LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None) as made:
        place = words.index("--scheduler") + 1
        yield [*words[:place], made.scheduler_address, *words[place + 1 :]]


def commands(block: Block) -> list[tuple[str, str]]:
    """The commands of a block, each with the output that is shown; none where it shows none."""
    text = block.text.replace("\\\n", " ")
    if block.language == "console":
        parts = re.split(r"^\$ ", text, flags=re.M)[1:]
        return [(line, output) for line, _, output in (part.partition("\n") for part in parts)]
    return [(line, "") for line in text.splitlines() if line.strip() and not line.startswith("#")]


DOCS = Path(__file__).parents[2] / "docs"
PAGES = sorted(page for page in DOCS.rglob("*.md") if not {"_build", "paper"} & set(page.parts))


def named(page):
    return page.relative_to(DOCS).as_posix()


def joint(folder, name="two-node"):
    """What a page calls joint.npz, without showing where it comes from."""
    shakedown.save_problem(folder / "joint.npz", shakedown.example(name))


def calculix(folder):
    """The deck of the example, and what `ccx punch` writes, as they are shipped."""
    for name in ("punch.inp", "punch.sti", "punch.dof"):
        (folder / name).write_bytes((files("shakedown.models.importing") / "example" / name).read_bytes())


FOLDERS = {
    "joint": joint,
    "block": partial(joint, name="block-9"),
    "calculix": calculix,
    "brake_reuss": brake_reuss.write,
}


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=named)
def test_the_blocks_of_a_page_run(page, tmp_path, request):
    whole = request.config.getoption("--whole-site")
    if not whole:
        request.getfixturevalue("undrawn")
    for maker in re.findall(r"^<!-- folder: (\w+) -->$", page.read_text(encoding="utf-8"), re.M):
        FOLDERS[maker](tmp_path)
    Page(page, tmp_path).run(slow=whole)


@pytest.mark.parametrize(
    "page", [*PAGES, DOCS.parent / "README.md", DOCS.parent / "CONTRIBUTING.md"], ids=lambda p: p.stem
)
def test_output_with_numbers_is_run(page):
    assert not_run(page) == []


TUTORIALS = [
    page for page in PAGES if page.parent.name == "tutorials" and "```pycon" in page.read_text("utf-8")
]


@pytest.fixture
def downloads(monkeypatch):
    pytest.importorskip("sphinx")
    monkeypatch.syspath_prepend(str(DOCS / "_extensions"))
    import downloads

    yield downloads
    sys.modules.pop("downloads")


@pytest.mark.parametrize("page", TUTORIALS, ids=lambda page: page.stem)
def test_the_script_and_the_notebook_hold_the_code_of_the_page(downloads, page):
    cells = downloads.cells(page.read_text("utf-8"))
    code = [text for kind, text in cells if kind == "code"]
    assert len(code) == page.read_text("utf-8").count("```pycon")
    script = downloads.script(cells)
    compile(script, page.stem, "exec")
    assert all(text in script for text in code)
    made = json.loads(downloads.notebook(cells))
    assert ["".join(cell["source"]) for cell in made["cells"] if cell["cell_type"] == "code"] == code


def test_an_example_that_raises_an_error_does_not_end_the_script(downloads):
    block = ">>> 1 / 0\nTraceback (most recent call last):\n    ...\nZeroDivisionError: division by zero\n>>> x = 2\n"
    exec(downloads.without_prompts(block), scope := {})
    assert scope["x"] == 2
