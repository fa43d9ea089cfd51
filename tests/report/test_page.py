"""What stands on the page."""

import base64
import json
import re
from html import unescape
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import ros_pose_stats
from ros_pose_stats import part_from_mesh
from ros_pose_stats.report import investigate, report_page
from ros_pose_stats.report.viewer import viewer_data
from ros_pose_stats.report.words import WORDS, in_words, said_once, three_digits
from ros_pose_stats.shapes.closed_forms import box
from tests import fine_parts
from tests.report.parts import block, demo

ROOT = Path(ros_pose_stats.__file__).resolve().parents[1]
VOID = {"meta", "link", "img", "br"}


class Reader(HTMLParser):
    """Texts, addresses, pictures and whether tags are closed in their order."""

    def __init__(self, page):
        super().__init__()
        self.texts, self.addresses, self.pictures, self._open = [], [], [], []
        self.feed(page)
        assert self._open == []

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.addresses += [given[name] for name in ("src", "href") if name in given]
        if tag == "img":
            self.pictures.append(given["alt"])
        if tag not in VOID:
            self._open.append(tag)

    def handle_endtag(self, tag):
        assert self._open.pop() == tag

    def handle_data(self, data):
        if self._open and self._open[-1] not in ("script", "style"):
            self.texts.append(data.replace("\xa0", " "))


@pytest.fixture(scope="module")
def page():
    return report_page(block((0, 1), 60.0), ("ros_pose_stats report block.stl --drops 300",))


@pytest.fixture(scope="module")
def read(page):
    return Reader(page)


def test_the_first_sentence_names_the_scene_and_all_its_numbers_are_the_drops(read):
    """Headline, cards, graph, feeder and table are one story: that of the counts."""
    found = block().simulated
    words = " ".join(read.texts)
    assert f"{found.scene[0].upper()}{found.scene[1:]}, this part comes to rest in" in words
    best = max({pose.group_probability for pose in found.poses})
    assert f"{100 * best:.1f} % of 300 simulated drops" in words
    assert "of the 300 simulated drops that came to rest below it" in words


@pytest.mark.parametrize("name", ["clamp", "gear", "hex_bolt", "cylinder"])
def test_the_splitting_graph_shows_the_shares_of_the_table(name):
    findings = demo(name)
    told = {pose.index: pose.probability for pose in findings.simulated.poses}
    ends = [node for node in findings.graph.walk() if not node.parts]
    assert sorted(node.poses for node in ends) == [(index,) for index in sorted(told)]
    assert {node.poses[0]: node.probability for node in ends} == pytest.approx(told)
    for node in findings.graph.walk():
        assert node.probability == pytest.approx(sum(told[pose] for pose in node.poses))
        if node.parts and node.probability:
            assert [part.probability / node.probability for part in node.parts] == \
                pytest.approx(node.transitions)
            assert sum(node.transitions) == pytest.approx(1.0)


def test_nothing_is_asked_of_a_network(page, read):
    assert all(address.startswith("data:") for address in read.addresses)
    assert not re.search(r"https?://(?!www\.w3\.org)", re.sub(r"base64,[^\"]*", "", page))
    assert "default-src 'none'" in page
    assert len(page) < 3e6


def test_poses_that_symmetry_makes_alike_have_a_picture_and_their_total(read):
    found = block().simulated
    words = " ".join(read.texts)
    pictures = [alt for alt in read.pictures if alt.startswith("The part in pose")]
    assert len(pictures) == 3
    for first, pose in enumerate(sorted(found.poses, key=lambda pose: pose.index)[::2]):
        total = f"{100 * pose.group_probability:.1f} %"
        assert f"The part in poses {2 * first}, {2 * first + 1}, {total} of the drops" in [
            alt.replace("\xa0", " ") for alt in pictures]
        for number in (total, f"each of 2, about {50 * pose.group_probability:.1f} %",
                       f"{1e3 * pose.height:.4g} mm", f"{1e3 * pose.barrier:.4g} mm",
                       f"{np.degrees(pose.margin):.3g}°", "every 180° of yaw"):
            assert number in words, (pose.index, number)


