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

"""Programs of the lab: what they measure and print, and the pages made of what was
stored.
"""

import re
import shutil

import numpy as np
import pytest

from lab.benchmarks import rolls
from lab.benchmarks.default_answer import holds, square_error
from lab.benchmarks.design.sections import PAGE as DESIGN
from lab.benchmarks.estimates import TOLERANCES
from lab.benchmarks.program import BENCHMARKS, write_pages
from lab.benchmarks.speed import speed_page
from lab.bodies import shapes
from lab.bodies.families import FAMILIES, family_part, family_poses
from lab.bodies.rolling import ROLLING
from lab.frame.page import DOCS, NUMBERS
from lab.frame.results import Results, Row, Section, load
from lab.training.split import counting
from lab.training.split.judge import errors_by_family
from lab.training.split.samples import JUDGE_SEED, read_samples
from ros_pose_stats import DropScene
from ros_pose_stats.core.estimators.fitted import SPLIT_FITS
from ros_pose_stats.core.simulation.drop_body import drop_body
from ros_pose_stats.core.simulation.drops import (
    compute_drops,
    drop_rules,
    release_directions,
)
from tests.answers import write_stl
from tests.running import ROOT

from .programs import lab

MEASURED = ROOT / "docs" / "measured"


def judged(text):
    """Each target of a printed table: its value, its limit, which side it must be on,
    the verdict.
    """
    for value, side, limit, verdict in re.findall(
        r"(\d[\d .]*(?:e-\d+)?), (limit|at least) ([\d.]+): (PASS|short of target)",
        text,
    ):
        yield (
            float(value.replace(" ", "")),
            float(limit),
            side == "at least",
            verdict == "PASS",
        )


def test_the_pages_are_those_of_the_stored_numbers(tmp_path):
    shutil.copytree(MEASURED / "numbers", tmp_path / "measured" / "numbers")
    for page in (BENCHMARKS, DESIGN):
        write_pages(page, tmp_path)
    for name in ("benchmarks.md", "speed.md", "design.md"):
        assert (tmp_path / "measured" / name).read_text() == (
            MEASURED / name
        ).read_text(), name
    misses = re.search(
        r"(\d+) of (\d+) targets are met", (MEASURED / "benchmarks.md").read_text()
    )
    results = [
        verdict for *_, verdict in judged((MEASURED / "benchmarks.md").read_text())
    ]
    assert len(results) == int(misses[2]) and sum(results) == int(misses[1])


def test_the_page_on_speed_has_the_demo_parts_whatever_the_default_tolerance():
    rows = [
        Row(
            f"clamp, 480 vertices, tolerance {tolerance:g}",
            {"poses": poses, "all, ms": 5.0, "trimesh, ms": 9.0},
        )
        for tolerance, poses in zip(TOLERANCES, (8, 7), strict=True)
    ]
    machine = dict.fromkeys(("processor", "cores", "python", "date"), "")
    core = Results(machine, (Section("demo", "The demo parts", "", tuple(rows)),))
    page = speed_page({"core": core}, {"sizes": []})
    (line,) = (line for line in page.splitlines() if line.startswith("| clamp"))
    cells = [cell.strip() for cell in line.strip("|").split("|")]
    assert cells == ["clamp, 480 vertices", "7", "5 ms", "9 ms"]


def test_the_reference_takes_its_noise_off_and_widens_bounds_by_it():
    """Of 400 drops, beside 2 000 others: their error is known, and so is what bounds
    hold, but for chance and the steps of counts.
    """
    trials = 4000
    share = np.array([0.4, 0.3, 0.3])
    draw = np.random.default_rng(5)
    shares = draw.multinomial(400, share, trials) / 400
    counts = draw.multinomial(2000, share, trials)
    variance = share * (1.0 - share) / 400
    squares = [square_error(*pair) for pair in zip(shares, counts, strict=True)]
    chance = 4.0 * np.std(squares) / np.sqrt(trials)
    assert abs(np.mean(squares) - variance.mean()) < chance
    reach = 1.645 * np.sqrt(variance)
    held = [
        holds(center, reach, count)
        for center, count in zip(shares, counts, strict=True)
    ]
    step = 1.0 / 2000 / np.sqrt(variance.min())
    chance = 4.0 * np.sqrt(0.9 * 0.1 / trials)
    assert np.abs(np.mean(held, axis=0) - 0.9).max() < chance + 0.21 * step


