"""CalculiX itself, where Debian's calculix-ccx is installed."""

import os
import subprocess

import pytest

from benchmarks import calculix_peer

needs_ccx = pytest.mark.needs(calculix_peer)


def ccx(folder, job):
    """Run a job, which must end well."""
    command, alone = [calculix_peer.PROGRAM, job], os.environ | {"OMP_NUM_THREADS": "1"}
    run = subprocess.run(command, cwd=folder, env=alone, capture_output=True, timeout=60)
    assert b"Job finished" in run.stdout, run.stdout[-2000:]
