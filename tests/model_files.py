"""Finite-element output that comes with the tests."""

from pathlib import Path

DATA = Path(__file__).parent / "data"
BLOCK = DATA / "calculix_9"
RING = DATA / "calculix_ring"  # axisymmetric
HEAT = DATA / "calculix_heat"  # heated, with the contact held and open
FIT = DATA / "calculix_fit"  # axisymmetric, with contact of CalculiX's own
