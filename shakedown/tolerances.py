"""The one place where the toolkit says how close is close enough."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Tolerances:
    """Relative tolerances; each comparison scales them by the norms of what it compares.

    Attributes
    ----------
    symmetry
        Largest |A − Aᵀ| accepted (and averaged away), relative to max |A|.
    definiteness
        Most negative eigenvalue of κ accepted as zero, relative to the largest.
    feasibility
        Largest violation of a constraint row, relative to the terms of that row.
    degeneracy
        Smallest reciprocal condition number at which an (n+1)-subset of
        normalised rows still counts as regular.
    cancellation
        A sum of two terms this small, relative to the terms, counts as zero.
    equilibration_sweeps
        Sweeps that bring the rows and columns of a linear program near the size 1.
    friction_law
        Largest violation of the friction law, relative to the largest reaction.
    """

    symmetry: float = 1e-8
    definiteness: float = 1e-8
    feasibility: float = 1e-9
    degeneracy: float = 1e-12
    friction_law: float = 1e-9
    cancellation: float = 1e-15
    equilibration_sweeps: int = 4


DEFAULT = Tolerances()
