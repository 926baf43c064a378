"""The frictional limits with the slack that a ball of slips needs at each of them."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.energy.energy_metric import EnergyMetric, cleaned, energy_metric, spreads
from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.constraints import Side, constraints, through_transient
from shakedown.joint.contact_zone import Zone
from shakedown.joint.derived import once_per_problem
from shakedown.joint.loading import transient_path
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import RigidSlips


@dataclass(frozen=True)
class EnergyRows:
    """G v + λ d + R s ≤ g: every limit keeps the slack R s at the centre v of a ball of radius R.

    Apart from the names of the rows, nothing here depends on the kind of limit: any linear condition
    on slip and load can be added, with the dual norm of its slip part as s.

    Attributes
    ----------
    G : (k, n)
        Coefficients of the slip v [force/length].
    d : (k,)
        Coefficients of the load factor λ [force].
    g : (k,)
        Right-hand sides [force].
    spread : (k,)
        s, coefficients of the radius in units of ``metric.unit`` [force/length].
    node, side : (k,)
        Node and side of every row (:class:`~shakedown.joint.constraints.Constraints`).
    metric
        The energy norm.
    rigid
        The slips that change no frictional limit, and where they are pinned.
    """

    G: FloatArray
    d: FloatArray
    g: FloatArray
    spread: FloatArray
    node: NDArray[np.intp]
    side: NDArray[np.intp]
    metric: EnergyMetric
    rigid: RigidSlips

    @property
    def n(self) -> int:
        """Number of contact nodes."""
        return self.G.shape[1]

    @property
    def coefficients(self) -> FloatArray:
        """G in the unknowns of programs: zero in the columns of pinned nodes."""
        return self.rigid.columns(self.G)

    def slack(self, slip: FloatArray, load_factor: float, radius: float = 0.0) -> FloatArray:
        """Distance to the limit of every row (k,), less what a ball of a relative radius needs [force]."""
        return self.g - self.G @ slip - load_factor * self.d - radius * self.spread

    def sizes(self, slip: FloatArray, load_factor: float, radius: float = 0.0) -> FloatArray:
        """The largest term of every row (k,) [force]; 1 for a row of zeros."""
        terms = np.maximum(np.abs(self.G) @ np.abs(slip), np.abs(load_factor * self.d))
        terms = np.maximum(np.maximum(terms, np.abs(self.g)), radius * self.spread)
        return np.where(terms > 0, terms, 1.0)

    def names(self, indices: NDArray[np.intp]) -> tuple[tuple[int, int], ...]:
        """(node, side) of some rows, in order, each once."""
        return tuple(dict.fromkeys((int(self.node[i]), int(self.side[i])) for i in sorted(indices)))


def energy_rows(problem: Problem, *, transient: bool = True, tolerances: Tolerances = DEFAULT) -> EnergyRows:
    """The 2n extremal rows of a problem, and 2n more for its transient load steps; built once per problem.

    Parameters
    ----------
    problem
        The joint and its loading.
    transient
        Whether the transient load steps, where the problem has them, are still to come.
        They are not scaled by the load factor.

    Examples
    --------
    >>> import shakedown
    >>> rows = energy_rows(shakedown.example("two-node"))
    >>> rows.G.shape, (rows.spread / np.abs(rows.G).max()).round(3)
    ((4, 2), array([0.176, 0.176, 0.101, 0.101]))
    """
    known, which = _known_rows(problem), (transient, tolerances)
    if which not in known:
        known[which] = _rows(problem, transient, tolerances)
    return known[which]


@once_per_problem
def _known_rows(problem: Problem) -> dict[tuple[bool, Tolerances], EnergyRows]:
    """Cached rows of one problem: each costs an eigenvalue problem and serves all load factors."""
    return {}


def _rows(problem: Problem, transient: bool, tolerances: Tolerances) -> EnergyRows:
    rows = through_transient(problem) if transient else constraints(problem)
    metric = energy_metric(problem.A, problem.B, rows.rigid, tolerances=tolerances)
    of_limits = spreads(problem.A, problem.B, problem.f, metric, tolerances=tolerances).ravel()
    B, sizes = problem.B[problem.law.smooth], metric.sizes[problem.law.smooth]
    spread = np.append(of_limits, metric.relative_dual_norms(B, sizes, tolerances, rigid=False))
    spread = np.tile(spread, len(rows.g) // len(spread))
    terms = problem.law.stiffness_terms(problem.A, problem.B)
    G = cleaned(rows.G, np.tile(terms, (len(rows.g) // len(terms), 1)))
    return EnergyRows(G, rows.d, rows.g, spread, rows.node, rows.side, metric, rows.rigid)


def check_resolved(rows: EnergyRows, slip: FloatArray, distance: float, tolerances: Tolerances) -> None:
    """Raise ``UsageError`` where a slip, or a distance around it, drowns the loads in its round-off."""
    friction = rows.side != Side.GAP
    loads = float(np.max(np.abs(rows.g[friction])) + np.max(np.abs(rows.d[friction])))
    most = tolerances.stored_digits / np.finfo(float).eps * loads
    with np.errstate(over="ignore"):
        locked = float((np.abs(rows.G[friction]) @ np.abs(slip)).max())
        steepest = float(np.linalg.norm(rows.G[friction] @ rows.metric.inverse, axis=1).max())
        around = steepest * distance / rows.metric.unit
    for name, found in (("initial slip", locked), ("distance", around)):
        if loads > 0 and found > most:
            raise UsageError(f"{name}: expected reactions below {most:.3g} from it, found {found:.3g}")


def without_margin(problem: Problem, rows: EnergyRows) -> str:
    """Why no ball can exist whatever the load, in words; empty where one may.

    A frictionless node has no margin, and a pressure that changes under a slip that
    costs no energy has no bound within any ball.
    """
    closed = np.unique(rows.node[rows.side != Side.GAP])
    smooth = closed[problem.f[closed] == 0.0]
    if smooth.size:
        return f"node {smooth[0]} has no friction, and so no margin to a limit"
    unbounded = np.flatnonzero(np.isinf(rows.spread))
    if unbounded.size:
        node, what = rows.node[unbounded[0]], "gap" if rows.side[unbounded[0]] == Side.GAP else "pressure"
        return (
            f"node {node}: a slip without tangential energy changes its {what} "
            "(with a normal stiffness added, kappa would not be positive semi-definite)"
        )
    return ""


def zone_rows(zone: Zone, *, transient: bool = True, tolerances: Tolerances = DEFAULT) -> EnergyRows:
    """The limits of the closed nodes, and of every open node that it stays open.

    Within a ball of radius R about v* the gap of an open node i falls below that at v* by
    ‖∂w_i/∂v_K‖ R at most, the dual norm of its slope in the energy norm of the condensed
    joint; that much slack it needs. A gap is multiplied by ``metric.unit``², a power of
    two [force/length], so that all rows are forces.

    Parameters
    ----------
    zone
        The closed and the open nodes. The columns are the slips of the closed nodes.
    transient
        Whether the transient load steps, where the problem has them, are still to come.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown.joint.contact_zone import contact_zone
    >>> rows = zone_rows(contact_zone(shakedown.example("two-node"), [1]))
    >>> rows.G.shape, rows.node, rows.side
    ((3, 1), array([0, 0, 1]), array([ 1, -1,  0]))
    """
    rows = energy_rows(zone.joint, transient=transient, tolerances=tolerances)
    if not zone.open_nodes:
        return rows
    whole, metric = zone.constraints, rows.metric
    gap = whole.side == Side.GAP
    slope, d, g, node = whole.G[gap], whole.d[gap], whole.g[gap], whole.node[gap]
    lengths = np.abs(slope) @ (metric.unit**2 / metric.sizes)
    spread = metric.relative_dual_norms(slope, lengths, tolerances)  # inf where a rigid slip changes it
    before = transient_path(zone.problem)
    if transient and len(before):
        layout, at_zero = zone.problem.layout, np.zeros(slope.shape[1])
        u = zone.displacements(at_zero, *layout.split(before))
        gaps = u[:, layout.gaps_of(node)].min(axis=0)
        slope, d, g = np.vstack([slope, slope]), np.append(d, np.zeros_like(d)), np.append(g, gaps)
        spread, node = np.tile(spread, 2), np.tile(node, 2)
    force = metric.unit**2
    return replace(
        rows,
        G=np.vstack([rows.G, force * slope]),
        d=np.append(rows.d, force * d),
        g=np.append(rows.g, force * g),
        spread=np.append(rows.spread, force * spread),
        node=np.append(np.array(zone.closed_nodes)[rows.node], node),
        side=np.append(rows.side, np.full(len(node), Side.GAP)),
    )
