"""What the constants of the algorithms decide: each is set to half and to twice its value, alone.

Asked are the commands ``solve``, ``simulate`` and ``critical`` of a few joints in the plane and in space.
What differs from their answers with the constants as they are is counted: words (statuses, sentences, nodes)
and numbers that are farther apart than 1e-9 of the largest in their array. Of a constant near 1, as 1.05, the
distance from 1 is halved and doubled. A constant is changed wherever it was imported to, stands behind one
that is derived from it, or is a default of a function. Where compiled code takes it, a process of its own
compiles from changed sources, which takes half a minute; the short form leaves that out.
"""

import ast
import importlib.machinery
import importlib.util
import multiprocessing
import re
import sys
import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import ExitStack, chdir
from functools import cache
from multiprocessing.connection import Connection
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FunctionType
from unittest.mock import patch

from benchmarks.answers import differences
from benchmarks.command_worker import answer
from benchmarks.structure import imported, is_number, sources, tree
from shakedown.report.text_table import table

TITLE = "Constants of the algorithms, each at half and at twice its value"
ROOT = Path(__file__).parents[1]
OF_ALGORITHMS = (
    "bounds",
    "programs",
    "motion",
    "long_term",
    "assessment",
    "ground.round_off",
    "joint.rigid_slips",
)
CODES = {"AS_GIVEN", "WORN", "FAILED", "NEVER", "STAGES", "DEGREE", "BYTES"}
FACTORS = (0.5, 2.0)
WITHIN = 1e-9
NEAR_ONE = (0.9, 1.1)
LEFT_OVER = re.compile(r"(residual|gap)$")  # round-off, and nothing but that
PATIENCE = 300.0  # seconds for one set of answers, of which a few are usual
JOINTS = ("two-node", "three-node", "receding-block", "two-node-3d")  # built in; two are drawn beside them
COMPILED = re.compile(r"^@(inner|summing|borrowing|entered|linked|compiled|checked)\b", re.MULTILINE)


def constants(root: Path = ROOT) -> Iterator[tuple[str, str, float]]:
    """Module, name and value of every constant of an algorithm; of codes several stand in a row."""
    for module, path in sources(root).items():
        for node in tree(path).body if module.startswith(OF_ALGORITHMS) else ():
            if isinstance(node, ast.Assign):
                found = {_name(name): _value(number) for name, number in zip(*_pairs(node), strict=False)}
                codes = len(found) > 1 and all(isinstance(v, int) and abs(v) < 10 for v in found.values())
                for name, value in found.items():
                    if name.isupper() and name not in CODES and value is not None and not codes:
                        yield module, name, value


def _pairs(node: ast.Assign) -> tuple[list[ast.expr], list[ast.expr]]:
    target = node.targets[0]
    if not isinstance(target, ast.Tuple):
        return [target], [node.value]
    return target.elts, node.value.elts if isinstance(node.value, ast.Tuple) else []


def _name(node: ast.expr) -> str:
    return node.id if isinstance(node, ast.Name) else ""


def _value(node: ast.expr) -> float | None:
    """The number that is written; None where it follows from another one."""
    return eval(ast.unparse(node), {}) if is_number(node) else None


def changed(value: float, factor: float) -> float:
    """Half or twice a constant: a whole number stays one, a number near 1 keeps its distance from it."""
    if isinstance(value, int):
        return max(1, round(value * factor))
    if NEAR_ONE[0] < value < NEAR_ONE[1] and value != 1.0:
        return 1.0 + (value - 1.0) * factor
    return value * factor


class _Changed(importlib.machinery.SourceFileLoader):
    """Loads a module with one of its constants changed, never from a cache."""

    def __init__(self, module: str, path: str, name: str, value: float) -> None:
        super().__init__(module, path)
        self.name, self.value = name, value

    def get_code(self, fullname: str):
        lines = self.get_data(self.path).decode().split("\n")
        places = (node for node in tree(Path(self.path)).body if isinstance(node, ast.Assign))
        place = next(node for node in places if self.name in {_name(part) for part in _pairs(node)[0]})
        lines.insert(place.end_lineno, f"{self.name} = {self.value!r}")
        return compile("\n".join(lines), self.path, "exec")


class _Finder:
    def __init__(self, module: str, path: Path, name: str, value: float) -> None:
        self.module, self.loader = module, _Changed(module, str(path), name, value)

    def find_spec(self, fullname: str, path=None, target=None):
        if fullname != self.module:
            return None
        return importlib.util.spec_from_file_location(fullname, self.loader.path, loader=self.loader)


def cases(short: bool) -> list[dict]:
    modules, found = sources(ROOT), []
    compiled = {
        module for module, path in modules.items() if COMPILED.search(path.read_text(encoding="utf-8"))
    }
    for module, name, value in constants():
        users = {module, *(to.removeprefix("shakedown.") for to in _importers()[f"shakedown.{module}", name])}
        takes = bool(compiled & users)
        kinds = [False] * (module not in compiled) + [True] * (takes and not short)
        case = {"module": module, "constant": name, "value": value}
        found += [case | {"compiled": kind, "factor": factor} for kind in kinds for factor in FACTORS]
    return found


