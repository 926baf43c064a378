"""What is asked of every joint when two checkouts are compared: the commands with their words, by turns."""

from dataclasses import dataclass

import numpy as np

from shakedown import Problem

COMMANDS = ("solve", "verify", "simulate", "map", "sweep", "critical")
MOST_SUBSETS = "20000"  # `critical` says that there are more, beyond
LOAD_FACTORS = ("0.3", "0.7", "0.95", "1.2", "2")
STARTS = ("zero", "safe", "witness")
SAMPLERS = ("sobol", "latin", "ball", "transients")
VARIED = (
    "friction=0.7:1.3:3",
    "amplitude=0.5:1.5:3",
    "mean=0.8:1.2:3",
    "phase=0:0.5:3",
    "stiffness=0.5,1,3",
    "coupling=0,0.5,1.5",
)
OF_ONE_COEFFICIENT = "f=0.1,0.4,1.5"  # refused where the nodes have different ones


@dataclass(frozen=True)
class Run:
    """One call of the command: what it is about, and its words."""

    command: str
    joint: str
    words: tuple[str, ...]

    @property
    def key(self) -> str:
        return " ".join(self.words)


def runs_of(joint: str, file: str, problem: Problem, number: int) -> list[Run]:
    """All that is asked of a joint; its number says which load factors, starts, samplers, parameters, …"""
    asked = {
        "solve": _solve(problem, number),
        "verify": _verify(number),
        "simulate": _simulate(number),
        "map": _map(problem, number),
        "sweep": [_sweep(problem, number)],
        "critical": [["--budget", MOST_SUBSETS, *["--all"] * (problem.n <= 4)]],
    }
    return [
        Run(command, joint, (command, file, *words, "--json", "-q"))
        for command, calls in asked.items()
        for words in calls
    ]


def _by_turns(choices: tuple[str, ...], number: int) -> str:
    return choices[number % len(choices)]


def _solve(problem: Problem, number: int) -> list[list[str]]:
    other = ["--initial", "given"] if problem.initial_slip is not None else ["--quick", "--distance", "0.1"]
    return [[], ["--open", "none"] if number % 3 == 0 else other]


def _verify(number: int) -> list[list[str]]:
    exact = ["--random", "1", "--cycles", "200"] if number % 4 else []
    steps = ["--random", "0", "--cycles", "20", "--load-factor", "0.8", "--method", "gauss-seidel"]
    return [exact, steps] if number % 4 == 1 else [exact]


def _simulate(number: int) -> list[list[str]]:
    default = ["--load-factor", _by_turns(LOAD_FACTORS, number), "--cycles", "200", "-o", "history.npz"]
    other = ["--load-factor", _by_turns(LOAD_FACTORS, number + 2), "--initial", _by_turns(STARTS, number)]
    if number % 3 == 0:
        other += ["--open", "auto"]
    if number % 4 == 1:
        other += ["--method", "gauss-seidel", "--cycles", "20"]
    return [default, other]


def _map(problem: Problem, number: int) -> list[list[str]]:
    chosen = ["--sampler", _by_turns(SAMPLERS, number)]
    if problem.n > 1 and number % 5 == 0:
        chosen = ["--grid", "0", "1"]
    load_factor = "0.5:1.5:2" if number % 3 == 0 else _by_turns(LOAD_FACTORS, number + 1)
    if "ball" in chosen:
        load_factor = "0.1"  # where there is one
    few = ["--states", "16", "--cycles", "200", "--workers", "1"]
    return [["--load-factor", load_factor, *few, *chosen, "-o", "map.npz"]]


def _sweep(problem: Problem, number: int) -> list[str]:
    varied = VARIED if np.ptp(problem.f) > 0 else (*VARIED, OF_ONE_COEFFICIENT)
    return ["--vary", _by_turns(varied, number), "--quick", "--load-factor", "1", "-o", "sweep.csv"]
