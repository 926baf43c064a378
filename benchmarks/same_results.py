"""Whether two checkouts say the same, to the last bit: ``python -m benchmarks same_results --reference …``.

``solve``, ``verify``, ``simulate``, ``map``, ``sweep``, ``critical`` and ``nodes`` run on every built-in
joint and on random ones in the plane and in space, ``import`` on the decks at hand, in one process of each
checkout's interpreter. Compared are exit codes, every leaf of the documents, sentences, messages, and what
the commands write: arrays by their bits, tables by their cells, reports and pictures line by line. What may
differ is :data:`benchmarks.answers.NOT_COMPARED`; with ``--within`` numbers may be near each other, where a
solver has changed. With ``--kept`` only what users' programs read is compared: exit codes, and in documents,
arrays and tables all keys that the reference has, with numbers, statuses and outcomes, but for
:data:`benchmarks.answers.GONE`; no sentences, pages and pictures. ``REFERENCE`` beside this file names the
commit before the deletions of the present round: ``git worktree add ../before $(cat benchmarks/REFERENCE)``.
"""

import argparse
import hashlib
import io
import json
import sys
import time
import zipfile
from collections import Counter
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing
from itertools import chain
from math import inf
from pathlib import Path
from typing import NamedTuple

import shakedown
from benchmarks.answers import NO_ANSWER, Answer, Checkout, Difference, differences
from benchmarks.commands_compared import COMMANDS, Run, imports, runs_of
from benchmarks.drawn_joints import drawn_joint, drawn_joint_in_space
from benchmarks.problems import file_of
from shakedown import Problem
from shakedown.files.atomic_write import atomic_write
from shakedown.report.facts import table

FIRST = 3  # runs of every command of which the first differing leaf is shown
LONGEST = 60  # characters of a value
TURNS = 6  # of load factors, starts, samplers, parameters that a built-in joint is asked for; a random one: 1
LIMIT = 300.0  # seconds for one answer
DECKS = Path(__file__).parents[1] / "tests" / "data"
LISTED = Run("example", "(their list)", ("example", "--json", "-q"))


class Joints(NamedTuple):
    """What both checkouts are asked, and the files that it needs: the problems of random joints, decks."""

    runs: list[Run]
    files: dict[str, bytes]

    @property
    def checksum(self) -> dict[str, str]:
        return {name: _checksum(content) for name, content in self.files.items()}


def main(words: list[str] | None = None) -> int:
    """Exit code 0 where all is the same, 1 where anything differs, or nothing was compared."""
    arguments = _parser().parse_args(words)
    commands = arguments.only.split(",")
    if unknown := set(commands) - set(COMMANDS):
        _parser().error(f"--only: expected some of {','.join(COMMANDS)}, found {','.join(sorted(unknown))}")
    joints = chosen_joints(arguments.joints, arguments.seed, arguments.on)
    runs = [run for run in joints.runs if run.command in (*commands, LISTED.command)]
    if arguments.kept:
        runs = [run for run in runs if "--json" in run.words]
    began = time.monotonic()
    reference, new = answers_of_both(arguments.reference, runs, joints, began + 60.0 * arguments.minutes)
    if arguments.save:
        save(arguments.save, reference, joints.checksum)
    compared = [run for run in runs if run.key in reference and run.key in new]
    within, kept = arguments.within, arguments.kept
    found = {run: differences(reference[run.key], new[run.key], within, kept) for run in compared}
    print(_summary(compared, found, reference, new), flush=True)
    print(_leaves_shown(found, arguments.list))
    cut = f"; {len(runs) - len(compared)} runs were not compared" if len(compared) < len(runs) else ""
    print(f"{(time.monotonic() - began) / 60.0:.1f} minutes{cut}")
    return int(any(found.values()) or not compared)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks same_results", description=__doc__)
    add = parser.add_argument
    add(
        "--reference",
        required=True,
        metavar="PYTHON",
        help="the other interpreter, or what --save kept of it",
    )
    add("--joints", type=int, default=200, help="number of random joints in the plane (200); half in space")
    add(
        "--within",
        type=float,
        default=0.0,
        help="numbers may be so far apart, as a share of their size",
    )
    add("--kept", action="store_true", help="compare the documents that the reference has, without words")
    add("--minutes", type=float, default=inf, help="ask no more after so long; what is left is counted")
    add("--seed", type=int, default=0, help="seed of the random joints (0)")
    add("--only", default=",".join(COMMANDS), metavar="COMMANDS", help="commands with commas between them")
    add("--on", metavar="JOINTS", help="these joints only: two-node,random-3,…")
    add("--save", metavar="FILE", help="keep the answers of the reference here")
    add("--list", action="store_true", help="show every leaf that differs")
    return parser


def chosen_joints(count: int, seed: int, names: str | None) -> Joints:
    """The runs of the built-in joints and of the random ones, or of those that are named."""
    built_in = {name: shakedown.example(name) for name in shakedown.example_names()}
    drawn = _drawn(count, seed)
    decks, files = imports(DECKS)
    chosen = names.split(",") if names else [*built_in, *drawn, *(run.joint for run in decks)]
    if unknown := set(chosen) - {*built_in, *drawn, *(run.joint for run in decks)}:
        raise SystemExit(f"--on: expected built-in or random joints, found {', '.join(sorted(unknown))}")
    runs = [LISTED, *(run for run in decks if run.joint in chosen)]
    for name in filter(chosen.__contains__, built_in):
        turns = [runs_of(name, name, built_in[name], turn) for turn in range(TURNS)]
        runs += dict.fromkeys(chain.from_iterable(turns))
    for name in filter(chosen.__contains__, drawn):
        runs += runs_of(name, f"{name}.npz", drawn[name], int(name.rpartition("-")[2]))
        files[f"{name}.npz"] = file_of(drawn[name])
    return Joints(runs, files)


