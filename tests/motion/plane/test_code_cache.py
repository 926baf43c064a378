"""Code on disk is used while no module of the package has changed, and only then."""

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
    code_cache.place_of.cache_clear()
    importlib.invalidate_caches()


def run_anew():
    """What the kernel gives in a package imported anew, and whether its code was found on disk."""
    forget()
    called = importlib.import_module("linked_modules.above").called
    return called(3.0), sum(called.stats.cache_hits.values()) == 1


def change(module, was, now):
    module.write_text(module.read_text().replace(was, now))


def folders(package):
    return [path for path in package.joinpath("__pycache__").iterdir() if path.is_dir()]


def test_a_change_in_any_module_compiles_anew(package):
    assert run_anew() == (7.0, False)
    assert run_anew() == (7.0, True)
    (first,) = folders(package)
    change(package / "below.py", "SIZE * x", "SIZE * x * 10.0")
    assert run_anew() == (61.0, False)
    change(package / "sizes.py", "2.0", "20.00")
    assert run_anew() == (601.0, False)
    assert run_anew() == (601.0, True)
    (last,) = folders(package)  # code of other sources is removed
    assert last != first
    assert sorted(path.suffix for path in last.rglob("*.nb?")) == [".nbc", ".nbi"]


def test_a_folder_of_the_user_keeps_code_of_several_versions(package, tmp_path, monkeypatch):
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "kept"))
    assert run_anew() == (7.0, False)
    change(package / "sizes.py", "2.0", "20.00")
    assert run_anew() == (61.0, False)
    change(package / "sizes.py", "20.00", "2.0")
    assert run_anew() == (7.0, True)
    assert len(list((tmp_path / "kept" / "linked_modules").iterdir())) == 2
    assert not package.joinpath("__pycache__").exists() or not folders(package)


def test_without_a_place_code_is_compiled_and_the_log_says_so(package, monkeypatch, caplog):
    monkeypatch.setattr(code_cache, "_can_be_written", lambda folder: False)
    assert [run_anew(), run_anew()] == [(7.0, False)] * 2
    assert caplog.messages[0].startswith("no place for compiled code: it is compiled anew in every run")


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
