"""Pieces of work that worker processes can import."""

import os
import signal
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shakedown.files.pieces import run_pieces


@dataclass(frozen=True)
class Squares:
    """The squares of ten numbers per piece, after a pause; work of some weight where that is asked for."""

    pause: float = 0.0
    weight: bytes = b""

    def __call__(self, number):
        time.sleep(self.pause)
        return {"square": np.arange(10 * number, 10 * number + 10) ** 2}


@dataclass(frozen=True)
class Deadly(Squares):
    """One piece ends the process that takes it, where asked once a piece of an output is kept."""

    output: str = ""

    def __call__(self, number):
        if number == 2:
            while self.output and not done(self.output):
                time.sleep(0.01)
            os.kill(os.getpid(), signal.SIGKILL)
        return super().__call__(number)


@dataclass(frozen=True)
class Mistaken(Squares):
    """Work with an error in it."""

    def __call__(self, number):
        raise ValueError(f"piece {number}")


def squares(pieces):
    return np.concatenate([piece["square"] for piece in pieces])


def done(path):
    """The numbers of the pieces kept beside an output."""
    return sorted(int(name.stem.partition("-")[2]) for name in Path(f"{path}.parts").glob("*.npz"))


if __name__ == "__main__":  # a run to be killed: output, number of pieces, workers, pause
    path, count, workers, pause = sys.argv[1], *map(float, sys.argv[2:])
    print("begun", flush=True)
    with run_pieces(Squares(pause), int(count), output=path, resume=True, workers=int(workers)) as pieces:
        print(squares(pieces).sum())
