"""The command of one checkout, run again and again in one process: a line of JSON in, a line of JSON out.

Started as a file by that checkout's interpreter (``python -P``), so it knows nothing of this one's package.
"""

import hashlib
import io
import json
import os
import runpy
import sys
import time
import warnings
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from unittest.mock import patch

import numpy as np

SHOWN = 200  # entries of an array that an answer holds beside its checksum


def answer(words: list[str]) -> dict:
    """What the command answers: exit code, stdout (read as JSON), stderr, the files that it leaves here."""
    before, out, err = set(Path().iterdir()), io.StringIO(), io.StringIO()
    began = time.perf_counter()
    with redirect_stdout(out), redirect_stderr(err), patch.object(sys, "argv", ["shakedown-bounds", *words]):
        try:
            runpy.run_module("shakedown", run_name="__main__")
            code = None
        except SystemExit as stop:
            code = stop.code
        except Exception as error:
            code = f"{type(error).__name__}: {error}"
    seconds = time.perf_counter() - began
    files = {path.name: contents(path) for path in sorted(set(Path().iterdir()) - before)}
    said = {"code": code, "out": parsed(out.getvalue()), "err": err.getvalue()}
    return said | {"files": files, "seconds": seconds}


def parsed(text: str) -> object:
    try:
        return json.loads(text)
    except ValueError:
        return text


def contents(path: Path) -> object:
    """What a file holds: arrays by their bits, a table by its cells. The file is gone afterwards."""
    found: object = "a file"
    if path.suffix == ".npz":
        with np.load(path, allow_pickle=False) as archive:
            found = {key: array(archive[key]) for key in archive.files}
    elif path.suffix == ".csv":
        found = [line.split(",") for line in path.read_text().splitlines()]
    path.unlink()
    return found


def array(values: np.ndarray) -> object:
    if values.dtype.kind == "U":
        return parsed(str(values)) if values.ndim == 0 else values.tolist()
    bits = hashlib.sha256(np.ascontiguousarray(values).tobytes()).hexdigest()
    few = values.ravel().tolist() if values.size <= SHOWN else None
    return {"values": few, "dtype": values.dtype.str, "shape": list(values.shape), "sha256": bits}


def main() -> None:
    import shakedown

    warnings.simplefilter("ignore")  # shown once per process, so no answer to one command
    with os.fdopen(os.dup(1), "w") as answers:
        os.dup2(2, 1)  # what a solver prints itself is no answer
        print(json.dumps({"package": shakedown.__file__}), file=answers, flush=True)
        for line in sys.stdin:
            print(json.dumps(answer(**json.loads(line))), file=answers, flush=True)


if __name__ == "__main__":
    main()
