"""The shape of the package: subpackages, layers and the direction of imports, read from the imports themselves."""

import ast
import tomllib
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest
from public_names import of_modules, public

import shakedown

PACKAGE = Path(shakedown.__file__).parent
ROOT = Path(__file__).parents[1]
CLI = PACKAGE / "cli" if (PACKAGE / "cli").is_dir() else ROOT / "cli"

# From the ground up; a module may import from its own folder, from the folders within that, and from
# lower layers only. Some folders of one subpackage stand on layers of their own.
LAYERS = (
    {"ground"},
    {"joint", "programs"},
    {"bounds", "files", "motion"},
    {"bounds.energy", "bounds.every_state", "motion.plane", "motion.space", "models.condensation"},
    {"long_term", "long_term.plane", "models.readers"},
    {"assessment", "long_term.space", "models", "models.importing", "fem"},
    {"studies", "plot"},
    {"report"},
    {"cli", "benchmarks", "__main__"},
)
LAYER = {subpackage: number for number, subpackages in enumerate(LAYERS) for subpackage in subpackages}
FACE = "__init__"  # the public names, loaded lazily: nothing of the package stands on them but its version
OPEN_SUBPACKAGES = {"fem", "ground", "plot", "report"}  # of which others may use whatever is not private
MOST_NAMES = 55  # at the top
INSIDE = {  # what commands and studies reach for beside public names: checks of targets, the loops that are timed
    ("cli.options", "shakedown.files.atomic_write"),
    ("cli.studies", "shakedown.files.pieces"),
    ("cli.solve", "shakedown.bounds.bound_result"),
    ("cli.solve", "shakedown.bounds.critical"),
    ("benchmarks.creep", "shakedown.assessment.creep_limit"),
    ("benchmarks.creep", "shakedown.long_term.creep_proofs"),
    ("benchmarks.stability", "shakedown.motion.course"),
    ("benchmarks.calculix_cycles", "shakedown.models.readers.formats"),
    ("benchmarks.calculix_cycles", "shakedown.models.readers.stiffness"),
    ("benchmarks.enumeration", "shakedown.bounds.intersection"),
    ("benchmarks.enumeration", "shakedown.bounds.walk_kernel"),
    ("benchmarks.implicit_steps", "shakedown.joint.law"),
    ("benchmarks.implicit_steps", "shakedown.motion.fixed_steps"),
    ("benchmarks.claims", "shakedown.files.atomic_write"),
    ("benchmarks.runner", "shakedown.files.atomic_write"),
    ("benchmarks.same_results", "shakedown.files.atomic_write"),
}
MOST_MODULES = 22


def sources() -> dict[str, Path]:
    """Dotted name below the package (or cli.…, benchmarks.…) of every source file."""
    found = {}
    for place, prefix in ((PACKAGE, ()), (CLI, ("cli",)), (ROOT / "benchmarks", ("benchmarks",))):
        for path in place.rglob("*.py"):
            parts = (*prefix, *path.relative_to(place).with_suffix("").parts)
            found[".".join(parts)] = path
    return found


SOURCES = sources()


@cache
def imports(path: Path) -> list[tuple[str, str]]:
    """(module, name) of every import of the package in a file."""
    found = []
    for node in ast.walk(ast.parse(path.read_text())):
        match node:
            case ast.Import(names=names):
                found += [(alias.name, "") for alias in names]
            case ast.ImportFrom(module=module, names=names, level=0):
                found += [(module, alias.name) for alias in names]
    return [(module, name) for module, name in found if module.split(".")[0] == "shakedown"]


def subpackage_of(dotted: str) -> str:
    """The folder that a module, or what it imports, lies in."""
    for length in (2, 1):
        subpackage = ".".join(dotted.split(".")[:length])
        if subpackage in LAYER:
            return subpackage
    return FACE


def test_every_subpackage_stands_on_a_layer():
    assert {subpackage_of(name) for name in SOURCES} <= {FACE, *LAYER}
    assert len(LAYERS) <= 9


