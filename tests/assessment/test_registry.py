"""A new kind of bound needs its function and one entry: it is in assessments, documents, pages and sweeps then."""

import json
import re
import sys
from dataclasses import dataclass
from types import ModuleType
from typing import ClassVar

import numpy as np
import pytest
from command import run

import shakedown
from shakedown.bounds.bound_result import Evidence
from shakedown.bounds.registry import BOUNDS, BoundKind, Claim, kinds_of
from shakedown.ground.status import Status


@dataclass(frozen=True, eq=False, repr=False)
class OfTwo(Evidence):
    """Evidence of a bound that is a share of another."""

    DOCUMENT: ClassVar[str] = "load_factor status share"

    share: float


@pytest.fixture
def half(monkeypatch):
    """A bound for the state asked about, between what is proved of it and λ_max."""
    module = ModuleType("half_way")

    def of_joint(limits):
        load_factor = 0.5 * (limits.accumulated.load_factor + limits.upper.load_factor)
        return shakedown.Bound("half", Status.OPTIMAL, load_factor, OfTwo(0.5))

    module.of_joint = of_joint
    monkeypatch.setitem(sys.modules, "half_way", module)
    kind = BoundKind("half", "λ_H", "half way", Claim.THIS_STATE, "half_way:of_joint")
    monkeypatch.setitem(BOUNDS, "half", kind)
    return kind


def test_a_new_kind_takes_part_in_what_is_proved(half):
    found = shakedown.assess(shakedown.example("two-node"))
    bound = found.details.half
    assert (bound.symbol, bound.share, half in kinds_of(Claim.THIS_STATE)) == ("λ_H", 0.5, True)
    assert found.proved_from_this_state == bound.load_factor > found.details.accumulated.load_factor
    assert found.details.from_state.kind == "half"


def test_a_new_kind_stands_in_documents_tables_sweeps_and_pictures(half):
    code, text, _ = run("solve", "two-node", "--json")
    said = json.loads(text)
    assert code == 0
    assert set(said["half"]) == {"load_factor", "status", "share"}
    assert said["assessment"]["proved_from_this_state"] == said["half"]["load_factor"]
    assert re.search(r"λ_H +half way +0\.7353", run("solve", "two-node", "--details")[1])
    found = shakedown.sweep(shakedown.example("two-node"), {"f": [0.3, 0.35]}, bounds=("half", "upper"))
    assert found.load_factors("half")[1] == pytest.approx(said["half"]["load_factor"], rel=1e-12)
    assert "lambda_H [1]" in found.columns()
    labels = [line.get_label() for line in shakedown.plot.regions(found).get_lines()]
    assert "λ_H, half way" in labels


def test_what_refutes_a_new_kind_withdraws_it(half, monkeypatch):
    far = lambda limits: shakedown.Bound("half", Status.OPTIMAL, 2.0, OfTwo(2.0))  # noqa: E731
    monkeypatch.setattr(sys.modules["half_way"], "of_joint", far)
    limits = shakedown.assess(shakedown.example("two-node")).details
    assert limits.half.undecided
    assert np.isnan(limits.half.load_factor)
    assert limits.from_state.kind == "accumulated"


def test_a_bound_has_its_evidence_and_says_what_it_has_not():
    bound = shakedown.energy_bound(shakedown.example("two-node"))
    assert bound.radius == bound.evidence.radius > 0
    assert bound.but(radius=1.0, load_factor=0.5).evidence.radius == 1.0
    with pytest.raises(AttributeError, match="kind 'energy' has no 'collapse_limits'"):
        _ = bound.collapse_limits


@pytest.mark.parametrize("name", ["two-node", "one-node-3d"])
def test_every_kind_is_computed_or_says_why_not(name):
    limits = shakedown.assess(shakedown.example(name)).details
    for kind in BOUNDS.values():
        found = getattr(limits, kind.name)
        if kind.exists_for(limits.problem):
            assert (found.kind, found.symbol) == (kind.name, kind.symbol)
        else:
            assert found.reason == kind.absent
