"""Which numbers converge with the mesh: verdicts of known sequences, tables, runs that are killed."""

from itertools import product

import numpy as np
import pytest
from command import document, run

import shakedown
from benchmarks.refinement import block_on_plane
from shakedown import plot
from shakedown.assessment.transient_limit import slip_limit
from shakedown.ground.shown_values import plain
from shakedown.report.study_facts import refinement_sheet
from shakedown.studies.refined import COLUMNS, SLOWEST, Refinement, trend

H = 2.0 ** -np.arange(5)
UNEVEN = np.array([1.0, 0.8, 0.41, 0.3])


@pytest.mark.parametrize("h", [H, UNEVEN])
@pytest.mark.parametrize(("order", "share"), [(0.6, -0.1), (1.0, 0.2), (2.0, -0.5), (4.0, 1.0)])
def test_what_converges_has_its_limit_and_order(h, order, share):
    found = trend(h, 7.0 * (1 + share * h**order))
    assert found.verdict == "converges"
    assert found.limit == pytest.approx(7.0, rel=1e-6)
    assert np.isnan(found.order) or found.order == pytest.approx(order, rel=1e-5)


@pytest.mark.parametrize("power", [0.05, 0.1, 0.24, 0.5, 0.9, 1.5])
def test_a_power_of_the_element_size_has_no_limit(power):
    for h in (H, UNEVEN):
        fallen, grown = trend(h, 3.0 * h**power), trend(h, 3.0 * h**-power)
        assert (fallen.verdict, grown.verdict) == ("falls", "grows")
        assert fallen.order == pytest.approx(power) == -grown.order
        assert np.isnan([fallen.limit, grown.limit]).all()


def test_what_changes_by_a_constant_amount_falls_to_zero():
    assert trend(H, np.array([3.0, 2.3, 1.6, 0.9, 0.2])).verdict == "falls"
    for last in ([1.2, 0.3, 0.0], [1.2, 0.0, 0.0]):
        assert trend(H, np.array([3.0, 2.1, *last])).verdict == "falls"


def test_what_is_zero_on_all_meshes_has_no_limit():
    for count in (2, 3, 5):
        found = trend(H[:count], np.zeros(count))
        assert found.verdict == "zero"
        assert np.isnan(found.limit)


def test_elements_not_nodes_tell_the_order():
    for power, directions in product((0.4, 1.0, 2.0), (1, 2)):
        edge = np.array([2, 4, 8])
        values = {"work": 1.0 + 0.3 / edge**power}
        meshes = edge, (edge + 1) ** directions, directions, values, edge**directions
        found = Refinement(1.0, None, None, *meshes)
        trend_of_it = found.trends["work"]
        if power < SLOWEST:
            assert trend_of_it.verdict == "undecided"
        else:
            assert trend_of_it.limit == pytest.approx(1.0, rel=1e-9)
            assert trend_of_it.order == pytest.approx(power, rel=1e-6)


@pytest.mark.parametrize(("order", "words"), [(0.52, "converges slowly"), (0.9, "converges")])
def test_slow_convergence_is_called_slow(order, words):
    """At order 0.52 an element half as large leaves 70 % of the error."""
    numbers = dict.fromkeys(COLUMNS, np.full(3, np.nan)) | {"impossible_above": 3.0 + 0.2 * H[:3] ** order}
    found = Refinement(1.0, None, None, H[:3], np.array([2, 3, 5]), 1, numbers, 1.0 / H[:3])
    table = refinement_sheet(shakedown.example("block-9"), found).sections[0].tables[0]
    assert [row[-3] for row in table.rows if row[0] == "impossible above"] == [words]


