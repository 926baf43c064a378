"""Moving sets of few nodes that lose uniqueness early, where there are too many sets to try all."""

import numpy as np

from shakedown.planar.uniqueness.moving_sets import LostAt, MovingSet, each_loses, first_to_lose
from shakedown.planar.uniqueness.scaled_stiffness import ScaledStiffness

LARGEST_SET = 8  # moving nodes up to which sets grow
NEIGHBOURS = 8  # nodes that each one is paired with
PROMISING = 4  # grown sets, the best with the sides they had, whose sides are all tried


def neighbours(stiffness: ScaledStiffness) -> list[tuple[int, int]]:
    """Ordered pairs of nodes, each node with those that it is coupled to most."""
    n, diagonal = stiffness.n, np.diag(stiffness.A)
    size = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    B = np.abs(stiffness.B)
    strength = (np.abs(stiffness.A) + B + B.T) / np.outer(size, size)
    np.fill_diagonal(strength, -1.0)
    most = np.argsort(-strength, axis=1)[:, : min(n - 1, NEIGHBOURS)]
    return [(i, int(j)) for i in range(n) for j in most[i]]


def few_nodes(stiffness: ScaledStiffness) -> list[MovingSet]:
    """Every node by itself, and every pair of neighbours."""
    pairs = {(min(pair), max(pair)) for pair in neighbours(stiffness)}
    return [MovingSet((i,)) for i in range(stiffness.n)] + [MovingSet(pair) for pair in sorted(pairs)]


def grown_set(stiffness: ScaledStiffness, *, separation: bool) -> LostAt:
    """A small factor at which uniqueness is lost, by sets that grow node by node from one or two nodes."""
    starts = few_nodes(stiffness)
    if separation:
        starts += [MovingSet((i,), (j,)) for i, j in neighbours(stiffness)]
    best = first_to_lose(stiffness, starts)
    for _ in range(LARGEST_SET):
        if not best.sides or len(best.moving.slipping) + len(best.moving.separated) >= LARGEST_SET:
            break
        found = _one_more(stiffness, best, separation=separation)
        if found.factor >= best.factor:
            break
        best = found
    return best


def _one_more(stiffness: ScaledStiffness, best: LostAt, *, separation: bool) -> LostAt:
    """The best set with one more node: the sides kept at first, then all sides of the promising ones."""
    slipping, separated = best.moving
    rest = [i for i in range(stiffness.n) if i not in slipping and i not in separated]
    sides = np.array(best.sides, dtype=float)
    both = np.array([[*sides, 1.0], [*sides, -1.0]])
    grown = list(each_loses(stiffness, [MovingSet((*slipping, i), separated) for i in rest], both))
    if separation:
        opened = [MovingSet(slipping, (*separated, i)) for i in rest]
        grown += each_loses(stiffness, opened, sides[None, :])
    grown.sort(key=lambda lost: lost.factor)
    return first_to_lose(stiffness, [lost.moving for lost in grown[:PROMISING]])
