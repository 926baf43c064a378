"""Are the limits and the verdict of a joint in uncoupled parts those of its parts, in whatever units?

Drawn joints of every kind, in the plane and in space, two by two in one joint that no entry of A, B or C
couples, the second one in lengths that are so many decades larger, and in forces that are so now and then.
Counted are joints one of whose limits is not the least of the two, whose outcome from slip zero is not the
worse of the two, or whose drift and slip are not those of both; and verdicts of which a walk of one period of
the whole joint slips otherwise.
"""

from dataclasses import replace

import numpy as np
from scipy.linalg import block_diag

import shakedown
from benchmarks.drawn_joints import drawn_joint, drawn_joint_in_space
from shakedown import Problem
from shakedown.motion.evolution import Evolution
from shakedown.report.facts import table

TITLE = "Limits and verdicts of joints in uncoupled parts"
LIMITS = ("λ_U", "λ_E", "λ_S", "λ_max")
WORST = ("shakedown", "separation", "cyclic-slip", "ratchetting", "undecided")
AGREE = {1: 1e-6, 2: 2e-4}  # of limits, by the number of directions: λ_S of discs is known to four digits
CYCLES = 200
FORCES = ("q_w", "p_w", "q_mean", "p_mean")


def cases(short: bool) -> list[dict]:
    joints = 2 if short else 50
    return [
        {"joint": joint, "decades": decades, "joints": joints}
        for joint in ("plane", "space")
        for decades in (-3, 0, 3)
    ]


def measure(case: dict) -> dict:
    counts = dict.fromkeys(("drawn", *LIMITS, "refused", "outcomes", "slips", "walks"), 0)
    for number in range(case["joints"]):
        parts = pair(case["joint"], number, case["decades"])
        whole = joined(parts)
        counts["drawn"] += 1
        for name in LIMITS:
            agrees = _limits_agree(name, parts, whole)
            counts["refused"] += agrees is None
            counts[name] += agrees is False
        load_factor = float(np.random.default_rng(number).uniform(0.3, 1.6))
        of_parts = [shakedown.long_term_state(part, load_factor, max_cycles=CYCLES) for part in parts]
        found = shakedown.long_term_state(whole, load_factor, max_cycles=CYCLES)
        counts["outcomes"] += found.outcome != max((each.outcome for each in of_parts), key=WORST.index)
        if found.period:
            counts["slips"] += not _slips_agree(found, of_parts)
            counts["walks"] += not _walk_agrees(found)
    return counts


def pair(joint: str, number: int, decades: int) -> list[Problem]:
    """Two drawn joints with as many load steps, the second one in other units."""
    drawn = drawn_joint if joint == "plane" else drawn_joint_in_space
    found = [drawn(9, 2 * number + k) for k in (0, 1)]
    m, normal = min(each.m for each in found), all(each.C is not None for each in found)
    first, second = (_cut(each, m, normal) for each in found)
    length, force = 10.0**decades, 10.0**decades if number % 2 else 1.0
    return [first, in_units(second, length, force)]


def _cut(problem: Problem, m: int, normal: bool) -> Problem:
    """A joint with the first load steps of its loop alone, and their mean where it has none of its own."""
    q_w, p_w = problem.q_w[:m], problem.p_w[:m]
    return Problem(
        A=problem.A,
        B=problem.B,
        C=problem.C if normal else None,
        f=problem.f,
        q_w=q_w,
        p_w=p_w,
        q_mean=q_w.mean(axis=0) if problem.q_mean is None else problem.q_mean,
        p_mean=p_w.mean(axis=0) if problem.p_mean is None else problem.p_mean,
    )


def in_units(problem: Problem, length: float, force: float) -> Problem:
    """A joint whose lengths and forces are so many times as large."""
    stiffness = {key: getattr(problem, key) for key in ("A", "B", "C")}
    loads = {key: force * getattr(problem, key) for key in FORCES}
    return replace(
        problem,
        **{key: None if block is None else force / length * block for key, block in stiffness.items()},
        **loads,
    )


def joined(parts: list[Problem]) -> Problem:
    """One joint of several that nothing couples."""
    stiffness = {key: [getattr(part, key) for part in parts] for key in ("A", "B", "C")}
    return Problem(
        **{key: None if blocks[0] is None else block_diag(*blocks) for key, blocks in stiffness.items()},
        **{key: np.concatenate([getattr(part, key) for part in parts], axis=-1) for key in ("f", *FORCES)},
    )


def _limits_agree(name: str, parts: list[Problem], whole: Problem) -> bool | None:
    """Whether a limit is the least of those of the parts; None where there is no answer."""
    try:
        least = min(_limit(name, part) for part in parts)
        found = _limit(name, whole)
    except shakedown.ShakedownError:
        return None
    return bool(found == least or abs(found - least) <= AGREE[whole.directions] * abs(least))


def _limit(name: str, problem: Problem) -> float:
    """A limit; below zero where nothing is proved, or no slip is safe."""
    if name in ("λ_S", "λ_U"):
        found = {"λ_S": shakedown.accumulated_bound, "λ_U": shakedown.universal_bound}[name](problem)
    else:
        bounds = {"λ_E": shakedown.energy_bound, "λ_max": shakedown.upper_bound}
        found = bounds[name](problem, certify=False)
    nothing = np.isnan(found.load_factor) or getattr(found, "least_load_factor", 0.0) > found.load_factor
    return -1.0 if nothing else found.load_factor


def _slips_agree(found: shakedown.LongTermState, of_parts: list[shakedown.LongTermState]) -> bool:
    """Whether slip and drift per cycle are those of the parts, each relative to its own."""
    first = 0
    for each in of_parts:
        n, d = each.problem.n, each.problem.directions
        own = found.slip_per_cycle[first : first + n] / found.period, found.drift[d * first : d * (first + n)]
        alone = each.slip_per_cycle / each.period, each.drift / each.period
        size = 1e-6 * np.abs(alone[0]).max()
        if np.abs(own[0] - alone[0]).max() > size or np.abs(own[1] / found.period - alone[1]).max() > size:
            return False
        first += n
    return True


def _walk_agrees(found: shakedown.LongTermState) -> bool:
    """Whether the whole joint slips as it is said to in a period from the state found."""
    motion: Evolution = found.motion()
    records = [motion.cycle() for _ in range(found.period)]
    if any(record is None for record in records):
        return False
    slip = np.sum([record.slip for record in records if record is not None], axis=0)
    least = np.abs(found.final_slip).max() * 1e-6
    return bool(np.abs(slip - found.slip_per_cycle).max() <= 1e-4 * slip.max() + least)


def tables(rows: list[dict]) -> str:
    words = ("drawn", *LIMITS, "refused", "outcomes", "slips", "walks")
    lines = [[row["joint"], f"1e{row['decades']}", *(str(row[word]) for word in words)] for row in rows]
    head = [
        "joints in",
        "times the lengths of the other",
        "drawn",
        *(f"{name} not the least" for name in LIMITS),
    ]
    return table([*head, "refused", "other outcome", "other slip", "other walk"], lines)


def figures(rows: list[dict]) -> dict:
    return {}
