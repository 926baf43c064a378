"""What is in a wheel and a source distribution: nothing is missing, nothing leaks."""

import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
EXPECTED = ("py.typed", "__init__.pyi", "files/data/block-9.npz", "models/importing/templates/abaqus.toml")
LEAKS = ("tests/", "benchmarks/", "docs/", "conftest.py", "__pycache__", ".nbi", ".nbc")


def sources() -> set[str]:
    """Every source of the package, as a wheel names it."""
    found = [
        path.relative_to(ROOT).as_posix()
        for folder in ("shakedown", "cli")
        for path in (ROOT / folder).rglob("*.py")
    ]
    return {name if name.startswith("shakedown/") else f"shakedown/{name}" for name in found}


def leaks(name: str) -> bool:
    """Whether a file has no place in either."""
    return any(word in name for word in LEAKS)


def said(missing: set[str], strange: set[str]) -> list[str]:
    """One line per fault."""
    return [
        *(f"missing: {name}" for name in sorted(missing)),
        *(f"leaks: {name}" for name in sorted(strange)),
    ]


def faults_of_wheel(names: set[str]) -> list[str]:
    """What a wheel lacks or should not hold."""
    missing = sources() - names
    missing |= {name for name in EXPECTED if f"shakedown/{name}" not in names}
    return said(missing, {name for name in names if not name.startswith("shakedown") or leaks(name)})


def faults_of_sdist(names: set[str]) -> list[str]:
    """What a source distribution lacks or should not hold."""
    listed = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"]
    folders = {package.replace("shakedown.cli", "cli").replace(".", "/") for package in listed}
    missing = {f"{folder}/__init__.py" for folder in folders} - names
    missing |= {"pyproject.toml", "README.md", "LICENSE", "CHANGELOG.md", "CITATION.cff"} - names
    return said(missing, {name for name in names if leaks(name)})


def main(wheel: str, sdist: str) -> int:
    """List both, and say what is wrong; how many faults."""
    with zipfile.ZipFile(wheel) as packed:
        in_wheel = set(packed.namelist())
    with tarfile.open(sdist) as packed:
        in_sdist = {name.partition("/")[2] for name in packed.getnames()}
    print(f"{Path(wheel).name}: {len(in_wheel)} files\n{Path(sdist).name}: {len(in_sdist)} files")
    print("\n".join(sorted(name for name in in_wheel if not name.endswith(".py"))))
    faults = [*faults_of_wheel(in_wheel), *faults_of_sdist(in_sdist)]
    print("\n".join(faults), file=sys.stderr, end="\n" if faults else "")
    return len(faults)


if __name__ == "__main__":
    sys.exit(bool(main(*sys.argv[1:])))
