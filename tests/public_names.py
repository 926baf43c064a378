"""What a user may rely on: the names at the top, and those that docs/names.md lists module by module."""

import importlib
import re
from pathlib import Path
from typing import Any

import shakedown

PAGE = Path(__file__).parents[1] / "docs" / "names.md"


def of_modules() -> dict[str, list[str]]:
    """The names that docs/names.md lists, by module."""
    rows = re.findall(r"^\| `(shakedown\.[\w.]+)` \| ([^|]+) \|", PAGE.read_text(encoding="utf-8"), re.M)
    return {module: re.findall(r"`(\w+)`", names) for module, names in rows}


def public() -> dict[str, Any]:
    """Every public name and what it names."""
    found = {name: getattr(shakedown, name) for name in shakedown.__all__}
    for path, names in of_modules().items():
        module = importlib.import_module(path)
        found |= {name: getattr(module, name) for name in names}
    return found
