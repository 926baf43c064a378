"""The whole suite is shared among the cores, file by file; no kernel is compiled in two processes at once."""

import gc
import os
import signal
import sys
import threading
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path
from zlib import crc32

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before NumPy: more threads wait for each other

import pytest
from markupsafe import Markup

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # by a shell that starts the tests in the background:
    signal.signal(signal.SIGINT, signal.default_int_handler)  # commands that are interrupted would never end
gc.set_threshold(50_000, 20, 20)  # as the command line does: at 700 the search for garbage takes its share

POSIX = (  # pipes, signals, devices, limits of a process
    "benchmarks",
    "files/test_cluster.py",
    "files/test_pieces_and_files.py",
    "cli/test_border.py",
    "hostile/test_odd_words.py",
    "hostile/test_readers_fuzz.py",
)
collect_ignore = [] if os.name == "posix" else list(POSIX)

HERE = Path(__file__).parent
FIRST = (  # what compiles the most, each worker other kernels; then what needs those of the first file at most
    "tests/assessment/test_assess.py",
    "tests/motion/space/test_directed_motion.py",
    "tests/bounds/test_critical.py",
    "tests/bounds/energy/",
    "tests/bounds/every_state/",
    "tests/programs/",
)
LIBRARIES = ("matplotlib.pyplot", "pandas", "numba")  # of many modules: a second or two each at first
MOST_WORKERS = 8  # each reads all tests before it runs its share


def pytest_addoption(parser):
    parser.addoption("--whole-site", action="store_true", help="also code blocks of the site that take long")


@pytest.hookimpl(tryfirst=True)
def pytest_cmdline_main(config):
    """All tests run on all cores; what is named on the command line, in this process unless ``-n`` is given."""
    if hasattr(config, "workerinput") or not config.pluginmanager.hasplugin("xdist"):
        return
    everything = config.args_source is config.ArgsSource.TESTPATHS
    if config.option.numprocesses is None and everything and not config.option.collectonly:
        config.option.numprocesses = "logical"
        config.option.maxprocesses = config.option.maxprocesses or MOST_WORKERS
    if config.option.numprocesses and config.option.dist == "no":
        config.option.dist = "loadfile"  # fixtures of a module are made once
        config.option.loadscopereorder = False
        sys.dont_write_bytecode = False  # some fifty processes read the sources: once is enough
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)


@pytest.hookimpl(tryfirst=True)
def pytest_collection(session):
    """Only processes that run tests read numba and hypothesis."""
    if getattr(session.config.option, "numprocesses", None):
        return
    from hypothesis import settings

    settings.register_profile("shakedown", deadline=None, derandomize=True, max_examples=25)
    settings.load_profile("shakedown")
    if hasattr(session.config, "workerinput") and not sys.dont_write_bytecode:
        _read_a_share(session.config)


def _read_a_share(config):
    """A worker imports its share of libraries and tests before it reads all: what is made of them is kept on disk."""
    number, count = int(config.workerinput["workerid"].removeprefix("gw")), config.workerinput["workercount"]
    asked = [HERE.parent / word.split("::")[0] for word in config.args]
    files = [path for path in sorted(HERE.rglob("test_*.py")) if any(map(path.is_relative_to, asked))]
    tests = [".".join(path.relative_to(HERE.parent).with_suffix("").parts) for path in files]
    for module in (*LIBRARIES[number::count], *tests[number::count]):
        with suppress(Exception, pytest.skip.Exception):  # said where the file is collected
            import_module(module)


def pytest_configure(config):
    config.addinivalue_line("markers", "needs(peer): left out where a program beside Python is not at hand")
    config.addinivalue_line(
        "markers", "slow: studies, pages, killed processes; run by -m slow, as in .ci/run"
    )


def pytest_runtest_setup(item):
    for mark in item.iter_markers("needs"):
        (peer,) = mark.args
        if not peer.is_here():
            pytest.skip(peer.ABSENT)


def pytest_collection_modifyitems(items):
    """No worker waits long for a kernel that another one compiles."""
    items.sort(
        key=lambda item: next((i for i, at in enumerate(FIRST) if item.nodeid.startswith(at)), len(FIRST))
    )


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish():
    """What was never closed is looked for once among all objects: pytest does so five times at its end."""
    gc.collect()
    gc.freeze()


@contextmanager
def one_compiler_at_a_time(path):
    """While it lasts, this process compiles a kernel, or reads its code, while it holds that kernel's byte of ``path``.

    Only the kernel that is called waits, not those that it calls in turn: so no two processes wait for each other.
    """
    from numba.core.dispatcher import Dispatcher

    try:
        import fcntl
    except ModuleNotFoundError:  # Windows: that processes compile the same at once only takes longer
        fcntl = None
    compile_alone, turn, depth = Dispatcher.compile, threading.RLock(), 0

    def compiled(dispatcher, signature):
        nonlocal depth
        place = crc32(f"{dispatcher.py_func.__module__}.{dispatcher.py_func.__qualname__}".encode())
        with turn:
            if not depth and fcntl:
                fcntl.lockf(file, fcntl.LOCK_EX, 1, place)
            depth += 1
            try:
                return compile_alone(dispatcher, signature)
            finally:
                depth -= 1
                if not depth and fcntl:
                    fcntl.lockf(file, fcntl.LOCK_UN, 1, place)

    with open(path, "w") as file:
        Dispatcher.compile = compiled
        try:
            yield
        finally:
            Dispatcher.compile = compile_alone


@pytest.fixture(scope="session", autouse=True)
def _compiled_once(request, tmp_path_factory):
    """Workers wait for each other's compiled code and read it, instead of compiling the same at the same time."""
    if not hasattr(request.config, "workerinput"):
        yield
        return
    with one_compiler_at_a_time(tmp_path_factory.getbasetemp().parent / "compiler.lock"):
        yield


@pytest.fixture
def undrawn(monkeypatch):
    """Pictures of pages are prepared but not drawn, which takes most of the time: for tests of a page's words."""
    monkeypatch.setattr("shakedown.plot.inline_svg.inline", lambda figure, alt: Markup("<svg></svg>"))


@pytest.fixture
def no_transient_limit(monkeypatch):
    """λ_T, half a second and more in space, is not sought: for tests of a verification that do not ask for it."""
    monkeypatch.setattr("shakedown.assessment.transient_limit.of_joint", lambda _: None)
