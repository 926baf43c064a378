"""One process compiles at a time: the next one finds the code in numba's cache on disk."""

import threading
from contextlib import contextmanager

from numba.core.dispatcher import Dispatcher

try:
    import fcntl
except (
    ModuleNotFoundError
):  # Windows: processes may compile the same at the same time, which only takes longer
    fcntl = None

COMPILE = Dispatcher.compile


@contextmanager
def one_compiler_at_a_time(path):
    """While it lasts, this process compiles, or reads compiled code, only while it holds the lock ``path``."""
    turn, depth = threading.RLock(), 0

    def compiled(dispatcher, signature):
        nonlocal depth
        with turn:
            if not depth and fcntl:
                fcntl.flock(file, fcntl.LOCK_EX)
            depth += 1
            try:
                return COMPILE(dispatcher, signature)
            finally:
                depth -= 1
                if not depth and fcntl:
                    fcntl.flock(file, fcntl.LOCK_UN)

    with open(path, "w") as file:
        Dispatcher.compile = compiled
        try:
            yield
        finally:
            Dispatcher.compile = COMPILE
