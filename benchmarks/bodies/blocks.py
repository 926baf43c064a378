"""The blocks of the thesis (chapters III and V), with mesh refinement as a parameter."""

from dataclasses import replace

import numpy as np

from benchmarks.bodies.bearing_ring import bearing_ring
from benchmarks.bodies.blade_root import blade_root
from benchmarks.bodies.bolted_flange import bolted_flange
from benchmarks.bodies.classical import cylinder_on_flat, press_fit
from shakedown import Problem, example
from shakedown.fem import ElasticBody, Material, Pressure, Support, block_mesh, contact_problem


def receding_block(
    # elements per quarter of the height; the contact has 16 · refinement + 1 nodes (8 · refinement + 1 with
    # symmetry)
    refinement: int = 2,
    *,
    symmetric: bool = False,  # take the right half only; the node on the plane of symmetry does not slip
    unloading: float = 1 / 3,  # lowest pressure of a cycle, relative to p_max [–]
    steps: int = 2,  # load steps of one cycle, an even number; straight lines between
    first_loading: int = 1,  # load steps from no load to p_max
) -> Problem:
    """The receding contact of thesis chapter III: a block h × 4h on a rigid plane, f = 0.35, ν = 0.3.

    A pressure on the central strip 2h of the top rises to p_max (transient load
    steps), then cycles between p_max and ``unloading`` · p_max. Nothing but the
    contact holds the block. Lengths are in h, pressures in p_max, and Young's
    modulus is 1, so slips are in p_max h/E: the response of such a contact is
    proportional to the load, and no other value would change anything.

    The thesis does not state its mesh; here elements are squares of side
    h/(4 · refinement), bilinear, in plane strain.

    Examples
    --------
    >>> block = receding_block(1)
    >>> block.n, block.m, block.q_transient.shape
    (17, 2, (2, 17))
    """
    half = 2.0
    width, left = (half, 0.0) if symmetric else (2 * half, -half)
    mesh = block_mesh(width, 1.0, round(4 * width) * refinement, 4 * refinement, origin=(left, 0.0))
    mesh = mesh.with_boundaries({"strip": lambda p: (p[1] > 1 - 1e-9) & (np.abs(p[0]) < 1.0)})
    # Samples after each step, so that a cycle leads from p_max to p_max.
    triangle = 1 - (1 - unloading) * (1 - np.abs(1 - 2 * np.arange(1, steps + 1) / steps))
    press = Pressure(
        boundary="strip", value=1.0, history=triangle, transient=np.arange(first_loading + 1) / first_loading
    )
    body = ElasticBody(
        mesh,
        Material(1.0, 0.3),
        supports=[Support("left", x=True, y=False)] if symmetric else [],
        loads=[press],
    )
    name = f"receding block (chapter III){', right half' if symmetric else ''}"
    return contact_problem(body, "bottom", 0.35, name=name, units="h, p_max")


def cantilevered_block(
    # multiplies the elements of both directions; the contact has 8 · refinement + 1 nodes (the thesis:
    # nine)
    refinement: int = 1,
) -> Problem:
    """The cantilevered block of thesis chapter V: h × 4.5h, one end fixed, the other on a slanted plane.

    A pressure 5000 + 1000 cos 10π(t + 0.1) [N/m²] acts on a small strip of the top, from 2 h to
    2.5 h; E = 200 GPa, ν = 0.3, f = 0.4, h = 1 m, plane strain. One period is 0.2 s, in 40 load steps.

    The thesis states neither the angle nor the strip nor the mesh. Here the free
    end is cut so that it rests on a plane at 60° to the horizontal, about the middle
    of its height; bilinear elements, eight across the height. λ_max = 1.178, the smallest
    positive of the 43,758 critical values 0.0003 (thesis, with its own: 1.0821, 0.0013).

    Examples
    --------
    >>> cantilevered_block().n
    9
    """
    block = block_mesh(4.5, 1.0, 36 * refinement, 8 * refinement)
    x, y = block.p
    slanted = np.vstack([x * (1 + (y - 0.5) / np.tan(np.pi / 3) / 4.5), y])
    mesh = replace(block, doflocs=np.ascontiguousarray(slanted)).with_boundaries(
        {"strip": lambda p: (p[1] > 1 - 1e-9) & (p[0] > 2.0) & (p[0] < 2.5)}
    )
    press = Pressure(
        boundary="strip", value=1.0, history=lambda t: 5000 + 1000 * np.cos(2 * np.pi * t + np.pi)
    )
    body = ElasticBody(mesh, Material(200e9, 0.3), supports=[Support("left")], loads=[press])
    return contact_problem(
        body, "right", 0.4, steps=40, name="slanted cantilevered block (chapter V)", units="N, m"
    )


def with_top_moved(block: Problem) -> Problem:
    """A block of CalculiX (block-9, block-33) with the loads that its welded reactions are made of.

    Its top is moved sideways by 2.5e-4 cos 2πt and down by 1e-3 + 1.5e-4 sin 2πt [mm]. Displacements that are
    prescribed are conjugate to minus the forces that hold them: by equilibrium the sums of the reactions.
    """
    turn = 2 * np.pi * np.arange(block.m) / block.m
    history = np.column_stack([2.5e-4 * np.cos(turn), -1e-3 - 1.5e-4 * np.sin(turn)])
    unit, *_ = np.linalg.lstsq(history, np.hstack([block.q_w, block.p_w]), rcond=None)
    held = unit.reshape(2, 2, block.n).sum(axis=2)
    return replace(
        block,
        load_reactions=unit,
        load_history=history,
        load_compliance=np.diag(np.diag(held)),  # the two are at right angles
        load_names=("top face sideways", "top face down"),
    )


def shipped_blocks() -> dict[str, Problem]:
    """The built-in problems that come from meshes, by name: blocks, classical contacts, joints of solids.

    They are kept in ``shakedown/files/data``, so that scikit-fem need not be there to
    use them; to make them again (those of CalculiX keep their matrices)::

        for name, problem in shipped_blocks().items():
            shakedown.save_problem(f"shakedown/files/data/{name}.npz", problem)
    """
    return {
        **{name: with_top_moved(example(name)) for name in ("block-9", "block-33")},
        "receding-block": receding_block(2, steps=20, first_loading=10),
        "cantilevered-block": cantilevered_block(),
        "press-fit": press_fit(),
        "cylinder-on-flat": cylinder_on_flat(),
        "bolted-flange": bolted_flange((8, 2, 2)),
        "blade-root": blade_root((2, 3)),
        "bearing-ring": bearing_ring(),
    }
