"""Arguments and options that several commands share: files, numbers, nodes, initial states."""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Callable
from functools import partial, reduce
from math import isfinite
from pathlib import Path
from typing import Any, Literal, TypeVar

import click
import numpy as np

import shakedown
from shakedown import Problem
from shakedown.files.atomic_write import check_table, check_target, pieces_beside
from shakedown.ground.constants import CYCLES, FloatArray
from shakedown.ground.shown_values import FEW_DIGITS, shortened

F = TypeVar("F", bound=Callable[..., Any])
NAMED = f"{__name__}.file"  # in a context: the file or built-in problem that a command was given
FORM = "LOW:HIGH:COUNT or VALUE,VALUE,…"
MOST_VALUES = 1_000_000  # values of a range
CLAIMS = f"{__name__}.claims"  # in a context: what the call reads and writes: names, paths, whether written
PICTURES = (".png", ".svg", ".pdf")
NODE_FILES = (".csv", ".vtu", ".vtp")
AT_LOAD_FACTOR = ("safe", "witness")  # states that exist at a load factor alone

option = partial(click.option, show_default=True)


def claim(name: str, path: str | os.PathLike[str], *, written: bool = False) -> None:
    """Note a file that is read or written.

    Raises ``UsageError`` where it is written and is another file of this call, or read and to be replaced.
    """
    path = os.fspath(path)
    claims: list[tuple[str, str, bool]] = click.get_current_context().meta.setdefault(CLAIMS, [])
    for other, known, replaced in claims:
        output, file, beside = (name, path, other) if written else (other, known, name)
        if (written or replaced) and _is_same(path, known):
            raise click.UsageError(f"{output}: expected another file than {beside}, found {shortened(file)}")
    claims.append((name, path, written))


def writes_whole(name: str, path: Path) -> None:
    """Note a file to write, after a check that it can be written."""
    check_target(path)
    claim(name, path, written=True)


def pieces_of(output: Path | None, resume: bool) -> None:
    """Note the folder beside the output in which a run keeps its pieces."""
    if output is not None:
        claim("the pieces of -o", pieces_beside(output), written=True)
    elif resume:
        raise click.UsageError("--resume: expected -o FILE, beside which the pieces of the run are kept")


def _is_same(one: str, other: str) -> bool:
    """Whether two paths lead to the same file, which need not exist yet."""
    try:
        both_exist = os.path.exists(one) and os.path.exists(other)
        return (
            os.path.samefile(one, other) if both_exist else os.path.realpath(one) == os.path.realpath(other)
        )
    except (OSError, ValueError):  # no file can have that name
        return False


def name_of(param: click.Parameter | None) -> str:
    """A parameter as the user types it: ``-o``, ``--picture``, ``FILE``."""
    if param is None:
        return "-o"
    return param.metavar or param.opts[0] if isinstance(param, click.Argument) else param.opts[0]


class Converted(click.ParamType):
    """What a function makes of the name of a parameter, as the user types it, and of its value."""

    def __init__(self, name: str, convert: Callable[[str, Any], Any]) -> None:
        self.name, self.of_named = name, convert

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        return self.of_named(name_of(param), value)


def output_file(endings: tuple[str, ...] = (), *, table: bool = False) -> Converted:
    """A file to write: before the work starts it is checked to be writable and no other file of the call."""

    def checked(name: str, value: Any) -> Path:
        if not value or str(value).endswith(("/", os.sep)):
            raise click.UsageError(f"{name}: expected the name of a file, found '{value}'")
        if endings and not str(value).lower().endswith(endings):
            known = " or ".join(filter(None, [", ".join(endings[:-1]), endings[-1]]))
            raise shakedown.UsageError(f"{value}: expected a name that ends in {known}")
        path = Path(value)
        writes_whole(name, path)
        if table:
            check_table(path)
        return path

    return Converted("path", checked)


