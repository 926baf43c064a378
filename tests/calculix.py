"""CalculiX itself, where Debian's calculix-ccx is installed."""

import os
import shutil
import subprocess

import pytest

CCX = shutil.which("ccx")
needs_ccx = pytest.mark.skipif(CCX is None, reason="ccx (Debian: calculix-ccx) is not installed")


def ccx(folder, job):
    """Run a job, which must end well."""
    run = subprocess.run(
        [CCX, job], cwd=folder, env=os.environ | {"OMP_NUM_THREADS": "1"}, capture_output=True, timeout=60
    )
    assert b"Job finished" in run.stdout, run.stdout[-2000:]