def measure(case: dict) -> dict:
    """What differs from the answers with the constants as they are, and the time, relative to theirs."""
    was, found = as_they_are(), _asked(case)
    if isinstance(found, str):
        return {"outcome": found, "words": 0, "numbers": 0, "first": [], "time": None}
    pairs = ((answers, found[0][key]) for key, answers in was[0].items())
    apart = [d for pair in pairs for d in differences(*pair, WITHIN) if not LEFT_OVER.search(d.path)]
    numbers = sum(_is_float(d.reference) for d in apart)
    return {
        "outcome": "differs" if apart else "same",
        "words": len(apart) - numbers,
        "numbers": numbers,
        "first": [f"{d.path}: {d.reference[:60]} -> {d.new[:60]}" for d in apart[:3]],
        "time": None if case["compiled"] else found[1] / was[1],
    }


@cache
def as_they_are() -> tuple[dict, float]:
    """The answers with the constants as they are; all that they need is loaded and compiled before."""
    answers()
    return answers()


def _is_float(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _asked(case: dict) -> tuple[dict, float] | str:
    """The answers with one constant changed and their processor time; or why there are none."""
    value, module = changed(case["value"], case["factor"]), f"shakedown.{case['module']}"
    if not case["compiled"]:
        with ExitStack() as stack:
            for place, what in _followed(module, case["constant"], value):
                stack.enter_context(patch.multiple(place, **what))
            return answers()
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=_compiled_anew, args=(module, case["constant"], value, there))
    process.start()
    there.close()
    try:
        found = here.recv() if here.poll(PATIENCE) else "no end"
    except EOFError:
        found = "died"
    process.kill()
    process.join()
    return found


def _followed(module: str, name: str, value: float) -> Iterator[tuple[object, dict]]:
    """Where a constant stands, and what becomes of it, of defaults and of constants derived from it."""
    was = getattr(sys.modules.get(module), name, None)
    for place in (module, *_importers()[module, name]):
        here = sys.modules.get(place)
        if here is None:  # nothing that is asked needs it
            continue
        yield here, {name: value}
        for function in vars(here).values():
            if isinstance(function, FunctionType) and any(v is was for v in function.__defaults__ or ()):
                yield (
                    function,
                    {"__defaults__": tuple(value if v is was else v for v in function.__defaults__)},
                )
        for node in tree(Path(here.__file__)).body:
            if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
                names = {n.id for n in ast.walk(node.value) if isinstance(n, ast.Name)}
                if node.targets[0].id.isupper() and name in names:
                    follows = eval(ast.unparse(node.value), vars(here) | {name: value})
                    yield from _followed(here.__name__, node.targets[0].id, follows)


@cache
def _importers() -> dict[tuple[str, str], list[str]]:
    """Where a name of a module was imported to."""
    modules, found = sources(ROOT), defaultdict[tuple[str, str], list[str]](list)
    for to, path in modules.items():
        for module, name, _ in imported(path, modules):
            found[f"shakedown.{module}", name].append(f"shakedown.{to}")
    return found


def _compiled_anew(module: str, name: str, value: float, there: Connection) -> None:
    with TemporaryDirectory() as folder:
        _load_changed(module, name, value, folder)
        there.send(answers())


def _load_changed(module: str, name: str, value: float, folder: str) -> None:
    """Forget the package; what is loaded from now on has the constant changed, and compiles in the folder."""
    import numba

    numba.config.CACHE_DIR = folder
    path = sources(ROOT)[module.removeprefix("shakedown.")]
    for loaded in [loaded for loaded in sys.modules if loaded.split(".")[0] == "shakedown"]:
        del sys.modules[loaded]
    sys.meta_path.insert(0, _Finder(module, path, name, value))


def answers() -> tuple[dict, float]:
    """What the commands say of built-in joints and of two drawn ones, and its processor time."""
    import shakedown
    from benchmarks.drawn_joints import drawn_joint, drawn_joint_in_space

    drawn = {"plane.npz": drawn_joint(0, 3), "space.npz": drawn_joint_in_space(0, 1)}
    asked = [["critical", "two-node", "--all"]]
    for joint in (*JOINTS, *drawn):
        asked += [["solve", joint], ["simulate", joint, "--load-factor", "0.6", "--initial", "safe"]]
    with TemporaryDirectory() as folder, chdir(folder):
        for name, joint in drawn.items():
            shakedown.save_problem(Path(name), joint)
        began = time.process_time()
        found = {" ".join(words): answer([*words, "--json", "-q"]) for words in asked}
        return found, time.process_time() - began


def tables(rows: list[dict]) -> str:
    by_constant: dict[tuple, dict] = {}
    for row in rows:
        by_constant.setdefault((row["module"], row["constant"], row["value"], row["compiled"]), {})[
            row["factor"]
        ] = row
    lines = [
        [module, name + " (compiled)" * compiled, f"{value:g}", *(_said(sides.get(f)) for f in FACTORS)]
        for (module, name, value, compiled), sides in by_constant.items()
    ]
    moved = sum(any(row["outcome"] != "same" for row in sides.values()) for sides in by_constant.values())
    counted = f"{moved} of {len(by_constant)} constants change an answer at half or at twice their value"
    headers = ["module", "constant", "value", "halved", "doubled"]
    return table(headers, lines, longest=len(lines)) + f"\n\n{counted}"


def _said(row: dict | None) -> str:
    if row is None:
        return "-"
    if row["outcome"] == "differs":
        return f"{row['words']} words, {row['numbers']} numbers"
    return row["outcome"]


def figures(rows: list[dict]) -> dict:
    return {}