def test_each_pose_is_listed_on_demand(page, read):
    found = block().simulated
    (hidden,) = re.findall(r"<details>(.*?)</details>", page, re.DOTALL)
    rows = [re.findall(r"<td>(.*?)</td>", row, re.DOTALL)
            for row in re.findall(r"<tr>(.*?)</tr>", hidden, re.DOTALL)[1:]]
    assert [(int(row[0]), int(row[1]), int(row[4])) for row in rows] == [
        (pose.index, pose.group, pose.count) for pose in found.poses]
    assert "Each of the 6 poses by itself" in read.texts


def test_a_part_without_symmetry_has_a_picture_a_pose():
    findings = demo("clamp")
    page = report_page(findings)
    pictures = [alt for alt in Reader(page).pictures if alt.startswith("The part in pose")]
    assert len(pictures) == len(findings.simulated.poses)
    assert "<details>" not in page and "symmetry" not in page


def test_a_pose_that_rolls_says_what_its_margin_means():
    words = " ".join(Reader(report_page(demo("cylinder"))).texts)
    assert "margin across its axis" in words and "at any yaw" in words
    assert words.count("* The part rolls in this pose") == 1


def test_every_method_tells_every_total(page):
    findings, told = block(), unescape(page).replace("\N{NO-BREAK SPACE}", " ")
    for found in (findings.simulated, findings.hybrid, *findings.estimates):
        for pose in sorted(found.poses, key=lambda pose: pose.index)[::2]:
            assert (f'title="{found.method}, poses {pose.index}, {pose.index + 1}: '
                    f'{100 * pose.group_probability:.1f} %, 90 % interval') in told


def test_the_feeder_is_told_rates_passes_and_that_each_drop_is_fresh(read):
    afresh = block((0, 1), 60.0).afresh
    words = " ".join(read.texts)
    assert f"{afresh.per_minute.value:.3g} accepted parts a minute" in words
    assert f"{afresh.passes.value:.3g} passes per accepted part" in words
    assert "Feeding: dropped again or flipped" not in words
    assert "taken as dropped afresh" in words
    assert "ros_pose_stats report block.stl --drops 300" in words


def test_wanted_poses_of_which_symmetry_has_more():
    words = " ".join(Reader(report_page(block((0,), 60.0))).texts)
    assert "A wanted pose has others that look the same Pose 1 looks the same as pose 0" in words


def test_a_kick_is_set_beside_dropping_again():
    findings = block((0, 1), 60.0, 0.02)
    read = Reader(report_page(findings))
    words = " ".join(read.texts)
    kicked = findings.kicked.feeding
    assert "Feeding: dropped again or flipped" in words
    for number in (findings.afresh.per_minute, kicked.per_minute, kicked.flips):
        assert f"{number.value:#.3g}" in words
    assert f"{100 * findings.kicked.flips.transition[2, 0]:.1f}" in words
    assert "Accepted parts a minute over the kick height" in read.pictures


def test_methods_settings_and_figures_are_there(read):
    words = " ".join(read.texts)
    for told in ("300 drops", "restitution", "seed", "cluster tolerance", "How to reproduce it",
                 block().part.digest):
        assert told in words
    assert sum("Contours of" in alt for alt in read.pictures) == 2
    assert any("Splitting graph" in alt for alt in read.pictures)
    assert any("can be reached" in alt for alt in read.pictures)


def test_warnings_come_in_plain_words():
    findings = demo("gear")
    words = " ".join(Reader(report_page(findings)).texts)
    assert findings.warnings
    for warning in findings.warnings:
        heading, sentence, meaning = in_words(warning)
        assert heading in words
        assert sentence in words
        assert meaning in words


