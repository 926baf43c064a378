"""What leads from a joint back to its model, and what its loads are: kept, checked, taken along, said in words."""

import json
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import shakedown
from shakedown import LoadCase, Problem, ProblemError, condense, load_problem, save_problem
from shakedown.joint.constraints import loading, with_initial_gap
from shakedown.joint.contact_zone import contact_zone
from shakedown.joint.units import LoadUnit, load_units, loads_in_words, units_at, units_of
from shakedown.report.data_facts import headline, joint_facts
from shakedown.studies.design_point import with_parameter

JOINT = shakedown.example("two-node")
DOMAIN = replace(JOINT, load_path="domain")
SOURCE = json.dumps(
    {"command": "shakedown-bounds import c.toml", "files": [{"name": "k.mtx", "sha256": "0" * 64}]}
)


def traced(**changes) -> Problem:
    """Two nodes of which everything is known."""
    more = {
        "label": ["4711/12", "4712/13"],
        "coordinates": [[0.0, 1.0, 0.0], [2.0, 1.0, 0.0]],
        "normal": [[0.0, 1.0, 0.0], [0.6, 0.8, 0.0]],
        "tangent": [[1.0, 0.0, 0.0], [0.8, -0.6, 0.0]],
        "node_area": [0.5, 0.0],
        "load_names": ["bolt", "traction"],
        "load_mean": [12.0, 20.0],
        "load_amplitude": [0.0, 20.0],
        "load_units": ["kN", "MPa"],
        "source": SOURCE,
        "x": [0.0, 2.0],
    }
    return replace(JOINT, **(more | changes))


def test_a_file_without_a_source_has_no_key_that_earlier_versions_refuse(tmp_path):
    save_problem(tmp_path / "p.npz", JOINT)
    newer = {"source", "label", "node_area", "load_names", "load_mean", "load_units", "load_path"}
    with np.load(tmp_path / "p.npz", allow_pickle=False) as file:
        assert not newer & set(file.files)
    assert (JOINT.load_path, JOINT.is_domain) == ("loop", False)
    assert "load_path" not in JOINT.to_dict()


DAMAGED = {
    "too few labels": ({"label": ["a"]}, "key 'label': expected shape (2,), found (1,)"),
    "labels that are no text": ({"label": [1.5, 2.5]}, "key 'label': expected one text each"),
    "one label": ({"label": "a"}, "key 'label': expected one text each, found 'a'"),
    "a label that a terminal obeys": ({"label": ["a", "\x1b[2J"]}, "found '\\x1b[2J' at label[1]"),
    "a label too long": ({"label": ["a", "7" * 201]}, "text of at most 200 characters that can be shown"),
    "a label of two lines": ({"label": ["a", "b\nc"]}, "text of at most 200 characters that can be shown"),
    "a load without a showable name": ({"load_names": ["\x00b"]}, "key 'load_names': expected text of at most 200 characters"),
    "no load": ({"load_names": []}, "key 'load_names': expected one text each"),
    "a load of negative amplitude": ({"load_amplitude": [0.0, -20.0]}, "key 'load_amplitude': expected amplitudes >= 0, found -20 at load 1"),
    "a load whose mean is no number": ({"load_mean": [1.0, np.nan]}, "key 'load_mean': expected finite numbers, found nan at load_mean[1]"),
    "a mean without an amplitude": ({"load_amplitude": None}, "key 'load_amplitude': required because 'load_mean' is given"),
    "units without loads": ({"load_mean": None, "load_amplitude": None}, "key 'load_mean': required because 'load_units' is given"),
    "loads without names": ({"load_names": None}, "key 'load_names': required because 'load_mean' is given"),
    "a negative area": ({"node_area": [0.5, -1e-9]}, "key 'node_area': expected areas >= 0, found -1e-09 at node 1"),
    "places in the plane": ({"coordinates": np.zeros((2, 2))}, "key 'coordinates': expected shape (2, 3), found (2, 2)"),
    "a normal of length 2": ({"normal": [[0, 2, 0], [0, 1, 0]]}, "key 'normal': expected vectors of length 1, found the length 2 at node 0"),
    "a source that is no JSON": ({"source": "import c.toml"}, "key 'source': expected JSON text"),
    "a source with NaN": ({"source": '{"a": NaN}'}, "key 'source': expected JSON text"),
    "a source too deep": ({"source": '{"a":' + "[" * 100_000 + "]" * 100_000 + "}"}, "key 'source': expected JSON text"),
    "warnings that are none": ({"source": '{"warnings": [1]}'}, "key 'source': expected JSON text, an object"),
}  # fmt: skip


