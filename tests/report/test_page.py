"""The page of a report: every section, alternative texts, units, nothing from outside, and the right colour.

That of a joint with two tangential directions has its own pictures.
"""

import json
import re
from copy import copy
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from markupsafe import Markup

import shakedown
from shakedown import Problem
from shakedown.assessment.assess import Assessment
from shakedown.assessment.verify import Verification
from shakedown.bounds.registry import BOUNDS
from shakedown.ground.status import OPEN, SLIP
from shakedown.report.data_facts import configuration, source_facts
from shakedown.report.facts import notes
from shakedown.report.html import instants, render, run_picture, state_pictures
from shakedown.report.limit_facts import limits_table
from shakedown.report.run_facts import answer, banner_class, limits_on_page, verify_sheet

ONE_IN_SPACE = shakedown.example("one-node-3d")
SECTIONS = ["limits-of-the-load-factor", "runs", "state-at-λ-=-1", "joint", "provenance"]
CLAIMS = ["proved from every state", "proved from this state", "impossible above"]
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
        subscript = self.open[-1:] == ["sub"]  # as it is written elsewhere: λ_E
        if subscript or self.after_subscript:
            self.words[-1] += f"_{data}" if subscript else data
        elif "style" not in self.open:
            self.words.append(data)
        self.after_subscript = subscript

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


@pytest.fixture(scope="module")
def two() -> Verification:
    return verified(shakedown.example("two-node"))


@pytest.fixture(scope="module")
def block() -> Verification:
    return verified(labelled())


