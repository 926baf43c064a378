"""The reference pages of the public names, from the package itself: what is new appears by itself.

The files themselves hold lists, for readers without the site, which ``python docs/_extensions/api_pages.py``
writes.
"""

import importlib
import inspect
import re
from pathlib import Path
from typing import Any

import shakedown
import shakedown.fem
import shakedown.plot

DOCS = Path(__file__).parents[1]
GROUPS = {  # heading: the subpackages whose names stand below it
    "The whole answer, prediction against simulation": ("assessment",),
    "Problems, and where they come from": ("joint", "files", "models"),
    "Limits of the load factor": ("bounds",),
    "Motion and long-term states": ("motion", "long_term"),
    "Many states, many designs": ("studies",),
    "Errors, statuses, tolerances": ("ground",),
    "Others": (),
}


def directive(module: str, name: str) -> str:
    """The autodoc directive of one object."""
    thing = getattr(importlib.import_module(module), name)
    if name == "BOUNDS":  # a dictionary has no docstring of its own
        return f".. py:data:: {module}.{name}\n\n   Every kind of bound by its name, and what it is about.\n"
    if not inspect.isclass(thing):
        return f".. autofunction:: {module}.{name}\n"
    if issubclass(thing, Exception):
        return f".. autoexception:: {module}.{name}\n   :show-inheritance:\n"
    return f".. autoclass:: {module}.{name}\n   :members:\n"


def chapter(heading: str, named: list[tuple[str, str]]) -> str:
    """A heading, and the objects (module, name) below it."""
    listed = "\n".join(directive(module, name) for module, name in named)
    return f"## {heading}\n\n```{{eval-rst}}\n{listed}```\n"


def top() -> str:
    """The names at the top, by the subpackage that they come from."""
    return "\n".join(chapter(heading, named) for heading, named in _groups().items())


def _groups() -> dict[str, list[tuple[str, str]]]:
    found: dict[str, list[tuple[str, str]]] = {heading: [] for heading in GROUPS}
    for name in shakedown.__all__:
        thing = getattr(shakedown, name)
        if inspect.ismodule(thing):
            continue
        subpackage = "bounds" if name == "BOUNDS" else thing.__module__.split(".")[1]
        heading = next(
            (heading for heading, subpackages in GROUPS.items() if subpackage in subpackages), "Others"
        )
        found[heading].append(("shakedown", name))
    return {heading: sorted(named, key=_class_last) for heading, named in found.items() if named}


def _class_last(named: tuple[str, str]) -> tuple[bool, str]:
    return named[1][0].isupper(), named[1]


def modules() -> str:
    """The names that names.md lists module by module."""
    rows = re.findall(r"^\| `(shakedown\.[\w.]+)` \| ([^|]+) \|", (DOCS / "names.md").read_text(), re.M)
    return "\n".join(
        chapter(
            f"`{module}`", [(module, name) for name in re.findall(r"`(\w+)`", names) if _shown(module, name)]
        )
        for module, names in rows
    )


def _shown(module: str, name: str) -> bool:
    """Whether autodoc has anything to say: constants and aliases speak by their name."""
    thing = getattr(importlib.import_module(module), name)
    return inspect.isclass(thing) or inspect.isfunction(thing)


def open_subpackage(module: str) -> str:
    """The public names of an open subpackage."""
    return chapter(f"`{module}`", _open_names(module))


def _open_names(module: str) -> list[tuple[str, str]]:
    names = [name for name in sorted(dir(importlib.import_module(module))) if not name.startswith("_")]
    return [(module, name) for name in names if _shown(module, name)]


def listed(groups: dict[str, list[tuple[str, str]]]) -> str:
    """Headings, and below each the names with the first lines of their docstrings."""
    text = ""
    for heading, named in groups.items():
        text += f"\n## {heading}\n\n"
        for module, name in named:
            thing = getattr(importlib.import_module(module), name)
            told = (inspect.getdoc(thing) if callable(thing) else "") or "The kinds of bounds, by name."
            summary = re.sub(r":[a-z]+:`~?([^`]+)`", r"`\1`", told.partition("\n")[0]).replace("``", "`")
            text += f"- `{name}`: {summary}\n"
    return text + "\n"


def named(groups: dict[str, list[tuple[str, str]]]) -> str:
    """Headings, and below each the names alone."""
    return (
        "".join(
            f"\n## {heading}\n\n" + ", ".join(f"`{name}`" for _, name in names) + "\n"
            for heading, names in groups.items()
        )
        + "\n"
    )


OPEN = ("shakedown.plot", "shakedown.fem")
END = "<!-- end of names -->"
MARKS = {  # what the site has in place of a mark, and of the list between it and the end
    "<!-- public names -->": top,
    "<!-- names of the modules -->": modules,
    "<!-- names of plot and fem -->": lambda: "\n".join(map(open_subpackage, OPEN)),
}
LISTS = {  # page, mark and list
    "library.md": ("<!-- public names -->", lambda: listed(_groups())),
    "pictures-and-bodies.md": (
        "<!-- names of plot and fem -->",
        lambda: named({f"`{module}`": _open_names(module) for module in OPEN}),
    ),
}


def written(page: str) -> str:
    """A page with the list that belongs between its marks."""
    mark, names = LISTS[page]
    head, _, rest = (DOCS / "reference" / page).read_text(encoding="utf-8").partition(mark)
    return f"{head}{mark}\n{names()}{END}{rest.partition(END)[2]}"


def fill(_: Any, __: str, source: list[str]) -> None:
    """Put the docstrings where a page has their mark."""
    for mark, names in MARKS.items():
        head, found, rest = source[0].partition(mark)
        if found:
            source[0] = head + names() + (rest.partition(END)[2] if END in rest else rest)


def setup(app: Any) -> dict[str, bool]:
    """Read by Sphinx."""
    app.connect("source-read", fill)
    return {"parallel_read_safe": True}


if __name__ == "__main__":
    for page in LISTS:
        text = written(page)
        (DOCS / "reference" / page).write_text(text, encoding="utf-8")
