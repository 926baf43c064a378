"""The structure of the package, counted from its source: ``python -m benchmarks.structure [ROOT]``.

Each figure stands beside the one of the start of the present round (``start`` in ``code_lines.json``). There,
too, is what the code lines of a subpackage may not exceed; ``--lower`` writes today's figures where they are
smaller. Nothing is imported or run. What is counted:

- *code lines* of the package and the command line, without blank lines, comments and docstrings;
- *files*, *packages*, *classes*, *capitals*: constants of modules in capitals, whatever they stand for;
- *arrows*: pairs of subpackages (the folders at the top of the package, and the command line) with an import
  between them;
- *plane modules*: files with the arithmetic of one tangential direction: slips before gaps (``2 * n``,
  ``u[:n]``, ``u[n:]``, ``n + i``), two rows a node (``[0::2]``, ``2 * j + 1``, interleaving), sides ±1;
- *law modules*: files that state Coulomb's law, the product of friction and pressure;
- *direction tests*: how often the number of tangential directions is compared with another number;
- *depth* of its folders, *functions* and those of more than forty code lines, *named numbers* (constants of a
  module) beside the fields of ``Tolerances``, *class names* that more than one class has;
- *public names* at the top of the package;
- *climbs*: followed from ``verify`` into every function that gets it, how often ``problem`` comes to a
  module that stands on a higher layer than the one before. Layers are the longest chain of imports.
"""

import ast
import io
import json
import sys
import tokenize
from collections import Counter
from collections.abc import Iterable, Iterator
from functools import cache
from itertools import pairwise
from pathlib import Path

FRICTION = {"f", "friction", "mu", "mus"}
PRESSURE = {
    "p",
    "p0",
    "p1",
    "p_w",
    "p_mean",
    "p_transient",
    "P",
    "B",
    "pressure",
    "normal",
    "pressures",
    "locked_p",
}
SIDES = {"BACKWARD", "FORWARD", "SIDES"}
LONG = 40
LARGEST = 10  # modules shown
CODE_LINES = Path(__file__).with_name("code_lines.json")
START = ("assessment.verify", "verify", "problem")


def sources(root: Path) -> dict[str, Path]:
    """Dotted name of every source file: below the package, or cli.…, benchmarks.…"""
    found = {}
    for place, prefix in (("shakedown", ()), ("cli", ("cli",)), ("benchmarks", ("benchmarks",))):
        for path in sorted((root / place).rglob("*.py")):
            parts = (*prefix, *path.relative_to(root / place).with_suffix("").parts)
            found[".".join(parts).removesuffix(".__init__")] = path
    return found


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def _statements(block: ast.AST) -> Iterator[ast.AST]:
    """All statements below one, without what they are made of: a tenth of the nodes."""
    for part in ("body", "orelse", "finalbody", "handlers", "cases"):
        for inner in getattr(block, part, ()):
            yield inner
            yield from _statements(inner)


