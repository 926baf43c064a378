"""Files to start from: a commented configuration for each code, and an example with all its files."""

import os
from importlib.resources import files
from pathlib import Path

from shakedown.ground.argument_kinds import checked
from shakedown.ground.errors import ProblemError, UsageError
from shakedown.models.readers.parsing import unfit

_KINDS = ("abaqus", "ansys", "calculix", "nastran", "reactions")


def import_template_names() -> tuple[str, ...]:
    """The codes for which there is a template.

    Examples
    --------
    >>> import_template_names()
    ('abaqus', 'ansys', 'calculix', 'nastran', 'reactions')
    """
    return _KINDS


@checked
def import_template(kind: str) -> str:
    """A commented configuration to start from, for :func:`shakedown.import_model`.

    Raises
    ------
    UsageError
        If there is none of that kind.

    Examples
    --------
    >>> "[contact]" in import_template("calculix")
    True
    """
    if kind not in _KINDS:
        raise UsageError(f"template: expected one of {', '.join(_KINDS)}, found {kind!r}")
    folder = files("shakedown.models.importing").joinpath("templates")
    return folder.joinpath(f"{kind}.toml").read_text(encoding="utf-8")


@checked
def write_import_template(kind: str, path: str | os.PathLike[str]) -> Path:
    """Write :func:`import_template` to a new file.

    Raises
    ------
    UsageError
        If there is none of that kind.
    ProblemError
        If the file is there already or cannot be written.
    """
    return _written(Path(path), import_template(kind))


@checked
def write_import_example(folder: str | os.PathLike[str]) -> list[Path]:
    """Write a whole example: a CalculiX deck, what CalculiX made of it, and the configuration.

    Parameters
    ----------
    folder
        Where to; it is made if need be, and must not hold files of these names.

    Raises
    ------
    ProblemError
        If a file is there already or cannot be written.
    """
    sources = sorted(files("shakedown.models.importing").joinpath("example").iterdir(), key=lambda s: s.name)
    return [_written(Path(folder) / source.name, source.read_text(encoding="utf-8")) for source in sources]


def _written(path: Path, text: str) -> Path:
    """Write a file, in a folder that is made if need be; ``ProblemError`` if it is there or cannot be."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with open(path, "x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError as error:
        raise unfit(error.filename, "no such file", "one; give another folder or name") from None
    except OSError as error:
        raise ProblemError(f"{path}: cannot be written ({error.strerror})") from None
    return path
