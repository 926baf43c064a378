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
import os
import re
import sys
import time
from collections.abc import Iterator
from functools import cache
from multiprocessing.connection import Connection
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FunctionType

from benchmarks.answers import ALONE, differences
from benchmarks.command_worker import answer
from benchmarks.structure import imported, is_number, sources
from shakedown.report.node_words import table

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
NO_NUMBERS = ("contact_status", "given_numbers")  # names of states, limits of input
CODES = {"AS_GIVEN", "CONE", "TRIPLE", "WORN", "FAILED", "NEVER", "STAGES", "DEGREE", "BYTES"}
FACTORS = (0.5, 2.0)
WITHIN = 1e-9
NEAR_ONE = (0.9, 1.1)
LEFT_OVER = re.compile(r"(residual|gap)$")  # round-off, and nothing but that
PATIENCE = 300.0  # seconds for one set of answers, of which a few are usual
COMPILED = re.compile(r"^@(inner|summing|borrowing|entered|linked|stamped|checked)\b", re.MULTILINE)


def constants(root: Path = ROOT) -> Iterator[tuple[str, str, float]]:
    """Module, name and value of every constant of an algorithm; of codes several stand in a row."""
    for module, path in sources(root).items():
        if not module.startswith(OF_ALGORITHMS):
            continue
        for name, value in _assigned(ast.parse(path.read_text(encoding="utf-8"))):
            if name not in CODES:
                yield module, name, value


def _assigned(tree: ast.Module) -> Iterator[tuple[str, float]]:
    for node in tree.body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name | ast.Tuple):
            names, values = _pairs(node)
            found = [ast.literal_eval(_folded(value)) for value in values if is_number(value)]
            if len(found) > 1 and all(isinstance(value, int) and abs(value) < 10 for value in found):
                continue  # codes
            yield from (
                (name.id, ast.literal_eval(_folded(value)))
                for name, value in zip(names, values, strict=False)
                if isinstance(name, ast.Name) and name.id.isupper() and is_number(value)
            )


def _pairs(node: ast.Assign) -> tuple[list[ast.expr], list[ast.expr]]:
    target = node.targets[0]
    if not isinstance(target, ast.Tuple):
        return [target], [node.value]
    return target.elts, node.value.elts if isinstance(node.value, ast.Tuple) else []


def _folded(node: ast.expr) -> ast.Constant:
    """The number that an expression of numbers stands for."""
    return ast.Constant(
        eval(compile(ast.Expression(ast.fix_missing_locations(node)), "constant", "eval"), {})
    )


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
        tree = ast.parse(self.get_data(self.path))
        for node in tree.body:
            if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name | ast.Tuple):
                names, values = _pairs(node)
                for k, (name, value) in enumerate(zip(names, values, strict=False)):
                    if isinstance(name, ast.Name) and name.id == self.name:
                        put = ast.copy_location(ast.Constant(self.value), value)
                        if isinstance(node.targets[0], ast.Tuple):
                            node.value.elts[k] = put
                        else:
                            node.value = put
        return compile(ast.fix_missing_locations(tree), self.path, "exec")


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
    into_compiled = {(to, name) for module in compiled for to, name, _ in imported(modules[module], modules)}
    for module, name, value in constants():
        takes = module in compiled or (module, name) in into_compiled
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
    os.environ.update(ALONE)
    with TemporaryDirectory() as folder:
        _answers(Path(folder))
        return _answers(Path(folder))


def _is_float(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _asked(case: dict) -> tuple[dict, float] | str:
    """The answers of a process of its own, and its processor time; or why there are none."""
    context = multiprocessing.get_context("fork")
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=_with_changed, args=(case, there))
    process.start()
    there.close()
    try:
        found = here.recv() if here.poll(PATIENCE) else "no end"
    except EOFError:
        found = "died"
    if process.is_alive():
        process.kill()
    process.join()
    return found


def _with_changed(case: dict, there: Connection) -> None:
    value, module = changed(case["value"], case["factor"]), f"shakedown.{case['module']}"
    with TemporaryDirectory() as folder:
        if case["compiled"]:
            _load_changed(module, case["constant"], value, folder)
        else:
            put(module, case["constant"], value)
        there.send(_answers(Path(folder)))


def put(module: str, name: str, value: float) -> None:
    """Change a constant in its module, where it was imported to, and what follows from it."""
    was, there = getattr(sys.modules[module], name), sys.modules[module]
    setattr(there, name, value)
    for place, path in sources(ROOT).items():
        here = sys.modules.get(f"shakedown.{place}")
        if here is None or not hasattr(here, name) or (here is not there and getattr(here, name) is not was):
            continue
        setattr(here, name, value)
        for function in vars(here).values():
            if isinstance(function, FunctionType) and function.__defaults__:
                function.__defaults__ = tuple(value if v is was else v for v in function.__defaults__)
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
                derived = node.targets[0].id
                if derived.isupper() and name in {
                    n.id for n in ast.walk(node.value) if isinstance(n, ast.Name)
                }:
                    put(here.__name__, derived, eval(ast.unparse(node.value), vars(here)))


def _load_changed(module: str, name: str, value: float, folder: str) -> None:
    """Forget the package; what is loaded from now on has the constant changed, and compiles in the folder."""
    import numba

    numba.config.CACHE_DIR = folder
    path = sources(ROOT)[module.removeprefix("shakedown.")]
    for loaded in [loaded for loaded in sys.modules if loaded.split(".")[0] == "shakedown"]:
        del sys.modules[loaded]
    sys.meta_path.insert(0, _Finder(module, path, name, value))


def _answers(folder: Path) -> tuple[dict, float]:
    """What the commands say of built-in joints and of two drawn ones, and its processor time."""
    import shakedown
    from benchmarks.drawn_joints import drawn_joint, drawn_joint_in_space

    os.chdir(folder)
    drawn = {"plane.npz": drawn_joint(0, 3), "space.npz": drawn_joint_in_space(0, 1)}
    for name, joint in drawn.items():
        shakedown.save_problem(Path(name), joint)
    asked = [["critical", "two-node", "--all"]]
    for joint in ("two-node", "three-node", "receding-block", "two-node-3d", *drawn):
        asked += [["solve", joint], ["simulate", joint, "--load-factor", "0.95", "--initial", "safe"]]
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
        [module, name + " (compiled)" * compiled, f"{value:g}", *(_said(sides[f]) for f in FACTORS)]
        for (module, name, value, compiled), sides in by_constant.items()
    ]
    moved = sum(any(row["outcome"] != "same" for row in sides.values()) for sides in by_constant.values())
    counted = f"{moved} of {len(by_constant)} constants change an answer at half or at twice their value"
    headers = ["module", "constant", "value", "halved", "doubled"]
    return table(headers, lines, longest=len(lines)) + f"\n\n{counted}"


def _said(row: dict) -> str:
    if row["outcome"] == "differs":
        return f"{row['words']} words, {row['numbers']} numbers"
    return row["outcome"]


def figures(rows: list[dict]) -> dict:
    return {}
