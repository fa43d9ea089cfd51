"""The page of a catalogue: what it holds, and how it sorts and filters in a real browser."""

import json
import re

import pytest
import trimesh

from ros_pose_stats import shapes
from ros_pose_stats.catalogue import page
from ros_pose_stats.catalogue.making import make_catalogue
from ros_pose_stats.catalogue.request import CatalogueRequest, find_parts
from ros_pose_stats.records import DropScene
from tests.bodies import write_stl
from tests.browser import Browser, browser_file
from tests.catalogue import boxes, here

SHAPES = {
    "a_cube": shapes.box(10.0, 10.0, 10.0), "b_bar": shapes.box(10.0, 12.0, 60.0),
    "c_plate": shapes.box(40.0, 30.0, 3.0), "d_block": shapes.box(20.0, 22.0, 25.0),
    "e_<i>odd</i> & 'name'": shapes.box(9.0, 10.0, 11.0),
}
REQUEST = CatalogueRequest(DropScene(0.4), "mm")
SERIOUS = CatalogueRequest(DropScene(0.995), "mm")


def write_parts(folder):
    folder.mkdir()
    for name, surface in SHAPES.items():
        write_stl(folder / f"{name.replace('/', '_')}.stl", surface)
    (folder / "f_letter.stl").write_text("Dear colleague,")
    return folder