def parsed(kind: str, expected: str, parse: Callable[[str], Any]) -> Converted:
    """What a function makes of a text; None where the text is not as expected."""

    def known(name: str, value: Any) -> Any:
        found = parse(value) if isinstance(value, str) else value
        if found is None:
            raise click.UsageError(f"{name}: expected {expected}, found '{shortened(value, 60)}'")
        return found

    return Converted(kind, known)


def numbers_of(text: str) -> FloatArray | None:
    """The values of ``LOW:HIGH:COUNT``, which rise, or of ``VALUE,VALUE,…``; None where a text is neither."""
    try:
        if ":" not in text:
            values = np.array([float(part) for part in text.split(",")])
            return values if np.isfinite(values).all() else None
        first, last, many = text.split(":")
        low, high, count = float(first), float(last), int(many)
    except ValueError:
        return None
    if not (isfinite(high - low) and low < high and 2 <= count <= MOST_VALUES):
        return None
    return np.linspace(low, high, count)


def open_nodes_of(text: str) -> tuple[int, ...] | str | None:
    """Nodes that stay open, or ``auto``."""
    if text in ("auto", "none"):
        return text if text == "auto" else ()
    numbers = text.split(",")
    known = all(number.isascii() and number.isdigit() and len(number) < 10 for number in numbers)
    return tuple(map(int, numbers)) if known else None


NUMBERS = parsed("numbers", f"{FORM} (finite numbers)", numbers_of)
OPEN_NODES = parsed("nodes", "auto, none or node numbers like 0,3,7", open_nodes_of)


def problem_file(*, imports: bool = False) -> Converted:
    """A problem file or the name of a built-in problem; a file of that name wins.

    Where it ``imports``, it may be an import configuration (.toml).
    """

    def read(name: str, value: Any) -> Problem | shakedown.Import:
        if isinstance(value, shakedown.Problem):
            return value
        if not value:
            raise click.UsageError("FILE: expected a file or the name of a built-in problem, found ''")
        if imports and value.lower().endswith(".toml"):
            return imported(name, value)
        click.get_current_context().meta[NAMED] = shlex.quote(value)
        if not os.path.exists(value) and value in shakedown.example_names():
            return shakedown.example(value)
        if not os.path.exists(value) and Path(value).suffix == "" and "/" not in value:
            names = ", ".join(shakedown.example_names())
            raise shakedown.ProblemError(
                f"{value}: no such file, and no built-in problem (there are {names})"
            )
        claim(name, value)
        return shakedown.load_problem(value)

    return Converted("file", read)


def imported(name: str, path: str | os.PathLike[str], **settings: Any) -> shakedown.Import:
    """The import of a configuration; it and the files that it names are noted as read."""
    claim(name, path)
    made = shakedown.import_model(path, **settings)
    for source in made.sources:
        claim(f"{source}, which {name} names", Path(path).parent / source)
    return made


def file_named() -> str:
    """The file or built-in problem that a command was given, as a shell takes it."""
    return str(click.get_current_context().meta[NAMED])


def start_of(
    problem: Problem, load_factor: float, initial: str | None, open_nodes: tuple[int, ...] | Literal["auto"]
) -> tuple[str, tuple[int, ...], FloatArray]:
    """The initial state of a run: the word for it, the nodes that are open, and the slip, (dn,)."""
    word = word_for(problem, initial)
    if open_nodes == "auto":  # those of the zone with the largest λ_max
        open_nodes = shakedown.upper_bound(problem, open_nodes="auto", certify=False).open_nodes
    return word, open_nodes, initial_state(problem, word, load_factor, open_nodes)


def word_for(problem: Problem, initial: str | None) -> str:
    """The initial state that is asked for, or the one where a user names none."""
    return initial or ("zero" if problem.initial_slip is None else "given")


