"""``friction`` of a configuration: one coefficient, one per contact node, or one per node set."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.importing.contact.contact_section import ContactSection, check_order
from shakedown.importing.model_section import Model
from shakedown.readers.text import quoted
from shakedown.readers.toml_table import Table, is_number, shown

Friction = FloatArray | Mapping[str, float]  # () or (n,), or a coefficient for each node set


def taken_friction(root: Table) -> Friction:
    """The key ``friction``, before the contact nodes are known."""
    value = root.content.get("friction")
    if isinstance(value, dict):
        root.take("friction", "a table", required=True)
        wrong = [item for item in value.values() if not is_number(item)]
        if wrong or not value:
            raise ProblemError(
                f"{root.where}: key 'friction': expected a number for each node set, found "
                f"{shown(wrong[0] if wrong else value)}"
            )
        return {name: float(item) for name, item in value.items()}
    if isinstance(value, list):
        return np.array(root.array("friction", float, (None,)), dtype=float)
    if not root.has("friction"):
        raise root.missing("friction", "a number, a list, or a table of node sets")
    return np.array(root.number("friction"))


def friction_of(given: Friction, contact: ContactSection, model: Model, where: str) -> FloatArray:
    """The coefficients, () or (n,). A pair has that of the set in which either of its nodes is.

    Raises
    ------
    ProblemError
        If a set is unknown or has no contact node, or a contact node is in none or in several of them.
    """
    where = f"{where}: key 'friction'"
    if not isinstance(given, Mapping):
        check_order(contact, where.removesuffix(": key 'friction'"), {"friction": given})
        return given
    bodies = contact.labels.reshape(len(contact.labels), -1)
    inside = {name: _inside(model.nodes(name, where), bodies) for name in given}
    for name, own in inside.items():
        if not own.any():
            raise ProblemError(f"{where}: expected contact nodes in the set {quoted(name)}, found none")
    count = np.sum(list(inside.values()), axis=0)
    if (count != 1).any():
        k = int(np.argmax(count != 1))
        found = " and ".join(quoted(name) for name, own in inside.items() if own[k]) or "none"
        raise ProblemError(
            f"{where}: expected every contact node in one of the sets, found {contact.names[k]} in {found}"
        )
    return np.asarray(sum(value * inside[name] for name, value in given.items()), dtype=float)


def _inside(nodes: NDArray[np.intp], bodies: NDArray[np.intp]) -> NDArray[np.bool_]:
    return np.asarray(np.isin(bodies, nodes).any(axis=1))