@pytest.mark.long
def test_the_default_answer_is_judged_by_many_drops():
    text = lab("benchmarks.default_answer", "--quick", "--families", "bars", "prisms")
    assert re.search(r"\| all \| 4 \|", text)
    verdicts = list(judged(text))
    assert len(verdicts) >= 10
    for value, limit, least, verdict in verdicts:
        assert verdict == (value >= limit if least else value < limit)


@pytest.mark.long
def test_a_quick_run_prints_every_table():
    text = lab("benchmarks.core", "--quick")
    for title in ("All estimators from the mesh", "MEAE and split"):
        assert title in text
    assert len(list(judged(text))) > 5 and "nan" not in text


@pytest.mark.long
def test_files_are_dropped_beside_designed_parts(tmp_path):
    for edge in (0.01, 0.02):
        write_stl(tmp_path / f"{edge}.stl", shapes.box(edge, 0.02, 0.03))
    text = lab("benchmarks.part_rates", "--quick", tmp_path)
    assert re.search(r"\| designed \| 6 \|", text)
    assert re.search(r"\| real files \| 2 \|", text)
    for value, limit, _, verdict in judged(text):
        assert verdict == (value >= limit)


@pytest.mark.long
def test_told_gains_are_judged_by_other_drops():
    text = lab("benchmarks.design", "--quick")
    assert re.search(r"\| demo parts \| \d+ \|", text) and "Derivatives" in text
    verdicts = list(judged(text))
    assert len(verdicts) == 4
    assert all(verdict for *_, limit, _, verdict in verdicts if limit == 1.0)


def test_bodies_of_every_family_are_rigid_and_the_same_again():
    for family in FAMILIES:
        parts = [family_part(family, 5, number) for number in (0, 7, 7)]
        assert parts[0].digest != parts[1].digest == parts[2].digest
        low, middle, high = np.linalg.eigvalsh(parts[0].inertia)
        assert low > 0.0 and high <= (low + middle) * (1.0 + 1e-12)
        assert len(family_poses(family, parts[0]).poses) > 1


def test_a_family_counted_anew_leaves_the_others_as_they_are(tmp_path, monkeypatch):
    monkeypatch.setitem(counting.BODIES, "prisms", (2, 1))
    stored = read_samples()
    counting.count_all(tmp_path, 1, lambda *_: None, ["prisms"])
    joined = counting.join_series(tmp_path, ["prisms"], stored)
    families = [row.family for row in joined]
    assert sorted(families, key=list(counting.BODIES).index) == families
    others = [
        [row for row in rows if row.family != "prisms"] for rows in (joined, stored)
    ]
    assert [row[:6] for row in others[0]] == [row[:6] for row in others[1]]
    prisms = {row[1:3] for row in joined if row.family == "prisms"}
    assert prisms == {(11, 0), (11, 1), (JUDGE_SEED, 0)}


def test_errors_of_a_family_are_those_of_its_bodies_for_judging():
    rows = [row for row in read_samples() if row.family == "nuts" and row.number < 3]
    errors = errors_by_family(rows, (SPLIT_FITS, SPLIT_FITS[:1]))
    assert list(errors) == ["nuts", "all"]
    assert np.array_equal(errors["nuts"], errors["all"])
    assert 0.3 < errors["nuts"][0] < 4.0 and errors["nuts"][0] != errors["nuts"][1]


@pytest.mark.long
@pytest.mark.parametrize("name", list(ROLLING))
def test_drops_that_are_ended_end_as_those_run_on_did(name):
    """Thirty thousand of each body; `python -m lab.benchmarks.rolls` ran them on."""
    reference = load(DOCS / NUMBERS / "rolls.json")
    (row,) = (row for row in reference.rows if row.name == name)
    scene = DropScene(rolls.RESTITUTION)
    body = drop_body(ROLLING[name](), scene)
    rules = drop_rules(scene, body.radius, draws=True)
    downs = release_directions(body, rolls.SEED, 0, row.cells["drops"])
    short = compute_drops(body, rules, downs)
    digest = rolls.units_digest(body.resting.unit[short.pose])
    assert digest == row.cells["digest"]