@pytest.fixture(scope="module")
def catalogue(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    made = make_catalogue(folder / "out", find_parts([write_parts(folder / "parts")]), REQUEST,
                          here(), keep_rows=True)
    (folder / "out" / "reports").mkdir()
    return made


@pytest.fixture(scope="module")
def in_chunks(tmp_path_factory):
    """The same parts on a page that takes rows from scripts beside it, two in each."""
    folder = tmp_path_factory.mktemp("chunks")
    parts = find_parts([write_parts(folder / "parts")])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(page, "EMBEDDED", 3)
        patch.setattr(page, "ROWS_A_CHUNK", 2)
        return make_catalogue(folder / "out", parts, REQUEST, here())


@pytest.fixture(scope="module")
def doubted(tmp_path_factory):
    """Two parts with OUTSIDE_FIT, on a plate that bounces as none was measured."""
    folder = tmp_path_factory.mktemp("doubted")
    parts = find_parts([write_parts(folder / "parts")])
    return make_catalogue(folder / "out", parts[1:3], SERIOUS, here())


class TestWhatIsWritten:
    def test_the_answer_comes_first(self, catalogue, doubted):
        lead = re.search(r'<p class="lead">(.*?)</p>', catalogue.page.read_text(), re.DOTALL)[1]
        assert "2 of 5 parts lie one way in at least 90&nbsp;% of drops" in lead
        assert "1 refused" in lead and "Serious" not in lead
        assert "(yaw) is left out" in catalogue.page.read_text()
        assert "Serious warnings about 2 parts: OUTSIDE_FIT\xa02." in doubted.page.read_text()

    def test_a_small_page_holds_everything(self, catalogue):
        text = catalogue.page.read_text()
        assert text.count("data:image/png;base64,") == len(SHAPES)
        assert not (catalogue.folder / "rows").exists()
        assert "<i>odd" not in text
        assert len(text) < 60_000

    def test_a_large_one_takes_rows_from_scripts(self, in_chunks):
        text = in_chunks.page.read_text()
        assert "data:image" not in text
        assert re.findall(r'<script src="([^"]+)"', text) == [f"rows/0000{k}.js" for k in range(3)]
        rows = []
        for file in sorted((in_chunks.folder / "rows").iterdir()):
            (call,) = re.fullmatch(r"addRows\((.*)\);\n", file.read_text()).groups()
            rows += json.loads(call)
        assert [row[0].rpartition("/")[2] for row in rows] == sorted(
            [*(f"{name.replace('/', '_')}.stl" for name in SHAPES), "f_letter.stl"])
        assert all((in_chunks.folder / row[2]).is_file() for row in rows if not row[1])

    def test_scripts_of_an_earlier_page_go(self, tmp_path):
        parts = find_parts([boxes(tmp_path / "parts")])
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(page, "EMBEDDED", 1)
            patch.setattr(page, "ROWS_A_CHUNK", 2)
            make_catalogue(tmp_path / "out", parts, REQUEST, here())
            assert len(list((tmp_path / "out" / "rows").iterdir())) == 3
            (tmp_path / "out" / "rows" / "mine.js").write_text("a script of somebody else")
            make_catalogue(tmp_path / "out", parts[:3], REQUEST, here())
        assert sorted(one.name for one in (tmp_path / "out" / "rows").iterdir()) == [
            "00000.js", "00001.js", "mine.js"]

    def test_a_report_has_a_name_that_a_link_can_have(self):
        row = {"file": "parts/b\udcf6x\x1b ü?.stl", "part_digest": 64 * "0"}
        assert page.report_name(row) == "reports/bx\x1b ü?_00000000.html"

    def test_a_report_that_was_made_is_linked(self, tmp_path):
        parts = find_parts([boxes(tmp_path / "parts")])
        made = make_catalogue(tmp_path / "out", parts, REQUEST, here(), keep_rows=True)
        report = tmp_path / "out" / page.report_name(made.rows[1])
        report.parent.mkdir()
        report.write_text("here it is")
        make_catalogue(tmp_path / "out", parts, REQUEST, here())
        text = made.page.read_text()
        linked = re.findall(r'"(reports/[^"]+)",(\d)', text)
        assert [int(there) for _, there in linked] == [0, 1, 0, 0, 0, 0]
        assert len({name for name, _ in linked}) == 6


NAMES = "[...document.querySelectorAll('#parts > tbody > tr:not(.more) .part button')]" \
        ".map(e => e.textContent.replace('.stl', '').slice(0, 1)).join('')"
ALL = "acbdef"
"""In the order in which the page opens: by the share of the best pose, refused ones last."""


def typed(field, value):
    """Fill in a field as typing does."""
    return (f"(e => {{ e.value = {json.dumps(value)}; e.dispatchEvent(new Event('input', "
            f"{{bubbles: true}})); }})(document.getElementById('{field}'))")


def head(name):
    return (f"[...document.querySelectorAll('thead button')].find(e => e.textContent === "
            f"'{name}').click()")


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    browser = Browser(tmp_path_factory.mktemp("profile"))
    yield browser
    browser.close()


@pytest.fixture(params=["catalogue", "in_chunks"])
def opened(request, browser):
    """The page in the browser."""
    made = request.getfixturevalue(request.param)
    browser.open("about:blank")
    browser.requests.clear()
    browser.complaints.clear()
    browser.open(made.page.as_uri())
    return browser


@pytest.mark.skipif(browser_file() is None, reason="no Chromium: apt install chromium")
class TestInABrowser:
    def test_it_asks_for_its_own_files_only(self, opened):
        assert opened.evaluate(NAMES) == ALL
        assert all(one.startswith("file:///") for one in opened.requests)
        assert opened.complaints == []
        opened.evaluate("document.querySelectorAll('#parts img').forEach(e => "
                        "{ e.loading = 'eager'; })")
        assert opened.evaluate(
            "Promise.all([...document.querySelectorAll('#parts img')].map(e => e.decode()"
            ".then(() => e.naturalWidth > 100)))") == [True] * len(SHAPES)
        assert opened.evaluate("document.querySelectorAll('#parts i:not(.bar i)').length") == 0

    def test_it_sorts_both_ways_and_what_is_not_known_comes_last(self, opened):
        opened.evaluate(head("Height"))
        assert opened.evaluate(NAMES) == "ceabdf"  # 3, 9, 10, 10, 20 mm
        opened.evaluate(head("Height"))
        assert opened.evaluate(NAMES) == "dabecf"
        opened.evaluate(head("Best pose"))
        assert opened.evaluate(NAMES) == ALL
        opened.evaluate(head("Best pose"))
        assert opened.evaluate(NAMES) == "edbcaf"
        opened.evaluate(head("Part"))
        opened.evaluate(head("Part"))
        assert opened.evaluate(NAMES) == "fedcba"
        assert opened.evaluate("document.querySelector('th[aria-sort]').getAttribute("
                               "'aria-sort')") == "descending"

    @pytest.mark.parametrize(("field", "value", "left"), [
        ("words", "BAR", "b"), ("words", "odd name", "e"), ("words", "expected", "f"),
        ("share", "99.95", "a"), ("passes", "1.001", "a"), ("fit-top", "9.5", "ce"),
        ("kind", "refused", "f"), ("kind", "answered", "abcde"),
        ("kind", "serious", ""), ("words", "nothing", ""),
    ])
    def test_it_filters(self, opened, field, value, left):
        opened.evaluate(typed(field, value))
        assert "".join(sorted(opened.evaluate(NAMES))) == left
        assert opened.evaluate("document.getElementById('count').textContent").startswith(
            f"{len(left)} of 6 parts")
        opened.evaluate("document.querySelector('button[type=reset]').click()")
        opened.evaluate("new Promise(f => setTimeout(f, 50))")
        assert opened.evaluate(NAMES) == ALL

    def test_a_box_that_it_fits_into_may_be_given_either_way_round(self, opened):
        opened.evaluate(typed("fit-length", "12"))
        opened.evaluate(typed("fit-width", "60"))
        assert opened.evaluate(NAMES) == "abe"

    def test_a_part_tells_its_poses_and_the_command_of_its_report(self, opened, catalogue):
        opened.evaluate("document.querySelectorAll('#parts .part button')[3].click()"
                        .replace("#parts .part", "#parts > tbody .part"))
        cells = opened.evaluate("[...document.querySelectorAll('.more tbody tr')].map(e => "
                                "e.cells[3].textContent + ', ' + e.cells[4].textContent)")
        assert [one.replace("\xa0", " ") for one in cells] == [
            "25 × 22 mm, 20 mm", "25 × 20 mm, 22 mm", "22 × 20 mm, 25 mm"]
        command = opened.evaluate("document.querySelector('.more code').textContent")
        assert re.fullmatch(r"ros_pose_stats report /\S+/parts/d_block\.stl --unit mm "
                            r"--restitution 0\.4 -o /\S+/out/reports/d_block_\w{8}\.html", command)
        opened.evaluate("document.querySelectorAll('#parts > tbody > tr:not(.more) .part button')"
                        "[4].click()")
        odd = opened.evaluate("document.querySelectorAll('.more code')[1].textContent")
        assert "'\"'\"'name'\"'\"'" in odd
        opened.evaluate("document.querySelectorAll('#parts > tbody > tr:not(.more) .part button')"
                        "[3].click()")
        assert opened.evaluate("document.querySelectorAll('.more').length") == 1

    def test_serious_warnings_are_coloured_and_can_be_asked_for(self, doubted, browser):
        browser.open("about:blank")
        browser.open(doubted.page.as_uri())
        browser.evaluate(typed("kind", "serious"))
        assert browser.evaluate(NAMES) == "cb"
        told = "[...document.querySelectorAll('.notes .serious')].map(e => e.textContent)"
        assert browser.evaluate(told) == ["OUTSIDE_FIT"] * 2
        notes = "[...document.querySelectorAll('td.notes')].map(e => e.textContent)"
        assert all(one.startswith("OUTSIDE_FIT") for one in browser.evaluate(notes))
        colours = browser.evaluate("['.notes .serious', '.notes'].map(one => getComputedStyle("
                                   "document.querySelector('td' + one)"
                                   " ?? document.querySelector(one)).color)")
        assert colours[0] != colours[1]
        browser.evaluate("document.querySelector('#parts > tbody .part button').click()")
        assert browser.evaluate("document.querySelector('.more p.warning').textContent"
                                ).startswith("OUTSIDE_FIT: ")

    def test_all_that_a_pose_has_is_in_view_on_a_phone(self, catalogue, browser):
        browser.open("about:blank")
        browser.open(catalogue.page.as_uri(), 390, 844, True)
        browser.evaluate("document.querySelectorAll('#parts > tbody .part button')"
                         ".forEach(e => e.click())")
        cells = browser.evaluate("[...document.querySelectorAll('.more td td')].map(e => "
                                 "[e.dataset.name, e.getBoundingClientRect().right])")
        assert {name for name, _ in cells} == {"Pose", "Share", "90 % interval", "Footprint",
                                               "Height", "Tilt to topple"}
        assert max(right for _, right in cells) <= 390

    def test_a_number_and_its_unit_stay_on_one_line(self, opened):
        cells = opened.evaluate("[...document.querySelectorAll('#parts > tbody > tr > td:not("
                                ".part):not(.refused)')].map(e => e.textContent)")
        assert not [one for one in cells if re.search(r"\d (mm|%|points|bit)", one)]
        assert any("\xa0points" in one for one in cells)

    def test_the_command_of_a_report_leaves_the_unit_to_a_file_that_declares_it(
            self, tmp_path, browser):
        for name in ("a.3mf", "b.stl"):
            trimesh.creation.box((10.0, 20.0, 30.0)).export(tmp_path / name)
        made = make_catalogue(tmp_path / "out", find_parts([tmp_path]),
                              CatalogueRequest(unit="cm"), here(), keep_rows=True)
        assert [row["top_m"] for row in made.rows] == pytest.approx([0.01, 0.1], rel=1e-6)
        assert not any("UNIT_OVERRIDDEN" in str(row["warnings"]) for row in made.rows)
        browser.open("about:blank")
        browser.open(made.page.as_uri())
        browser.evaluate("document.querySelectorAll('#parts > tbody .part button')"
                         ".forEach(e => e.click())")
        commands = browser.evaluate("[...document.querySelectorAll('.more code')]"
                                    ".map(e => e.textContent)")
        assert {"--unit cm" in one: "a.3mf" in one for one in commands} == {
            True: False, False: True}

    @pytest.mark.parametrize(("width", "phone"), [(1280, False), (390, True)])
    def test_it_is_not_wider_than_the_window(self, catalogue, browser, width, phone):
        browser.open("about:blank")
        browser.open(catalogue.page.as_uri(), width, 844, phone)
        browser.evaluate("document.querySelectorAll('#parts > tbody .part button')"
                         ".forEach(e => e.click())")
        assert browser.evaluate("document.documentElement.scrollWidth") == width
        cut = browser.evaluate(
            "[...document.querySelectorAll('h1,h3,p,label,button,#parts > tbody > tr > td')]"
            ".filter(e => e.getBoundingClientRect().right > innerWidth + 1)"
            ".map(e => e.textContent)")
        assert cut == []
        assert browser.evaluate("getComputedStyle(document.getElementById('sort').parentNode)"
                                ".display !== 'none'") == phone

    def test_sorting_at_a_phone_s_width(self, catalogue, browser):
        browser.open("about:blank")
        browser.open(catalogue.page.as_uri(), 390, 844, True)
        browser.evaluate("(e => { e.value = 'top'; e.dispatchEvent(new Event('change')); })"
                         "(document.getElementById('sort'))")
        assert browser.evaluate(NAMES) == "ceabdf"

    def test_many_parts_are_shown_some_at_a_time(self, catalogue, browser):
        browser.open("about:blank")
        browser.open(catalogue.page.as_uri())
        browser.evaluate("addRows([...Array(250)].map((_, k) => [`x_${k}.stl`, 'no part'])); "
                         "refresh()")
        count = "document.querySelectorAll('#parts > tbody > tr').length"
        assert browser.evaluate(count) == 100
        browser.evaluate("document.getElementById('more').click()")
        browser.evaluate("document.getElementById('more').click()")
        assert browser.evaluate(count) == 256
        assert browser.evaluate("document.getElementById('more').hidden")
