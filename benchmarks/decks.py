"""Read every deck of a folder as an import does: ``python -m benchmarks.decks FOLDER``.

Prints which decks are refused, and why, and which end in an error of the program; if one does, the exit code
is 1. Decks are files ``*.inp`` anywhere below the folder.
"""

import sys
from collections import Counter
from pathlib import Path

from shakedown import ProblemError
from shakedown.models.readers.deck import read_deck


def outcome(path: Path) -> tuple[str, str]:
    """Whether a deck is read, refused or crashes the reader, and why."""
    try:
        read_deck(path)
    except ProblemError as error:
        return "refused", str(error)
    except Exception as error:
        return "crashed", f"{path}: {type(error).__name__}: {error}"
    return "read", ""


def main(words: list[str]) -> int:
    """Print the outcome of all decks of a folder."""
    if len(words) != 1 or not Path(words[0]).is_dir():
        print("usage: python -m benchmarks.decks FOLDER", file=sys.stderr)
        return 2
    found = Counter[str]()
    for path in sorted(Path(words[0]).rglob("*.inp")):
        what, why = outcome(path)
        found[what] += 1
        if why:
            print(f"{what}: {why}")
    print(", ".join(f"{found[what]} {what}" for what in ("read", "refused", "crashed")))
    return int(found["crashed"] > 0)


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
