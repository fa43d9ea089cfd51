"""The benchmark of drops, tiny: what is reported and how, never how long it took."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.drops import beside_mujoco, measure, soundness
from benchmarks.drops.dropper import Dropper, paper_droppers, pick_evenly
from benchmarks.drops.soundness import scale_thresholds
from benchmarks.pictures import PICTURES, draw
from benchmarks.report import render_page, table, write_page
from benchmarks.results import Results, Row, Section, Target, save
from benchmarks.timing import Pace

ONCE = Pace(2, 10.0)
TINY = measure.Plan(bodies=3, few=2, drops=3, rates=ONCE, theirs=1, ours=2, scaling_drops=40,
                    pieces=2, scaling=ONCE, ellipsoids=(10, 16, 24), fineness=(1, 2, 3),
                    flattened=(30, 200, 250), growth_seconds=1e-4, growth=ONCE,
                    threshold_drops=5, lattice_seeds=3, prefixes=(10, 20), target=0.1,
                    stop_seeds=3, long_drops=200)
SECTIONS = ["drop_rates", "beside_mujoco", "drop_scaling", "drop_growth", "drop_slopes",
            "drop_thresholds", "drop_lattice", "drop_stopping"]


@pytest.fixture(scope="module")
def results() -> Results:
    return measure.run(TINY, say=lambda _: None)


@pytest.fixture(scope="module")
def droppers() -> list[Dropper]:
    return paper_droppers(5)


class TestTheRun:
    def test_every_table_is_there(self, results):
        assert [section.name for section in results.sections] == SECTIONS

    def test_rows_of_a_table_have_the_same_columns(self, results):
        for section in results.sections:
            assert len({tuple(row.cells) for row in section.rows}) == 1

    def test_numbers_of_rows(self, results):
        found = {section.name: len(section.rows) for section in results.sections}
        del found["beside_mujoco"], found["drop_scaling"]
        assert found == {"drop_rates": 3, "drop_growth": 12, "drop_slopes": 4,
                         "drop_thresholds": 9, "drop_lattice": 9, "drop_stopping": 4}

    def test_figures_are_finite(self, results):
        for row in results.rows:
            assert all(isinstance(value, str) or math.isfinite(value)
                       for value in row.cells.values())

    def test_all_demands_are_judged(self, results):
        judged = {target.name for row in results.rows for target in row.targets}
        assert judged >= {"drops/s", "aim: drops/s", "slope"}

    def test_the_page_has_it_all(self, results, tmp_path):
        save(results, tmp_path / "benchmarks" / "drops.json")
        page = write_page(tmp_path).read_text(encoding="utf-8")
        assert page == render_page([results])
        for section in results.sections:
            assert section.title in page
            assert section.timed in page
        picture = PICTURES["drop_growth"]
        assert f"]({picture.stem.as_posix()}.png)" in page
        assert (tmp_path / picture.stem).with_suffix(".svg").stat().st_size > 0


class TestMujoco:
    def test_without_it_the_section_says_how_to_get_it(self, droppers, monkeypatch, tmp_path):
        monkeypatch.setattr(beside_mujoco, "available", lambda: False)
        section = beside_mujoco.beside_mujoco(droppers[:1], 1, 1)
        assert "pip install mujoco" in section.timed
        assert "not installed" in table(section)
        assert draw(section, tmp_path) == []

    def test_with_it_both_settings_are_judged(self, results):
        pytest.importorskip("mujoco")
        rows = results.section("beside_mujoco").rows
        assert len(rows) == 6
        for row in rows:
            assert row.cells["least"] <= row.cells["ratio"] <= row.cells["most"]
            assert row.cells["10 %"] <= row.cells["measured restitution"] <= row.cells["90 %"]
            assert row.cells["depth"] == pytest.approx(0.01, rel=0.4)
            (target,) = row.targets
            assert target.at_least
            assert target.value == row.cells["ratio"]


class TestDroppers:
    def test_the_papers_bodies_have_poses_to_choose_from(self, droppers):
        assert all(dropper.poses >= 2 for dropper in droppers)
        assert len({dropper.name for dropper in droppers}) == 5

    def test_a_few_are_spread_over_the_sizes(self, droppers):
        sizes = [dropper.vertices for dropper in pick_evenly(droppers, 3)]
        assert sizes == sorted(sizes)
        assert set(sizes) <= {dropper.vertices for dropper in droppers}
        assert [one.vertices for one in pick_evenly(droppers, 5)] == sorted(
            one.vertices for one in droppers)

    def test_effort_counts_the_impacts_of_the_drops(self, droppers):
        dropper = droppers[0]
        rules = dropper.rules(0.5)
        assert rules.height == pytest.approx(20.0)
        effort = dropper.effort(rules, 4, 50)
        # Other rounding of the same starts: a drop or two may go another way.
        assert effort.impacts == pytest.approx(dropper.drop(rules, 4, 50).impacts.mean(), rel=0.3)
        assert effort.steps > 0.0

    def test_scaled_thresholds_allow_the_cut_that_goes_with_them(self, droppers):
        rules = droppers[0].rules(0.5)
        loose = scale_thresholds(rules, 100.0)
        assert loose.slow == pytest.approx(100.0 * rules.slow)
        assert loose.touching == pytest.approx(100.0 * rules.touching)
        assert loose.soft / loose.slow**2 == pytest.approx(rules.soft / rules.slow**2)
        assert scale_thresholds(rules, 1.0) == rules


@pytest.mark.parametrize(("value", "met"), [(500.0, True), (499.0, False), (600.0, True)])
def test_a_demand_can_be_a_least_one(value, met):
    target = Target("ratio", value, 500.0, at_least=True)
    assert target.met == met
    assert "at least 500" in str(target)
    section = Section("s", "T", "t", (Row("r", {"x": 1.0}, (target,)),))
    page = render_page([Results({}, (section,))])
    assert ("short of target" in page) != met


def test_the_largest_by_chance_grows_with_the_number():
    found = [soundness._largest_by_chance(number) for number in (0, 1, 10, 100)]
    assert found == sorted(found)
    assert found[1] == pytest.approx(0.6745, abs=0.05)
    assert np.isfinite(found).all()


def test_quick_runs_are_not_stored(capsys):
    with pytest.raises(SystemExit):
        measure.main(["--quick", "--write"])
    assert "--write stores full runs" in capsys.readouterr().err
