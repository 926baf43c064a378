"""What leads from an imported problem back to the model: areas, names, the source."""

import json
import os
from collections.abc import Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from shakedown.condensation.load_case import LoadCase
from shakedown.ground.float_array import FloatArray
from shakedown.ground.visible_text import LONGEST_NAME, shortened, visible
from shakedown.importing.contact.contact_section import ContactSection
from shakedown.joint.fields.places import bearing_no_pressure

LONGEST_CONFIGURATION = 200_000  # bytes that are kept word for word; of a longer one its SHA-256 must do


def positive_areas(contact: ContactSection) -> tuple[FloatArray | None, tuple[str, ...]]:
    """The areas of the nodes, or None and a warning where the elements give some node no positive one."""
    warning = () if contact.area is None else bearing_no_pressure(contact.area, contact.names)
    return (None if warning else contact.area), warning


def load_names(cases: Sequence[LoadCase], where: str) -> tuple[str, ...]:
    """Names of the load cases; one without a name is called by its place in the configuration."""
    return tuple(shortened(visible(case.name.removeprefix(f"{where}: ")), LONGEST_NAME - 1) for case in cases)


def source_text(
    config_path: str | os.PathLike[str],
    sources: Mapping[str, str],
    command: str,
    warnings: Sequence[str] = (),
) -> str:
    """``source`` of a problem as JSON: toolkit, command, configuration, files, warnings; no date."""
    raw = Path(config_path).read_bytes()
    text = raw.decode() if len(raw) <= LONGEST_CONFIGURATION else None
    about = {
        "toolkit": f"shakedown-bounds {_version()}",
        "command": command,
        "configuration": {"name": Path(config_path).name, "text": text},
        "files": [{"name": name, "sha256": digest} for name, digest in sources.items()],
        "warnings": list(warnings),
    }
    return json.dumps({key: value for key, value in about.items() if value})


def _version() -> str:
    try:
        return version("shakedown-bounds")
    except PackageNotFoundError:  # a copy that was never installed
        return "unknown"
