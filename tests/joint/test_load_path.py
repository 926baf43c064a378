"""The load steps are a loop in its order, or the corners of a load domain: said, stored, handed on."""

from dataclasses import replace

import numpy as np

import shakedown
from shakedown import LoadCase, Problem, condense, load_problem, save_problem
from shakedown.joint.constraints import loading
from shakedown.joint.contact_zone import contact_zone

JOINT = shakedown.example("two-node")
DOMAIN = replace(JOINT, load_path="domain")


def test_a_loop_is_the_default_and_leaves_no_key(tmp_path):
    assert (JOINT.load_path, JOINT.is_domain) == ("loop", False)
    save_problem(tmp_path / "loop.npz", JOINT)
    with np.load(tmp_path / "loop.npz") as file:
        assert "load_path" not in file.files
    assert "load_path" not in JOINT.to_dict()


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
