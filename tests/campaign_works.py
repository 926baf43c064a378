"""Pieces of work that worker processes can import."""

import os
import signal
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shakedown.campaign.crew import Crew
from shakedown.campaign.journal import journal_at
from shakedown.campaign.pieces import run_campaign
from shakedown.campaign.stored_result import packed, unpacked


@dataclass(frozen=True)
class Squares:
    """The squares of ten numbers per piece, after a pause; work of some weight where that is asked for."""

    pause: float = 0.0
    weight: bytes = b""

    def __call__(self, number):
        time.sleep(self.pause)
        return packed({"square": np.arange(10 * number, 10 * number + 10) ** 2})


@dataclass(frozen=True)
class Deadly:
    """One piece ends the process that takes it; ``once``: only where no such file stands yet."""

    once: Path | None = None

    def __call__(self, number):
        if number == 2 and not (self.once and self.once.exists()):
            if self.once:
                self.once.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return bytes([number])


def mistaken(number):
    raise ValueError(f"piece {number}")


def squares(journal):
    return np.concatenate([unpacked(piece)["square"] for piece in journal.pieces()])


if __name__ == "__main__":  # a run to be killed: journal, number of pieces, workers, pause
    path, count, workers, pause = sys.argv[1], *map(float, sys.argv[2:])
    with journal_at(path, {"what": "squares"}, resume=True) as journal:
        print("begun", flush=True)
        run_campaign(Squares(pause), int(count), journal, Crew(workers=int(workers)))
        print(squares(journal).sum())
