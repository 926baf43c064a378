"""A load factor in the loads that the user knows: what is scaled, what is not, and where it is rounded to."""

import dataclasses
from fractions import Fraction

import numpy as np
import pytest

import shakedown
from shakedown.joint.units import loads_in_words
from shakedown.report.data_facts import headline, joint_facts


def joint(names, means, amplitudes, units=None):
    loads = {"load_names": names, "load_mean": means, "load_amplitude": amplitudes, "load_units": units}
    return dataclasses.replace(shakedown.example("two-node"), **loads)


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
        down, up = (
            Fraction(loads_in_words(one, load_factor, way).removeprefix("load ± ").removesuffix(" N"))
            for way in ("down", "up")
        )
        assert down <= exact <= up
        assert exact * Fraction(98, 100) < down
        assert up < exact * Fraction(102, 100)


def test_numbers_are_written_without_exponents():
    assert loads_in_words(joint(["a"], [1250.0], [123456.0], ["N"]), 1.0, "down") == "a 1250 ± 123400 N"
    assert loads_in_words(joint(["a"], [-0.5], [0.00125])) == "a -0.5 ± 0.00125"
    assert loads_in_words(joint(["a"], [0.0], [2e12]), 1.0, "up") == "a ± 2e+12"


def test_a_joint_that_does_not_say_its_loads_has_no_words():
    assert loads_in_words(shakedown.example("two-node")) == ""
    assert (
        loads_in_words(dataclasses.replace(AXIAL, load_mean=None, load_amplitude=None, load_units=None)) == ""
    )


def test_the_report_says_the_loads_where_they_are_known():
    assert "loads at λ = 1: axial load 20 ± 20 kN; bolt preload 12 kN, unchanged" in headline(AXIAL)
    bare = dataclasses.replace(AXIAL, load_mean=None, load_amplitude=None, load_units=None)
    assert [each.shown for each in joint_facts(bare) if each.label == "load cases"] == [
        "bolt preload, axial load"
    ]
