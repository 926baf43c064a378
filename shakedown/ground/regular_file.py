"""Files to read: regular ones only, so that no pipe blocks and no device reads without end."""

import os
import stat
from io import BufferedReader

from shakedown.ground.errors import ProblemError


def open_regular(path: str | os.PathLike[str], expected: str = "a regular file") -> BufferedReader:
    """Open a regular file for reading bytes; whatever else has that name is never waited for.

    Parameters
    ----------
    path
        The file; symbolic links are followed.
    expected
        What to call the file in a message.

    Raises
    ------
    ProblemError
        If there is no such file, it cannot be read, or it is a directory, a pipe,
        a device or a socket. The message does not repeat the path.
    """
    try:
        handle = os.open(path, os.O_RDONLY | _flag("O_NONBLOCK") | _flag("O_CLOEXEC") | _flag("O_BINARY"))
    except FileNotFoundError:
        raise ProblemError("no such file") from None
    except IsADirectoryError:
        raise ProblemError(f"expected {expected}, found a directory") from None
    except (OSError, ValueError) as error:  # ValueError: a NUL or half a character in the name
        reason = error.strerror if isinstance(error, OSError) else error
        raise ProblemError(f"cannot be read ({reason})") from None
    try:
        mode = os.fstat(handle).st_mode
        if not stat.S_ISREG(mode):
            raise ProblemError(f"expected {expected}, found {kind_of(mode)}")
        return os.fdopen(handle, "rb")
    except BaseException:
        os.close(handle)
        raise


def kind_of(mode: int) -> str:
    """The kind of a file that is not regular, in words."""
    return "a directory" if stat.S_ISDIR(mode) else "a pipe, a device or a socket"


def _flag(name: str) -> int:
    """A flag of ``os.open``, 0 where the system does not know it."""
    return int(getattr(os, name, 0))
