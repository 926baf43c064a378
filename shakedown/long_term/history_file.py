"""The recorded path of a simulation as a file."""

import os

import numpy as np

from shakedown.errors import UsageError
from shakedown.files.atomic_write import atomic_write
from shakedown.long_term.simulation import Simulation


def save_history(path: str | os.PathLike[str], run: Simulation) -> None:
    """Write the recorded path of a simulation to an NPZ file, whole or not at all.

    The file has the arrays of :class:`EventHistory` or of :class:`History`, and
    ``load_factor``, ``initial_slip``.

    Raises
    ------
    UsageError
        If the simulation was not recorded, or the file cannot be written.
    """
    if not isinstance(run, Simulation):
        raise UsageError(f"run: expected a Simulation, found {type(run).__name__}")
    if run.history is None:
        raise UsageError("nothing to write: simulate with record=True")
    arrays = {key: getattr(run.history, key) for key in type(run.history).__annotations__}
    with atomic_write(path) as file:
        np.savez(file, load_factor=run.load_factor, initial_slip=run.initial_slip, **arrays)
