"""Odd words on the command line: an answer, a status or one line."""

import os

import numpy as np
from hostile.campaign import judge, numbers

import shakedown

FEW = 30
COMMANDS = ["solve", "critical", "simulate", "simulate", "example", "import", "verify"]
OPTIONS = {
    "solve": ["--json", "-q", "--details", "--open", "--initial", "--distance", "--require"],
    "critical": ["--json", "-q", "--all", "--budget"],
    "simulate": ["--json", "-q", "--load-factor", "--initial", "--cycles", "--method", "-o"],
    "example": ["--json", "-q", "-o"],
    "import": ["--json", "-q", "-o"],
    "verify": ["--json", "-q", "-o", "--load-factor", "--random", "--seed", "--cycles", "--method"],
}
WITH_VALUE = {
    "--budget", "--load-factor", "--initial", "--cycles", "--method", "-o", "--random", "--seed", "--open",
    "--distance", "--require",
}  # fmt: skip
FILES = [
    "p.npz", "v.npy", "one-node", "uncoupled", "s.npz", "text", "", ".", "-", "none.npz", "nobody", "pipe", "link", "c.toml",
]  # fmt: skip
ENDLESS = ("pipe", "link")  # left out where a reader of another subpackage opens the file
VALUES = [
    "0", "1", "0.5", "-1", "1e300", "1e308", "1e400", "-0", "nan", "inf", "-inf", "5e-324", "0x10", "1_000", "٣", "²",
    "9" * 400, "zero", "safe", "witness", "given", "given:0", "given:1", "given:" + "9" * 5000, "given:-1", "zero:0",
    "v.npy", "w.npy", "p.npz", "text", "pipe", "link", "/dev/zero", "out", "new/out", ".", "", "event", "gauss-seidel",
    "EVENT", "\x1b[2J", "a\nb", "\ud800", "\udce9", "x" * 300, "x" * 70_000, "--", "--json", "-o", "%s", "{}", "$(id)", "18446744073709551616",
]  # fmt: skip


def odd_words(rng: np.random.Generator) -> list[str]:
    """A command with some of its options, most of them with a value, some words damaged."""
    command = COMMANDS[rng.integers(len(COMMANDS))]
    if command == "verify" and rng.random() < 0.8:  # whole seconds each
        command = "simulate"
    files = [name for name in FILES if command != "import" or name not in ENDLESS]
    words = [command, files[rng.integers(len(files))]] if rng.random() < 0.95 else [command]
    if command == "simulate" and rng.random() < 0.7:
        words += ["--load-factor", "0.5"]
    for _ in range(rng.integers(0, 4)):
        option = OPTIONS[command][rng.integers(len(OPTIONS[command]))]
        words.append(option)
        if option in WITH_VALUE and rng.random() < 0.95:
            words.append(VALUES[rng.integers(len(VALUES))])
    if rng.random() < 0.15:
        at = int(rng.integers(len(words)))
        words[at] = VALUES[rng.integers(len(VALUES))]
    # a cheap run is as good as a dear one; the command takes the last value
    cheap = {
        "simulate": ["--cycles", "2"],
        "verify": ["--cycles", "2", "--random", "0"],
        "critical": ["--budget", "50000"],
    }
    return words + (cheap.get(command, []) if rng.random() < 0.9 else [])


def furnish(folder) -> None:
    """The files that the words may name."""
    shakedown.save_problem(folder / "p.npz", shakedown.example("three-node"))
    shakedown.save_problem(folder / "s.npz", shakedown.example("two-node-3d"))
    np.save(folder / "v.npy", np.zeros(1))
    np.save(folder / "w.npy", np.full(3, 1e200))
    (folder / "text").write_text("\x1b[31mnothing\n")
    (folder / "c.toml").write_text("[stiffness]\nfile = 'none'\n")
    os.mkfifo(folder / "pipe")
    (folder / "link").symlink_to("/dev/zero")


def test_odd_words(tmp_path):
    furnish(tmp_path)
    codes = [
        judge(number, odd_words(np.random.default_rng([4, number])), str(tmp_path)) for number in numbers(FEW)
    ]
    assert {0, 2} <= set(codes)
    assert (tmp_path / "pipe").is_fifo()
    assert (tmp_path / "link").is_symlink()
