"""Patches of a contact laid flat: a plane as it is, a cylinder or a cone unrolled, others projected."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import PER_CENT, SIX_DIGITS
from shakedown.ground.shown_values import few
from shakedown.joint.contact_patches import TURN, IntArray, contact_patches, normals_of

OFF = 0.05  # relative deviation of places and normals from the fitted shape that is accepted
ALONG_AN_AXIS = 1.0 - PER_CENT  # cosine from which on a direction is named after an axis of the model


@dataclass(frozen=True, eq=False)
class Patch:
    """One patch of a contact, laid flat.

    Attributes
    ----------
    nodes : (k,)
        Which nodes it has; one at the seam of a closed cylinder twice.
    points : (k, 2)
        Where they are drawn [length].
    frame : (k, 2, 3)
        The directions in the model that lead to the right and upwards there.
    axes
        What the axes of the picture are called.
    kind
        What it is, in words, where it is curved.
    faces : (m, 4), optional
        Between which of these nodes there are faces; −1 as the last of a triangle.
    """

    nodes: IntArray
    points: FloatArray
    frame: FloatArray
    axes: tuple[str, str]
    kind: str = ""
    faces: IntArray | None = None


def laid_flat(
    places: FloatArray, normals: FloatArray | None, faces: NDArray[np.integer] | None
) -> list[Patch]:
    """The patches of a contact, the one with the most nodes first (:func:`contact_patches`)."""
    parts = contact_patches(places, normals, faces)
    return [flat(places, normals, nodes, between) for nodes, between in parts]


def flat(places: FloatArray, normals: FloatArray | None, nodes: IntArray, faces: IntArray | None) -> Patch:
    """One patch laid flat, in the way that fits it."""
    at = places[nodes]
    beside = None if normals is None else normals[nodes]
    known = beside if faces is None else _of_nodes(at, beside, faces)
    mean = _mean_normal(at, known)
    plane = _mean_normal(at, None)
    if abs(plane @ mean) > TURN:  # normals at the edge of the patch may be those of the edge
        mean = plane * np.sign(plane @ mean)
    sag = np.ptp(at @ mean - at.mean(axis=0) @ mean)
    size = float(np.linalg.norm(np.ptp(at, axis=0)))
    if known is None or sag <= OFF * size:
        return _projected(nodes, at, mean, faces)
    found = _cone(nodes, at, known, faces) or _cylinder(nodes, at, known, faces)
    return found or replace(_projected(nodes, at, mean, faces), kind="curved, projected")


def _of_nodes(at: FloatArray, normals: FloatArray | None, faces: IntArray) -> FloatArray:
    """Unit normals of nodes from the faces of their own patch, so that an edge does not mix both sides."""
    total, across = np.zeros_like(at), normals_of(at, normals, faces)
    for corner in faces.T:
        np.add.at(total, corner[corner >= 0], across[corner >= 0])
    size = np.linalg.norm(total, axis=1)
    bare = size == 0
    total[bare] = across.sum(axis=0) if normals is None else normals[bare]
    return np.asarray(total / np.linalg.norm(total, axis=1).clip(np.finfo(float).tiny)[:, None])


def _mean_normal(at: FloatArray, known: FloatArray | None) -> FloatArray:
    mean = np.zeros(3) if known is None else known.mean(axis=0)
    if np.linalg.norm(mean) < 0.5:  # unknown, or pointing in all directions
        mean = flattest(at)
    return np.asarray(mean / np.linalg.norm(mean))


def flattest(at: FloatArray) -> FloatArray:
    """The direction in which points extend least; for collinear points an axis of the model."""
    arms = at - at.mean(axis=0)
    arms = arms / (np.abs(arms).max() or 1.0)
    sizes, directions = np.linalg.eigh(arms.T @ arms)
    if sizes[1] > SIX_DIGITS**2 * sizes[2]:
        return np.asarray(directions[:, 0])
    return np.eye(3)[int(np.ptp(at, axis=0).argmin())]


def _projected(nodes: IntArray, at: FloatArray, normal: FloatArray, faces: IntArray | None) -> Patch:
    """The patch projected along a normal."""
    most = int(np.abs(normal).argmax())
    names = "along the patch", "across the patch"
    if abs(normal[most]) > ALONG_AN_AXIS:
        kept = [k for k in range(3) if k != most]
        frame, names = np.eye(3)[kept], ("xyz"[kept[0]], "xyz"[kept[1]])
    else:
        first = np.eye(3)[int(np.abs(normal).argmin())]
        first = first - (first @ normal) * normal
        first /= np.linalg.norm(first)
        frame = np.stack([first, np.cross(normal, first)])
    return Patch(nodes, at @ frame.T, np.tile(frame, (len(nodes), 1, 1)), names, "", faces)


def _cylinder(nodes: IntArray, at: FloatArray, normals: FloatArray, faces: IntArray | None) -> Patch | None:
    """The patch unrolled, where normals are perpendicular to an axis and nodes on a circle about it."""
    axis = _upwards(np.linalg.eigh(normals.T @ normals)[1][:, 0])
    if np.sqrt(np.mean((normals @ axis) ** 2)) > OFF:
        return None
    plane = _across(axis)
    flat = at @ plane.T
    middle = flat.mean(axis=0)
    rows = np.column_stack([2.0 * (flat - middle), np.ones(len(flat))])
    found = np.linalg.lstsq(rows, ((flat - middle) ** 2).sum(axis=1), rcond=None)[0]
    arms = flat - middle - found[:2]
    radii = np.linalg.norm(arms, axis=1)
    radius = float(radii.mean())
    if np.abs(radii - radius).max() > OFF * radius:
        return None
    angle, nodes, faces, copies = _unrolled(np.arctan2(arms[:, 1], arms[:, 0]), nodes, faces)
    out = np.column_stack([np.cos(angle), np.sin(angle)]) @ plane
    frame = np.stack([np.cross(axis, out), np.tile(axis, (len(out), 1))], axis=1)
    points = np.column_stack([radius * (angle - angle.mean()), (at @ axis)[copies]])
    most = int(np.abs(axis).argmax())
    name = "xyz"[most] if axis[most] > ALONG_AN_AXIS else "along the axis"
    return Patch(nodes, points, frame, (f"around, R = {few(radius, 3)}", name), "cylinder", faces)


def _cone(nodes: IntArray, at: FloatArray, normals: FloatArray, faces: IntArray | None) -> Patch | None:
    """The patch unrolled, where all normals meet one axis at the same angle."""
    axis = _upwards(np.linalg.eigh(np.cov(normals.T))[1][:, 0])
    lean = normals @ axis
    if np.std(lean) > OFF or abs(lean.mean()) < OFF:
        return None
    plane = _across(axis)
    flat = normals @ plane.T
    rows = np.column_stack([flat[:, 1], -flat[:, 0]])  # the normal through each place meets the axis
    centre = np.linalg.lstsq(rows, (rows * (at @ plane.T)).sum(axis=1), rcond=None)[0]
    arms, height = at @ plane.T - centre, at @ axis
    radii = np.linalg.norm(arms, axis=1)
    if np.ptp(height) < OFF * np.ptp(radii):
        return None
    slope, start = np.polyfit(height - height.mean(), radii, 1)
    off = np.abs(start + slope * (height - height.mean()) - radii).max()
    if off > OFF * radii.max() or not abs(slope) > OFF:
        return None
    sine, away = abs(slope) / float(np.hypot(1.0, slope)), float(np.sign(slope))
    axis, plane, arms = away * axis, plane * [[1.0], [away]], arms * [1.0, away]  # measured from the apex
    angle, nodes, faces, copies = _unrolled(np.arctan2(arms[:, 1], arms[:, 0]), nodes, faces)
    out = np.column_stack([np.cos(angle), np.sin(angle)]) @ plane
    generator = sine * out + np.sqrt(1.0 - sine**2) * axis
    turned = sine * (angle - angle.mean())
    right, up = np.cos(turned)[:, None], np.sin(turned)[:, None]
    around = np.cross(axis, out)
    frame = np.stack([right * around + up * generator, right * generator - up * around], axis=1)
    points = (radii[copies] / sine)[:, None] * np.column_stack([np.sin(turned), np.cos(turned)])
    kind = f"cone, {few(float(np.degrees(np.arcsin(sine))), 3)}° to its axis"
    return Patch(nodes, points - points.mean(axis=0), frame, ("around the cone", "along it"), kind, faces)


def _start(angle: FloatArray) -> float:
    """The angle after the largest gap; among gaps equal up to round-off, that of the first node."""
    order = np.sort(angle)
    gaps = np.diff(np.append(order, order[0] + 2 * np.pi))
    alike = np.flatnonzero(gaps >= (1.0 - SIX_DIGITS) * gaps.max())
    begins = order[(alike + 1) % len(order)]
    away = np.abs(np.mod(angle[None] - begins[:, None] + np.pi, 2 * np.pi) - np.pi)
    first = (away <= SIX_DIGITS).argmax(axis=1)  # the first such node
    start = begins[int(first.argmin())] + np.pi - SIX_DIGITS
    return float(np.mod(start, 2 * np.pi) - np.pi + SIX_DIGITS)  # π and −π are the same angle


def _unrolled(
    angle: FloatArray, nodes: IntArray, faces: IntArray | None
) -> tuple[FloatArray, IntArray, IntArray | None, IntArray]:
    """Angles from the largest gap on; nodes whose faces lie across the seam stand at both ends.

    With the nodes and faces, and which of the nodes given each one is.
    """
    start = _start(angle)
    angle = np.mod(angle - start + SIX_DIGITS, 2 * np.pi) - SIX_DIGITS
    copies = np.arange(len(nodes))
    if faces is not None:
        corners = np.where(faces < 0, faces[:, :1], faces)
        across = np.ptp(angle[corners], axis=1) > np.pi
        early = across[:, None] & (faces >= 0) & (angle[corners] < np.pi)
        again = np.unique(faces[early])
        number = np.zeros(len(nodes), dtype=np.intp)
        number[again] = len(nodes) + np.arange(len(again))
        faces = np.where(early, number[faces], faces)
        copies = np.concatenate([copies, again])
    later = np.arange(len(copies)) >= len(nodes)
    return angle[copies] + 2 * np.pi * later + start, nodes[copies], faces, copies


def _upwards(axis: FloatArray) -> FloatArray:
    return axis if axis[int(np.abs(axis).argmax())] > 0 else -axis


def _across(axis: FloatArray) -> FloatArray:
    """Two directions perpendicular to an axis, (2, 3), that form a right-handed frame with it."""
    first = np.eye(3)[int(np.abs(axis).argmin())]
    first = first - (first @ axis) * axis
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(axis, first)])
