"""What is asked of every joint when two checkouts are compared: the commands with their words, by turns."""

from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from shakedown import Problem
from shakedown.models.importing.templates import import_template_names, write_import_example

OF_JOINTS = ("solve", "verify", "simulate", "map", "sweep", "critical", "nodes")
COMMANDS = (*OF_JOINTS, "import")
MOST_SUBSETS = "20000"  # `critical` says that there are more, beyond
LOAD_FACTORS = ("0.3", "0.7", "0.95", "1.2", "2")
STARTS = ("zero", "safe", "witness")
SAMPLERS = ("sobol", "ball", "transients")
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
        "nodes": _nodes(problem, number),
    }
    said = _by_turns(OF_JOINTS, number)  # in sentences and tables, too
    return [
        *(
            Run(command, joint, (command, file, *words, "--json", "-q"))
            for command, calls in asked.items()
            for words in calls
        ),
        Run(said, joint, (said, file, *asked[said][0], "-q")),
    ]


def imports(decks: Path) -> tuple[list[Run], dict[str, bytes]]:
    """What is asked of `import`: templates, the example, the decks in a folder; and their files."""
    runs = [Run("import", kind, ("import", "--template", kind)) for kind in import_template_names()]
    runs.append(Run("import", "example", ("import", "--template", "example", "-o", "written", "-q")))
    with TemporaryDirectory() as folder:
        example = write_import_example(folder)
        files = {f"example/{path.name}": path.read_bytes() for path in example}
    found = sorted(path for path in decks.rglob("*") if path.is_file())
    files |= {path.relative_to(decks).as_posix(): path.read_bytes() for path in found}
    for name in sorted(name for name in files if name.endswith("/import.toml")):
        joint = name.split("/")[0]
        shown, written = ("--check", "--picture", f"{joint}.svg"), ("-o", f"{joint}.npz")
        calls = (*shown, "--json", "-q"), (*shown, "-q"), (*written, "--json", "-q"), (*written, "-q")
        runs += [Run("import", joint, ("import", name, *words)) for words in calls]
    return runs, files


def _by_turns(choices: tuple[str, ...], number: int) -> str:
    return choices[number % len(choices)]


def _solve(problem: Problem, number: int) -> list[list[str]]:
    other = ["--initial", "given"] if problem.initial_slip is not None else ["--distance", "0.1"]
    return [[], ["--open", "none"] if number % 3 == 0 else other]


def _verify(number: int) -> list[list[str]]:
    exact = ["--random", "1", "--cycles", "200"] if number % 4 else []
    if number % 4 == 3:
        exact += ["-o", "report.html"]
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
    drawn = ["--picture", "map.svg"] if number % 4 == 2 else []
    return [["--load-factor", load_factor, *few, *chosen, "-o", "map.npz", *drawn]]


def _sweep(problem: Problem, number: int) -> list[str]:
    varied = VARIED if np.ptp(problem.f) > 0 else (*VARIED, OF_ONE_COEFFICIENT)
    return ["--vary", _by_turns(varied, number), "--quick", "--load-factor", "1", "-o", "sweep.csv"]


def _nodes(problem: Problem, number: int) -> list[list[str]]:
    wear = ["--wear-coefficient", "1e-8"] if number % 2 and problem.node_area is not None else []
    return [
        ["--load-factor", _by_turns(LOAD_FACTORS, number + 3), "--cycles", "200", *wear, "-o", "nodes.csv"]
    ]