def imported(path: Path, modules: dict[str, Path]) -> Iterator[tuple[str, str, str]]:
    """(module, name there, name here) of every import of the project in a file."""
    for node in _statements(tree(path)):
        if isinstance(node, ast.Import):
            found = [(alias.name, "", alias.asname or alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and not node.level:
            found = [(node.module or "", alias.name, alias.asname or alias.name) for alias in node.names]
        else:
            continue
        for module, name, here in found:
            top, _, below = module.partition(".")
            if top not in ("shakedown", "benchmarks"):
                continue
            place = module if top == "benchmarks" else below or "__init__"
            inner = f"{below}.{name}" if below else name
            yield (inner, "", here) if inner in modules and top == "shakedown" else (place, name, here)


def subpackage(module: str) -> str:
    return module.split(".")[0]


def arrows(modules: dict[str, Path]) -> set[tuple[str, str]]:
    pairs = {
        (subpackage(module), subpackage(to))
        for module, path in modules.items()
        for to, _, _ in imported(path, modules)
    }
    apart = {"__init__", "__main__", "benchmarks"}  # doors, and what stands outside
    return {(one, other) for one, other in pairs if one != other and not {one, other} & apart}


def code_lines(path: Path) -> int:
    """Lines with code on them."""
    lines: set[int] = set()
    silent = {
        tokenize.COMMENT,
        tokenize.NL,
        tokenize.NEWLINE,
        tokenize.INDENT,
        tokenize.DEDENT,
        tokenize.ENCODING,
    }
    for token in tokenize.generate_tokens(io.StringIO(path.read_text(encoding="utf-8")).readline):
        if token.type not in silent and token.type != tokenize.ENDMARKER:
            lines.update(range(token.start[0], token.end[0] + 1))
    for node in ast.walk(tree(path)):
        if (
            isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
            and ast.get_docstring(node) is not None
        ):
            lines.difference_update(range(node.body[0].lineno, (node.body[0].end_lineno or 0) + 1))
    return len(lines)


def lines_of(node: ast.FunctionDef) -> int:
    """Lines of a function without its docstring."""
    said = node.body[0] if ast.get_docstring(node) is not None else None
    silent = 0 if said is None else (said.end_lineno or 0) - said.lineno + 1
    return (node.end_lineno or 0) - node.lineno + 1 - silent


def named_numbers(path: Path) -> int:
    """Constants of a module: capitals that stand for a number, or for several."""
    found = 0
    for node in tree(path).body:
        if isinstance(node, ast.Assign) and len(node.targets) == 1:
            target, value = node.targets[0], node.value
            names = target.elts if isinstance(target, ast.Tuple) else [target]
            values = value.elts if isinstance(value, ast.Tuple) and len(names) > 1 else [value]
            pairs = zip(names, values, strict=False)
            found += sum(
                isinstance(name, ast.Name) and name.id.isupper() and is_number(value) for name, value in pairs
            )
    return found


def is_number(node: ast.AST) -> bool:
    if isinstance(node, ast.UnaryOp):
        return is_number(node.operand)
    if isinstance(node, ast.BinOp):
        return is_number(node.left) and is_number(node.right)
    return isinstance(node, ast.Constant) and type(node.value) in (int, float)


def of_kind(paths: Iterable[Path], kind: type) -> Iterator:
    return (node for path in paths for node in ast.walk(tree(path)) if isinstance(node, kind))


def _word(node: ast.AST) -> str:
    """The last name in an operand: ``problem.f[:, None]`` is f."""
    while isinstance(node, ast.Subscript):
        node = node.value
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else ""


def _is(node: ast.AST | None, value: int) -> bool:
    return isinstance(node, ast.Constant) and node.value == value and not isinstance(node.value, bool)


def _is_plane(node: ast.AST) -> bool:
    if isinstance(node, ast.BinOp):
        words = {_word(node.left), _word(node.right)}
        if isinstance(node.op, ast.Mult):
            return (_is(node.left, 2) or _is(node.right, 2)) and bool(
                words & {"n", "j", "i", "node", "nodes", "count"}
            )
        return isinstance(node.op, ast.Add) and "n" in words and "" not in words
    if isinstance(node, ast.Slice):
        halves = [end for end in (node.lower, node.upper) if end is not None]
        pairs = _is(node.step, 2) and (node.lower is None or _is(node.lower, 0) or _is(node.lower, 1))
        return pairs or (len(halves) == 1 and _word(halves[0]) == "n")
    return isinstance(node, ast.Name) and node.id in SIDES


def _is_law(node: ast.AST) -> bool:
    if not (isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult)):
        return False
    left, right = _word(node.left), _word(node.right)
    return (left in FRICTION and right in PRESSURE) or (right in FRICTION and left in PRESSURE)


def _is_direction_test(node: ast.Compare) -> bool:
    numbers = all(isinstance(other, ast.Constant) for other in node.comparators)
    return _word(node.left) == "directions" and numbers


def with_arithmetic(modules: dict[str, Path], kind) -> list[str]:
    return [module for module, path in modules.items() if any(kind(node) for node in ast.walk(tree(path)))]


def capitals(path: Path) -> int:
    """Names in capitals that a module assigns."""
    found = 0
    for node in tree(path).body:
        targets = node.targets if isinstance(node, ast.Assign) else []
        targets = [node.target] if isinstance(node, ast.AnnAssign) else targets
        for target in targets:
            names = target.elts if isinstance(target, ast.Tuple) else [target]
            found += sum(isinstance(name, ast.Name) and name.id.isupper() for name in names)
    return found


def lines_by_subpackage(root: Path) -> dict[str, int]:
    """Code lines of every folder at the top of the package, of its own modules, and of the command line."""
    found = Counter[str]()
    for module, path in sources(root).items():
        if subpackage(module) != "benchmarks":
            above = path.relative_to(root).parts[:-1]
            found[above[1] if len(above) > 1 else above[0]] += code_lines(path)
    return dict(sorted(found.items()))


def public_names(root: Path) -> int:
    """The names that the package declares: in its stub, or where its own module imports them."""
    stub = root / "shakedown" / "__init__.pyi"
    face = tree(stub if stub.exists() else root / "shakedown" / "__init__.py")
    return len(
        {
            a.asname
            for node in ast.walk(face)
            if isinstance(node, ast.ImportFrom)
            for a in node.names
            if a.asname
        }
    )


def layers(modules: dict[str, Path]) -> dict[str, int]:
    """The longest chain of imports below every module."""
    below = {
        module: {to for to, _, _ in imported(path, modules)} & set(modules) - {module}
        for module, path in modules.items()
    }

    @cache
    def layer(module: str) -> int:
        return 1 + max((layer(to) for to in below[module] if to != "__init__"), default=0)

    return {module: layer(module) for module in modules}


class Trip:
    """What is handed a parameter, function by function, in the order in which the code is written."""

    def __init__(self, modules: dict[str, Path]) -> None:
        self.modules, self.seen, self.route = modules, set[tuple[str, str, str]](), list[str]()
        self.names = {
            module: {here: (to, name) for to, name, here in imported(path, modules)}
            for module, path in modules.items()
        }
        self.functions = {
            module: {
                node.name: node
                for node in ast.walk(tree(path))
                if isinstance(node, ast.FunctionDef | ast.ClassDef)
            }
            for module, path in modules.items()
        }

    def follow(self, module: str, function: str, parameter: str) -> list[str]:
        """Modules in the order in which they are entered, as often as they are."""
        if not self.route or self.route[-1] != module:
            self.route.append(module)
        if (module, function, parameter) in self.seen:
            return self.route
        self.seen.add((module, function, parameter))
        body = self.functions[module][function]
        calls = [node for node in ast.walk(body) if isinstance(node, ast.Call)]
        for call in sorted(calls, key=lambda call: (call.end_lineno, call.end_col_offset)):
            for position, name in self._handed(call, parameter):
                target = self._target(module, call)
                into = target and self._parameter(*target, position, name)
                if target and into:
                    self.follow(*target, into)
        return self.route

    def _handed(self, call: ast.Call, parameter: str) -> Iterator[tuple[int, str]]:
        for position, value in enumerate(call.args):
            if isinstance(value, ast.Name) and value.id == parameter:
                yield position, ""
        for keyword in call.keywords:
            if isinstance(keyword.value, ast.Name) and keyword.value.id == parameter and keyword.arg:
                yield -1, keyword.arg

    def _target(self, module: str, call: ast.Call) -> tuple[str, str] | None:
        name = _word(call.func)
        if name == "sought" and call.args:  # an optional step: what is called stands first
            name = _word(call.args[0])
        place, there = self.names[module].get(name, (module, name))
        return (place, there) if there in self.functions.get(place, {}) else None

    def _parameter(self, module: str, function: str, position: int, name: str) -> str:
        """What a callee calls the argument at a position, or of a name."""
        node = self.functions[module][function]
        if isinstance(node, ast.ClassDef):
            inner = [
                part for part in node.body if isinstance(part, ast.FunctionDef) and part.name == "__init__"
            ]
            if not inner:
                return ""
            node, position = inner[0], position + 1
        arguments = [argument.arg for argument in (*node.args.posonlyargs, *node.args.args)]
        if name:
            return name if name in arguments + [argument.arg for argument in node.args.kwonlyargs] else ""
        return arguments[position] if position < len(arguments) else ""


def climbs(modules: dict[str, Path]) -> int:
    height = layers(modules)
    route = Trip(modules).follow(*START)
    return sum(height[there] > height[here] for here, there in pairwise(route))


def counts(root: Path) -> dict[str, int]:
    modules = sources(root)
    package = {module: path for module, path in modules.items() if subpackage(module) != "benchmarks"}
    paths, classes = package.values(), Counter(node.name for node in of_kind(package.values(), ast.ClassDef))
    folders = [path.relative_to(root).parent for path in paths if path.name == "__init__.py"]
    return {
        "code lines": sum(map(code_lines, paths)),
        "files": len(package),
        "packages": len(folders),
        "classes": sum(classes.values()),
        "capitals": sum(map(capitals, paths)),
        "public names": public_names(root),
        "subpackages": len({subpackage(module) for module in modules}),
        "arrows": len(arrows(modules)),
        "depth": max(len(folder.parts) for folder in folders),
        "functions": sum(1 for _ in of_kind(paths, ast.FunctionDef)),
        "of > 40 lines": sum(lines_of(node) > LONG for node in of_kind(paths, ast.FunctionDef)),
        "named numbers": sum(map(named_numbers, paths)),
        "shared classes": sum(count > 1 for count in classes.values()),
        "plane modules": len(with_arithmetic(package, _is_plane)),
        "law modules": len(with_arithmetic(package, _is_law)),
        "direction tests": sum(map(_is_direction_test, of_kind(paths, ast.Compare))),
        "climbs": climbs(modules),
    }


def main() -> None:
    places = [word for word in sys.argv[1:] if not word.startswith("-")]
    root = Path(places[0]) if places else Path(__file__).parents[1]
    kept = json.loads(CODE_LINES.read_text(encoding="utf-8"))
    lines, start = lines_by_subpackage(root), kept["start"]
    print(f"{'':16}{'now':>8}{'start':>8}")
    for what, count in counts(root).items():
        print(f"{what:16}{count:8,}{start.get(what, ''):>8}")
    print(f"\n{'code lines of':16}{'now':>8}{'at most':>8}")
    for name, count in lines.items():
        print(f"{name:16}{count:8,}{kept['at_most'].get(name, 0):8,}")
    largest = sorted(((code_lines(path), name) for name, path in sources(root).items()), reverse=True)
    print("\nlargest modules")
    for count, name in [one for one in largest if subpackage(one[1]) != "benchmarks"][:LARGEST]:
        print(f"{count:16,}  {name}")
    if "--lower" in sys.argv:
        at_most = {name: min(lines.get(name, 0), most) for name, most in kept["at_most"].items()}
        kept["at_most"] = {name: most for name, most in at_most.items() if most}
        CODE_LINES.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    if "--list" in sys.argv:
        package = {
            module: path
            for module, path in sources(root).items()
            if subpackage(module) not in ("cli", "benchmarks")
        }
        print("plane:", *with_arithmetic(package, _is_plane), sep="\n  ")
        print("law:", *with_arithmetic(package, _is_law), sep="\n  ")


if __name__ == "__main__":
    main()
