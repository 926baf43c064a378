"""Elastic bodies that several tests use."""

import numpy as np

from shakedown.fem import Displacement, ElasticBody, Material, Support, block_mesh, contact_problem

STEEL = Material(200e3, 0.3)


def pair(n, *, upper=STEEL, lower=STEEL, lower_rows=2, f=0.3, order=1):
    """Two blocks on each other, the upper one pressed and sheared through its top."""
    loads = [
        Displacement(boundary="top", x=0.0, y=-1e-3, history=1.0),
        Displacement(boundary="top", x=2e-4, y=0.0, history=lambda t: np.sin(2 * np.pi * t)),
    ]
    above = ElasticBody(block_mesh(2.0, 1.0, 2 * n, n), upper, loads=loads, order=order)
    mesh = block_mesh(2.0, 1.0, 2 * n, lower_rows, origin=(0.0, -1.0))
    below = ElasticBody(mesh, lower, supports=[Support("bottom")], order=order)
    return contact_problem(above, "bottom", f, against=(below, "top"), steps=12)
