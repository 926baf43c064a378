"""The reference pages of the public names, from the package itself: what is new appears by itself."""

import importlib
import inspect
import re
from pathlib import Path

from sphinx.application import Sphinx

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
    return "\n".join(
        chapter(heading, sorted(named, key=_class_last)) for heading, named in found.items() if named
    )


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
    names = [name for name in sorted(dir(importlib.import_module(module))) if not name.startswith("_")]
    return chapter(f"`{module}`", [(module, name) for name in names if _shown(module, name)])


MARKS = {
    "<!-- public names -->": top,
    "<!-- names of the modules -->": modules,
    "<!-- names of plot and fem -->": lambda: (
        open_subpackage("shakedown.plot") + "\n" + open_subpackage("shakedown.fem")
    ),
}


def fill(_: Sphinx, __: str, source: list[str]) -> None:
    """Put the names where a page has their mark."""
    for mark, names in MARKS.items():
        if mark in source[0]:
            source[0] = source[0].replace(mark, names())


def setup(app: Sphinx) -> dict[str, bool]:
    """Read by Sphinx."""
    app.connect("source-read", fill)
    return {"parallel_read_safe": True}
