"""Modes with the contact stuck against those of one welded body; modal loads; structures that nothing supports."""

import json

import numpy as np
import pytest
from scipy.linalg import eigh

import shakedown
from shakedown import ProblemError, damping
from shakedown.fem import (
    ElasticBody,
    Force,
    Material,
    Pressure,
    Support,
    block_mesh,
    brick_mesh,
    contact_problem,
    modal_load,
)
from shakedown.fem.loads import mass_of

STEEL = Material(100.0, 0.3, density=2.0)
SIZE, COUNTS = (4.0, 1.0), (8, 2)


def pair(solid=False, *, supports=(), press=1.0, material=STEEL):
    """Two blocks one on the other, pressed together; and the same as one block."""
    if solid:
        counts, size = (3, 2, 1), (3.0, 1.0, 0.5)
        upper, lower = (brick_mesh(size, counts, origin=(0.0, 0.0, z)) for z in (0.5, 0.0))
        whole = brick_mesh((3.0, 1.0, 1.0), (3, 2, 2))
    else:
        upper, lower = (block_mesh(*SIZE, *COUNTS, origin=(0.0, y)) for y in (1.0, 0.0))
        whole = block_mesh(SIZE[0], 2 * SIZE[1], COUNTS[0], 2 * COUNTS[1])
    loads = [[Pressure(face, press, history=1.0)] for face in ("top", "bottom")]
    return (
        ElasticBody(upper, material, loads=loads[0], supports=supports),
        ElasticBody(lower, material, loads=loads[1], supports=supports),
        ElasticBody(whole, material, supports=supports),
    )


def frequencies(body):
    """All circular frequencies of a body, densely."""
    free = np.setdiff1d(np.arange(body.basis.N), body.held_rows())
    K, M = (matrix.toarray()[np.ix_(free, free)] for matrix in (body.stiffness, mass_of(body)))
    return np.sqrt(np.maximum(eigh(K, M, eigvals_only=True), 0))


@pytest.mark.parametrize(("solid", "held", "rigid"), [(False, False, 3), (False, True, 0), (True, False, 6)])
def test_with_its_contact_stuck_a_pair_vibrates_as_one_body(solid, held, rigid):
    """Rigid motions of a free one do not count; the mass is that of the bodies, the shape has mass one."""
    first, second, whole = pair(solid, supports=[Support("left")] if held else [])
    expected = frequencies(whole)[rigid : rigid + 3]
    found = [modal_load(first, "bottom", k, against=(second, "top")) for k in range(2)]
    np.testing.assert_allclose([load.frequency for load in found], expected[:2], rtol=1e-8)
    for load in found:
        assert load.free is not held
        assert load.shape @ load.force == pytest.approx(1.0, rel=1e-10)


def test_at_rest_a_mode_has_its_frequency_and_above_it_falls_and_damps():
    """Nothing supports the pair: what holds it while it is condensed bears nothing, and is told."""
    first, second, _ = pair()
    load = modal_load(first, "bottom", against=(second, "top"))
    joint = contact_problem(first, "bottom", 0.3, against=(second, "top"), modal=[load], steps=16)
    assert joint.load_names == ("pressure", "pressure", "mode 0")
    assert np.isnan(joint.load_frequency).tolist() == [True, True, False]
    origin = json.loads(joint.source)
    assert "for the condensation alone" in origin["free"]
    assert origin["modes"] == [{"mode": 0, "frequency": load.frequency}]
    curve = damping(joint, [0.1, 1.0, 4.0, 5.0], load="mode 0")
    np.testing.assert_allclose(curve.frequency[0], load.frequency, rtol=1e-8)
    assert curve.dissipation[0] == 0
    assert curve.proved[0]
    assert curve.frequency[-1] < 0.999 * load.frequency
    assert curve.damping_ratio[-1] > 1e-4


def test_nodes_that_the_preload_leaves_open_are_open_in_the_mode():
    first, second, _ = pair()
    stuck = modal_load(first, "bottom", against=(second, "top"))
    opened = modal_load(first, "bottom", against=(second, "top"), open_nodes=[0, 1])
    assert opened.frequency < stuck.frequency


WRONG = {
    "no density": ({"material": Material(100.0, 0.3)}, {}, "material: expected a density for a mode, found none"),
    "no such mode": ({}, {"mode": 10**6}, "mode: expected a number from 0 to"),
    "no such node": ({}, {"open_nodes": [99]}, "open nodes: expected node numbers from 0 to 8, found 99"),
}  # fmt: skip


@pytest.mark.parametrize(("bodies", "asked", "line"), WRONG.values(), ids=WRONG)
def test_what_is_no_mode_is_said(bodies, asked, line):
    first, second, _ = pair(**bodies)
    with pytest.raises(shakedown.ShakedownError, match=line):
        modal_load(first, "bottom", **({"against": (second, "top")} | asked))


def test_loads_out_of_balance_on_a_free_structure_are_named():
    first, second, _ = pair()
    pushed = ElasticBody(first.mesh, STEEL, loads=[Force(boundary="top", value=(1.0, 0.0), history=1.0)])
    with pytest.raises(
        ProblemError, match="loads: expected loads in equilibrium, as nothing supports the bodies"
    ):
        contact_problem(pushed, "bottom", 0.3, against=(second, "top"))
