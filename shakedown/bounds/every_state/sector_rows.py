"""Conditions of slip in a sector on a reaction: two half-planes, from one least pressure."""

import numpy as np

from shakedown.bounds.every_state.least_pressures import LeastPressures
from shakedown.bounds.every_state.scaled_joint import ScaledJoint
from shakedown.bounds.every_state.sectors import Sectors, turned
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import EPS, MUCH, SIX_DIGITS

SAMPLES = 17  # samples of the curve of a sector; in between its curvature is bounded


def sector_rows(joint: ScaledJoint, least: LeastPressures, half: float) -> tuple[Sectors, FloatArray]:
    """The ends E of sectors about the directions of some least pressures, and their sizes t.

    With the multipliers for slip along the middle, a node that slips along any u has g(u) p_i ≥ π,
    g(u) = 1 − f_i (h_i − Y_i · u). So f p_i + u · w > 0 follows from −g(u) u · w < f π, and for all u of the
    sector from −t E · w < f π at both ends, if 0, t E of the one and t E of the other end span a
    triangle that holds the curve g(u) u.

    Returns
    -------
    ends
        Two to each sector, as sectors without width.
    sizes : (2c,)
        t of each end [–].
    """
    node, middle = least.sectors.node, least.sectors.middle
    every, f = np.arange(len(node)), joint.f[node]
    Y = least.multipliers.reshape(len(node), -1, 2)[every, node]
    across_middle = turned(middle)
    base = 1.0 - f * least.weights[every, node] + f * least.error
    wave = f[:, None] * np.stack([np.sum(Y * middle, axis=1), np.sum(Y * across_middle, axis=1)], axis=1)
    sizes = _covering(base, wave, half)
    cosine, sine = np.cos(half), np.sin(half)
    ends = np.stack([cosine * middle - sine * across_middle, cosine * middle + sine * across_middle], axis=1)
    return Sectors(np.repeat(node, 2), ends.reshape(-1, 2), 0.0), sizes.ravel()


def _covering(base: FloatArray, wave: FloatArray, half: float) -> FloatArray:
    """Sizes (c, 2) of ends whose triangle with 0 holds g u, g = base + wave · (cos δ, sin δ), |δ| ≤ half."""
    swing = np.hypot(wave[:, 0], wave[:, 1])
    highest = np.maximum(base + swing, SIX_DIGITS)
    at_ends = np.stack([_curve(base, wave, angle) for angle in (-half, half)], axis=1)
    # Ends whose ratio is beyond that are covered by one circle.
    uneven = at_ends.min(axis=1) < MUCH * highest
    ends = np.where(uneven[:, None], highest[:, None], at_ends)
    first, second = 1.0 / ends[:, 0], 1.0 / ends[:, 1]
    even, odd = 0.5 * (first + second) / np.cos(half), 0.5 * (second - first) / np.sin(half)
    angles = half * np.linspace(-1.0, 1.0, SAMPLES)
    gauge = [_curve(base, wave, d) * (even * np.cos(d) + odd * np.sin(d)) for d in angles]
    curvature = (np.abs(base) + 4.0 * swing) * np.hypot(even, odd)
    step = 2.0 * half / (SAMPLES - 1)
    stretch = np.max(gauge, axis=0) + step**2 / 8.0 * curvature + 64 * EPS * (1.0 + np.abs(base) + swing)
    return np.asarray(ends * np.maximum(stretch, SIX_DIGITS)[:, None])


def _curve(base: FloatArray, wave: FloatArray, angle: float) -> FloatArray:
    return np.asarray(base + wave[:, 0] * np.cos(angle) + wave[:, 1] * np.sin(angle))
