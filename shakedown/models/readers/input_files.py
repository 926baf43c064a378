"""The files that a configuration names: found, read, remembered with their SHA-256."""

import hashlib
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from shakedown.ground.errors import ProblemError
from shakedown.models.readers.text import open_input

Result = TypeVar("Result")


@dataclass
class InputFiles:
    """Paths relative to the folder of the configuration.

    Attributes
    ----------
    folder : Path
        Where the configuration stands.
    sources : dict
        SHA-256 of every file that was read, by the name that the configuration gives it.
    """

    folder: Path
    sources: dict[str, str] = field(default_factory=dict)

    def path(self, name: str) -> Path:
        """The path of a file that the configuration names."""
        return self.folder / name

    def read(self, name: str, reader: Callable[[Path], Result]) -> Result:
        """What a reader returns for a file that the configuration names.

        A file outside the folder may be read like any other, but no message
        repeats anything of its content.

        Raises
        ------
        ProblemError
            As the reader raises it.
        """
        path = self.path(name)
        open_input(path).close()
        try:
            found = reader(path)
        except ProblemError as error:
            if self._inside(path):
                raise
            said = str(error).partition(", found ")[0]
            raise ProblemError(
                f"{said} (what was found is not shown: the file lies outside the folder)"
            ) from None
        if name not in self.sources:
            self.sources[name] = sha256(path)
        return found

    def _inside(self, path: Path) -> bool:
        try:
            return Path(os.path.realpath(path)).is_relative_to(os.path.realpath(self.folder))
        except (OSError, ValueError):  # a name that no file can have
            return True

    def same(self, first: str, second: str) -> bool:
        """Whether two names lead to one file."""
        try:
            return os.path.samefile(self.path(first), self.path(second))
        except (OSError, ValueError):
            return False


def sha256(path: str | os.PathLike[str]) -> str:
    """SHA-256 of a regular file, in hexadecimal digits."""
    with open_input(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
