"""What an import finds of a model itself: its bodies and what holds them, patches, resultants and moments."""

import numpy as np
import pytest
import writers
from command import run
from scipy import sparse

import shakedown
from shakedown.fem import ElasticBody, Material, Support, block_mesh

STEEL = Material(200e3, 0.3)


@pytest.fixture(scope="module")
def clamp(tmp_path_factory):
    """A pad between two jaws; the lower jaw is held, the upper one pressed down beside its middle."""
    folder = tmp_path_factory.mktemp("clamp")
    bodies = [
        ElasticBody(block_mesh(2.0, 1.0, 4, 2), STEEL),
        ElasticBody(block_mesh(2.0, 1.0, 4, 2, origin=(0.0, -1.0)), STEEL, supports=[Support("bottom")]),
        ElasticBody(block_mesh(2.0, 1.0, 4, 2, origin=(0.0, 1.0)), STEEL),
    ]
    dofs = np.vstack([body.dofs + np.array([1 + 100 * k, 0]) for k, body in enumerate(bodies)])
    K = sparse.block_diag([body.stiffness for body in bodies]).toarray()
    held = len(bodies[0].dofs) + bodies[1].held_rows()
    K[held, held] = 1e36
    places = [
        (node + 1 + 100 * k, *body.positions(np.array([node]))[0])
        for k, body in enumerate(bodies)
        for node in np.unique(body.dofs[:, 0])
    ]

    def along(k, boundary):
        nodes = [node + 1 + 100 * k for node in bodies[k].normals_on(boundary)[0].tolist()]
        return sorted(nodes, key={label: x for label, x, _ in places}.__getitem__)

    pairs = [
        *zip(along(0, "bottom"), along(1, "top"), strict=True),
        *zip(along(0, "top"), along(2, "bottom"), strict=True),
    ]
    pressed = next(label for label, x, y in places if (x, y) == (1.5, 2.0))
    (folder / "nodes").write_text("".join(f"{label} {x} {y} 0\n" for label, x, y in places))
    (folder / "k").write_text(writers.abaqus_matrix(K, dofs.tolist()))
    (folder / "clamp.toml").write_text(
        f"""friction = 0.3
units = "N, mm"
[model]
file = "nodes"
[stiffness]
file = "k"
[[contact]]
name = "below"
pairs = {[list(pair) for pair in pairs[:5]]}
normal = [0, 1]
[[contact]]
name = "above"
pairs = {[list(pair) for pair in pairs[5:]]}
normal = [0, -1]
[[load]]
name = "clamp"
forces = [[{pressed}, 2, -70.0]]
history = [1.0, 0.9]
"""
    )
    return folder / "clamp.toml"


def test_a_clamp_is_told_patch_by_patch(clamp):
    made = shakedown.import_model(clamp)
    assert [body.name for body in made.evidence.bodies] == ["body 1", "body 2", "body 3"]
    assert [body.contact_nodes for body in made.evidence.bodies] == [10, 5, 5]
    assert [len(body.free) for body in made.evidence.bodies] == [3, 0, 3]
    assert made.evidence.patches.tolist() == [0] * 5 + [1] * 5
    (load,) = made.loads
    np.testing.assert_allclose(load.contact, 0, atol=1e-9)
    found = {part.what: (*part.force, *part.moment) for part in load.parts}
    expected = {
        "applied, body 3": (0, -70, -35),  # half a millimetre beside the middle of the contact
        "contact, below": (0, 70, 35),
        "contact, above": (0, -70, -35),
        "supports, body 2": (0, 70, 35),
    }
    assert found.keys() == expected.keys()
    for what, numbers in expected.items():
        np.testing.assert_allclose(found[what], numbers, atol=1e-9)
    _, out, _ = run("import", str(clamp), "--check")
    lines = [line.split() for line in out.splitlines()]
    assert ["contact,", "above", "0", "-70", "-35"] in lines
    assert all(len(line) <= 80 for line in out.splitlines())
