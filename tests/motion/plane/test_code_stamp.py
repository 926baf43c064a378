"""Code on disk is used while no module that it was compiled from has changed, and only then."""

import errno
import importlib
import os
import sys

import numba
import pytest
from numba.core.caching import IndexDataCacheFile

from shakedown.ground import code_cache

MODULES = {
    "__init__": "",
    "sizes": "SIZE = 2.0\n",
    "below": "from linked_modules.sizes import SIZE\n"
    "from shakedown.ground.named_state import inner\n\n\n"
    "@inner\ndef scaled(x):\n    return SIZE * x\n",
    "above": "from shakedown.ground.named_state import entered\n\n"
    "from .below import (\n    scaled,\n)\n\n\n"
    "@entered\ndef called(x):\n    return scaled(x) + 1.0\n",
    "beside": "SIZE = 1.0\n",
}


@pytest.fixture
def package(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    folder = tmp_path / "linked_modules"
    folder.mkdir()
    for module, source in MODULES.items():
        (folder / f"{module}.py").write_text(source)
    yield folder
    forget()


def forget():
    for name in [name for name in sys.modules if name.split(".")[0] == "linked_modules"]:
        del sys.modules[name]
    importlib.invalidate_caches()


def run_anew():
    """What the kernel gives in a package imported anew, and whether its code was found on disk."""
    forget()
    called = importlib.import_module("linked_modules.above").called
    return called(3.0), sum(called.stats.cache_hits.values()) == 1


def change(module, was, now):
    module.write_text(module.read_text().replace(was, now))


def test_a_change_in_any_module_below_compiles_anew(package):
    assert run_anew() == (7.0, False)
    assert run_anew() == (7.0, True)
    change(package / "below.py", "SIZE * x", "SIZE * x * 10.0")
    assert run_anew() == (61.0, False)
    change(package / "sizes.py", "2.0", "20.00")
    assert run_anew() == (601.0, False)
    change(package / "beside.py", "1.0", "10.00")
    assert run_anew() == (601.0, True)
    kept = [path.suffix for path in package.joinpath("__pycache__").iterdir()]
    assert (kept.count(".nbi"), kept.count(".nbc")) == (1, 1)


def test_code_for_types_of_another_version_compiles_anew(package):
    """As after an upgrade in place: what is on disk names a class that is gone."""
    (package / "above.py").write_text(
        "from typing import NamedTuple\n\nfrom shakedown.ground.named_state import entered\n\n\n"
        "class Pair(NamedTuple):\n    x: float\n\n\n@entered\ndef called(x):\n    return summed(Pair(x))\n\n\n"
        "@entered\ndef summed(pair):\n    return pair.x + 1.0\n"
    )
    run_anew()
    summed = importlib.import_module("linked_modules.above").summed
    assert summed(importlib.import_module("linked_modules.above").Pair(3.0)) == 4.0
    change(package / "above.py", "Pair", "Couple")
    forget()
    above = importlib.import_module("linked_modules.above")
    assert above.summed(above.Couple(3.0)) == 4.0


def test_without_a_stamp_nothing_is_taken_from_disk(package, monkeypatch):
    monkeypatch.setattr(code_cache, "stamp", lambda module: None)
    assert run_anew() == (7.0, False)
    assert run_anew() == (7.0, False)


def test_where_the_disk_is_full_compiled_code_is_used_and_the_log_says_so_once(package, monkeypatch, caplog):
    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    code_cache._say_that_nothing_is_kept.cache_clear()
    with monkeypatch.context() as patched:
        patched.setattr(IndexDataCacheFile, "save", full)
        assert [run_anew(), run_anew()] == [(7.0, False)] * 2
    (said,) = caplog.messages
    assert said.startswith("compiled code cannot be kept (No space left on device): it is compiled anew")
    assert [run_anew(), run_anew()] == [(7.0, False), (7.0, True)]  # with room again


def test_a_kernel_stands_on_the_modules_whose_code_is_linked_into_it():
    importlib.import_module("shakedown.long_term.plane.phase_loop")
    below = code_cache.modules_below("shakedown.long_term.plane.phase_loop")
    loops = ("active_set", "moving_state", "rate_problem", "run")
    below_them = ("status", "named_state")
    assert {f"shakedown.motion.plane.{module}" for module in loops} <= set(below)
    assert {f"shakedown.ground.{module}" for module in below_them} <= set(below)
    assert "shakedown.motion.plane.gauss_seidel" not in below
