"""Initial states on the command line: words, state numbers, files."""

from __future__ import annotations

import os
from typing import Literal

import click
import numpy as np

import shakedown
from shakedown import Problem
from shakedown.ground.float_array import FloatArray
from shakedown.ground.visible_text import shortened

from .claims import reads

LONGEST_INDEX = 18  # digits of a state number


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


def initial_state(
    problem: Problem, load_factor: float, initial: str, open_nodes: tuple[int, ...] = ()
) -> FloatArray:
    """The initial slip, (dn,), that a word or a file on the command line stands for."""
    word, colon, index = initial.partition(":")
    if colon and word in ("zero", "safe", "witness"):
        raise click.UsageError(f"--initial {shortened(initial)}: only given takes a state number")
    if word == "zero":
        return np.zeros(problem.layout.slip_size)
    if word == "given":
        return _given(problem, index)
    if word == "safe":
        lasting = not open_nodes and not moved_by_transient(problem, load_factor)
        safe = shakedown.safe_slip(problem, load_factor, open_nodes=open_nodes, transient=lasting)
        return _existing(safe.slip, "a safe slip", load_factor)
    if word == "witness":
        if problem.directions > 1:
            raise click.UsageError(
                "--initial witness: expected one tangential direction, found two (it is of a first collapse)"
            )
        return _existing(
            shakedown.lower_bound(problem).slip, "a critical slip state of the first collapse", load_factor
        )
    return _from_file(initial)


def moved_by_transient(problem: Problem, load_factor: float) -> bool:
    """Whether transient load steps move every slip that is safe in the loop."""
    if problem.q_transient is None:
        return False
    return shakedown.safe_slip(problem, load_factor, transient=True).status == "infeasible"


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


def _existing(slip: FloatArray, what: str, load_factor: float) -> FloatArray:
    if np.isnan(slip).any():
        raise click.UsageError(f"there is no such initial state: {what} does not exist at {load_factor:g}")
    return slip


def _from_file(path: str) -> FloatArray:
    if not os.path.lexists(path):
        raise click.UsageError(
            f"--initial {shortened(path)}: expected zero, given, given:K, safe, witness or an NPY file"
        )
    reads(click.get_current_context(silent=True), "--initial", path)
    try:
        return shakedown.load_initial_slip(path)
    except shakedown.ProblemError as error:
        raise click.UsageError(f"--initial {error}") from None
