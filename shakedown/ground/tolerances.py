"""How close is close enough: the tolerances that decide answers. Guards of one algorithm stand with it."""

from dataclasses import dataclass, fields

from shakedown.ground.argument_kinds import check_fields
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import short

FIRST_DIGIT = 5.0  # seven digits, an accuracy of 1e-7, mean an error of 5e-7 where the first digit is 1


@dataclass(frozen=True, repr=False)
class Tolerances:
    """Relative tolerances; each comparison scales them by the norms of what it compares.

    Attributes
    ----------
    symmetry
        Largest |A − Aᵀ| accepted (and averaged away), relative to max |A|; likewise C.
    definiteness
        Most negative eigenvalue of κ accepted as zero, relative to the largest.
    feasibility
        Largest violation of a constraint row, relative to the terms of that row.
    degeneracy
        Smallest reciprocal condition number at which an (n+1)-subset of
        normalised rows still counts as regular.
    cancellation
        A sum of two terms this small, relative to the terms, counts as zero.
    agreement
        Largest difference between a bound by linear programming and the same bound by
        interior points, relative to the bounds.
    equilibration_sweeps
        Sweeps that bring the rows and columns of a linear program near the size 1.
    friction_law
        Largest violation of the friction law, relative to the largest reaction.
    constrained_diagonal
        Diagonal entries of a stiffness matrix from here on mark constrained rows.
    condensed_pattern
        Largest coupling K_ij that counts as none, relative to √(K_ii K_jj).
    singular_pivot
        Smallest pivot of an interior stiffness, relative to the largest, that
        still holds the interior in place.
    zero_mode
        Largest eigenvalue of κ that counts as a rigid motion, relative to the largest.
    cross_check
        Largest difference between the condensed stiffness and a static run,
        relative to the largest reaction (printed results have about seven digits).
    printed_digits
        Largest asymmetry, and largest eigenvalue of a rigid motion, of a stiffness
        put together from printed reactions, relative to its largest.
    stored_digits
        An answer is not proved if the round-off of the stored stiffness, at the slip found,
        reaches this share of the loads.
    convergence
        Last change of slip or gap at which a Gauss–Seidel load step counts as
        solved, relative to the length scale of the scene; of a stiff node that of its reaction,
        relative to the softest node's.
    steadiness
        Slip per cycle, or difference of slips one period apart, that counts as
        none in a cycle-by-cycle simulation, relative to the length scale.
    limit
        Distance from a friction limit, from p = 0 or from w = 0 at which a node of
        an exact evolution is there, relative to the force or length scale.
    path
        Error that a path in two tangential directions may gather over one cycle, by the
        estimate of its steps, relative to the length scale. In the plane there is none.
    rate
        Rate that counts as zero, relative to the largest one of the instant.
    periodicity
        How far one period may miss a long-term state, relative to the length
        scale; slip per period of that size counts as none.
    slip_change
        Change of a period of a motion in space, relative to its slip, below which it is a cycle if its slip
        lasts to three digits. For motions that never come to rest, as above λ_max: others may do so slowly.
    same_cycle
        Limit cycles whose slips differ by less than this, relative to the length scale,
        are one.

    Raises
    ------
    UsageError
        If one is not a number ≥ 0.
    """

    symmetry: float = 1e-8
    definiteness: float = 1e-8
    feasibility: float = 1e-9
    degeneracy: float = 1e-12
    friction_law: float = 1e-9
    cancellation: float = 1e-15
    agreement: float = 1e-7
    constrained_diagonal: float = 1e35
    condensed_pattern: float = 1e-12
    singular_pivot: float = 1e-13
    zero_mode: float = 1e-9
    cross_check: float = 1e-5
    printed_digits: float = 1e-6
    stored_digits: float = 1e-3
    convergence: float = 1e-13
    steadiness: float = 1e-9
    limit: float = 1e-13
    path: float = 1e-8
    rate: float = 1e-13
    periodicity: float = 1e-10
    slip_change: float = 0.0
    same_cycle: float = 1e-7
    equilibration_sweeps: int = 4

    def __post_init__(self) -> None:
        check_fields(self)
        for each in fields(self):
            value = getattr(self, each.name)
            if not 0 <= value <= 1e300:  # largest tolerance; anything larger, or NaN, is a mistake
                whole = "a whole number" if isinstance(value, int) else "a number"
                raise UsageError(f"Tolerances: {each.name}: expected {whole} >= 0, found {short(value)}")

    def __repr__(self) -> str:
        changed = [f"{k}={v!r}" for k, v in vars(self).items() if v != getattr(Tolerances, k)]
        return f"Tolerances({', '.join(changed)})"


DEFAULT = Tolerances()
