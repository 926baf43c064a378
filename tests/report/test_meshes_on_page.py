"""What a report says of other meshes and of averaged slips."""

import json

import numpy as np
import pytest
from command import document, run

import shakedown
from shakedown import UsageError
from shakedown.report.html import render, write_report
from shakedown.studies.refined import COLUMNS, Refinement
from tests.report.test_page import Page, nominal

H = np.array([1.0, 0.5, 0.25])


@pytest.fixture(scope="module")
def meshes():
    """Three meshes of which block-9 is one; work converges to 2, λ_max falls, nothing is proved."""
    numbers = dict.fromkeys(COLUMNS, np.zeros(3)) | {
        "work": 2.0 + H,
        "largest_slip": np.array([1.0, 2.0, 1.0]),
        "averaged_impossible_above": 3.0 - H**2,
        "impossible_above": H**0.2,
    }
    same = ("", shakedown.example("block-9").fingerprint, "")
    return Refinement(
        1.5, 0.5, None, np.arange(3.0), np.array([5, 9, 17]), 1, numbers, same, np.array([4.0, 8.0, 16.0])
    )


@pytest.mark.usefixtures("undrawn")
def test_the_section_the_first_page_and_the_json_have_them(meshes, tmp_path):
    v = nominal("block-9")
    write_report(tmp_path / "page.html", v, average=0.5, refinement=meshes)
    page = Page((tmp_path / "page.html").read_text())
    assert {"href": "#meshes"} in page.all("a")
    section = page.text.split(" Meshes ")[-1]
    assert "Averaged over 0.5 mm: 5 knots" in page.text
    assert "friction work [N mm] 3 2.5 2.25 converges 2 1 " in section
    assert "impossible above 1 0.8706 0.7579 falls" in section
    assert "λ = 1.5" in section
    found = json.loads((tmp_path / "page.json").read_text())
    assert found["refinement"] == meshes.to_dict()
    between = shakedown.assess(shakedown.averaged(v.problem, 0.5))
    assert found["averaged"]["impossible_above"] == between.impossible_above
    bare = render(v)
    assert 'id="meshes"' not in bare
    assert "Averaged over" not in bare


def test_meshes_of_another_joint_are_refused_before_the_work(meshes, tmp_path, monkeypatch):
    with pytest.raises(UsageError, match="expected meshes of which the joint has one"):
        render(nominal("two-node"), refinement=meshes)
    meshes.save(tmp_path / "t.csv")
    monkeypatch.setattr(shakedown, "verify", None)
    for words, said in (
        (["--refinement", str(tmp_path / "t.csv")], "found only others"),
        (["--average", "0"], "above 0"),
    ):
        code, _, error = run("verify", "two-node", *words)
        assert code == 2
        assert said in error


def test_the_command_takes_both(meshes, tmp_path):
    meshes.save(tmp_path / "t.csv")
    told = document(
        "verify", "block-9", "--random", "0", "--load-factor", "1",
        "--average", "0.5", "--refinement", str(tmp_path / "t.csv"),
    )  # fmt: skip
    assert told["refinement"] == meshes.to_dict()
    assert told["averaged"]["nodes"] == 5
