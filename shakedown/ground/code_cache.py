"""Compiled code on disk: where it is kept, and whether it matches all the sources it was compiled from.

Where there is no place, the kernels are compiled anew in every run. Numba keeps the code of a function
beside a stamp of the one file that the function stands in. What that function calls in other modules, and
the constants that it takes from them, are compiled into it: where one of those has changed, the code on disk
is of no use either.
"""

import logging
import re
import sys
from collections.abc import Callable
from functools import cache
from hashlib import sha256
from importlib.util import resolve_name
from itertools import count
from pathlib import Path
from typing import Any, cast

import numba
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.dispatcher import Dispatcher

from shakedown.ground.errors import UsageError

NUMBERS = count()
WANTED = ("_optimize_final_module", "_finalize_final_module", "_finalize_dynamic_globals")


def ensure_code_can_be_compiled() -> bool:
    """Let kernels that ask for a cache be compiled also where numba finds no place for one.

    Numba looks for a folder that it can write: ``NUMBA_CACHE_DIR``, ``__pycache__``
    beside the source, the user's own cache. Where the package is read-only and the
    user has no home, it refuses to define the kernels at all. Then they are defined
    without a cache, and a line of the log says so.

    Raises
    ------
    UsageError
        If ``NUMBA_DISABLE_JIT`` is set: the kernels hold states that only compiled code knows.

    Returns
    -------
    bool
        Whether there is a place for compiled code.
    """
    if cast(Any, numba.config).DISABLE_JIT:
        raise UsageError("NUMBA_DISABLE_JIT: expected it unset, as the motion is followed by compiled code")
    try:
        numba.njit(cache=True)(_asks_for_a_cache)
    except RuntimeError:  # numba: no locator available
        cast(Any, Dispatcher).enable_caching = _without_cache
        logging.getLogger("shakedown").warning(
            "no place for compiled code: it is compiled anew in every run, which takes about half a minute; "
            "set NUMBA_CACHE_DIR to a folder that can be written"
        )
        return False
    return True


def _asks_for_a_cache() -> None:
    """Defined, never called and so never compiled."""


def _without_cache(_: object) -> None:
    """Replacement for ``Dispatcher.enable_caching``: a dispatcher starts without a cache."""


IMPORTED = re.compile(r"^(?:from\s+(\S+)\s+import\s+(\([^)]*\)|[^\n#]*)|import\s+([^\n#]*))", re.MULTILINE)


def stamped(compiled: Any) -> Any:
    """A compiled function whose code on disk is used while no module that it stands on changes.

    Numba overwrites code that is out of date. Where it keeps its stamps elsewhere than expected,
    or a source cannot be read, nothing is taken from disk. On a full disk it is used and not kept.
    """
    on_disk = getattr(compiled, "_cache", None)
    if on_disk is None or on_disk.cache_path is None:  # no place for compiled code
        return compiled
    on_disk.save_overload = _kept_where_possible(on_disk.save_overload)
    index: Any = getattr(on_disk, "_cache_file", None)
    below = stamp(compiled.py_func.__module__)
    if below is None or not hasattr(index, "_source_stamp") or not hasattr(index, "_load_index"):
        on_disk.disable()
    else:
        index._source_stamp = (index._source_stamp, below)
        index._load_index = _nothing_of_other_versions(index._load_index)
    return compiled


def _kept_where_possible(save: Callable[..., None]) -> Callable[..., None]:
    """Writes compiled code, or says in the log, once, why it cannot be written."""

    def saved(*code: Any) -> None:
        try:
            save(*code)
        except OSError as error:
            _say_that_nothing_is_kept(error.strerror or str(error))

    return saved


@cache
def _say_that_nothing_is_kept(reason: str) -> None:
    logging.getLogger("shakedown").warning(
        "compiled code cannot be kept (%s): it is compiled anew in every run; set NUMBA_CACHE_DIR to a "
        "folder with room for it",
        reason,
    )


def _nothing_of_other_versions(load: Callable[[], Any]) -> Callable[[], Any]:
    """The index on disk; empty where another version wrote it with a type unknown here."""

    def loaded() -> Any:
        try:
            return load()
        except (AttributeError, ImportError):
            return {}

    return loaded


def stamp(module: str) -> str | None:
    """A number for the sources of a module and of the modules below it; None if one cannot be read."""
    found = modules_below(module)
    sources = [_source(name) for name in found]
    if None in sources:
        return None
    whole = sha256()
    for name, source in zip(found, sources, strict=True):
        whole.update(f"\0{name}\0{source}".encode())
    return whole.hexdigest()


def modules_below(module: str) -> list[str]:
    """The module and all modules of its package that it, or one of them, imports at its top, by name."""
    seen, waiting = set[str](), [module]
    while waiting:
        name = waiting.pop()
        if name not in seen:
            seen.add(name)
            waiting += _imported(name, _source(name) or "")
    return sorted(seen)


def _imported(module: str, source: str) -> list[str]:
    """Names of the modules of the same package, packages too, that the lines of a source import."""
    package = sys.modules[module].__package__
    names = list[str]()
    for start, words, plain in IMPORTED.findall(source):
        if start:
            base = resolve_name(start, package)
            names += [base, *(f"{base}.{word}" for word in re.findall(r"\w+", words))]
        else:
            names += re.findall(r"[\w.]+", plain)
    top = module.split(".")[0]
    return [name for name in names if name.split(".")[0] == top and name in sys.modules]


@cache
def _read(path: str, changed: int) -> str:
    return Path(path).read_text(encoding="utf-8")


def _source(module: str) -> str | None:
    """The source of a loaded module; None if it has none that can be read."""
    path = getattr(sys.modules[module], "__file__", None)
    try:
        return _read(path, Path(path).stat().st_mtime_ns) if path else None
    except (OSError, UnicodeDecodeError):
        return None


class _NoEnvironment:
    """The code generator, which writes no environment into code that does not exist."""

    def __init__(self, codegen: Any) -> None:
        self._codegen = codegen

    def __getattr__(self, name: str) -> Any:
        return getattr(self._codegen, name)

    def set_env(self, name: str, environment: Any) -> None:
        """Nothing to do."""


class LinkedLibrary(JITCodeLibrary):
    """Code to be linked into that of callers, as it was lowered."""

    @property
    def codegen(self) -> Any:
        return _NoEnvironment(self._codegen)

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
    known = all(hasattr(JITCodeLibrary, name) for name in WANTED)
    return {"pipeline_class": LinkedCompiler} if known else {}
