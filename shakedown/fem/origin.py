"""What a problem made from meshes was made of, as ``Problem.source`` keeps it."""

import hashlib
import json
import os
from collections.abc import Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from skfem import Mesh

from shakedown import __version__
from shakedown.fem.body import AXES, BodyLoad, ElasticBody, Material, Support
from shakedown.ground.constants import EACH_SHOWN, FloatArray

FILE = "read_from"  # attribute of a mesh: name and SHA-256 of the file that it was read from
Entry = dict[str, Any]  # of a JSON object


class Contact(NamedTuple):
    """What was asked of the contact: friction, initial gap, load steps, bolts, how two bodies are coupled."""

    f: ArrayLike
    gap: object
    steps: int | None
    bolts: Sequence[object] = ()
    coupling: str = "nodes"
    free: bool = False
    modes: Sequence[tuple[int, float]] = ()


def remember_file(mesh: Mesh, path: str | os.PathLike[str]) -> Mesh:
    """Note on a mesh from which file it was read, and return it."""
    digest = hashlib.sha256(Path(path).read_bytes()).hexdigest()
    setattr(mesh, FILE, {"name": Path(path).name, "sha256": digest})
    return mesh


def origin_text(
    bodies: Sequence[tuple[ElasticBody, str]], contact: Contact, warnings: Sequence[str] = ()
) -> str:
    """``source`` of a problem as JSON: no date, no machine, the same text for the same joint.

    Parameters
    ----------
    bodies
        Each body with its contact boundary.
    contact
        What else was given.
    warnings
        What is doubtful of the joint.

    Examples
    --------
    >>> from shakedown.fem import Material, Pressure, block_mesh
    >>> press = Pressure("top", 2.0, history=1.0)
    >>> body = ElasticBody(block_mesh(2.0, 1.0, 4, 2), Material(210e3, 0.3), loads=[press])
    >>> found = json.loads(origin_text([(body, "bottom")], Contact(0.5, 0.0, 8)))
    >>> found["bodies"][0]["loads"]
    [{'kind': 'Pressure', 'history': 1.0, 'boundary': 'top', 'value': 2.0}]
    """
    files = [getattr(body.mesh, FILE) for body, _ in bodies if hasattr(body.mesh, FILE)]
    gap = contact.gap if callable(contact.gap) or np.any(np.asarray(contact.gap)) else "none"
    about: Entry = {
        "toolkit": f"shakedown-bounds {__version__}",
        "made_by": "shakedown.fem.contact_problem",
        "friction": _told(contact.f),
        "steps": contact.steps,
        "gap": _told(gap),
        "coupling": None if contact.coupling == "nodes" else contact.coupling,
        "bolts": [_fields(bolt) for bolt in contact.bolts],
        "bodies": [_body(body, boundary, contact.steps) for body, boundary in bodies],
        "free": "held, statically determinate, for the condensation alone" if contact.free else None,
        "modes": [{"mode": mode, "frequency": frequency} for mode, frequency in contact.modes],
        "files": files,
        "warnings": list(warnings),
    }
    return json.dumps({key: value for key, value in about.items() if value not in (None, [])})


def _body(body: ElasticBody, boundary: str, steps: int | None) -> Entry:
    parts = {"whole body": body.material} if isinstance(body.material, Material) else body.material
    plane = {"plane": body.plane, "thickness": float(body.thickness)} if body.dimension == 2 else {}
    rigid = {"rigid": list(body.rigid)} if body.rigid else {}
    return {
        "contact": boundary,
        **plane,
        **rigid,
        "materials": {name: _fields(material) for name, material in parts.items()},
        "mesh": _mesh(body),
        "supports": [_support(support, body.dimension) for support in body.supports],
        "loads": [_load(load, steps) for load in body.loads],
    }


def _mesh(body: ElasticBody) -> Entry:
    mesh = body.mesh
    *orders, shape = body.kind.names
    low, high = mesh.p.min(axis=1).tolist(), mesh.p.max(axis=1).tolist()
    return {
        "elements": int(mesh.nelements),
        "nodes": int(body.dofs[:, 0].max()) + 1,
        "type": f"{orders[body.order - 1]} {shape}",
        **{axis: [low[k], high[k]] for k, axis in enumerate(AXES[: body.dimension])},
    }


def _support(support: Support, dimension: int) -> Entry:
    return {"boundary": support.boundary, "holds": [AXES[k - 1] for k in support.holds(dimension)]}


def _load(load: BodyLoad, steps: int | None) -> Entry:
    """Kind of a load, and whatever was given for it."""
    told, history = _fields(load), getattr(load, "history", None)
    if callable(history) and steps is not None:
        values = np.asarray(history(np.arange(steps) / steps), dtype=float)
        told["history"] = f"a function of time, {_range(values)} at {steps} load steps"
    return {"kind": type(load).__name__, **told}


def _fields(thing: object) -> Entry:
    """What was given for the fields of a dataclass."""
    names: list[str] = [field.name for field in fields(thing)] if is_dataclass(thing) else []
    given = {name: getattr(thing, name) for name in names}
    return {name: _told(value) for name, value in given.items() if value is not None}


def _told(value: Any) -> Any:
    """A value for JSON: numbers, texts and short lists as they are, a longer list as its size and range."""
    if value is None or isinstance(value, str):
        return value
    if callable(value):
        return "a function of place"
    if isinstance(value, tuple):
        return [_told(part) for part in value]
    values = np.asarray(value, dtype=float)
    if values.size <= EACH_SHOWN:
        return values.tolist()
    return f"{values.size} values, {_range(values)}"


def _range(values: FloatArray) -> str:
    low, high = f"{values.min():.6g}", f"{values.max():.6g}"
    return f"all {low}" if values.min() == values.max() else f"{low} … {high}"
