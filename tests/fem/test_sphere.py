"""A sphere on a flat against Cattaneo, Mindlin and Deresiewicz, and rolled, against Wetter and Popov."""

import numpy as np
import pytest
from rolling_sphere import rolling_limit, rolling_sphere

import shakedown
from benchmarks.bodies.sphere import (
    disc_patches,
    sphere_contact,
    sphere_on_flat,
)
from shakedown.motion.evolution import evolve

F = 0.5


def area(polygon):
    x, y = polygon.T
    return 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))


def test_the_patches_are_those_of_the_disc():
    patches, edges = disc_patches(3)
    assert len(patches) == 37
    areas = np.array([area(patch) for patch in patches])
    counts = np.array([1, 6, 12, 18])
    assert areas == pytest.approx(np.repeat(np.pi * np.diff(edges**2) / counts, counts), rel=1e-12)


def test_the_classical_solution_is_one():
    contact, force = sphere_contact(F, poisson=0.3), 0.8 * F
    edges = np.linspace(0, 1, 2001)
    assert contact.held_back(edges, force).sum() == pytest.approx(force)
    middle = (edges[1:] + edges[:-1]) / 2
    assert (contact.pressure(middle) * np.diff(np.pi * edges**2)).sum() == pytest.approx(1, rel=1e-5)
    forces = np.linspace(0, force, 4001)
    pushed = np.array([contact.displacement(each) for each in forces])
    lens = (
        8 * np.trapezoid(forces, pushed) - 4 * force * pushed[-1]
    )  # Masing: the loop is the first push, doubled
    assert contact.dissipation(force) == pytest.approx(lens, rel=1e-5)


def test_cycles_are_mindlins_in_every_direction():
    contact, works = sphere_contact(F), []
    for direction in (0.0, 0.4):
        run = evolve(sphere_on_flat(4, shear=0.6, direction=direction, f=F), 1.0, cycles=2)
        works.append(run.cycles[1].friction_dissipation)
    assert works[1:] == pytest.approx(works[:1], rel=1e-10)
    most = contact.dissipation(F)  # errors are a share of that times the square of a ring's width
    assert works[0] == pytest.approx(contact.dissipation(0.6 * F), abs=most / 4.5**2)
    crest = int(np.argmin(np.abs(run.history.cycle - 0.25)))
    held = np.hypot(*run.history.q[crest].reshape(-1, 2).T)
    _, edges = disc_patches(4)
    rings = np.add.reduceat(held, np.cumsum([0, 1, 6, 12, 18]))
    assert np.abs(rings - contact.held_back(edges, 0.6 * F)).sum() < 0.05 * 0.6 * F


def test_the_rolled_sphere_is_held_below_the_limit_and_creeps_above_it():
    limit = rolling_limit(0.3)
    below, above = (
        shakedown.simulate(
            rolling_sphere(0.4, amplitude=0.3, shear=share * limit, direction=0.4, f=F),
            1.0, cycles=60,
        )
        for share in (0.9, 1.2)
    )  # fmt: skip
    assert below.outcome == "separation"  # squares open and close; none slips
    assert above.outcome == "ratchetting"
    crept = above.drift.reshape(-1, 2)
    assert crept == pytest.approx(np.tile(crept[0], (len(crept), 1)), abs=1e-6)  # as one body
    assert np.arctan2(*crept[0][::-1]) == pytest.approx(0.4, abs=0.05)
