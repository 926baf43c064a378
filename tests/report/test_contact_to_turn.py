"""The contact to turn on the page: its numbers are those of the state, and in a browser its controls do what they say."""

import json
from dataclasses import replace

import chromium
import numpy as np
import pytest
from markupsafe import Markup

import shakedown
from shakedown.plot.patch_places import can_be_turned, patch_data
from shakedown.plot.paths import slip_of_nodes, so_far, work_of_nodes
from shakedown.report.html import environment
from tests.plot import test_patch

NAMES = ["</script>", "b", "c", "d"]
JOINT = replace(test_patch.JOINT, faces=[[0, 1, 2, 3]], node_area=np.full(4, 0.5), label=NAMES)
ASK = """(() => {
  const canvas = document.querySelector("canvas"), field = document.querySelector("select");
  const slider = document.querySelector("input"), told = document.querySelector(".told");
  const picture = () => canvas.toDataURL(), colours = () => {
    const count = {}, all = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
    for (let k = 0; k < all.length; k += 4) {
      const one = all.slice(k, k + 4).join();
      if (all[k + 3]) count[one] = (count[one] || 0) + 1;
    }
    return Object.entries(count).filter((each) => each[1] > 200).map((each) => each[0].split(",").map(Number));
  };
  const press = (key) => canvas.dispatchEvent(new KeyboardEvent("keydown", { key, cancelable: true }));
  const said = { status: colours(), hidden: document.getElementById("view").hidden, high: canvas.width };
  field.value = "1"; field.dispatchEvent(new Event("change"));
  said.slips = [];
  for (let k = 0; k <= slider.max; k++) {
    slider.value = k; slider.dispatchEvent(new Event("input")); said.slips.push(picture());
  }
  said.slips = new Set(said.slips).size; said.time = document.querySelector("output").textContent;
  press("n"); said.told = told.textContent; press("p"); said.before = told.textContent;
  const kept = picture(); press("a"); said.same = picture() === kept;
  return JSON.stringify({ ...said, wrong, fields: field.options.length, wide: document.documentElement.scrollWidth });
})()"""


@pytest.fixture(scope="module")
def state():
    return shakedown.long_term_state(JOINT, 1.4)


@pytest.fixture(scope="module")
def view(state):
    return {"data": Markup(patch_data(state)), "which": "at λ = 1.4", "name": "λ = 1.4"}


def test_a_node_that_slips_by_round_off_alone_sticks_in_the_view(state):
    still = replace(state, slip_per_cycle=1e-12 * state.slip_per_cycle)
    assert "1" in json.loads(patch_data(state))["status"]
    assert set(json.loads(patch_data(still))["status"]) == {"0"}


def test_slip_and_work_so_far_grow_from_nothing_to_those_of_the_period(state):
    times = np.linspace(state.history.cycle[0], state.history.cycle[-1], 30)
    for found, whole in zip(
        so_far(state, times), (slip_of_nodes(state, JOINT), work_of_nodes(state)), strict=True
    ):
        np.testing.assert_array_equal(found[0], 0.0)
        np.testing.assert_allclose(found[-1], whole, rtol=1e-12)
        assert (np.diff(found, axis=0) >= -1e-12 * whole.max()).all()


def test_the_page_holds_the_state_at_instants_of_its_period(state, view):
    data = json.loads(view["data"])
    assert "</script>" not in view["data"]
    times = state.history.cycle[0] + np.array(data["times"])
    at = state.history.at(np.clip(times, *state.history.cycle[[0, -1]]))
    assert data["status"] == "".join(map(str, np.abs(at.state).ravel()))
    pressure, slip, work = (np.array(one["values"]) for one in data["numbers"])
    np.testing.assert_allclose(pressure.reshape(-1, 4), at.p / 0.5, atol=1e-3 * at.p.max())
    np.testing.assert_allclose(slip[-4:], state.slip_per_cycle, rtol=1e-4)
    np.testing.assert_allclose(work[-4:], work_of_nodes(state) / 0.5, rtol=1e-4)
    names = ["pressure [MPa]", "slip so far [mm]", "friction work so far per area [N/mm]"]
    assert [one["name"] for one in data["numbers"]] == names
    place = np.array(data["places"]).T
    scale = np.linalg.norm(test_patch.CORNERS - [1.0, 0.5, 5.0], axis=1).max()
    np.testing.assert_allclose(scale * place + [1.0, 0.5, 5.0], test_patch.CORNERS, atol=1e-3)
    turn = np.array(data["turn"])
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-3)
    assert np.linalg.det(turn) > 0
    assert data["faces"] == [[0, 1, 2, 3]]


@pytest.mark.parametrize(
    ("name", "turned"),
    [("press-fit", True), ("bolted-flange", True), ("four-node-3d", False), ("block-9", False)],
)
def test_what_has_three_places_not_in_a_line_can_be_turned(name, turned):
    assert can_be_turned(shakedown.example(name)) == turned
    row = np.arange(4.0)[:, None] * [1.0, 2.0, 3.0]
    assert not can_be_turned(replace(JOINT, coordinates=row, x=None, faces=None))


@pytest.mark.needs(chromium)
def test_in_a_browser_the_slider_changes_the_colours_and_nothing_goes_wrong(view, tmp_path):
    page = f'<div style="width: 400px">{environment().get_template("view.html.j2").render(view=view)}</div>'
    data, said = json.loads(view["data"]), json.loads(chromium.said_by(page, ASK, tmp_path))
    assert said["wrong"] == []
    assert not said["hidden"]
    started = data["status"][4 * data["start"] :][:4]
    stick, slip = (any(shown[zero] == 0 for shown in said["status"]) for zero in (0, 2))  # of blue, of red
    assert (stick, slip) == ("0" in started, "1" in started)
    assert said["slips"] > 5
    assert said["time"] == "t = 1 cycles"
    assert said["told"].startswith("node 0 (FE </script>), ")
    assert "slip so far = " in said["told"]
    assert said["before"].startswith("node 3 (FE d)")
    assert said["same"]
    assert said["fields"] == 4
    assert 300 <= said["high"] <= 400