def test_what_all_methods_warn_of_is_said_once():
    lines = [("area", ["LOW_DROP: area does not know the height", "OPEN_MESH: the area"]),
             ("qse", ["LOW_DROP: qse does not know the height", "OPEN_MESH: the area"]),
             ("eae", ["LOW_DROP: eae does not know the height"]),
             ("split", ["NEAR_TIE: of split alone"])]
    assert said_once(lines) == (
        "LOW_DROP: area (likewise qse and eae) does not know the height", "OPEN_MESH: the area",
        "NEAR_TIE: of split alone")


def test_a_low_drop_is_one_warning():
    part = part_from_mesh(*box(0.04, 0.03, 0.02))
    findings = investigate(part, drops=100, seed=1, workers=1, drop_height=0.03)
    codes = [line.partition(":")[0] for line in findings.warnings]
    assert codes.count("LOW_DROP") == 1


def test_lengths_have_no_exponent_and_stay_with_their_units():
    part = part_from_mesh(*box(22.0, 18.0, 14.0), part_id="hall")
    page = unescape(report_page(investigate(part, drops=100, seed=1, workers=1)))
    assert "22000 \N{MULTIPLICATION SIGN} 18000 \N{MULTIPLICATION SIGN} 14000\xa0mm" in page
    assert not re.search(r"\de[+-]\d", " ".join(Reader(page).texts))
    lines = re.findall(r"<(?:p|dd)\b[^>]*>([^<]*)", page)  # cells of tables are not broken
    assert len(lines) > 30
    assert not [line for line in lines if re.search(r"\d (mm\b|%)", line)]


def test_commands_can_be_copied():
    page = report_page(block(), ("ros_pose_stats report 'block 3 mm.stl'",))
    assert "block 3 mm.stl" in page


@pytest.mark.parametrize(("number", "told"), [(2.0, "2.00"), (31.04, "31.0"), (278.4, "278"),
                                              (999.6, "1000"), (2604.2, "2604")])
def test_numbers_keep_their_zeros(number, told):
    assert three_digits(number) == told


def test_every_warning_has_its_words():
    text = (ROOT / "docs/warnings.md").read_text(encoding="utf-8")
    assert set(re.findall(r"^\| `([A-Z_]+)` \|", text, re.MULTILINE)) == set(WORDS)


def test_names_of_parts_cannot_write_html():
    from dataclasses import replace

    findings = block()
    page = report_page(replace(findings, part=replace(findings.part, part_id="<b>&'")))
    assert "<b>&" not in page
    assert "&lt;b&gt;&amp;" in page
    Reader(page)


def test_the_mesh_of_the_view_is_that_of_the_part():
    findings = demo("clamp")
    part, found = findings.part, findings.simulated
    data = json.loads(viewer_data(part, found.poses, found.radius))
    places = np.frombuffer(base64.b64decode(data["vertices"]), "<f4").reshape(-1, 3)
    numbers = np.frombuffer(base64.b64decode(data["triangles"]), "<u2")
    shown = part.center_of_mass + found.radius * places[numbers].astype(float)
    true = part.surface_vertices[part.surface_triangles].reshape(-1, 3)
    assert np.abs(shown - true).max() < 1e-7 * found.radius
    assert [pose["index"] for pose in data["poses"]] == [pose.index for pose in found.poses]
    for told, pose in zip(data["poses"], found.poses, strict=True):
        assert told["turn"] == pytest.approx(pose.orientation.tolist(), abs=1e-8)
        assert told["height"] * found.radius == pytest.approx(pose.height)


@pytest.mark.parametrize("body", [fine_parts.gear(), fine_parts.screw(384)],
                         ids=["30 000 triangles", "300 000 triangles"])
def test_the_page_of_a_fine_part_stays_small(body):
    part = part_from_mesh(*body, part_id="fine")
    assert len(part.triangles) > 30_000
    findings = investigate(part, drops=100, seed=1, workers=1)
    page = report_page(findings)
    assert len(page) < 3e6
    data = viewer_data(part, findings.simulated.poses, findings.simulated.radius)
    triangles = base64.b64decode(json.loads(data)["triangles"])
    assert 15_000 < len(triangles) / 6 <= 20_000
    assert len(data) < 4e5
