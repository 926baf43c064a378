"""Code of functions that only compiled code calls: linked into their callers, compiled there alone.

Numba optimises every function and turns it into machine code, and links it into its callers, where it
is optimised and turned into machine code again, level by level. Of functions that are never called
from Python nobody uses the first copy: without it the first run takes three fifths of the time.
The library class is no documented part of numba, so where it is not as expected, everything is as
numba does it.
"""

from itertools import count
from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler

NUMBERS = count()
WANTED = ("_optimize_final_module", "_finalize_final_module", "_finalize_dynamic_globals")


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
