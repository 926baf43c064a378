"""The energy rows of a joint of which some nodes stay open."""

from dataclasses import replace

import numpy as np

from shakedown.bounds.energy.energy_rows import EnergyRows, energy_rows
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.constraints import Side
from shakedown.joint.contact_zone import Zone
from shakedown.joint.loading import transient_path


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
