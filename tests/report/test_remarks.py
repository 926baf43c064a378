"""What the report says beside an outcome."""

import shakedown
from shakedown.report.json_documents import simulation_document
from shakedown.report.page_tables import remarks


def test_jumps_open_nodes_and_proof_are_told():
    jumping = shakedown.simulate(shakedown.example("one-node-separation"), 1.0)
    assert remarks(jumping) == " (jumps per cycle: 1, damping takes 0.4048)"
    proved = shakedown.simulate(shakedown.example("two-node"), 0.5)
    assert remarks(proved) == " (proved)"
    apart = shakedown.Problem(A=[[1.0]], B=[[0.0]], C=[[1.0]], f=0.5, q_w=[[0.0]], p_w=[[-1.0]])
    assert remarks(shakedown.simulate(apart, 1.0)) == " (open throughout: node 0)"
    cycling = shakedown.simulate(shakedown.example("two-node"), 1.0)
    assert remarks(cycling) == ""


def test_the_document_of_a_simulation_tells_friction_from_jumps():
    document = simulation_document(shakedown.simulate(shakedown.example("one-node-separation"), 1.0))
    parts = document["friction_dissipation_per_cycle"] + document["jump_dissipation_per_cycle"]
    assert document["dissipation_per_cycle"] == parts
    assert (document["jumps_per_cycle"], document["open_nodes"], document["proved"]) == (1.0, [], False)
    assert document["energy_margin"] is None
    stepped = shakedown.simulate(shakedown.example("two-node"), 1.0, method="gauss-seidel")
    assert simulation_document(stepped)["jumps_per_cycle"] is None