@pytest.mark.parametrize("kind", DAMAGED)
def test_damaged_values_are_refused_in_one_line(kind):
    changes, message = DAMAGED[kind]
    with pytest.raises(ProblemError) as caught:
        traced(**changes)
    assert message in str(caught.value)
    assert len(str(caught.value)) < 400
    assert str(caught.value).isprintable()


def test_a_problem_of_some_of_the_nodes_knows_which():
    problem = traced()
    zone = contact_zone(problem, [0]).joint
    assert zone.label == ("4712/13",)
    assert zone.coordinates.tolist() == [[2.0, 1.0, 0.0]]
    assert zone.node_area.tolist() == [0.0]
    assert zone.source == SOURCE
    assert zone.loads == problem.loads == (("bolt", 12.0, 0.0, "kN"), ("traction", 20.0, 20.0, "MPa"))
    tight = with_initial_gap(problem, -1e-3)
    assert tight.label == problem.label
    assert np.array_equal(tight.normal, problem.normal)


def test_a_factor_on_the_loading_is_one_on_the_loads():
    problem = traced()
    half, twice = with_parameter(problem, "amplitude", 0.5), with_parameter(problem, "mean", 2.0)
    assert [load[1:3] for load in half.loads] == [(12, 0), (20, 10)]
    assert [load[1:3] for load in twice.loads] == [(24, 0), (40, 20)]


@pytest.mark.parametrize("key", ["label", "coordinates", "node_area", "load_units", "source", "x"])
def test_equality_sees_every_field_and_never_raises(key):
    other = replace(traced(), **{key: "" if key == "source" else None})
    assert traced() == traced()
    assert traced() != other
    assert other != traced()
    assert traced() != "two-node"


def test_round_off_of_the_mean_of_a_constant_load_is_no_load():
    constant = Problem(A=[[1.0]], B=[[0.0]], f=0.5, q_w=[[0.1]] * 3, p_w=[[0.7]] * 3)
    assert (constant.q_w != constant.q_w.mean(axis=0)).any()
    loop = loading(constant)
    assert not loop.q1.any()
    assert not loop.p1.any()


def test_a_domain_survives_the_round_trip(tmp_path):
    save_problem(tmp_path / "domain.npz", DOMAIN)
    again = load_problem(tmp_path / "domain.npz")
    assert again == DOMAIN != JOINT
    assert again.is_domain
    assert again.to_dict()["load_path"] == "domain"
    assert "load domain" in repr(again)
    assert again.fingerprint != JOINT.fingerprint


def test_parts_of_a_joint_keep_it():
    assert contact_zone(DOMAIN, [1]).joint.is_domain


def test_loads_with_ranges_make_a_domain_and_histories_a_loop():
    K, dofs = np.diag(np.full(4, 5.0)) - 1.0, [(n, d) for n in (1, 2) for d in (1, 2)]

    def made(*loads: LoadCase) -> Problem:
        return condense(K, dofs, [1], [0, 1], loads, 0.3, fixed=[2, 3], allow_sparse=True)

    dead, force = LoadCase(history=1.0, force=[0.0, -9.0, 0.0, 0.0]), [1.0, 0.0, 0.0, 0.0]
    assert made(dead, LoadCase(range=(-1, 1), force=force)).load_path == "domain"
    assert made(dead, LoadCase(history=[-1, 1], force=force)).load_path == "loop"


def joint(names, means, amplitudes, units=None):
    loads = {"load_names": names, "load_mean": means, "load_amplitude": amplitudes, "load_units": units}
    return replace(JOINT, **loads)


AXIAL = joint(["bolt preload", "axial load"], [12, 20], [0, 20], ["kN", "kN"])


@pytest.mark.parametrize(
    ("load_factor", "rounding", "words"),
    [
        (1.0, "nearest", "axial load 20 ± 20 kN; bolt preload 12 kN, unchanged"),
        (1.27, "up", "axial load 20 ± 25.4 kN; bolt preload 12 kN, unchanged"),  # and not 25.41: it is exact
        (1.2749, "down", "axial load 20 ± 25.49 kN; bolt preload 12 kN, unchanged"),
        (1.2701, "up", "axial load 20 ± 25.41 kN; bolt preload 12 kN, unchanged"),
        (0.0, "down", "axial load 20 ± 0 kN; bolt preload 12 kN, unchanged"),
        (np.inf, "up", "axial load 20 kN with any amplitude; bolt preload 12 kN, unchanged"),
        (np.nan, "up", ""),
    ],
)
def test_lambda_scales_the_amplitude_only(load_factor, rounding, words):
    assert loads_in_words(AXIAL, load_factor, rounding) == words


