"""Arrays as bytes, and a problem as one number: what a journal holds."""

import hashlib
from collections.abc import Mapping
from dataclasses import fields
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shakedown.model.problem import Problem


def packed(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Arrays by name as the bytes of an NPZ archive.

    Examples
    --------
    >>> unpacked(packed({"slip": np.array([0.5, 0.25])}))["slip"]
    array([0.5 , 0.25])
    """
    buffer = BytesIO()
    np.savez(buffer, allow_pickle=False, **arrays)
    return buffer.getvalue()


def unpacked(piece: bytes) -> dict[str, NDArray[Any]]:
    """The arrays that :func:`packed` put together."""
    with np.load(BytesIO(piece), allow_pickle=False) as archive:
        return {key: archive[key] for key in archive.files}


def unpacked_array(piece: bytes, key: str) -> NDArray[Any]:
    """One of the arrays that :func:`packed` put together."""
    with np.load(BytesIO(piece), allow_pickle=False) as archive:
        return np.asarray(archive[key])


def fingerprint(problem: Problem) -> str:
    """SHA-256 of all arrays of a problem, and that they are a load domain: what a campaign is compared by.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("two-node")
    >>> fingerprint(joint) == fingerprint(shakedown.example("two-node"))
    True
    """
    digest = hashlib.sha256()
    for field in fields(problem):
        value = getattr(problem, field.name)
        if isinstance(value, np.ndarray):
            digest.update(f"{field.name} {value.dtype.str} {value.shape};".encode())
            digest.update(np.ascontiguousarray(value).tobytes())
    if problem.is_domain:
        digest.update(b"load domain;")
    return digest.hexdigest()
