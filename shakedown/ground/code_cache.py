"""Compiled code on disk: in a folder that is named by a hash of all sources of the package.

Numba keeps the code of a function beside a stamp of the one file that the function stands in. What that
function calls in other modules, and the constants that it takes from them, are compiled into it: where one
of those has changed, the code on disk is of no use either. So code that was compiled from other sources
lies in another folder.
"""

import logging
from collections.abc import Callable
from copy import copy
from functools import cache
from hashlib import sha256
from itertools import count
from pathlib import Path
from shutil import rmtree
from sys import modules
from tempfile import TemporaryFile
from typing import Any, cast

import numba
from numba.core.caching import FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.misc.appdirs import user_cache_dir

from shakedown.ground.errors import UsageError

NUMBERS = count()
FOLDER = "compiled-"  # of the package, and the first digits of the hash of its sources
NOT_KEPT = "it is compiled anew in every run, about half a minute; set NUMBA_CACHE_DIR to a folder"

if cast(Any, numba.config).DISABLE_JIT:
    raise UsageError("NUMBA_DISABLE_JIT: expected it unset, as the motion is followed by compiled code")


def compiled(function: Callable[..., Any], **options: Any) -> Any:
    """Compile a function that is called from Python; its code on disk is that of the present sources.

    Where no folder can be written, or the disk is full, it is compiled anew in every run, and a line of the
    log says so.
    """
    found: Any = numba.njit(function, **options)
    place, settings = place_of(function.__module__.partition(".")[0]), cast(Any, numba.config)
    if place is not None:
        given, settings.CACHE_DIR = settings.CACHE_DIR, str(place)
        found._cache = _KeptCode(function)
        settings.CACHE_DIR = given
    return found


@cache
def place_of(package: str) -> Path | None:
    """The folder of the compiled code of a package as it is: the first of three that can be written.

    In ``NUMBA_CACHE_DIR``, beside the package (there code of other sources is removed), or in the cache of
    the user.
    """
    file = modules[package].__file__
    if file is None:  # no package, but a folder of modules
        return None
    root = Path(file).parent
    given = cast(Any, numba.config).CACHE_DIR
    beside, name = root / "__pycache__", f"{FOLDER}{hash_of_sources(root)[:16]}"
    own = Path(user_cache_dir(package, appauthor=False))
    for above in (Path(given) / package if given else None, beside, own):
        if above is not None and _can_be_written(above / name):
            for other in above.glob(f"{FOLDER}*") if above == beside else ():
                if other.name != name:
                    rmtree(other, ignore_errors=True)
            return above / name
    logging.getLogger("shakedown").warning(f"no place for compiled code: {NOT_KEPT} that can be written")
    return None


def hash_of_sources(root: Path) -> str:
    """A number for the names and contents of all modules below a folder."""
    whole = sha256()
    for path in sorted(root.rglob("*.py")):
        whole.update(f"\0{path.relative_to(root).as_posix()}\0".encode() + path.read_bytes())
    return whole.hexdigest()


def _can_be_written(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


class _KeptCode(FunctionCache):
    """Numba's cache of the code of a function, which goes without where the disk is full."""

    def save_overload(self, *code: Any) -> None:
        try:
            super().save_overload(*code)
        except OSError as error:
            _say_that_nothing_is_kept(error.strerror or str(error))


@cache
def _say_that_nothing_is_kept(reason: str) -> None:
    logging.getLogger("shakedown").warning(
        f"compiled code cannot be kept ({reason}): {NOT_KEPT} with room for it"
    )


class LinkedLibrary(JITCodeLibrary):
    """Code to be linked into that of callers, as it was lowered."""

    @property
    def codegen(self) -> Any:
        """The code generator, which writes no environment into code that does not exist."""
        silent: Any = copy(self._codegen)
        silent.set_env = lambda name, environment: None
        return silent

    def _optimize_final_module(self) -> None:
        """Callers do that, with their own."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True


class LinkedCompiler(Compiler):
    """The pipeline of numba with such a library."""

    def __init__(
        self, typing: Any, target: Any, library: Any, args: Any, return_type: Any, flags: Any, locals: Any
    ) -> None:
        if library is None:
            library = LinkedLibrary(target.codegen(), f"linked_{next(NUMBERS)}")
        super().__init__(typing, target, library, args, return_type, flags, locals)


def pipeline() -> dict[str, Any]:
    """The option of ``njit`` that compiles a function so, where numba is as expected."""
    known = all(
        hasattr(JITCodeLibrary, name)
        for name in ("_optimize_final_module", "_finalize_final_module", "_finalize_dynamic_globals")
    )
    return {"pipeline_class": LinkedCompiler} if known else {}
