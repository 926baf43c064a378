"""The built-in problems, each a problem file: the thesis's own, counter-examples, finite-element blocks.

Those of a few nodes are defined in ``benchmarks/bodies/small_problems.py``.
"""

from importlib import resources

from shakedown.files.npz import load_problem
from shakedown.ground.argument_kinds import checked
from shakedown.ground.errors import UsageError
from shakedown.joint.problem import Problem

NAMES = (
    # One node below its critical friction 2 (thesis, appendix A).
    "one-node",
    # One node above its critical friction: separation and stick in turn (A.6), cyclic slip (A.7).
    "one-node-separation",
    "one-node-cyclic",
    # The two-node system of thesis 5.3.1, and without coupling.
    "two-node",
    "uncoupled",
    # Cyclic slip below the first collapse: of one node, of two together.
    "three-node",
    "pair-cycle",
    # Two limit cycles, both stable: the initial state decides.
    "two-attractors",
    # The two-node system of thesis 6.4, whose state jumps.
    "jump",
    # Elastic block, plane strain, 9 or 33 contact nodes on a rigid plane, top face moved (CalculiX 2.20).
    "block-9",
    "block-33",
    # The receding contact of chapter III, 33 contact nodes; its outer nodes separate.
    "receding-block",
    # The slanted, cantilevered block of chapter V, nine contact nodes; λ_1 = 0 by lift-off.
    "cantilevered-block",
    # A hollow shaft pressed into a hub (Lamé), pulled oval to and fro; nine contact nodes.
    "press-fit",
    # A cylinder pressed onto a flat (Hertz), moved along it to and fro; thirteen nodes, the outer open.
    "cylinder-on-flat",
    # Two tangential directions, loaded out of phase in space: one, two and four nodes, and an elastic block.
    "one-node-3d",
    "two-node-3d",
    "four-node-3d",
    "block-3x3",
    # A sector of a bolted flange, and the dovetail root of a blade after its spin; 24 pairs each.
    "bolted-flange",
    "blade-root",
    # The outer ring of a rolling bearing in a rigid housing: it creeps under eight balls; 64 nodes.
    "bearing-ring",
)


@checked
def example(name: str) -> Problem:
    """A built-in problem by name.

    Raises
    ------
    UsageError
        If there is no problem of that name.

    Examples
    --------
    >>> example("two-node").n
    2
    """
    if name not in NAMES:
        raise UsageError(f"no built-in problem '{name}'; there are {', '.join(NAMES)}")
    with resources.as_file(resources.files("shakedown.files") / "data" / f"{name}.npz") as path:
        return load_problem(path)


def example_names() -> tuple[str, ...]:
    """Names of the built-in problems.

    Examples
    --------
    >>> "two-node" in example_names()
    True
    """
    return NAMES
