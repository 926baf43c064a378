"""Files to start from: a commented configuration for each code, and an example with all its files."""

import os
from importlib.resources import files
from pathlib import Path

from shakedown.ground.argument_kinds import checked
from shakedown.ground.errors import ProblemError, UsageError

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
    target, written = Path(folder), []
    try:
        target.mkdir(parents=True, exist_ok=True)
        for source in sorted(
            files("shakedown.models.importing").joinpath("example").iterdir(), key=lambda s: s.name
        ):
            with open(target / source.name, "x", encoding="utf-8") as file:
                file.write(source.read_text(encoding="utf-8"))
            written.append(target / source.name)
    except FileExistsError as error:
        raise ProblemError(
            f"{error.filename}: expected no such file, found one; give another folder"
        ) from None
    except OSError as error:
        raise ProblemError(f"{folder}: cannot be written ({error.strerror})") from None
    return written
