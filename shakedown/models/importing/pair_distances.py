"""How far apart the two nodes of every pair lie in the model, along the surface and across it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE, THREE_DIGITS
from shakedown.joint.contact_patches import NEIGHBOURS
from shakedown.joint.result import Result
from shakedown.models.condensation.surface_coupling import REACH
from shakedown.models.importing.contact_section import ContactSection
from shakedown.models.readers.mesh import Mesh

DOUBTFUL = 0.03  # relative to the spacing, along the surface: more than the rounding of printed coordinates


@dataclass(frozen=True, eq=False, repr=False)
class PairDistances(Result):
    """Distances of the pairs, in the length of the model.

    Attributes
    ----------
    names : tuple of str
        The pairs.
    along : (n,)
        Distance along the surface [length]: 0 where the meshes of both sides match.
    across : (n,)
        Distance along the normal [length]: the gap as the model is drawn, negative where the bodies overlap.
    spacing : (n,)
        Distance from a node of the first body to the nearest other one of the contact [length]; NaN for a
        single pair.
    """

    names: tuple[str, ...]
    along: FloatArray
    across: FloatArray
    spacing: FloatArray

    @property
    def off(self) -> FloatArray:
        """Distances along the surface relative to the spacing, (n,)."""
        return self.along / self.spacing

    @property
    def apart(self) -> FloatArray:
        """Distances across the surface relative to the spacing, (n,)."""
        return np.abs(self.across) / self.spacing

    def to_dict(self) -> dict[str, object]:
        """What ``shakedown-bounds import --check --json`` writes of them."""
        return {
            "along": {"largest": self.along.max(), "mean": self.along.mean()},
            "across": {"largest": np.abs(self.across).max(), "mean": np.abs(self.across).mean()},
            "along_by_spacing": {"largest": self.off.max(), "mean": self.off.mean()},
            "across_by_spacing": {"largest": self.apart.max(), "mean": self.apart.mean()},
        }


def distances_of(contact: ContactSection, mesh: Mesh | None) -> PairDistances | None:
    """Distances of the pairs of a contact, or of those that equations make; None where there are none."""
    if mesh is None:
        return None
    pairs = contact.labels
    if contact.relative:
        keys = [(label, contact.axes[0]) for label in contact.first.tolist()]
        pairs = np.array([mesh.relative[key] for key in keys if key in mesh.relative])
    if len(pairs) < contact.first.size or pairs.ndim == 1:
        return None
    first, second = mesh.at(pairs[:, 0]), mesh.at(pairs[:, 1])
    return pair_distances(contact.names, first, second, contact.unit_normals, mesh.coordinates)


def pair_distances(
    names: Sequence[str],
    first: FloatArray,
    second: FloatArray,
    normals: FloatArray,
    model: FloatArray | None = None,
) -> PairDistances:
    """Distances between the nodes (n, 3) of the first body and those of the second, by normals (n, 3).

    For a single pair the spacing is taken from the nodes of the whole ``model``, (k, 3).

    Examples
    --------
    >>> first = np.array([[0.0, 0, 0], [1, 0, 0], [3, 0, 0]])
    >>> found = pair_distances("abc", first, first + [0.1, -0.2, 0], np.array([[0.0, 2, 0]] * 3))
    >>> found.off.round(12).tolist(), found.across.round(12).tolist()
    ([0.1, 0.1, 0.05], [0.2, 0.2, 0.2])
    """
    unit = normals / np.linalg.norm(normals, axis=1)[:, None]
    between = first - second
    across = (between * unit).sum(axis=1)
    along = np.linalg.norm(between - across[:, None] * unit, axis=1)
    spacing = _spacings(first)
    if len(first) == 1 and model is not None and len(model) > 2:
        spacing = np.sort(np.linalg.norm(model - first, axis=1))[2:3]  # beyond itself and its partner
    return PairDistances(tuple(names), along, across, spacing)


def _spacings(places: FloatArray) -> FloatArray:
    """The distance of every node from the nearest one that lies elsewhere, (n,); NaN where there is none."""
    if len(places) == 1:
        return np.full(1, np.nan)
    distance, _ = cKDTree(places).query(places, k=min(len(places), NEIGHBOURS))
    elsewhere = distance > NEGLIGIBLE * np.ptp(places, axis=0).max()
    first = np.argmax(elsewhere, axis=1)
    return np.where(elsewhere.any(axis=1), distance[np.arange(len(places)), first], np.nan)


def check_distances(pairs: PairDistances, where: str, *, gap_is_stated: bool) -> tuple[str, ...]:
    """Warnings about pairs that do not lie on each other; without a stated gap they should touch as drawn.

    Raises
    ------
    ProblemError
        If two nodes lie so far apart that they are hardly meant to be partners.
    """
    _refuse(pairs, pairs.off, pairs.along, where, "along the surface")
    if not gap_is_stated:
        over = "across it; say 'gap' where they are meant (\"coordinates\": as the model is drawn)"
        _refuse(pairs, pairs.apart, np.abs(pairs.across), where, over)
    warnings, names = [], pairs.names
    k, largest = _worst(pairs.off)
    if largest > DOUBTFUL:
        warnings.append(
            f"pairs do not lie on each other: {names[k]} is {pairs.along[k]:.3g} apart along the surface, "
            f"{largest:.2g} of the spacing (mean {np.nanmean(pairs.off):.2g}), and taken as lying at one "
            "place"
        )
    k, largest = _worst(pairs.apart)
    if largest > THREE_DIGITS and not gap_is_stated:
        drawn = "overlap by" if pairs.across[k] < 0 else "lie apart by"
        warnings.append(
            f"pairs are drawn so that they {drawn} {abs(pairs.across[k]):.3g} across the surface "
            f'({names[k]}), but taken as touching: gap = "coordinates" takes what is drawn, gap = 0 says '
            "that touching is meant"
        )
    return tuple(warnings)


def drawn_apart(contact: ContactSection) -> tuple[str, ...]:
    """A warning about coupled surfaces that are drawn apart or into each other without a stated gap."""
    coupling = contact.surfaces
    if coupling is None or contact.gap_is_stated:
        return ()
    mean = float(coupling.distance[1])
    if abs(mean) <= (THREE_DIGITS if coupling.flat else DOUBTFUL) * coupling.size:
        return ()
    drawn = "overlap by" if mean < 0 else "lie apart by"
    word = ' (or "coordinates")' if coupling.flat else ""
    return (
        f"the surfaces are drawn so that they {drawn} {abs(mean):.3g} on average, but taken as touching: "
        f"gap = a number{word} takes what is meant, gap = 0 says that touching is",
    )


def check_gap(contact: ContactSection) -> tuple[str, ...]:
    """A warning about a gap, or an interference, that is large beside the distance of the nodes."""
    if contact.coordinates is None or not contact.gap.any():
        return ()
    spacing, gap = _spacings(contact.coordinates), np.broadcast_to(contact.gap, len(contact.coordinates))
    nearest, deepest = np.nan_to_num(gap / spacing).min(), np.nan_to_num(-gap / spacing).max()
    if nearest <= REACH and deepest <= REACH:
        return ()
    found = f"the bodies touch nowhere: the least gap is {gap.min():.3g}"
    if deepest > REACH:
        found = f"the interference is up to {-gap.min():.3g}"
    return (
        f"{found}, {max(nearest, deepest):.2g} of the spacing of the nodes: is it in the unit of the model?",
    )


def _worst(share: FloatArray) -> tuple[int, float]:
    """Where a share of the spacing is largest, and how large; 0 where no spacing is known."""
    known = np.nan_to_num(share)
    return int(np.argmax(known)), float(known.max())


def _refuse(pairs: PairDistances, share: FloatArray, distance: FloatArray, where: str, how: str) -> None:
    far = np.flatnonzero(share > REACH)
    if far.size:
        k = int(far[np.argmax(share[far])])
        raise ProblemError(
            f"{where}: key 'pairs': expected nodes that lie on each other (nearer than {REACH:g} of the "
            f"spacing {pairs.spacing[k]:.3g}), found {pairs.names[k]} {distance[k]:.3g} apart {how}"
        )
