"""A shrink fit from its deck to pressures: as CalculiX has them with contact of its own."""

import re

import numpy as np
import pytest
from model_files import FIT

import shakedown

ENDS, INSIDE = [0, 4], [1, 2, 3]


def printed(path):
    """Contact pressures by hub node at the end of every step."""
    steps = []
    for line in path.read_text().splitlines():
        fields = line.split()
        if line.lstrip().startswith("contact stress"):
            steps.append({})
        elif re.fullmatch(r"\d+", fields[0] if fields else ""):
            steps[-1][int(fields[0])] = float(fields[1])
    return steps


@pytest.mark.parametrize(("step", "kelvin"), [(0, 0.0), (1, 20.0)], ids=["assembled", "heated"])
def test_pressures_are_those_of_contact_in_calculix(step, kelvin):
    made = shakedown.import_model(FIT / "import.toml", changes={"load.1.history": kelvin / 20.0})
    problem = made.problem
    assert made.contact.gap == pytest.approx(-0.012, rel=1e-9)
    assert [load.mean for load in problem.loads] == [kelvin]
    nodes = shakedown.node_results(shakedown.simulate(problem, 0.0))
    theirs = np.array(
        [printed(FIT / "contact.dat")[step][int(name.partition("/")[0])] for name in nodes.label]
    )
    theirs[ENDS] *= 2
    assert nodes.units["pressure_max"] == "MPa"
    np.testing.assert_allclose(nodes.pressure_max, theirs, rtol=5e-4)
    # of the interference: the load steps are alike but for round-off
    assert nodes.slip_range.max() <= 1e-15 * 0.012
    assert theirs[INSIDE].min() > 15