def test_rounded_numbers_stay_on_the_safe_side():
    """What is safe is never said to be larger than it is, what is impossible never smaller."""
    rng = np.random.default_rng(1)
    for exponent, value in zip(rng.uniform(-8, 8, 60), rng.uniform(1, 10, 60), strict=True):
        amplitude = float(value * 10**exponent)
        load_factor = float(rng.uniform(0.01, 3))
        exact = Fraction(repr(load_factor)) * Fraction(repr(amplitude))
        one = joint(["load"], [0.0], [amplitude], ["N"])
        words = [loads_in_words(one, load_factor, way) for way in ("down", "up")]
        down, up = (Fraction(text.removeprefix("load ± ").removesuffix(" N")) for text in words)
        assert down <= exact <= up
        assert exact * Fraction(98, 100) < down
        assert up < exact * Fraction(102, 100)


@pytest.mark.parametrize(
    ("units", "stress"),
    [
        *((units, "GPa") for units in ("mN, um", "mN, µm", "kN, mm", "GN, m")),
        *((units, "MPa") for units in ("N, mm", "MN, m")),
        *((units, "kPa") for units in ("kN, m", "GN, km")),
        *(
            (units, units.replace(", ", "/") + "²")
            for units in ("N, cm", "daN, mm", "kgf, mm", "lbf, in", "kip, ft")
        ),
    ],
)
def test_a_pascal_has_its_prefix_where_there_is_one(units, stress):
    assert units_of(replace(JOINT, units=units)).stress == stress


def test_numbers_are_written_without_exponents():
    assert loads_in_words(joint(["a"], [1250.0], [123456.0], ["N"]), 1.0, "down") == "a 1250 ± 123400 N"
    assert loads_in_words(joint(["a"], [-0.5], [0.00125])) == "a -0.5 ± 0.00125"
    assert loads_in_words(joint(["a"], [0.0], [2e12]), 1.0, "up") == "a ± 2e+12"


@pytest.mark.parametrize("load_factor", [0.0, 1.0, 2.5])
def test_units_of_each_load_make_the_loads_at_every_load_factor(load_factor):
    """With means of its own, and a load that does not reach the contact."""
    unit = [[1.0, 2.0, 0.5, 0.0], [0.0, -1.0, 3.0, 4.0], [0.0] * 4]
    history = [[1.0, 0, 5], [2, -1, 5], [0, 4, 5]]
    welded = np.array(history) @ unit
    mean = np.array([0.3, 0.7, -0.2, 4.0]) @ np.linalg.pinv(unit[:2]) @ unit[:2]
    loads = {"q_w": welded[:, :2], "p_w": welded[:, 2:], "q_mean": mean[:2], "p_mean": mean[2:]}
    acting = {"load_reactions": unit, "load_history": history}
    joint = Problem(A=2 * np.eye(2), B=np.zeros((2, 2)), f=0.5, **loads, **acting)
    q, p = loading(joint).at(load_factor)
    np.testing.assert_allclose(units_at(joint, load_factor) @ unit, np.hstack([q, p]), atol=1e-13)
    for name, at in (("amplitude", (load_factor, 1.0)), ("mean", (1.0, load_factor))):
        changed = with_parameter(joint, name, load_factor)
        np.testing.assert_allclose(units_at(changed, 1.0), units_at(joint, *at), atol=1e-13)


def test_a_load_that_is_never_there_has_no_unit_of_its_own():
    one = Problem(A=[[2.0]], B=[[0.0]], f=0.5, q_w=[[1.0], [-1.0]], p_w=[[3.0], [3.0]], units="N, mm")
    said = {"load_mean": [0.0, 0.0], "load_amplitude": [3.0, 5.0], "load_units": ["kN", "K"]}
    acting = {"load_reactions": [[1.0, 0.0], [1.0, 1.0]], "load_history": [[1.0, 0.0], [-1.0, 0.0]]}
    push, heat = load_units(replace(one, load_names=["push", "heat"], **said, **acting))
    assert (push.size, push.load, heat) == (3000.0, "N", LoadUnit())


def test_the_report_says_the_loads_where_they_are_known():
    assert "loads at λ = 1: axial load 20 ± 20 kN; bolt preload 12 kN, unchanged" in headline(AXIAL)
    bare = replace(AXIAL, load_mean=None, load_amplitude=None, load_units=None)
    assert loads_in_words(bare) == loads_in_words(JOINT) == ""
    (cases,) = [each.shown for each in joint_facts(bare) if each.label == "load cases"]
    assert cases == "bolt preload, axial load"
