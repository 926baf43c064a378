"""Docstrings are plain text, as a terminal shows it: what reST would take for markup is escaped."""

import re

from sphinx.application import Sphinx

LITERAL = re.compile(r"(``.*?``)")
TYPE = re.compile(r"^(\s*:(?:type|vartype|rtype)(?: [^:]+)?: )(.+)$")


def without_bars(line: str) -> str:
    """|q| is an absolute value, and no substitution; between double backticks it stands for itself."""
    return "".join(
        part if part.startswith("``") else part.replace("|", r"\|") for part in LITERAL.split(line)
    )


def as_text(line: str) -> str:
    """A type like "(n, 2), optional" is text, and no list of names to look up."""
    found = TYPE.match(line)
    return f"{found[1]}*{found[2].strip('*')}*" if found else line


def plain(_: Sphinx, __: str, ___: str, ____: object, _____: object, lines: list[str]) -> None:
    """After napoleon has made fields of the sections."""
    example = False
    for k, line in enumerate(lines):
        example = bool(line.strip()) and (example or line.lstrip().startswith(">>>"))
        if not example:
            lines[k] = as_text(without_bars(line))


def setup(app: Sphinx) -> dict[str, bool]:
    """Read by Sphinx."""
    app.connect("autodoc-process-docstring", plain, priority=900)
    return {"parallel_read_safe": True}
