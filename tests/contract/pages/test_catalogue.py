# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""The page of a catalogue: what it holds, and how it sorts and filters in a real
browser.
"""

import json
import re

import pytest

from .reading import Page

NAMES = (
    "[...document.querySelectorAll('#parts > tbody > tr:not(.more) .part button')]"
    ".map(e => e.textContent.slice(0, 1)).join('')"
)
OPEN_ALL = (
    "document.querySelectorAll('#parts > tbody .part button').forEach(e => e.click())"
)
KNOWN = "abcdegh"


def typed(field, value):
    """Fill in a field as typing does."""
    return (
        f"(e => {{ e.value = {json.dumps(value)}; e.dispatchEvent(new Event('input', "
        f"{{bubbles: true}})); }})(document.getElementById('{field}'))"
    )


def head(name):
    return (
        f"[...document.querySelectorAll('thead button')].find(e => e.textContent === "
        f"'{name}').click()"
    )


def order(values, name, falling=False):
    """First letters of the parts by a value, those refused last."""
    rows = {row["file"].rpartition("/")[2][0]: row for row in values["parts"]}
    assert len({rows[letter][name] for letter in KNOWN}) >= len(KNOWN) - 1
    return (
        "".join(sorted(KNOWN, key=lambda letter: rows[letter][name], reverse=falling))
        + "f"
    )


def opened(browser, catalogue, *size):
    browser.open("about:blank")
    browser.requests.clear()
    browser.complaints.clear()
    browser.open((catalogue[0] / "index.html").as_uri(), *size)
    return browser


class TestWhatIsWritten:
    def test_the_answer_comes_first(self, small):
        lead = re.search(
            r'<p class="lead">(.*?)</p>',
            (small[0] / "index.html").read_text(encoding="utf-8"),
            re.DOTALL,
        )[1]
        assert re.search(
            r"\d of 7 parts lie one way in at least 90&nbsp;% of drops", lead
        )
        assert "Warnings about 1 part.</span>" in lead and ">1 refused.<" in lead

    def test_what_a_person_must_look_at_stands_before_the_table_in_words(self, small):
        text = Page(small[0] / "index.html").text
        _, _, below = text.partition("Look at these first")
        look, _, table = below.partition(" Files are named from")
        assert re.match(
            r" Refused 1 part Show These have no numbers\. f_letter\.stl: expected .*"
            r"Is the unit right\? 1 part Show Lengths, heights .* g_tiny\.stl$",
            look,
        )
        assert "UNIT_SUSPECT" not in text and "Lengths, heights" not in table

    def test_files_are_named_from_the_folder_that_they_have_in_common(self, small):
        page = Page(small[0] / "index.html")
        common = small[0].with_name("parts")
        assert f"Files are named from {common} ." in page.text
        assert page.source.count(str(common)) == 2  # there, and for commands
        assert '["h/h_declared.3mf","",' in page.source

    def test_a_small_page_is_one_file(self, small):
        page = Page(small[0] / "index.html")
        assert page.source.count("data:image/png;base64,") == len(KNOWN)
        assert not [
            name for name in page.addresses if not name.startswith(("data:", "#"))
        ]
        assert "<i>odd" not in page.source and len(page.source) < 100_000

    def test_a_large_one_stays_small_and_names_what_it_takes(self, large):
        page = Page(large[0] / "index.html")
        files = [name for name in page.addresses if not name.startswith(("data:", "#"))]
        assert files and all((large[0] / name).is_file() for name in files)
        assert "data:image/png" not in page.source and len(page.source) < 60_000


@pytest.mark.parametrize("kind", ["small", "large"])
def test_it_asks_for_its_own_files_only_and_shows_their_pictures(
    request, browser, kind
):
    opened(browser, catalogue := request.getfixturevalue(kind))
    assert browser.evaluate(NAMES)[:7] == order(catalogue[1], "best_share", True)[:7]
    assert all(address.startswith("file:///") for address in browser.requests)
    assert browser.complaints == []
    browser.evaluate(
        "document.querySelectorAll('#parts img').forEach(e => { e.loading = 'eager'; })"
    )
    assert browser.evaluate(
        "Promise.all([...document.querySelectorAll('#parts img')].map(e => e.decode()"
        ".then(() => e.naturalWidth > 100)))"
    ) == [True] * len(KNOWN)
    assert (
        browser.evaluate("document.querySelectorAll('#parts i:not(.bar i)').length")
        == 0
    )


def test_it_sorts_both_ways_and_what_is_not_known_comes_last(small, browser):
    opened(browser, small)
    for column, name in (("Height", "top_m"), ("Best pose", "best_share")):
        orders = []
        for _ in range(2):
            browser.evaluate(head(column))
            orders.append(browser.evaluate(NAMES))
        assert sorted(orders) == sorted(
            order(small[1], name, falling) for falling in (True, False)
        )
    browser.evaluate(head("Part"))
    assert browser.evaluate(NAMES) == "abcdefgh"
    browser.evaluate(head("Part"))
    assert browser.evaluate(NAMES) == "hgfedcba"
    assert (
        browser.evaluate(
            "document.querySelector('th[aria-sort]').getAttribute('aria-sort')"
        )
        == "descending"
    )


def test_it_sorts_at_a_phones_width_too(small, browser):
    opened(browser, small, 390, 844, True)
    browser.evaluate(
        "(e => { e.value = 'top'; e.dispatchEvent(new Event('change')); })"
        "(document.getElementById('sort'))"
    )
    assert browser.evaluate(NAMES) == order(small[1], "top_m")


@pytest.mark.parametrize(
    ("fields", "remaining"),
    [
        ({"words": "BAR"}, "b"),
        ({"words": "odd name"}, "e"),
        ({"words": "expected"}, "f"),
        ({"words": "nothing"}, ""),
        ({"share": "99.95"}, "a"),
        ({"passes": "1.001"}, "a"),
        ({"fit-top": "9.5"}, "ceg"),
        ({"kind": "refused"}, "f"),
        ({"kind": "answered"}, KNOWN),
        ({"kind": "warned"}, "g"),
        ({"kind": "UNIT_SUSPECT"}, "g"),
        ({"words": "unit_suspect right?"}, "g"),
        # A box that a part is to fit into, given either way round.
        ({"fit-length": "14", "fit-width": "60"}, "abeg"),
    ],
)
def test_it_filters(small, browser, fields, remaining):
    opened(browser, small)
    for field, value in fields.items():
        browser.evaluate(typed(field, value))
    assert "".join(sorted(browser.evaluate(NAMES))) == remaining
    assert browser.evaluate("document.getElementById('count').textContent").startswith(
        f"{len(remaining)} of 8 parts"
    )
    browser.evaluate(
        "new Promise(done => { document.querySelector('form').addEventListener("
        "'reset', () => setTimeout(done, 0)); "
        "document.querySelector('button[type=reset]').click(); })"
    )
    assert len(browser.evaluate(NAMES)) == 8


def test_a_part_tells_its_poses_and_the_command_of_its_report(small, browser):
    opened(browser, small)
    browser.evaluate(head("Part"))
    browser.evaluate(OPEN_ALL)
    poses = browser.evaluate(
        "[...document.querySelectorAll('.more')].map(more => "
        "[...more.querySelectorAll('table > tbody > tr')].map(e => "
        "e.cells[3].textContent + ', ' + e.cells[4].textContent))"
    )
    assert [text.replace("\xa0", " ") for text in poses[3]] == [
        "25 × 22 mm, 20 mm",
        "25 × 20 mm, 22 mm",
        "22 × 20 mm, 25 mm",
    ]
    commands = browser.evaluate(
        "[...document.querySelectorAll('.more code')].map(e => e.textContent)"
    )
    (block,) = (command for command in commands if "d_block" in command)
    assert re.fullmatch(
        r"ros_pose_stats report /\S+/parts/d_block\.stl --unit mm "
        r"--restitution 0\.4 -o /\S+/out/reports/d_block_\w{8}\.html",
        block,
    )
    assert any("'\"'\"'name'\"'\"'" in command for command in commands)
    # A file that declares its unit keeps it.
    assert {
        "--unit mm" in command: "h_declared" in command for command in commands
    } == {True: False, False: True}
    browser.evaluate(OPEN_ALL)
    assert browser.evaluate("document.querySelectorAll('.more').length") == 0


def test_a_concern_shows_its_parts(small, browser):
    opened(browser, small)
    for kind, letter in (("UNIT_SUSPECT", "g"), ("refused", "f")):
        browser.evaluate(
            f"document.querySelector('#concerns [data-kind={kind}]').click()"
        )
        assert browser.evaluate(NAMES) == letter


def test_warnings_stand_out(small, browser):
    opened(browser, small)
    script = "[...document.querySelectorAll('.notes .warned')].map(e => e.textContent)"
    assert browser.evaluate(script) == ["Is the unit right?"]
    colours = browser.evaluate(
        "['.notes .warned', 'td.notes'].map(name => getComputedStyle("
        "document.querySelector(name)).color)"
    )
    assert colours[0] != colours[1]
    browser.evaluate(OPEN_ALL)
    assert browser.evaluate(
        "document.querySelector('.more p.warning').textContent"
    ).startswith("Is the unit right? ")


@pytest.mark.parametrize(("width", "phone"), [(1280, False), (390, True)])
def test_all_of_it_is_within_the_window_and_numbers_keep_their_units(
    small, browser, width, phone
):
    opened(browser, small, width, 844, phone)
    cells = browser.evaluate(
        "[...document.querySelectorAll('#parts > tbody > tr > td:not("
        ".part):not(.refused)')].map(e => e.textContent)"
    )
    assert not [text for text in cells if re.search(r"\d (mm|%|points|bit)", text)]
    browser.evaluate(OPEN_ALL)
    browser.evaluate(
        "[...document.querySelectorAll('select')].forEach(e => "
        "e.add(new Option('Nobody has measured the estimate there. '.repeat(4))))"
    )
    assert browser.evaluate("document.documentElement.scrollWidth") == width
    assert (
        browser.evaluate(
            "[...document.querySelectorAll('h1,h3,p,label,button,#parts > tbody > tr > "
            "td,.more td')].filter(e => e.getBoundingClientRect().right > innerWidth + "
            "1).map(e => e.textContent)"
        )
        == []
    )


def test_many_parts_are_shown_some_at_a_time(large, browser):
    opened(browser, large)
    count = "document.querySelectorAll('#parts > tbody > tr').length"
    counts = [browser.evaluate(count)]
    while not browser.evaluate("document.getElementById('more').hidden"):
        browser.evaluate("document.getElementById('more').click()")
        counts.append(browser.evaluate(count))
        assert counts[-1] > counts[-2]
    assert len(counts) > 2 and counts[-1] == 408
