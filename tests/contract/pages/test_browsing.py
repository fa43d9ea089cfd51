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

"""Pages in a real browser: nothing asked of a network, nothing cut off, and the part
turns.
"""

import signal

import pytest
import trimesh

from lab.bodies import shapes
from tests.answers import write_stl

from .watching import WatchingCommand

HARMLESS = ("software WebGL", "GPU stall")
"""What a browser without a graphics card says of itself."""

SHOWN = """(() => {
  const view = document.getElementById('view'), copy = document.createElement('canvas');
  copy.width = view.width;
  copy.height = view.height;
  const pen = copy.getContext('2d');
  pen.drawImage(view, 0, 0);
  const data = pen.getImageData(0, 0, copy.width, copy.height).data;
  let blue = 0;
  for (let i = 0; i < data.length; i += 4) blue += data[i + 2] > data[i] + 40;
  return blue / (data.length / 4);
})()"""
"""Share of the view that shows the blue part."""

STATE = (
    "(e => [e.azimuth, e.elevation, e.pose])(document.getElementById('view').dataset)"
)

CUT = """[...document.querySelectorAll('h1,h2,h3,p,dd,dt,button,pre,figcaption')]
  .filter(e => e.getBoundingClientRect().right > innerWidth + 1)
  .map(e => e.textContent)"""

BROKEN = """[...document.querySelectorAll('td small')].filter(e => {
  const range = document.createRange();
  range.selectNodeContents(e);
  return new Set([...range.getClientRects()].map(box => box.top)).size > 1;
}).map(e => e.textContent)"""
"""Intervals in a table that are on several lines."""

TEXTS = """(() => [...document.images]
  .filter(e => e.src.startsWith('data:image/svg')).map(e => {
  const source = atob(e.src.split(',')[1]);
  const drawing = new DOMParser().parseFromString(source, 'image/svg+xml')
    .documentElement;
  document.body.append(drawing);
  const page = drawing.getBoundingClientRect();
  const boxes = [...drawing.querySelectorAll('g[id^=text_]')].map(text =>
    text.getBoundingClientRect()).filter(box => box.width > 0);
  drawing.remove();
  const cut = boxes.filter(box => box.left < page.left || box.right > page.right
    || box.top < page.top || box.bottom > page.bottom);
  const over = boxes.filter((a, i) => boxes.some((b, j) => j < i && a.left < b.right
    && b.left < a.right && a.top < b.bottom && b.top < a.bottom));
  return [e.alt, boxes.length, cut.length, over.length];
}))()"""
"""Of every drawing: its name, and how many texts it has, are cut off, and cover
another.
"""


@pytest.fixture(params=["report", "clamp", "comparison"])
def file(request):
    return request.getfixturevalue(request.param)[1]


@pytest.mark.parametrize(("fragment", "renderer"), [("", "webgl"), ("#2d", "2d")])
def test_the_view_turns_and_shows_the_pose_that_is_asked_for(
    clamp, browser, fragment, renderer
):
    browser.open("about:blank")
    browser.open(clamp[1].as_uri() + fragment)
    assert browser.evaluate("document.getElementById('view').dataset.renderer") in (
        renderer,
        "2d",
    )
    assert browser.evaluate(SHOWN) > 0.03
    state = browser.evaluate(STATE)
    browser.evaluate(
        "document.getElementById('view').scrollIntoView({block: 'center'})"
    )
    x, y = browser.evaluate(
        "(r => [r.x + r.width / 2, r.y + r.height / 2])"
        "(document.getElementById('view').getBoundingClientRect())"
    )
    browser.drag((x, y), (x + 120, y + 40))
    turned_state = browser.evaluate(STATE)
    assert float(turned_state[0]) != float(state[0]) and float(
        turned_state[1]
    ) != float(state[1])
    assert browser.evaluate(SHOWN) > 0.03
    browser.evaluate("document.querySelectorAll('#poses-of-view button')[2].click()")
    browser.evaluate(
        "new Promise(f => requestAnimationFrame(() => requestAnimationFrame(f)))"
    )
    assert browser.evaluate(STATE)[2] != state[2]
    assert browser.evaluate(SHOWN) > 0.03


@pytest.mark.parametrize(("width", "phone"), [(1280, False), (390, True)])
def test_a_page_asks_for_nothing_and_is_no_wider_than_the_window(
    file, browser, width, phone
):
    browser.open("about:blank")
    browser.requests.clear()
    browser.complaints.clear()
    browser.open(file.as_uri(), width, 844, phone)
    assert browser.requests == [file.as_uri()]
    assert [
        line for line in browser.complaints if not any(w in line for w in HARMLESS)
    ] == []
    assert browser.evaluate("document.documentElement.scrollWidth") <= width
    assert browser.evaluate(CUT) == browser.evaluate(BROKEN) == []
    assert browser.evaluate(
        "[...document.images].every(e => e.complete && e.naturalWidth > 0)"
    )


def test_no_text_of_a_drawing_is_cut_off_or_covers_another(
    report, clamp, rock, browser
):
    for _, file in (report, clamp, rock):
        browser.open("about:blank")
        browser.open(file.as_uri())
        drawings = browser.evaluate(TEXTS)
        assert len(drawings) >= 4
        assert [
            drawing for drawing in drawings if drawing[1] < 5 or drawing[2] + drawing[3]
        ] == []