def test_too_little_to_tell():
    assert trend(H[:2], np.array([1.0, 0.9])).verdict == "undecided"
    for values in ([1, 1, 1, np.inf, np.inf], [1, 1, np.inf, 1, 1], [1, 1.2, 1.0, 1.2, 1.0]):
        assert trend(H, np.array(values)).verdict == "undecided"
    for h in ([1.0, 1.0, 0.5], [1.0, 0.5, 0.5]):
        assert trend(np.array(h), np.array([1.0, 0.8, 0.799])).verdict == "undecided"
    assert trend(np.array([np.inf, 1.0, 0.5]), np.array([1.0, 0.9, 0.85])).verdict == "undecided"
    assert trend(H, 7 + H**0.4).verdict == trend(H, H**0.01).verdict == "undecided"
    coarse = [trend(H[:3], 7 + share * H[:3] ** 4.5) for share in (3.5, 0.7)]  # no elements are as fast
    assert [f"{found.verdict} {found.order}" for found in coarse] == ["undecided nan", "converges nan"]
    level = np.array([0.36998, 0.36823, 0.36511])  # within 1.3 %, the last change the larger one
    assert trend(np.array([210, 351, 528]) ** -0.5, level).verdict == "undecided"


def by_dozen(size):
    return block_on_plane(2 * size, 0.2)


@pytest.fixture(scope="module")
def found():
    return shakedown.refine(by_dozen, [2, 4, 8], radius=0.5, load_factor=2.0, slip_below=1e-4)


def test_the_block_below_the_critical_friction(found):
    table = found.table()
    assert list(table) == [
        "size",
        "nodes",
        *COLUMNS,
        "directions",
        "elements",
        "load_factor",
        "radius",
        "slip_below",
    ]
    assert table["nodes"].tolist() == [5, 9, 17]
    assert found.verdict["impossible_above"] == "falls"
    assert 0.084 < found.order["impossible_above"] < 0.13  # from above: Williams
    assert found.verdict["averaged_impossible_above"] == "converges"
    assert table["averaged_impossible_above"][0] == table["impossible_above"][0]
    assert table["slip_limit"][1] == slip_limit(by_dozen(4), 1e-4).load_factor
    assert found.to_frame().shape == (3, len(table))
    assert set(found.to_dict()) == {
        "load_factor",
        "radius",
        "slip_below",
        "table",
        "verdict",
        "limit",
        "order",
    }
    assert plot.refinement(found).get_ylim()[0] == 0.0


@pytest.mark.slow
def test_the_command_says_the_same(found, tmp_path):
    paths = [str(tmp_path / f"{size}.npz") for size in (2, 4)]
    for path, size in zip(paths, (2, 4), strict=True):
        shakedown.save_problem(path, by_dozen(size))
    words = ("refine", *paths, "--average", "0.5", "--load-factor", "2", "--slip-below", "1e-4")
    told = document(*words)
    for name in COLUMNS:
        assert told["table"][name] == plain(found.numbers[name][:2])
    code, out, _ = run(*words, "--picture", str(tmp_path / "p.png"))
    assert code == 0
    assert "undecided" in out
    assert max(map(len, out.splitlines())) <= 80
    assert run("refine", *reversed(paths))[::2] == (
        2,
        "shakedown-bounds: meshes: expected one joint, the coarsest first, found [9, 5] contact nodes\n",
    )


def loose_chain(n):
    """Nodes in a row with a spring from each to the next, which only friction holds."""
    springs, wave = np.eye(n, k=1) + np.eye(n, k=-1), np.arange(6)[:, None] + np.linspace(0.0, 2.0, n)
    A, nothing = np.diag(springs.sum(axis=1)) - springs, np.zeros((n, n))
    return shakedown.Problem(A=A, B=nothing, f=0.5, q_w=np.sin(wave), p_w=4.0 + np.cos(wave))


def test_where_friction_alone_holds_creep_has_its_columns(tmp_path):
    found = shakedown.refine(loose_chain, [3, 5])
    limits = [shakedown.creep_limit(loose_chain(n)) for n in (3, 5)]
    assert found.numbers["creep"].tolist() == [limit.load_factor for limit in limits]
    assert found.numbers["creep_proved"].tolist() == [limit.proved for limit in limits]
    rows = refinement_sheet(loose_chain(5), found).sections[0].tables[0].rows
    assert [row[0] for row in rows][-2:] == ["least seen to creep", "no creep below"]
    assert "creep proved: " + found.verdict["creep_proved"] in [
        line.get_label() for line in plot.refinement(found).lines
    ]