def _drawn(count: int, seed: int) -> dict[str, Problem]:
    """Random joints, after every two in the plane one in space."""
    drawn = {}
    for number in range(count):
        drawn[f"random-{number}"] = drawn_joint(seed, number)
        if number % 2:
            drawn[f"space-{number // 2}"] = drawn_joint_in_space(seed, number // 2)
    return drawn


def _checksum(file: bytes) -> str:
    """Of a deck, or of the arrays in a problem file, by their names."""
    if not zipfile.is_zipfile(io.BytesIO(file)):  # a deck
        return hashlib.sha256(file).hexdigest()
    with zipfile.ZipFile(io.BytesIO(file)) as archive:
        members = {name: archive.read(name) for name in sorted(archive.namelist())}
    return hashlib.sha256(b"".join(name.encode() + content for name, content in members.items())).hexdigest()


def answers_of_both(
    reference: str, runs: list[Run], joints: Joints, until: float = inf
) -> tuple[dict[str, Answer], dict[str, Answer]]:
    """The answers of the reference, asked beside this checkout or read, and of this checkout."""
    kept = _kept(reference)
    if kept is not None:
        _check_kept(reference, kept, runs, joints.checksum)
    with ExitStack() as stack:
        here = stack.enter_context(closing(Checkout(sys.executable, joints.files, LIMIT)))
        _check_place(here)
        if kept is not None:
            print(f"reference {reference}\nnew       {here.package}", flush=True)
            return kept["answers"], _asked(here, runs, until)
        there = stack.enter_context(closing(Checkout(reference, joints.files, LIMIT)))
        print(f"reference {there.package}\nnew       {here.package}", flush=True)
        if there.package == here.package:
            print("This is one checkout: no difference means only that its results can be reproduced.")
        with ThreadPoolExecutor(2) as threads:
            first, second = threads.map(lambda side: _asked(side, runs, until), (there, here))
        return first, second


def _asked(side: Checkout, runs: list[Run], until: float) -> dict[str, Answer]:
    """The answers to all runs, or to the first of them, where time is up."""
    answers: dict[str, Answer] = {}
    for number, run in enumerate(runs, 1):
        if time.monotonic() > until:
            break
        answers[run.key] = side.answer(run)
        if sys.stderr.isatty():
            print(f"\r\033[K{number}/{len(runs)} {run.key[:80]}", end="", file=sys.stderr, flush=True)
    return answers


def _check_place(here: Checkout) -> None:
    """The process next door must not have found another package than the one that draws the joints."""
    if Path(here.package) != Path(shakedown.__file__):
        raise SystemExit(f"{here.python} imports {here.package}, expected {shakedown.__file__}")


def save(path: str, answers: dict[str, Answer], checksum: dict[str, str]) -> None:
    """Keep answers, and of which joints they are."""
    with atomic_write(path) as file:
        file.write(json.dumps({"joints": checksum, "answers": answers}).encode())


def _kept(reference: str) -> dict | None:
    """What ``save`` wrote, or None where the reference is an interpreter."""
    if not Path(reference).is_file():
        raise SystemExit(
            f"--reference {reference}: expected an interpreter or a file of --save, found neither"
        )
    with open(reference, "rb") as file:
        if file.read(1) != b"{":
            return None
        file.seek(0)
        return json.load(file)


def _check_kept(path: str, kept: dict, runs: Iterable[Run], checksum: dict[str, str]) -> None:
    """Answers can be compared with only if they are to the same questions about the same joints."""
    other = [name for name, bits in checksum.items() if kept["joints"].get(name) != bits]
    if other:
        raise SystemExit(f"{path}: its answers are about other joints than {', '.join(other[:5])}")
    missing = [run.key for run in runs if run.key not in kept["answers"]]
    if missing:
        raise SystemExit(f"{path}: no answer to {missing[0]} ({len(missing)} such questions)")


def _summary(
    runs: list[Run],
    found: dict[Run, list[Difference]],
    reference: dict[str, Answer],
    new: dict[str, Answer],
) -> str:
    """One row per command: joints compared, joints that differ, runs, seconds of both."""
    rows = []
    for command in dict.fromkeys(run.command for run in runs):
        mine = [run for run in runs if run.command == command]
        joints, differing = {run.joint for run in mine}, {run.joint for run in mine if found[run]}
        seconds = [sum(side[run.key]["seconds"] for run in mine) for side in (reference, new)]
        silent = sum(str(reference[run.key]["code"]).startswith(NO_ANSWER) for run in mine)
        rows.append([command, len(joints), len(differing), len(mine), silent, *(f"{s:.1f}" for s in seconds)])
    headers = ["command", "joints", "differ", "runs", "unanswered", "reference s", "new s"]
    return table(headers, [[str(cell) for cell in row] for row in rows])


def _leaves_shown(found: dict[Run, list[Difference]], everything: bool) -> str:
    """All leaves that differ, or the first one of each of a few runs of every command."""
    lines, shown = [], Counter[str]()
    for run, leaves in found.items():
        shown[run.command] += bool(leaves)
        if not leaves or (shown[run.command] > FIRST and not everything):
            continue
        lines.append(f"{run.joint}: {run.key} ({len(leaves)} leaves differ)")
        for leaf in leaves if everything else leaves[:1]:
            lines += [f"  {leaf.path}"]
            lines += [f"    reference {_short(leaf.reference)}", f"    new       {_short(leaf.new)}"]
    if not lines:
        return "No difference."
    return "\n".join(lines if everything else [*lines, "(--list shows every run and leaf)"])


def _short(text: str) -> str:
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}…"
