"""Whether matrix, row map and deck belong to one model: common neighbours, free rigid motions."""

from collections import Counter
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import FOUR_DIGITS, MUCH, SIX_DIGITS
from shakedown.ground.tolerances import DEFAULT
from shakedown.models.importing.bodies import coupled_nodes, rigid_motions
from shakedown.models.importing.contact_section import ContactSection
from shakedown.models.readers.mesh import SOLIDS, Mesh
from shakedown.models.readers.stiffness import Stiffness
from shakedown.models.readers.text import LOOKED_AT

_UNALIKE = 200.0  # ratio beyond which units differ: mm for m gives 1,000, element shapes or ν = 0.499 less


def model_doubts(stiffness: Stiffness, contact: ContactSection, mesh: Mesh | None) -> tuple[str, ...]:
    """Warnings where matrix, row map and deck hardly belong together, or nodes that touch are no pairs."""
    labels, node, coupled = coupled_nodes(stiffness)
    part = connected_components(coupled, directed=False)[1]
    body = dict(zip(labels.tolist(), part.tolist(), strict=True))
    found = tuple(doubt for patch in contact.parts for doubt in _both_ways(patch, body))
    if mesh is None:
        return found
    found += _touching(contact, mesh, labels, part)
    if not mesh.elements or stiffness.superelement or mesh.relative or mesh.rotated:
        return found
    touching = _neighbours(mesh, labels)
    inside = _inside(stiffness, mesh, labels, node, touching)
    if not inside.any():
        return found
    return (
        *found,
        *_strange(labels, inside, coupled, touching),
        *_resisting(stiffness, mesh, labels, node, inside),
        *_out_of_size(stiffness, mesh, inside[node]),
    )


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


def _strange(
    labels: NDArray[np.intp], inside: NDArray[np.bool_], coupled: sparse.csr_array, touching: sparse.csr_array
) -> tuple[str, ...]:
    """A warning where the matrix couples nodes that share no element."""
    strange = (coupled - coupled.multiply(touching))[:, labels > 0].sum(
        axis=1
    ) > 0  # internal nodes have none
    share = strange[inside].mean()
    if share <= MUCH:  # springs, equations or unknown elements may explain so few
        return ()
    return (
        f"the matrix couples nodes that share no element of the deck ({100 * share:.0f} % of those inside, "
        f"first {labels[np.argmax(inside & strange)]}): are matrix, row map and deck of one run?",
    )


def _resisting(
    stiffness: Stiffness,
    mesh: Mesh,
    labels: NDArray[np.intp],
    node: NDArray[np.intp],
    inside: NDArray[np.bool_],
) -> tuple[str, ...]:
    """A warning where rigid motions meet resistance inside the model."""
    resisted = np.zeros(len(labels))
    np.maximum.at(resisted, node, _resistance(stiffness, mesh))
    resisted[~inside] = 0.0
    count = int((resisted > FOUR_DIGITS).sum())
    if not count:
        return ()
    share, most = count / inside.sum(), labels[np.argmax(resisted)]
    cause = "are coordinates and matrix of one model?" if share > MUCH else "springs, or damaged entries?"
    return (
        f"rigid motions of the deck's nodes meet resistance at {count} of {inside.sum()} nodes inside the "
        f"model, most at {most}: {cause}",
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


def _touching(
    contact: ContactSection, mesh: Mesh, labels: NDArray[np.intp], part: NDArray[np.intp]
) -> tuple[str, ...]:
    """A warning about nodes of two bodies at one place that are no pair of the contact."""
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


def _neighbours(mesh: Mesh, labels: NDArray[np.intp]) -> sparse.csr_array:
    """Which of the nodes share an element, (k, k)."""
    number = {label: k for k, label in enumerate(labels.tolist())}
    pairs = [
        (row, number[label])
        for row, (_, nodes) in enumerate(mesh.elements.values())
        for label in nodes
        if label in number
    ]
    row, column = np.array(pairs, dtype=np.intp).reshape(-1, 2).T
    inside = sparse.coo_array(
        (np.ones(len(row)), (row, column)), shape=(len(mesh.elements), len(labels))
    ).tocsr()
    return ((inside.T @ inside) > 0).tocsr()


def _inside(
    stiffness: Stiffness,
    mesh: Mesh,
    labels: NDArray[np.intp],
    node: NDArray[np.intp],
    touching: sparse.csr_array,
) -> NDArray[np.bool_]:
    """Which nodes belong to elements all of whose nodes have free rows in all their directions, (k,)."""
    dofs = stiffness.dofs
    free = (stiffness.K.diagonal() < DEFAULT.constrained_diagonal) & np.isin(dofs[:, 1], (1, 2, 3))
    rows = np.bincount(node[free], minlength=len(labels))
    whole = rows == rows.max()
    there = set(labels[whole].tolist())
    lacking = {k for _, nodes in mesh.elements.values() if not there.issuperset(nodes) for k in nodes}
    known = np.asarray(touching.diagonal() > 0)  # is the node of an element
    return known & whole & ~np.isin(labels, list(lacking))


def _resistance(stiffness: Stiffness, mesh: Mesh) -> FloatArray:
    """The force that a rigid motion of its neighbours causes in every row, relative to its terms, (N,)."""
    dofs = stiffness.dofs
    place = dict(zip(mesh.labels.tolist(), mesh.coordinates, strict=True))
    xyz = np.array([place.get(label, np.zeros(3)) for label in dofs[:, 0].tolist()])
    axes = [2] if mesh.axisymmetric else sorted({1, 2, 3} & set(dofs[:, 1].tolist()))
    motions = rigid_motions(dofs, xyz - xyz.mean(axis=0), axes)
    terms = abs(stiffness.K) @ np.abs(motions)
    met = np.abs(stiffness.K @ motions)
    return np.asarray((met / np.maximum(terms, np.finfo(float).tiny)).max(axis=1))
