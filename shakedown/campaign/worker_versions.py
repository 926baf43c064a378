"""The software of this process. Cluster workers run this text, so it imports only the standard library."""

import hashlib
import platform
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path

PACKAGES = "numpy", "scipy", "numba", "clarabel"
NONE = "none"


@cache
def versions() -> dict[str, str]:
    """By name the version of Python and of what results depend on, and a checksum of the toolkit's own code.

    Examples
    --------
    >>> list(versions())[1:]
    ['shakedown-bounds', 'numpy', 'scipy', 'numba', 'clarabel', 'Python']
    """
    found = {name: _version_of(name) for name in ("shakedown-bounds", *PACKAGES)}
    return {"the code of shakedown": _code()} | found | {"Python": platform.python_version()}


def _version_of(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return NONE


def _code() -> str:
    """A checksum of the package's files as they would be imported."""
    try:
        spec = find_spec("shakedown")
    except ImportError:
        spec = None
    if spec is None or spec.origin is None:
        return NONE
    folder, digest = Path(spec.origin).parent, hashlib.sha256()
    for path in sorted(folder.rglob("*.py")):
        digest.update(path.relative_to(folder).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:12]
