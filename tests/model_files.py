"""Finite-element output that comes with the tests."""

from pathlib import Path

BLOCK = Path(__file__).parent / "data" / "calculix_9"
