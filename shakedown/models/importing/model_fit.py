"""Whether matrix, row map and deck belong to one model: common neighbours, free rigid motions."""

from collections import Counter
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from shakedown.ground.round_off import FOUR_DIGITS, MUCH, RESOLVED, SIX_DIGITS
from shakedown.ground.tolerances import DEFAULT
from shakedown.models.importing.bodies import rigid_motions
from shakedown.models.importing.contact_section import ContactSection
from shakedown.models.readers.mesh import SOLIDS, Mesh
from shakedown.models.readers.stiffness import Stiffness
from shakedown.models.readers.text import LOOKED_AT

_UNALIKE = 200.0  # ratio beyond which units differ: mm for m gives 1,000, element shapes or ν = 0.499 less


def model_doubts(stiffness: Stiffness, contact: ContactSection, mesh: Mesh | None) -> tuple[str, ...]:
    """Warnings where matrix, row map and deck hardly belong together, or nodes that touch are no pairs."""
    body = dict(zip(stiffness.dofs[:, 0].tolist(), stiffness.parts.tolist(), strict=True))
    found = tuple(doubt for patch in contact.parts for doubt in _both_ways(patch, body))
    if mesh is None:
        return found
    found += _touching(contact, mesh, body)
    if not mesh.elements or stiffness.superelement or mesh.relative or mesh.rotated:
        return found
    nodes = stiffness.dofs[stiffness.dofs[:, 0] > 0, 0]
    unknown = nodes[~np.isin(nodes, mesh.labels)]
    if len(unknown) > MUCH * len(nodes):
        found += (
            f"{len(unknown)} of {len(nodes)} rows are of nodes that are none of the deck, first "
            f"{unknown[0]}: are matrix, row map and deck of one run?",
        )
    inside = _inside(stiffness, mesh)
    if not inside.any():
        return found
    return (*found, *_resisting(stiffness, mesh, inside), *_out_of_size(stiffness, mesh, inside))


def _out_of_size(stiffness: Stiffness, mesh: Mesh, inside: NDArray[np.bool_]) -> tuple[str, ...]:
    """A warning where stiffnesses are far from those of the materials and elements of the deck.

    The diagonal of a row is about E in the plane, E times a length in space, E times the circumference of
    a body of revolution; ``inside`` says which rows, (N,).
    """
    if not mesh.young:
        return ()
    size = np.ones(1)
    if mesh.axisymmetric:
        size = 2 * np.pi * mesh.at(stiffness.dofs[inside, 0])[:, 0]
    elif any(shape in SOLIDS for shape, _ in mesh.elements.values()):
        measured = list(mesh.elements.values())[:LOOKED_AT]
        size = np.array([np.ptp(mesh.at(nodes), axis=0).mean() for _, nodes in measured])
    length = max(float(np.median(size)), np.finfo(float).tiny)
    found = float(np.median(stiffness.K.diagonal()[inside])) / length
    low, high = min(mesh.young), max(mesh.young)
    if low / _UNALIKE <= found <= high * _UNALIKE:
        return ()
    times = found / (high if found > high else low)
    return (
        f"the stiffness is {times:.1g} times what Young's modulus and the elements of the deck make: are "
        "they in the same units, is 'scale' right?",
    )


def _resisting(stiffness: Stiffness, mesh: Mesh, inside: NDArray[np.bool_]) -> tuple[str, ...]:
    """A warning where rigid motions meet resistance in rows (N,) inside the model."""
    xyz = np.array([mesh.places.get(label, [0.0] * 3) for label in stiffness.dofs[:, 0].tolist()])
    axes = [2] if mesh.axisymmetric else sorted({1, 2, 3} & set(stiffness.dofs[:, 1].tolist()))
    motions = rigid_motions(stiffness.dofs, xyz - xyz.mean(axis=0), axes)
    terms = abs(stiffness.K) @ np.abs(motions)
    met = (np.abs(stiffness.K @ motions) / np.maximum(terms, np.finfo(float).tiny)).max(axis=1)
    most = max(FOUR_DIGITS, RESOLVED * (stiffness.accuracy or 0.0))
    nodes, resisting = (set(stiffness.dofs[rows, 0].tolist()) for rows in (inside, inside & (met > most)))
    if not resisting:
        return ()
    far = len(resisting) > MUCH * len(nodes)
    return (
        f"rigid motions of the deck's nodes meet resistance at {len(resisting)} of {len(nodes)} nodes inside "
        f"the model, most at {stiffness.dofs[np.argmax(met * inside), 0]}: "
        + ("are matrix, row map and deck of one run?" if far else "springs, or damaged entries?"),
    )


def _both_ways(contact: ContactSection, part: Mapping[int, int]) -> tuple[str, ...]:
    """A warning about pairs of the same two bodies that do not all name the same body first."""
    bodies = [tuple(part[node] for node in np.atleast_1d(pair).tolist()) for pair in contact.labels]
    count = Counter(bodies)
    turned = [
        k
        for k, own in enumerate(bodies)
        if (other := own[::-1]) != own and other in count and (count[own], own) < (count[other], other)
    ]
    if not turned:
        return ()
    return (
        f"{len(turned)} pair(s), first {contact.names[turned[0]]}, name the bodies the other way round: "
        "there slip, gap and normal are those of the second body",
    )


def _touching(contact: ContactSection, mesh: Mesh, body: Mapping[int, int]) -> tuple[str, ...]:
    """A warning about nodes of two bodies at one place that are no pair of the contact."""
    labels, part = np.array(list(body)), np.array(list(body.values()))
    if contact.relative or not set(labels.tolist()) <= set(mesh.labels.tolist()):
        return ()
    places = mesh.at(labels)
    size = float(np.ptp(places, axis=0).max())
    close = cKDTree(places).query_pairs(SIX_DIGITS * size, output_type="ndarray")
    close = close[part[close[:, 0]] != part[close[:, 1]]]
    pairs = {frozenset(pair) for pair in contact.facing.tolist()}
    coupled = [set(patch.clamped.tolist()) for patch in contact.parts if patch.surfaces is not None]
    alone = [
        pair
        for pair in labels[close].tolist()
        if frozenset(pair) not in pairs and not any(own.issuperset(pair) for own in coupled)
    ]
    if not alone:
        return ()
    return (
        f"nodes of two bodies lie at one place and are no pair of the contact ({len(alone)} times, first "
        f"{alone[0][0]} and {alone[0][1]}): the bodies pass through each other there",
    )


def _inside(stiffness: Stiffness, mesh: Mesh) -> NDArray[np.bool_]:
    """Rows of nodes of elements all of whose nodes have free rows in all their directions, (N,)."""
    dofs = stiffness.dofs
    free = (stiffness.K.diagonal() < DEFAULT.constrained_diagonal) & np.isin(dofs[:, 1], (1, 2, 3))
    labels, count = np.unique(dofs[free, 0], return_counts=True)
    there = set(labels[count == count.max(initial=0)].tolist())
    elements = [nodes for _, nodes in mesh.elements.values()]
    lacking = {node for nodes in elements if not there.issuperset(nodes) for node in nodes}
    known = {node for nodes in elements for node in nodes} & there
    return np.isin(dofs[:, 0], list(known - lacking))
