"""No kernel is compiled by two processes at once: the second one finds the code in numba's cache on disk."""

import threading
from contextlib import contextmanager
from zlib import crc32

from numba.core.dispatcher import Dispatcher

try:
    import fcntl
except ModuleNotFoundError:  # Windows: that processes compile the same at once only takes longer
    fcntl = None

COMPILE = Dispatcher.compile


@contextmanager
def one_compiler_at_a_time(path):
    """While it lasts, this process compiles a kernel, or reads its code, while it holds that kernel's byte of ``path``.

    Only the kernel that is called waits, not those that it calls in turn: so no two processes wait for each other.
    """
    turn, depth = threading.RLock(), 0

    def compiled(dispatcher, signature):
        nonlocal depth
        place = crc32(f"{dispatcher.py_func.__module__}.{dispatcher.py_func.__qualname__}".encode())
        with turn:
            if not depth and fcntl:
                fcntl.lockf(file, fcntl.LOCK_EX, 1, place)
            depth += 1
            try:
                return COMPILE(dispatcher, signature)
            finally:
                depth -= 1
                if not depth and fcntl:
                    fcntl.lockf(file, fcntl.LOCK_UN, 1, place)

    with open(path, "w") as file:
        Dispatcher.compile = compiled
        try:
            yield
        finally:
            Dispatcher.compile = COMPILE
