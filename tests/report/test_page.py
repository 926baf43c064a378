"""The page of a report: every section, alternative texts, units, nothing from outside, and the right colour."""

import json
import re
from dataclasses import replace
from functools import cache
from html.parser import HTMLParser

import numpy as np
import pytest

import shakedown
from benchmarks.bodies.classical import press_fit
from shakedown import Problem
from shakedown.assessment.verify import Verification
from shakedown.fem import ElasticBody, Material, Pressure, Traction, block_mesh, contact_problem
from shakedown.ground.shown_values import down, up
from shakedown.report.answer_words import banner_class, limits_in_words, margin_of_answer
from shakedown.report.data_page import configuration, source_rows
from shakedown.report.html import render
from shakedown.report.page_tables import limits_on_page
from shakedown.report.period_figures import as_given_state, cycling_state
from shakedown.report.verification_figures import run_pictures
from tests.altered import with_limits

SECTIONS = ["problem", "bounds", "runs", "state", "nodes", "limited", "friction", "conclusion", "words"]
VOID = {"meta", "input", "link", "br", "img", "use", "path", "circle", "image", "rect"}
FIRST = 1500  # characters of the page's text that a screen shows


class Page(HTMLParser):
    """What the tests ask of a page: its elements, whether each is closed, and its text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.open: list[str] = []
        self.words: list[str] = []
        self.after_subscript = False
        self.feed(text)
        assert self.open == [], f"never closed: {self.open}"

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID or tag == "use":
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        if tag in self.open[-1:]:
            self.open.pop()

    def handle_data(self, data):
        if self.open[-1:] == ["sub"]:  # as it is written elsewhere: λ_E
            self.words[-1] += f"_{data}"
            self.after_subscript = True
        elif "style" not in self.open:
            if self.after_subscript:
                self.words[-1] += data
            else:
                self.words.append(data)
            self.after_subscript = False

    def all(self, tag):
        return [attributes for name, attributes in self.elements if name == tag]

    @property
    def text(self):
        return " ".join(" ".join(self.words).split())


def labelled() -> Problem:
    """A block with everything that a problem can tell about its nodes and its origin."""
    block = shakedown.example("block-9")
    place = np.column_stack([block.x, np.zeros(9), np.zeros(9)])
    return replace(
        block,
        name="bracket",
        label=[f"{4700 + k}" for k in range(9)],
        coordinates=place,
        normal=np.tile([0.0, 1.0, 0.0], (9, 1)),
        tangent=np.tile([1.0, 0.0, 0.0], (9, 1)),
        node_area=np.full(9, 0.25),
        load_names=["assembly", "vibration"],
        source='{"toolkit": "shakedown 0.2", "command": "import joint.toml", "configuration": "[model]\\nx = 1", '
        '"files": [{"name": "joint.inp", "sha256": "ab12"}]}',
    )


def verified(problem: Problem) -> Verification:
    return shakedown.verify(problem, random_states=1)


@cache
def nominal(name: str) -> Verification:
    """A built-in joint under the nominal load alone."""
    return shakedown.verify(shakedown.example(name), random_states=0, load_factors=[1.0])


@pytest.fixture(scope="module")
def two() -> Verification:
    return verified(shakedown.example("two-node"))


@pytest.fixture(scope="module")
def block() -> Verification:
    return verified(labelled())


@pytest.fixture(scope="module")
def jump() -> Verification:
    return verified(shakedown.example("jump"))


@pytest.fixture(scope="module")
def two_page(two) -> str:
    return render(two)


@pytest.fixture(scope="module")
def block_page(block) -> str:
    return render(block)


@pytest.fixture(scope="module", params=["two-node", "labelled"])
def page(request, two_page, block_page) -> Page:
    known = {"two-node": two_page, "labelled": block_page}
    return Page(known.get(request.param) or render(verified(shakedown.example(request.param))))


def test_every_section_is_there_and_can_be_reached(page):
    assert [found["id"] for found in page.all("h2")] == SECTIONS
    assert [found["href"] for found in page.all("a")] == [f"#{name}" for name in SECTIONS]


def test_every_picture_says_what_is_to_be_seen(page):
    pictures = page.all("svg")
    assert len(pictures) >= 6
    for picture in pictures:
        assert picture["role"] == "img"
        assert len(picture["aria-label"]) > 20
    assert len(page.all("figcaption")) == len(page.all("figure"))


def test_nothing_comes_from_outside_and_nothing_runs(page):
    for _, attributes in page.elements:
        for key in ("src", "href", "xlink:href"):
            assert (attributes.get(key) or "#").startswith(("#", "data:image/png")), attributes
    assert not page.all("script")
    assert not page.all("link")
    assert "http" not in page.text


def test_no_number_is_missing_without_a_dash(page):
    assert not re.search(r"\b(nan|NaN|inf|None(?! of))\b", page.text)


def test_what_is_referred_to_is_there(page):
    known = {attributes.get("id") for _, attributes in page.elements}
    for _, attributes in page.elements:
        if (attributes.get("href") or "").startswith("#"):
            assert attributes["href"][1:] in known
        for found in re.findall(r"url\(#(\w+)\)", " ".join(filter(None, attributes.values()))):
            assert found in known
        assert attributes.get("for") in (None, *known)


def test_every_table_names_its_columns_for_narrow_screens(page):
    assert all("data-name" in cell for cell in page.all("td")) or page.all("table")
    tables = [attributes.get("class") for attributes in page.all("table")]
    assert tables.count("cards") == 5
    assert len(page.all("details")) >= 3


def test_the_first_screen_has_the_answer(page):
    start = page.text[:FIRST]
    assert "(λ = 1) the joint" in start
    for name in ("proved from this state", "proved from every state", "impossible above", "slip"):
        assert name in start


def test_the_style_knows_paper_darkness_and_narrow_screens(two_page):
    style = re.search(r"<style>(.*?)</style>", two_page, re.DOTALL)[1]
    for rule in ("@media print", "size: A4", "prefers-color-scheme: dark", "max-width: 640px"):
        assert rule in style
    assert "details::details-content { content-visibility: visible" in style
    assert style.count("{") == style.count("}")


def test_pictures_of_all_load_factors_share_their_axes_and_one_legend(two):
    cycles, alone, planes = run_pictures(two)
    for shown in (cycles, planes):
        names = set(re.findall(r">([^<>]+)</text>", shown.legend))
        assert {"zero", "safe", "witness", "random 0", "ball 0"} <= names
        assert not any(re.search(r">(zero|witness)</text>", panel.svg) for panel in shown.panels)
    ticks = [re.findall(r">(10⁻?[⁰¹²³⁴-⁹]+|\d)</text>", panel.svg) for panel in cycles.panels]
    assert len(ticks) == 3
    assert all(found == ticks[0] for found in ticks)
    assert [panel.name for panel in planes.panels[:3]] == [panel.name for panel in cycles.panels]
    assert all(re.search(r"λ = ", name) for name in re.findall(r">([^<>]+)</text>", alone.legend))


def test_colours_of_pictures_follow_the_page(block_page):
    pictures = "".join(re.findall(r"<svg.*?</svg>", block_page, re.DOTALL)).lower()
    assert "var(--ink)" in pictures
    for colour in ("#000000", "#ffffff", "#0072b2"):
        assert colour not in pictures


def test_labels_units_and_sources_are_told(block_page):
    page = Page(block_page)
    for words in (
        "FE label",
        "4704",
        "pressure [MPa]",
        "slip per period [mm]",
        "dissipation per cycle [N mm]",
        "p_w mean [N]",
        "area [mm²]",
        "SHA-256 ab12",
        "joint.inp",
        "import joint.toml",
        "assembly, vibration",
        "with seed 0",
        "x [mm]",
    ):
        assert words in page.text, words
    assert "[model]\nx = 1" in block_page


def test_a_joint_from_meshes_tells_its_material_mesh_and_loads():
    press = Pressure("top", 60.0, history=1.0)
    shear = Traction("top", (12.0, 0.0), history=lambda t: np.sin(2 * np.pi * t))
    body = ElasticBody(block_mesh(4.0, 2.0, 4, 2), Material(210e3, 0.3), loads=[press, shear], thickness=10.0)
    rows = dict(source_rows(contact_problem(body, "bottom", 0.5, steps=8, units="N, mm")))
    assert rows["made by"] == "shakedown.fem.contact_problem"
    assert rows["material"] == "Young's modulus 210000 MPa, Poisson's ratio 0.3"
    assert rows["thickness"] == "10 mm"
    assert rows["mesh"] == "elements 8, nodes 15, bilinear quadrilaterals, x (0, 4) mm, y (0, 2) mm"
    assert rows["load 1"] == "Pressure, 60 MPa, on top, times 1, constant"
    assert rows["load 2"] == "Traction, (12, 0) MPa, on top, times a function of time, -1 … 1 at 8 load steps"
    both = dict(source_rows(press_fit()))
    assert both["initial gap"] == "-0.001 mm"
    assert both["body 1: supports"] == "on floor, holds y; on wall, holds x"
    assert "on outside" in both["body 2: load 1"]


@pytest.mark.parametrize(
    "source", ['{"bodies": 3}', '{"bodies": [3, {"loads": [3], "mesh": null}]}', '{"configuration": [1]}']
)
def test_a_source_of_another_make_is_shown_as_it_is(source):
    problem = replace(shakedown.example("two-node"), source=source)
    assert all(isinstance(text, str) for row in source_rows(problem) for text in row)
    assert len(configuration(problem)) == 2


@pytest.mark.usefixtures("undrawn")
def test_the_configuration_of_an_import_is_shown_as_its_text(block):
    kept = {"name": "joint.toml", "text": '[model]\nname = "<b>"\r\nx = 1'}
    problem = replace(block.problem, source=json.dumps({"configuration": kept}))
    text = render(with_limits(block, problem=problem))
    assert "Configuration of the import: joint.toml" in text
    assert "[model]\nname = &#34;&lt;b&gt;&#34;\nx = 1</pre>" in text
    assert "\\n" not in configuration(problem)[1]


def test_what_was_averaged_away_is_not_called_a_finding(block_page):
    row = re.search(r"A and C symmetric</td>(.*?)</tr>", block_page)[1]
    assert "yes, as stored" in row
    assert "averaged" in row


@pytest.mark.parametrize("name", ["two-node", "receding-block", "block-9", "jump", "one-node", "three-node"])
def test_a_joint_that_slips_for_ever_is_never_green(name):
    v = nominal(name)
    outcome, colour = v.as_given.simulation.outcome, banner_class(v)
    assert (colour == "agree") <= (outcome == "shakedown" and not v.disagreements and not v.open_questions)
    assert (outcome in ("cyclic-slip", "ratchetting")) <= (colour == "disagree")


@pytest.mark.usefixtures("undrawn")
def test_fixed_load_steps_alone_make_no_green_banner():
    block = shakedown.example("block-9")
    assert banner_class(nominal("block-9")) == "agree"
    stepped = shakedown.verify(block, load_factors=[1.0], method="gauss-seidel", random_states=0)
    assert stepped.as_given.simulation.outcome == "shakedown"
    assert banner_class(stepped) == "open"
    assert "did not go from event to event" in render(stepped)


@pytest.mark.usefixtures("undrawn")
def test_a_contradiction_stands_right_below_the_answer(two):
    text = Page(
        render(replace(two, disagreements=("λ_max: 1 by linear programming, 2 by the independent solver",)))
    ).text
    assert 0 < text.index("DISAGREEMENT: 1 finding") - text.index("At the nominal load") < 300
    assert text.index("2 by the independent solver") < text.index("proved from this state")


@pytest.mark.usefixtures("undrawn")
def test_a_solver_that_gives_up_is_a_note_and_changes_no_colour(jump):
    noted = replace(jump, notes=("λ_1: the independent solver (CLARABEL) stopped without an answer",))
    assert banner_class(noted) == banner_class(jump)
    assert "Note: λ_1: the independent solver (CLARABEL) stopped" in Page(render(noted)).text


def test_the_margin_is_about_this_state(two, block):
    assert margin_of_answer(two).startswith(
        "With the varying part of the load 34.27 % smaller it is proved to shake down from every state, "
        "26.85 % starting without slip"
    )
    assert margin_of_answer(block).startswith(
        "The varying part of the load alone may be 366.3 % larger, proved"
    )


def test_loops_are_those_of_the_loading_as_given_or_say_of_which(two, block):
    assert cycling_state(two).state is as_given_state(two).state
    assert as_given_state(block).state.outcome == "shakedown"
    assert cycling_state(block).state.load_factor > 1
    factor = cycling_state(block).state.load_factor
    assert cycling_state(block).which == f"at λ = {factor:.7g}, the nearest simulated load that slips"


def test_the_scale_has_a_version_for_narrow_screens(two_page):
    scale = re.search(r'<div class="scale">(.*?)</div>\s*<nav', two_page, re.DOTALL)[1]
    wide, narrow = re.findall(r"<svg.*?</svg>", scale, re.DOTALL)
    width = [float(re.search(r'viewBox="0 0 ([\d.]+)', svg)[1]) for svg in (wide, narrow)]
    assert width[1] < 260 < width[0]  # at 360 px its letters are larger than drawn
    assert all("λ</tspan>" not in svg and "0.657" in svg for svg in (wide, narrow))
    style = re.search(r"<style>(.*?)</style>", two_page, re.DOTALL)[1]
    assert ".scale .panel + .panel { display: none; }" in style.split("@media screen and (max-width")[0]
    assert ".scale .panel + .panel { display: block; }" in style.split("@media screen and (max-width")[1]


def test_words_and_symbols_are_told(page):
    start = page.text.rindex("Words and symbols")
    words = page.text[start:]
    for name in (
        "λ_E", "λ_U", "λ_1", "λ_T", "λ_max", "safe slip", "witness", "shakedown", "cyclic slip", "ratchetting",
        "separation", "undecided", "energy norm", "swing bound", "multiplier", "friction threshold",
    ):  # fmt: skip
        assert name in words


def test_a_line_on_the_floor_may_be_separation(block_page):
    assert "has shaken down, or is separation" in Page(block_page).text


def test_where_no_node_slips_no_panel_is_drawn_but_that_is_said(block):
    assert not block.as_given.simulation.slip_per_cycle.any()
    alone = replace(block, runs=(block.as_given,))
    (cycles,) = run_pictures(alone)
    assert cycles.panels == ()
    assert cycles.caption == "Not drawn, as nothing slips or no cycle ends: λ = 1, between."
    titles = [panel.name for panel in run_pictures(block)[0].panels]
    assert titles
    assert not any(title.startswith("λ = 1,") for title in titles)


def test_the_limits_of_validity_name_zone_loads_states_and_model(block):
    words = " ".join(limits_in_words(block))
    for part in (
        "all nodes stay in contact",
        "48 load steps",
        "seed 0",
        "9 contact nodes",
        "Coulomb",
        "quasi-static",
    ):
        assert part in words
    assert "nodes 0–4, 28–32 open" in limits_in_words(nominal("receding-block"))[0]


def test_the_same_verification_makes_the_same_page(two, two_page):
    first, second = (re.sub(r"\d{4}-\d\d-\d\d \d\d:\d\d UTC", "", page) for page in (two_page, render(two)))
    assert first == second


def test_pages_are_small(block_page):
    assert len(block_page.encode()) < 800_000


def test_no_limit_on_the_page_is_rounded_to_the_unsafe_side(two):
    for name, value in limits_on_page(two).items():
        exact = {
            "λ_S": two.limits.accumulated.load_factor,
            "λ_T": two.transient.load_factor,
            "λ_U": two.limits.universal.load_factor,
            "λ_1": two.limits.lower.load_factor,
            "λ_max": two.limits.upper.load_factor,
        }[name]
        assert (value >= exact) if name == "λ_max" else (value <= exact)
        assert value == pytest.approx(exact, rel=1e-6)


def test_a_body_that_slides_away_has_its_page():
    free = Problem(
        A=[[0.0]], B=[[0.0]], C=[[1.0]], f=0.5, q_w=[[0.9], [-0.1]], p_w=[[1.0], [1.0]]
    )  # no cycle comes to its end
    found = verified(free)
    page = render(found)
    assert "slides away" in page
    assert "given relative to node 0, where slip is set to zero.</p>" in page  # one full stop
    assert banner_class(found) != "agree"
    text = page.replace("\N{NO-BREAK SPACE}", " ")
    assert "Not drawn, as nothing slips or no cycle ends: λ = 1" in text
    assert "No state is drawn: at λ = 1 no long-term state was found." in text
    assert "There are no results per node: no long-term state at λ = 1: the body slides away" in text


def test_a_limit_is_the_same_number_everywhere_on_the_page(two, two_page, block, block_page):
    """Text, cards, tables and pictures: rounded once, to at least four digits."""
    names = {"E": "energy", "U": "universal", "S": "accumulated", "1": "lower", "max": "upper"}
    for found, page in ((two, two_page), (block, block_page)):
        text = re.sub(r"<sub>(\w+)</sub>", r"_\1", page).replace("\N{NO-BREAK SPACE}", " ")
        said = set(re.findall(r"λ_(\w+)\s*=\s*([\d.]+\d)", text))
        for name, number in said - {("T", number) for _, number in said}:
            rounded = up if name == "max" else down
            assert number == rounded(getattr(found.limits, names[name]).load_factor), (name, said)
        assert re.search(rf">λ = {re.escape(down(found.assessment.proved_from_this_state))}0*<", text)
        assert f">λ_max = {up(found.assessment.impossible_above)}<" in text
