"""The page of a joint with two tangential directions: every section, its own pictures, no empty panel."""

import json
from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown.ground.status import OPEN, SLIP
from shakedown.report.data_facts import source_facts
from shakedown.report.html import instants, render

JOINT = shakedown.example("one-node-3d")


@pytest.fixture(scope="module")
def verification():
    return shakedown.verify(JOINT, load_factors=[1.4], random_states=0)


def test_the_page_has_orbits_and_zones_in_place_of_what_the_plane_has(verification, undrawn):
    page = render(verification)
    for words in (
        "Slip orbits of the nodes",
        "What sticks, slips and is open",
        "Normal reactions, and use of friction",
    ):
        assert words in page
    for absent in ("Hysteresis", "first collapse", "no wedging", "subsets", "f threshold"):
        assert absent not in page
    assert "1 node (3-D), 24 load steps" in page
    assert "There is no view to turn: the problem does not say where its nodes are." in page
    assert "<script" not in page  # its node has no place


def test_instants_show_what_opens_where_as_many_nodes_slip_at_others():
    """Nodes 17 and 23 of this state are open for 6 to 7 % of the period, one at a time, and slip before."""
    path = shakedown.long_term_state(shakedown.example("bolted-flange"), 1.764).history
    shown = path.at(np.array(instants(path))).state
    assert (shown == OPEN).any()
    assert (shown == SLIP).any()


def test_loads_bolts_and_all_three_extents_are_told():
    source = {
        "bolts": [{"head": "washer", "preload": 12e3, "stiffness": 2e5, "history": 1.0}],
        "bodies": [
            {
                "mesh": {"elements": 2, "x": [0, 1], "y": [0, 2], "z": [-3, 0]},
                "loads": [
                    {"kind": kind, "value": [1.0, 0.0, 0.0]} for kind in ("Force", "Traction", "BodyForce")
                ],
            }
        ],
    }
    told = source_facts(replace(JOINT, units="N, mm", source=json.dumps(source)))
    rows = {fact.label: fact.shown for fact in told}
    assert rows["bolts"] == "head washer, preload 12000, stiffness 200000, history 1"
    for kind in ("Force", "Traction", "BodyForce"):
        assert f"kind {kind}, value (1, 0, 0)" in rows["bodies"]
    assert "x (0, 1), y (0, 2), z (-3, 0)" in rows["bodies"]