@pytest.mark.parametrize("subpackage", sorted(LAYER))
def test_imports_go_down(subpackage):
    modules = [module for module in SOURCES if subpackage_of(module) == subpackage]
    modules = [module for module in modules if module != "__main__"]  # the door to the command line
    for module in modules:
        for imported, name in imports(SOURCES[module]):
            target = subpackage_of(".".join([*imported.split(".")[1:], name]))
            if target == FACE:
                down = subpackage in LAYERS[-1] or name == "__version__"
            else:
                own = f"{target}.".startswith(f"{subpackage}.")
                down = own or LAYER[target] < LAYER[subpackage]
            assert down, f"{module} imports {imported} {name}"


def test_no_subpackage_has_a_circle():
    graph = {
        module: {".".join(imported.split(".")[1:]) for imported, _ in imports(path)} & set(SOURCES) - {module}
        for module, path in SOURCES.items()
    }
    TopologicalSorter(graph).prepare()  # raises an error that names a circle


def test_subpackages_are_small_and_say_what_they_are_for():
    elsewhere = {FACE, "__main__", "cli", "benchmarks", "models.readers", "fem"}
    for subpackage in {subpackage_of(name) for name in SOURCES} - elsewhere:
        folder = PACKAGE / Path(*subpackage.split("."))
        modules = [path for path in folder.glob("*.py") if path.stem != "__init__"]
        parts = [path.parent for path in folder.glob("*/__init__.py")]
        inside = [path for path in parts if f"{subpackage}.{path.name}" not in LAYER]
        assert len(modules) + len(inside) <= MOST_MODULES, subpackage
        assert modules or parts, subpackage
        purpose = ast.get_docstring(ast.parse((folder / "__init__.py").read_text()))
        assert purpose, subpackage
        unnamed = [path.stem for path in modules if f"``{path.stem}``" not in purpose]
        unnamed += [path.name for path in parts if f"``{path.name}/``" not in purpose]
        assert not unnamed, f"{subpackage}: the reading order does not name {unnamed}"


def test_every_subpackage_is_packaged():
    listed = set(tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"])
    folders = (path.parent.relative_to(PACKAGE) for path in PACKAGE.rglob("__init__.py"))
    subpackages = {".".join(("shakedown", *folder.parts)) for folder in folders}
    assert listed == subpackages | {"shakedown.cli"}


def test_no_module_is_named_as_a_part_of_another():
    elsewhere = {"models.readers", "fem", "motion.plane", "cli", "benchmarks"}
    named = [name for name in SOURCES if "." in name and subpackage_of(name) not in elsewhere]
    stems = [name.split(".")[-1] for name in named if not name.endswith(FACE)]
    assert len(stems) == len(set(stems))
    parts = [(a, b) for a in stems for b in stems if b.startswith(f"{a}_") or b.endswith(f"_of_{a}")]
    assert not parts


def test_the_top_is_small_and_every_public_name_stands_in_one_place():
    assert len(shakedown.__all__) <= MOST_NAMES
    listed = [name for names in of_modules().values() for name in names]
    assert len(listed) == len(set(listed)) > 0
    assert not set(listed) & set(shakedown.__all__)
    for name, thing in public().items():
        assert not name.startswith("_")
        assert not callable(thing) or thing.__doc__, f"{name} is public and says nothing"


def test_cvxpy_is_used_in_one_module():
    """Slow to import, and independent of the solvers that answers come from: what a user's own solver comes through."""
    modules = [module for module, path in SOURCES.items() if "import cvxpy" in path.read_text()]
    modules = [module for module in modules if subpackage_of(module) != "benchmarks"]
    assert modules == ["bounds.independent_solver"]


def test_commands_and_studies_use_public_names_only():
    listed = of_modules()
    modules = [module for module in SOURCES if subpackage_of(module) in {"cli", "benchmarks"}]
    assert {subpackage_of(module) for module in modules} == {"cli", "benchmarks"}
    for module, imported, name in [(one, *found) for one in modules for found in imports(SOURCES[one])]:
        subpackage = imported.split(".")[1] if "." in imported else name
        names = ["", *shakedown.__all__] if imported == "shakedown" else listed.get(imported, ())
        allowed = name in names or (module, imported) in INSIDE
        allowed |= subpackage in OPEN_SUBPACKAGES and not name.startswith("_")
        assert allowed, f"{module} imports {name} from {imported}"
