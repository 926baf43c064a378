"""A verification that was killed goes on with what is recorded, and ends as an undisturbed one."""

from dataclasses import replace

import numpy as np
import pytest
from command import run

import shakedown
from shakedown import Problem
from shakedown.bounds import onset
from shakedown.campaign import recorded_steps
from shakedown.report import html

PLANE = shakedown.example("two-node")
SPACE = Problem(A=[[2, 0], [0, 2]], B=[[0, 0]], f=0.4, q_w=[[0.4, 0], [0.4, 1]], p_w=[[1], [1]])


@pytest.fixture(autouse=True)
def every_step_alone(monkeypatch):
    monkeypatch.setattr(recorded_steps, "EVERY", 0.0)


def verified(joint, **words):
    return shakedown.verify(joint, load_factors=[0.3], random_states=0, **words)


def said(found):
    """All that a document says, but how long runs took."""
    document = found.to_dict()
    for each in document["runs"]:
        del each["seconds"]
    return document


@pytest.mark.parametrize(("joint", "kills"), [(PLANE, 3), (SPACE, 1)], ids=["plane", "space"])
@pytest.mark.usefixtures("no_transient_limit")
def test_killed_at_any_instant_it_ends_as_an_undisturbed_one(tmp_path, joint, kills):
    path, whole, kept = tmp_path / "report.html.partial", said(verified(joint)), []
    found = verified(joint, partial=path, save=lambda _: kept.append(path.read_bytes()))
    assert said(found) == whole
    assert not path.exists()
    for place in np.random.default_rng(0).integers(kept[0].index(b"\x93piece"), len(kept[0]), kills):
        path.write_bytes(kept[0][:place])
        again = verified(joint, partial=path, resume=True)
        assert said(again) == whole
        assert again.problem is joint


def test_what_is_recorded_is_not_done_again(tmp_path, monkeypatch):
    path, runs = tmp_path / "report.html.partial", []

    def disk_is_full(found):
        runs.extend(found.runs)
        raise shakedown.UsageError("cannot be written")

    with pytest.raises(shakedown.UsageError, match="cannot be written"):
        verified(PLANE, partial=path, save=disk_is_full)
    for word in ("plan._At", "recorded_work.second_bounds", "recorded_work.critical_load_factors"):
        monkeypatch.setattr(f"shakedown.assessment.{word}", None)
    again = verified(PLANE, partial=path, resume=True)
    assert [run.seconds for run in again.runs] == [run.seconds for run in runs]


def test_a_verification_asked_otherwise_is_refused(tmp_path):
    path = tmp_path / "report.html.partial"
    with pytest.raises(KeyboardInterrupt):
        verified(PLANE, partial=path, progress=lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
    with pytest.raises(shakedown.UsageError, match="unfinished run is recorded there; resume it, or remove"):
        verified(PLANE, partial=path)
    with pytest.raises(shakedown.UsageError, match="recorded with cycles = 1000, not 999"):
        verified(PLANE, partial=path, resume=True, cycles=999)
    with pytest.raises(shakedown.UsageError, match="recorded with problem = "):
        verified(shakedown.example("three-node"), partial=path, resume=True)


@pytest.mark.parametrize(
    ("joint", "asked"),
    [(replace(PLANE, C=None), "0.3"), (shakedown.example("one-node-separation"), "1")],
    ids=["without normal stiffness", "given states"],
)
@pytest.mark.usefixtures("undrawn")
def test_what_is_known_can_be_read_while_the_work_goes_on(joint, asked, tmp_path, monkeypatch):
    """From the bounds and λ = 1 on, before λ_T: the page says what is missing, and goes when all is there."""
    pages, target = [], tmp_path / "report.html"
    monkeypatch.setattr("shakedown.assessment.recorded_work.SHOWN_EVERY", 0.0)
    monkeypatch.setattr("shakedown.assessment.recorded_work.LEISURE", 0.0)
    written = html.render

    def rendered(found, *more):
        """Pages between the first one and the last are the first one again."""
        page = written(found, *more) if not pages or not found.unfinished else pages[0][-1]
        pages.append((found.unfinished, [run.simulation.load_factor for run in found.runs], page))
        return page

    monkeypatch.setattr(html, "render", rendered)
    shakedown.save_problem(tmp_path / "joint.npz", joint)
    words = ("verify", "joint.npz", "-o", str(target), "--load-factor", asked, "--random", "0")
    code, _, err = run(*words, cwd=tmp_path)
    assert code == 0, err
    unfinished, factors, page = pages[0]
    assert unfinished == (
        "Unfinished: all other runs, the check of the mesh and the independent solver are to come."
    )
    assert factors == [1.0]
    assert unfinished in page
    assert pages[-1][0] == ""
    assert sorted(path.name for path in tmp_path.glob("report*")) == ["report.html", "report.json"]


def test_what_one_page_has_computed_the_next_does_not(monkeypatch):
    monkeypatch.setattr("shakedown.assessment.recorded_work.SHOWN_EVERY", 0.0)
    monkeypatch.setattr("shakedown.assessment.recorded_work.LEISURE", 0.0)
    slipping, asked, pages = onset.first_slip, [], []
    monkeypatch.setattr(
        "shakedown.assessment.every_limit.first_slip",
        lambda *about, **how: asked.append(about) or slipping(*about, **how),
    )
    found = verified(PLANE, so_far=lambda page: pages.append(page.limits.first_slip))
    assert found.limits.first_slip is pages[0]
    assert len(pages) > 2
    assert len(asked) == 1
    assert found.transient is not None


@pytest.mark.usefixtures("no_transient_limit")
def test_threads_change_no_run(tmp_path, monkeypatch):
    alone = said(shakedown.verify(SPACE, random_states=2))
    monkeypatch.setattr("shakedown.bounds.space_methods.FEW_NODES", 0)
    monkeypatch.setattr("shakedown.assessment.verify.all_cores", lambda: 3)
    path = tmp_path / "report.html.partial"
    assert said(shakedown.verify(SPACE, random_states=2, partial=path)) == alone


@pytest.mark.usefixtures("no_transient_limit")
def test_what_fails_in_a_thread_is_raised(monkeypatch):
    monkeypatch.setattr("shakedown.bounds.space_methods.FEW_NODES", 0)
    monkeypatch.setattr("shakedown.assessment.verify.all_cores", lambda: 2)
    monkeypatch.setattr("shakedown.assessment.verify.run_of", lambda *_: 1 // 0)
    with pytest.raises(ZeroDivisionError):
        verified(SPACE)
