"""One mesh tells whether its edge decides the limits: where they fall with the mesh, and only there."""

from dataclasses import replace

import numpy as np
import pytest
from command import document, run
from joints_in_space import random_joint

import shakedown
from benchmarks.bodies.classical import press_fit
from benchmarks.bodies.sphere import sphere_on_flat
from benchmarks.refinement import block_on_plane, similar_blocks


@pytest.mark.parametrize("joint", [block_on_plane(8, 0.2), block_on_plane(8, 0.3)])
def test_it_warns_where_the_corner_slips_at_any_load(joint):
    mesh = shakedown.assess(joint).details.mesh
    assert mesh.edge_share > 0.7
    assert sorted(mesh.edge_nodes) == [0, joint.n - 1]
    assert mesh.coarser["impossible_above"] > 0.1
    assert mesh.warning.startswith("The edge determines λ_max (node 0, 8). ")
    change = f"{100 * mesh.coarser['impossible_above']:.0f} % higher"
    assert f"On the coarser mesh (every second node) impossible above is {change}, " in mesh.warning
    assert mesh.warning.endswith("; a finer mesh may lower them.")


@pytest.mark.slow
def test_a_round_rim_decides_although_no_node_of_it_does_alone():
    mesh = shakedown.assess(sphere_on_flat(3)).details.mesh
    assert mesh.edge_share > 0.99
    assert mesh.edge_nodes == ()
    assert mesh.warning.startswith("The edge determines λ_max. ")


def test_what_is_zero_already_does_not_get_lower():
    mesh = shakedown.assess(shakedown.example("block-9")).details.mesh
    assert mesh.coarser["proved_from_every_state"] == np.inf
    assert "proved from every state is positive, here 0." in mesh.warning


@pytest.mark.parametrize("joint", [press_fit(1), similar_blocks(8, 0.3)])
def test_it_says_nothing_where_limits_converge(joint):
    mesh = shakedown.assess(joint).details.mesh
    assert mesh.edge_share < 0.01
    assert set(mesh.coarser) == {"impossible_above", "proved_from_this_state", "proved_from_every_state"}
    assert max(map(abs, mesh.coarser.values())) < 0.1
    assert mesh.warning is None


def test_it_is_silent_where_nodes_are_few_or_nowhere():
    for joint in (shakedown.example("two-node"), block_on_plane(4, 0.2), replace(press_fit(1), x=None)):
        mesh = shakedown.assess(joint).details.mesh
        assert np.isnan(mesh.edge_share)
        assert (mesh.coarser, mesh.warning) == ({}, None)


@pytest.mark.parametrize(("side", "tells"), [(3, False), (4, True)])
def test_of_a_patch_sixteen_nodes_make_a_coarser_mesh(side, tells):
    x = np.stack(np.meshgrid(*[np.arange(float(side))] * 2), axis=-1).reshape(-1, 2)
    joint = replace(random_joint(np.random.default_rng(0), side**2), x=x)
    assert np.isfinite(shakedown.assess(joint).details.mesh.edge_share) == tells


def test_the_command_tells_it(tmp_path):
    path = str(tmp_path / "block.npz")
    shakedown.save_problem(path, block_on_plane(8, 0.2))
    said = document("solve", path, "--average", "0.5")
    assert set(said["mesh"]) == {"edge_share", "coarser", "warning"}
    assert said["averaged"]["nodes"] == 5
    twice = said["averaged"]["impossible_above"] / said["assessment"]["impossible_above"] - 1
    assert said["mesh"]["coarser"]["impossible_above"] == pytest.approx(twice, rel=1e-9)
    out = " ".join(run("solve", path, "--average", "0.5")[1].split())
    assert said["mesh"]["warning"] in out
    assert "Averaged over 0.5: 5 knots" in out


def test_the_three_numbers_of_an_averaged_joint_are_about_the_averaged_state():
    joint = block_on_plane(8, 0.3)
    rough = 1e-5 * np.random.default_rng(0).normal(size=9)
    found = shakedown.assess(joint, rough).averaged(0.5)
    between = shakedown.averaged(replace(joint, initial_slip=rough), 0.5)
    again = shakedown.assess(between, between.initial_slip[0])
    assert found.proved_from_this_state == pytest.approx(again.proved_from_this_state, rel=1e-9)