def initial_state(
    problem: Problem, initial: str, load_factor: float | None = None, open_nodes: tuple[int, ...] = ()
) -> FloatArray:
    """The initial slip, (dn,), that a word or a file stands for; some words need a load factor."""
    states = () if problem.initial_slip is None else problem.initial_slip
    made = ("zero", *(() if load_factor is None else AT_LOAD_FACTOR))
    given = re.fullmatch("given(?::([0-9]{1,9}))?", initial)
    if given and int(given[1] or 0) < len(states):
        return states[int(given[1] or 0)]
    if initial in made:
        from shakedown.bounds.named_start import named_start

        return named_start(problem, load_factor or 0.0, initial, open_nodes)
    if given or initial in AT_LOAD_FACTOR or not os.path.lexists(initial):
        why = f"of a problem with {len(states)} given states" if given else "which is no file"
        known = f"{', '.join(('zero', 'given', 'given:K', *made[1:]))} or PATH.npy"
        raise click.UsageError(f"--initial: expected {known}, found {shortened(initial)}, {why}")
    claim("--initial", initial)
    try:
        return shakedown.load_initial_slip(initial)
    except shakedown.ProblemError as error:
        raise click.UsageError(f"--initial {error}") from None


problem = click.argument("problem", metavar="FILE", type=problem_file())
load_factor = option(
    "--load-factor",
    type=float,
    default=1.0,
    help="Load factor λ ≥ 0 of the periodic loading; 1 is the nominal load.",
)
initial = option(
    "--initial",
    metavar="STATE",
    default="zero",
    help="State of proofs and simulations: zero, given, given:K or PATH.npy.",
)
open_nodes = option(
    "--open",
    "open_nodes",
    type=OPEN_NODES,
    default="auto",
    help="Open nodes: auto (the best zone), none, or numbers like 0,3,7.",
)
cycles = option(
    "--cycles",
    type=click.IntRange(min=1),
    default=CYCLES,
    help="Give up as undecided after so many cycles.",
)
method = option(
    "--method",
    type=click.Choice(["event", "gauss-seidel"]),
    default="event",
    help="From event to event, or at fixed load steps.",
)
average = option(
    "--average",
    type=float,
    metavar="RADIUS",
    help="Also averaged over this length (in the joint's unit): two elements of the coarsest mesh, or more.",
)
slip_below = option(
    "--slip-below",
    type=float,
    metavar="LENGTH",
    help="Also whether, or up to which load factor, slip ranges in the long run stay below this.",
)
digits = option(
    "--digits", type=click.IntRange(1, 15), default=FEW_DIGITS, help="Digits of load factors, at least."
)
seed = option("--seed", type=click.IntRange(min=0), default=0, help="Seed of what is random.")
table = option("-o", "--output", type=output_file(table=True), help="Write the rows here (.csv or .parquet).")
picture = option("--picture", type=output_file(PICTURES), help="Draw it here (.png, .svg or .pdf).")
pieces = option("--resume", is_flag=True, help="Go on with what a run that was stopped left in OUTPUT.parts.")
workers = option("--workers", type=click.IntRange(min=1), default=1, help="Processes.")
scheduler = option(
    "--scheduler", metavar="ADDRESS", help="Work on the dask cluster of this scheduler instead."
)


def run(command: F) -> F:
    """What one run is of, where it begins, and how long it may take."""
    start = option(
        "--initial",
        metavar="STATE",
        help="zero, safe (through the transient too, where there is such a slip), witness (the critical slip "
        "state of λ_1, in the plane), given, given:K (state K of the file) or PATH.npy. "
        "Default: given where the file has initial_slip, else zero.",
    )
    opened = option(
        "--open",
        "open_nodes",
        type=OPEN_NODES,
        default="none",
        help="Nodes that are open at the start: none, numbers like 0,3,7, or auto: those of the zone "
        "of λ_max.",
    )
    return reduce(lambda made, add: add(made), (cycles, opened, start, load_factor, problem), command)
