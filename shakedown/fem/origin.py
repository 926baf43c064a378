"""What a problem made from meshes was made of, as ``Problem.source`` keeps it."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from shakedown import __version__
from shakedown.fem.body import AXES, BodyLoad, ElasticBody, Material
from shakedown.fem.mesh import FILE
from shakedown.ground.constants import EACH_SHOWN, FloatArray

Entry = dict[str, Any]  # of a JSON object


def origin_text(
    bodies: Sequence[tuple[ElasticBody, str]],
    steps: int | None,
    contact: Mapping[str, object],
    warnings: Sequence[str] = (),
) -> str:
    """``source`` of a problem as JSON: no date, no machine, the same text for the same joint.

    Parameters
    ----------
    bodies
        Each body with its contact boundary.
    steps
        Load steps at which functions of time are sampled.
    contact
        What else was given: friction, initial gap, bolts, how two bodies are coupled.
    warnings
        What is doubtful of the joint.

    Examples
    --------
    >>> from shakedown.fem import Material, Pressure, block_mesh
    >>> press = Pressure("top", 2.0, history=1.0)
    >>> body = ElasticBody(block_mesh(2.0, 1.0, 4, 2), Material(210e3, 0.3), loads=[press])
    >>> found = json.loads(origin_text([(body, "bottom")], 8, {"friction": 0.5}))
    >>> found["bodies"][0]["loads"]
    [{'kind': 'Pressure', 'history': 1.0, 'boundary': 'top', 'value': 2.0}]
    """
    about: Entry = {
        "toolkit": f"shakedown-bounds {__version__}",
        "made_by": "shakedown.fem.contact_problem",
        "steps": steps,
        **{key: _told(value) for key, value in contact.items()},
        "bodies": [_body(body, boundary, steps) for body, boundary in bodies],
        "files": [getattr(body.mesh, FILE) for body, _ in bodies if hasattr(body.mesh, FILE)],
        "warnings": list(warnings),
    }
    return json.dumps({key: value for key, value in about.items() if value not in (None, [])})


def _body(body: ElasticBody, boundary: str, steps: int | None) -> Entry:
    parts = {"whole body": body.material} if isinstance(body.material, Material) else body.material
    low, high = body.mesh.p.min(axis=1).tolist(), body.mesh.p.max(axis=1).tolist()
    *orders, shape = body.kind.names
    mesh = {
        "elements": int(body.mesh.nelements),
        "nodes": int(body.dofs[:, 0].max()) + 1,
        "type": f"{orders[body.order - 1]} {shape}",
        **{axis: [low[k], high[k]] for k, axis in enumerate(AXES[: body.dimension])},
    }
    held = [(each.boundary, each.holds(body.dimension)) for each in body.supports]
    return {
        "contact": boundary,
        **({"plane": body.plane, "thickness": float(body.thickness)} if body.dimension == 2 else {}),
        **({"rigid": list(body.rigid)} if body.rigid else {}),
        "materials": {name: _told(material) for name, material in parts.items()},
        "mesh": mesh,
        "supports": [{"boundary": name, "holds": [AXES[k - 1] for k in along]} for name, along in held],
        "loads": [_load(load, steps) for load in body.loads],
    }


def _load(load: BodyLoad, steps: int | None) -> Entry:
    """Kind of a load, and whatever was given for it."""
    told, history = _told(load), getattr(load, "history", None)
    if callable(history) and steps is not None:
        values = np.asarray(history(np.arange(steps) / steps), dtype=float)
        told["history"] = f"a function of time, {_range(values)} at {steps} load steps"
    return {"kind": type(load).__name__, **told}


def _told(value: Any) -> Any:
    """A value for JSON: numbers, texts and short lists as they are, a longer list as its size and range."""
    if value is None or isinstance(value, str | int):
        return value
    if is_dataclass(value) or isinstance(value, Mapping):
        given = (
            value
            if isinstance(value, Mapping)
            else {own.name: getattr(value, own.name) for own in fields(value)}
        )
        return {name: _told(part) for name, part in given.items() if part is not None}
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