@pytest.fixture(scope="module")
def two_page(two) -> str:
    """For its words: pictures are not drawn."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("shakedown.plot.inline_svg.inline", lambda figure, alt: Markup("<svg></svg>"))
        return render(two)


@pytest.fixture(scope="module")
def block_page(block) -> str:
    return render(block)


@pytest.fixture(scope="module")
def page(block_page) -> Page:
    return Page(block_page)


def test_every_section_is_there_and_can_be_reached(page):
    assert [found["id"] for found in page.all("h2")] == SECTIONS
    assert len(page.all("details")) >= 2
    assert [found["href"] for found in page.all("a")] == [f"#{name}" for name in SECTIONS]


def test_every_picture_says_what_is_to_be_seen(page):
    pictures = page.all("svg")
    assert len(pictures) >= 6
    for picture in pictures:
        assert picture["role"] == "img"
        assert len(picture["aria-label"]) > 20
    assert len(page.all("figcaption")) == len(page.all("figure"))


def test_a_page_is_small_nothing_comes_from_outside_and_nothing_runs(page, block_page):
    assert len(block_page.encode()) < 800_000
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


def test_the_first_screen_has_the_answer(page):
    start = page.text[:FIRST]
    assert "(λ = 1) the joint" in start
    for name in ("proved from this state", "proved from every state", "impossible above", "slip"):
        assert name in start


def test_pictures_of_all_load_factors_share_their_axes_and_one_legend(two):
    cycles = run_picture(two)
    names = set(re.findall(r">([^<>]+)</text>", cycles.legend))
    assert {"zero", "safe", "witness", "random 0", "ball 0"} <= names
    assert not any(re.search(r">(zero|witness)</text>", panel[1]) for panel in cycles.panels)
    ticks = [re.findall(r">(10⁻?[⁰¹²³⁴-⁹]+|\d)</text>", panel[1]) for panel in cycles.panels]
    assert len(ticks) >= 3
    assert all(found == ticks[0] for found in ticks)


def test_colours_of_pictures_follow_the_page(block_page):
    pictures = "".join(re.findall(r"<svg.*?</svg>", block_page, re.DOTALL)).lower()
    assert "var(--ink)" in pictures
    for colour in ("#000000", "#ffffff", "#0072b2"):
        assert colour not in pictures


def test_labels_units_and_sources_are_told(page, block_page):
    for words in (
        "4704", "Σ|Δv| [mm]", "SHA-256 ab12", "joint.inp",
        "import joint.toml", "assembly, vibration", "seed 0", "N, mm", "48 load steps", "Coulomb",
    ):  # fmt: skip
        assert words in page.text, words
    assert "[model]\nx = 1" in block_page


@pytest.mark.usefixtures("undrawn")
def test_the_configuration_of_an_import_is_shown_as_its_text(block):
    kept = {"name": "joint.toml", "text": '[model]\nname = "<b>"\r\nx = 1'}
    problem, limits = replace(block.problem, source=json.dumps({"configuration": kept})), copy(block.limits)
    vars(limits).update(problem=problem)
    text = render(replace(block, assessment=Assessment(limits)))
    assert "Configuration of the import: joint.toml" in text
    assert "[model]\nname = &#34;&lt;b&gt;&#34;\nx = 1</pre>" in text
    assert "\\n" not in configuration(problem)[1]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("one-node", "slips in every cycle: simulated."),
        ("one-node-separation", "opens and closes in every cycle: simulated."),
        ("jump", "shakes down with node 1 open: proved by following its cycles."),
        ("block-9", "shakes down from zero slip: proved."),
        ("receding-block", ""),
        ("three-node", ""),
    ],
)
def test_a_joint_that_slips_for_ever_is_never_green_and_the_answer_is_the_outcome(name, said):
    v = shakedown.verify(shakedown.example(name), random_states=0, load_factors=[1.0])
    assert answer(v).startswith(f"At the nominal load (λ = 1) the joint {said}")
    outcome, colour = v.as_given.simulation.outcome, banner_class(v)
    assert (colour == "agree") <= (outcome == "shakedown" and not v.disagreements and not v.open_questions)
    assert (outcome in ("cyclic-slip", "ratchetting")) <= (colour == "slips")
    assert banner_class(replace(v, disagreements=("λ_max: 1 and 2",))) == "disagree"


def test_of_many_loads_those_with_the_largest_loops_are_shown(monkeypatch):
    monkeypatch.setattr("shakedown.plot.inline_svg.inline", lambda figure, alt: Markup(alt))
    joint = Problem(
        A=[[2.0]], B=[[0.0]], f=0.5, q_w=[[-1.2], [1.2]], p_w=[[2.0], [2.0]], load_names=["a", "b", "c", "d"],
        load_reactions=np.outer([-0.1, -0.5, -0.2, -0.4], [1.0, 0.0]), load_compliance=np.eye(4),
        load_history=np.outer([1.0, -1.0], np.ones(4)),
    )  # fmt: skip
    pictures = state_pictures(shakedown.verify(joint, load_factors=[], random_states=0))
    (loops,) = [each for each in pictures if each.caption.startswith("Loops of the loads")]
    assert [re.search(r"\((\w)\), area", panel)[1] for _, panel in loops.panels] == ["b", "d", "c"]


@pytest.mark.usefixtures("undrawn")
def test_a_contradiction_stands_right_below_the_answer(two):
    text = Page(
        render(replace(two, disagreements=("λ_max: 1 by linear programming, 2 by the independent solver",)))
    ).text
    assert 0 < text.index("DISAGREEMENT: 1 finding") - text.index("At the nominal load") < 300
    assert text.index("2 by the independent solver") < text.index("proved from this state")


@pytest.mark.usefixtures("undrawn")
def test_the_same_verification_makes_the_same_page(two):
    first, second = (re.sub(r"\d{4}-\d\d-\d\d \d\d:\d\d UTC", "", render(two)) for _ in range(2))
    assert first == second


@pytest.mark.usefixtures("undrawn")
def test_a_body_that_slides_away_has_its_page():
    free = Problem(
        A=[[0.0]], B=[[0.0]], C=[[1.0]], f=0.5, q_w=[[0.9], [-0.1]], p_w=[[1.0], [1.0]]
    )  # no cycle comes to its end
    found = verified(free)
    text = Page(render(found)).text.replace("\N{NO-BREAK SPACE}", " ")
    assert "the joint does not hold: the body slides away" in text
    assert "slips relative to node 0" in text
    assert banner_class(found) == "slips"
    assert "Not drawn, as nothing slips or no cycle ends: λ = 1" in text
    assert "No state is drawn: at λ = 1 no long-term state was found." in text
    assert "results per node none" in text


def is_rounded(shown: str, exact: float, *, above: bool) -> bool:
    """Whether a number is another one rounded to the safe side, to four digits at least."""
    unit = 10.0 ** (np.floor(np.log10(exact)) - 3)
    return bool(0 <= (float(shown) - exact) * (1 if above else -1) < 1.001 * unit)


@pytest.mark.parametrize("name", ["two", "block"])
def test_every_limit_is_that_of_the_json_rounded_to_the_safe_side(name, request):
    """Claims, table of limits and scale."""
    found, page = request.getfixturevalue(name), Page(request.getfixturevalue(f"{name}_page")).text
    told = found.to_dict() | found.assessment.to_dict()
    claimed = verify_sheet(found).claims.rows
    assert [row[0] for row in claimed] == [*CLAIMS]
    for claim, shown, margin, valid in claimed:
        exact = told[claim.replace(" ", "_")]
        assert is_rounded(shown, exact, above=claim == CLAIMS[2]) if exact else shown == "not proved"
        assert f"{claim} {shown} {margin} {valid}" in page
    words = {kind.symbol: word for word, kind in BOUNDS.items()}
    rows = [row for row in limits_table(found.limits, simulated=True).rows if row[0] in words]
    assert len(rows) >= len(words) - 1  # λ_c only where a slip is rigid
    for symbol, title, shown, *_ in rows:
        exact = told[words[symbol]]["load_factor"]
        assert is_rounded(shown, exact, above=symbol == "λ_max") if exact else shown == "0"
        assert re.search(rf"{symbol} ?{title} {re.escape(shown)}", page)
    for symbol, value in limits_on_page(found).items():
        exact = told[words[symbol]]["load_factor"]
        assert (value >= exact) if symbol == "λ_max" else (value <= exact)
        assert value == pytest.approx(exact, rel=1e-3)  # four digits


@pytest.mark.usefixtures("undrawn", "no_transient_limit")
def test_the_page_in_space_has_orbits_and_zones_in_place_of_what_the_plane_has():
    page = render(shakedown.verify(ONE_IN_SPACE, load_factors=[1.4], random_states=0))
    drawn = "Slip orbits of the nodes", "What sticks, slips and is open"
    for words in (*drawn, "Normal reactions, and use of friction", notes.directions, notes.reached):
        assert words in page
    for absent in ("Hysteresis", "first collapse", "no wedging", "subsets", "f threshold"):
        assert absent not in page
    assert "1 node (3-D), 24 load steps" in page
    assert "There is no view to turn: the problem does not say where its nodes are." in page
    assert "<script" not in page  # its node has no place


def test_instants_show_what_opens_where_as_many_nodes_slip_at_others():
    """Nodes 17 and 23 of this state are open for 6 to 7 % of the period, one at a time, and slip before."""
    path = shakedown.long_term_state(shakedown.example("bolted-flange"), 1.764).history
    shown = path.at(np.array(instants(path))).state
    assert (shown == OPEN).any()
    assert (shown == SLIP).any()


def test_loads_bolts_and_all_three_extents_are_told():
    kinds = "Force", "Traction", "BodyForce"
    loads = [{"kind": kind, "value": [1.0, 0.0, 0.0]} for kind in kinds]
    body = {"mesh": {"elements": 2, "x": [0, 1], "y": [0, 2], "z": [-3, 0]}, "loads": loads}
    bolt = {"head": "washer", "preload": 12e3, "stiffness": 2e5, "history": 1.0}
    source = json.dumps({"bolts": [bolt], "bodies": [body]})
    told = source_facts(replace(ONE_IN_SPACE, units="N, mm", source=source))
    rows = {fact.label: fact.shown for fact in told}
    assert rows["bolts"] == "head washer, preload 12000, stiffness 200000, history 1"
    for kind in kinds:
        assert f"kind {kind}, value (1, 0, 0)" in rows["bodies"]
    assert "x (0, 1), y (0, 2), z (-3, 0)" in rows["bodies"]