def test_no_figure_is_squeezed_or_covered_in_print(clamp, browser):
    browser.open("about:blank")
    browser.open(clamp[1].as_uri(), 720, 1000)
    browser.ask("Emulation.setEmulatedMedia", media="print")
    try:
        boxes = browser.evaluate(
            "[...document.querySelectorAll('.pair img')].map(e => "
            "e.getBoundingClientRect()).map(r => [r.left, r.right, r.width])"
        )
        assert len(boxes) == 4
        for left_box, right in zip(boxes[::2], boxes[1::2], strict=True):
            assert left_box[1] <= right[0]
            assert min(left_box[2], right[2]) > 0.4 * 720
        assert browser.evaluate("document.documentElement.scrollWidth") == 720
    finally:
        browser.ask("Emulation.setEmulatedMedia", media="")


CURRENT = """new Promise(done => {
  const look = () => document.getElementById("version").dataset.version === "%d"
    ? done(true) : setTimeout(look, 10);
  look();
})"""
"""Until the page that follows a file shows some version."""

PICTURED = """[...document.querySelectorAll("canvas.still")].map(e => {
  const data = e.getContext("2d").getImageData(0, 0, e.width, e.height).data;
  let blue = 0;
  for (let i = 0; i < data.length; i += 4) blue += data[i + 2] > data[i] + 40;
  return blue / (data.length / 4);
})"""
"""Of each picture of a pose the share that shows the blue part."""


def serious(complaints, *expected):
    """Complaints of a browser but for the harmless and the expected ones."""
    harmless = (*HARMLESS, *expected)
    return [line for line in complaints if not any(word in line for word in harmless)]


def test_the_page_follows_its_file_and_stays_as_it_was_turned(tmp_path, browser):
    file = write_stl(tmp_path / "box.stl", shapes.box(20.0, 30.0, 40.0))
    command = WatchingCommand(file, "--wanted", "4,5")
    try:
        browser.open("about:blank")
        browser.requests.clear()
        browser.complaints.clear()
        browser.open(command.address)
        browser.evaluate(CURRENT % 1)
        browser.evaluate("document.querySelector('#view').scrollIntoView()")
        browser.evaluate("document.querySelectorAll('button[data-show]')[2].click()")
        x, y = browser.evaluate(
            "(r => [r.x + r.width / 2, r.y + r.height / 2])"
            "(document.getElementById('view').getBoundingClientRect())"
        )
        browser.drag((x, y), (x + 120, y + 40))
        kept = f"[...{STATE}, scrollY]"
        before = browser.evaluate(kept)
        write_stl(file, shapes.box(20.0, 30.0, 29.0))
        browser.evaluate(CURRENT % 2)
        browser.evaluate("new Promise(f => requestAnimationFrame(() => f()))")
        after = browser.evaluate(kept)
        # The third pose that was shown is on a side that is the second now.
        assert (before[2], after[2]) == ("4", "2")
        assert after[:2] == before[:2] and after[3] > 0
        assert min(browser.evaluate(PICTURED)) > 0.03 and browser.evaluate(SHOWN) > 0.03
        assert browser.evaluate("document.title").endswith("accepted: box.stl")
        for width in (390, 1280):
            browser.ask(
                "Emulation.setDeviceMetricsOverride",
                width=width,
                height=844,
                deviceScaleFactor=1,
                mobile=False,
            )
            assert browser.evaluate(CUT) == []
            assert browser.evaluate("document.documentElement.scrollWidth") <= width
        assert all(url.startswith(command.address) for url in browser.requests)
        assert serious(browser.complaints) == []
    finally:
        assert command.end(signal.SIGINT) == (0, "")
    browser.evaluate(
        """new Promise(done => {
          const look = () => document.getElementById("ended").textContent
            .includes("has ended") ? done(true) : setTimeout(look, 50);
          look();
        })"""
    )
    # The page's last question has no answer, in any of the ways of a network.
    assert serious(browser.complaints, "net::ERR_") == []


COLORED = """new Promise(done => {
  const view = document.getElementById("view"), copy = document.createElement("canvas");
  const look = () => {
    [copy.width, copy.height] = [view.width, view.height];
    const pen = copy.getContext("2d");
    pen.drawImage(view, 0, 0);
    const data = pen.getImageData(0, 0, copy.width, copy.height).data;
    let orange = 0;
    for (let i = 0; i < data.length; i += 4) orange += data[i] > data[i + 2] + 30;
    if (orange) done([orange, document.querySelectorAll("#pushes li").length]);
    else setTimeout(look, 100);
  };
  look();
})"""
"""Once faces are coloured: pixels of the view where to take away, and how many changes
are listed.
"""


@pytest.mark.long
def test_where_to_push_is_listed_and_coloured(parts, tmp_path, browser):
    """A thick clamp that is to lie on its broad faces is better thinner."""
    clamp = trimesh.load_mesh(parts / "clamp.stl")
    surface = clamp.vertices * (1.0, 1.0, 1.3), clamp.faces
    file = write_stl(tmp_path / "thick.stl", surface)
    command = WatchingCommand(file, "--wanted", "0,1")
    try:
        browser.open("about:blank")
        browser.open(command.address)
        orange, listed = browser.evaluate(COLORED)
        assert listed == 3 and orange > 1000
        listing = browser.evaluate("document.getElementById('pushes').textContent")
        assert "moved in by" in listing and "points" in listing
    finally:
        assert command.end() == (0, "")
