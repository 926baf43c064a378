"""The structure of the package, counted from its source: ``python -m benchmarks.structure [ROOT]``.

Each figure stands beside the one of the start of the present round (``start`` in ``code_lines.json``). There,
too, is what the code lines of a subpackage may not exceed; ``--lower`` writes today's figures where they are
smaller. Nothing is imported or run. What is counted:

- *code lines* of the package and the command line, without blank lines, comments and docstrings;
- *files*, *packages*, *classes*, *functions* and those of more than forty code lines;
- *capitals*: constants of modules in capitals, whatever they stand for;
- *public names* at the top of the package;
- *arrows*: pairs of subpackages (the folders at the top of the package, and the command line) with an import
  between them.
"""

import ast
import io
import json
import sys
import tokenize
from collections import Counter
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

LONG = 40
LARGEST = 10  # modules shown
CODE_LINES = Path(__file__).with_name("code_lines.json")
SILENT = {
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENCODING,
    tokenize.ENDMARKER,
}


def sources(root: Path) -> dict[str, Path]:
    """Dotted name of every source file: below the package, or cli.…"""
    found = {}
    for place, prefix in (("shakedown", ()), ("cli", ("cli",))):
        for path in sorted((root / place).rglob("*.py")):
            parts = (*prefix, *path.relative_to(root / place).with_suffix("").parts)
            found[".".join(parts).removesuffix(".__init__")] = path
    return found


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def of_kind(paths: Iterable[Path], kind: type) -> Iterator:
    return (node for path in paths for node in ast.walk(tree(path)) if isinstance(node, kind))


def arrows(modules: dict[str, Path]) -> set[tuple[str, str]]:
    """Pairs of subpackages of which the first imports from the second."""
    folders = {module.split(".")[0] for module in modules}
    pairs = {
        (module.split(".")[0], part)
        for module, path in modules.items()
        for node in of_kind([path], ast.ImportFrom)
        for name in node.names
        for part in f"{node.module}.{name.name}".split(".")[1:2]
        if (node.module or "").split(".")[0] == "shakedown" and part in folders
    }
    return {(one, other) for one, other in pairs if one not in (other, "__init__", "__main__")}


def code_lines(path: Path) -> int:
    """Lines with code on them; a text that comes first in a module or a body is its docstring."""
    lines, before = set[int](), tokenize.INDENT
    for token in tokenize.generate_tokens(io.StringIO(path.read_text(encoding="utf-8")).readline):
        docstring = token.type == tokenize.STRING and before == tokenize.INDENT
        if token.type not in SILENT and not docstring:
            lines.update(range(token.start[0], token.end[0] + 1))
        if token.type not in (tokenize.NL, tokenize.COMMENT):
            before = token.type
    return len(lines)


def lines_of(node: ast.FunctionDef) -> int:
    """Lines of a function without its docstring."""
    said = node.body[0] if ast.get_docstring(node) is not None else None
    silent = 0 if said is None else (said.end_lineno or 0) - said.lineno + 1
    return (node.end_lineno or 0) - node.lineno + 1 - silent


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
    for path in sources(root).values():
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


def counts(root: Path) -> dict[str, int]:
    modules = sources(root)
    paths = modules.values()
    return {
        "code lines": sum(map(code_lines, paths)),
        "files": len(modules),
        "packages": sum(path.name == "__init__.py" for path in paths),
        "classes": sum(1 for _ in of_kind(paths, ast.ClassDef)),
        "capitals": sum(map(capitals, paths)),
        "public names": public_names(root),
        "functions": sum(1 for _ in of_kind(paths, ast.FunctionDef)),
        "of > 40 lines": sum(lines_of(node) > LONG for node in of_kind(paths, ast.FunctionDef)),
        "arrows": len(arrows(modules)),
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
    for count, name in largest[:LARGEST]:
        print(f"{count:16,}  {name}")
    if "--lower" in sys.argv:
        at_most = {name: min(lines.get(name, 0), most) for name, most in kept["at_most"].items()}
        kept["at_most"] = {name: most for name, most in at_most.items() if most}
        CODE_LINES.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
