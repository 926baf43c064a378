"""Initial states on the command line: words, state numbers, files."""

from __future__ import annotations

import os
from typing import Literal

import click

import shakedown
from shakedown import Problem
from shakedown.ground.float_array import FloatArray
from shakedown.ground.visible_text import shortened

from .claims import reads

LONGEST_INDEX = 18  # digits of a state number
AT_LOAD_FACTOR = ("safe", "witness")  # words for states that exist at one load factor
AT_NONE = "zero, given, given:K"  # and those that exist without one


def zone_nodes(problem: Problem) -> tuple[int, ...]:
    """The nodes that are open in the zone with the largest λ_max."""
    return shakedown.upper_bound(problem, open_nodes="auto", certify=False).open_nodes


def start_of(
    problem: Problem, load_factor: float, initial: str | None, open_nodes: tuple[int, ...] | Literal["auto"]
) -> tuple[str, tuple[int, ...], FloatArray]:
    """The initial state of a run: the word for it, the nodes that are open, and the slip, (dn,)."""
    default = "zero" if problem.initial_slip is None else "given"
    word = default if initial is None else initial
    opened = zone_nodes(problem) if open_nodes == "auto" else open_nodes
    return word, opened, initial_state(problem, load_factor, word, opened)


def refuse_at_load_factor(initial: str | None) -> None:
    """Raise ``UsageError`` for a state that exists at one load factor, where none is asked about."""
    if initial in AT_LOAD_FACTOR:
        raise click.UsageError(f"--initial {initial}: expected {AT_NONE} or PATH.npy")


def initial_state(
    problem: Problem,
    load_factor: float,
    initial: str,
    open_nodes: tuple[int, ...] = (),
    expected: str = f"{AT_NONE}, {', '.join(AT_LOAD_FACTOR)}",
) -> FloatArray:
    """The initial slip, (dn,), that a word or a file on the command line stands for."""
    word, colon, index = initial.partition(":")
    if colon and word in ("zero", *AT_LOAD_FACTOR):
        raise click.UsageError(f"--initial {shortened(initial)}: only given takes a state number")
    if word == "given":
        return _given(problem, index)
    from shakedown.bounds.named_start import NAMES, named_start

    if word in NAMES:
        return named_start(problem, load_factor, word, open_nodes)
    return _from_file(initial, expected)


def _given(problem: Problem, index: str) -> FloatArray:
    states = problem.initial_slip
    if states is None:
        raise click.UsageError("--initial given: the problem has no initial_slip")
    shown = shortened(index, 20)
    if not index.isdecimal() and index:
        raise click.UsageError(f"--initial given:{shown}: expected a state number")
    if len(index) > LONGEST_INDEX or int(index or 0) >= len(states):
        raise click.UsageError(f"--initial given:{shown}: the problem has {len(states)} state(s), from 0")
    return states[int(index or 0)]


def _from_file(path: str, expected: str) -> FloatArray:
    if not os.path.lexists(path):
        is_path = os.path.splitext(path)[1] or os.path.basename(path) != path
        why = "no such file" if is_path else f"expected {expected} or an NPY file"
        raise click.UsageError(f"--initial {shortened(path)}: {why}")
    reads(click.get_current_context(silent=True), "--initial", path)
    try:
        return shakedown.load_initial_slip(path)
    except shakedown.ProblemError as error:
        raise click.UsageError(f"--initial {error}") from None
