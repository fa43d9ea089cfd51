"""The benchmarks on tiny bodies: what is reported and how, never how long it took."""

from __future__ import annotations

import gc
import math

import numpy as np
import pytest

from benchmarks import bodies, core, growth
from benchmarks.report import FIGURE, render_page, table, write_page
from benchmarks.results import Results, Row, Section, Target, format_cell, load, save
from benchmarks.timing import Contender, Pace, race
from ros_pose_stats import part_from_mesh, resting_poses

ONCE = Pace(2, 10.0)
TINY = core.Plan(random=(10,), smooth=(40,), near_sphere=60, fineness=(1, 2, 3),
                 flattened=(200, 250, 300), fit_from=1, seeds=1, demo=False, slow=ONCE,
                 quick=ONCE)


@pytest.fixture(scope="module")
def results() -> Results:
    return core.run(TINY, say=lambda _: None)


class TestTheRun:
    def test_every_table_is_there(self, results):
        names = [section.name for section in results.sections]
        assert names == ["all_estimators", "near_sphere", "paper_size", "growth", "slopes"]

    def test_every_body_has_its_rows(self, results):
        assert [row.name for row in results.section("all_estimators").rows] == [
            f"{body}, tolerance {tolerance}"
            for body in ("random polyhedron 0, 10 vertices", "ellipsoid, 40 vertices",
                         "sphere, 40 vertices")
            for tolerance in ("0", "0.0025")]
        assert len(results.section("near_sphere").rows) == 4
        assert len(results.section("growth").rows) == 6
        assert len(results.section("slopes").rows) == 2 * len(growth.STAGES)

    def test_figures_are_finite_and_positive(self, results):
        for section in results.sections[:-1]:
            for row in section.rows:
                assert all(math.isfinite(value) and value > 0.0 for value in row.cells.values())
        for row in results.section("slopes").rows:
            assert math.isfinite(row.cells["slope"])
            assert math.isfinite(row.cells["error"])
            assert math.isfinite(row.cells["last decade"])

    def test_all_demands_are_judged(self, results):
        judged = {target.name for row in results.rows for target in row.targets}
        assert judged >= {"all / trimesh", "all, s", "splits, ms", "estimate, ms", "slope"}

    def test_the_machine_is_described(self, results):
        assert {"processor", "cores", "python", "numpy", "scipy", "numba", "trimesh",
                "date"} <= results.machine.keys()


class TestThePage:
    def test_it_names_every_row_and_section(self, results):
        page = render_page([results])
        for section in results.sections:
            assert section.title in page
            assert section.timed in page
            for row in section.rows:
                assert f"| {row.name} |" in page

    def test_it_is_written_from_what_is_stored(self, results, tmp_path):
        save(results, tmp_path / "benchmarks" / "core.json")
        page = write_page(tmp_path)
        assert page.read_text(encoding="utf-8") == render_page([results])
        assert (tmp_path / FIGURE).with_suffix(".png").stat().st_size > 0
        assert (tmp_path / FIGURE).with_suffix(".svg").stat().st_size > 0

    def test_results_survive_storage(self, results, tmp_path):
        save(results, tmp_path / "found.json")
        assert load(tmp_path / "found.json") == results

    @pytest.mark.parametrize(("value", "word"), [(4.9, "PASS"), (5.1, "short of target")])
    def test_a_miss_is_said_plainly(self, value, word):
        section = Section("s", "A table", "What is timed.",
                          (Row("a body", {"ms": 1.0}, (Target("all / hull", value, 5.0),)),))
        assert f"all / hull {value:.2f}, limit 5: {word}" in table(section).replace("**", "")
        first = render_page([Results({}, (section,))]).partition("##")[0]
        assert ("- a body: all / hull" in first) == (word != "PASS")


class TestBodies:
    @pytest.mark.parametrize("fineness", [1, 2, 5, 12])
    def test_a_rounded_box_has_six_stable_faces(self, fineness):
        body = bodies.rounded_box(fineness)
        resting = resting_poses(part_from_mesh(body.vertices, body.triangles), 0.0)
        assert len(body.vertices) == 4 * (fineness + 1) * (fineness + 2)
        assert len(resting.poses) == 6

    @pytest.mark.parametrize("vertices", [200, 400, 1500])
    def test_a_flattened_ellipsoid_has_six_stable_faces(self, vertices):
        body = bodies.flattened_ellipsoid(vertices)
        resting = resting_poses(part_from_mesh(body.vertices, body.triangles), 0.0)
        assert len(body.vertices) == pytest.approx(vertices, rel=0.15)
        assert len(resting.poses) == 6

    def test_growth_refuses_another_number_of_stable_faces(self):
        with pytest.raises(ValueError, match="stable faces, not 6"):
            growth.growth([bodies.sphere(30)], ONCE)

    @pytest.mark.parametrize("vertices", [10, 23])
    def test_random_polyhedra_depend_on_their_seed_alone(self, vertices):
        first, again = (bodies.random_polyhedron(vertices, 1) for _ in range(2))
        other = bodies.random_polyhedron(vertices, 2)
        assert len(first.vertices) == vertices
        assert np.array_equal(first.vertices, again.vertices)
        assert not np.array_equal(first.vertices, other.vertices)


class TestSlopes:
    def test_a_power_law_is_found_exactly(self):
        vertices = np.array([10.0, 100.0, 1000.0, 20000.0])
        found = growth.fit_slope(vertices, 3e-6 * vertices**1.15)
        assert found.value == pytest.approx(1.15, abs=1e-12)
        assert found.error == pytest.approx(0.0, abs=1e-7)

    def test_scatter_gives_the_textbook_error(self):
        x, y = np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.0, 1.1, 1.9, 3.2])
        design = np.column_stack((np.ones(4), x))
        covariance = np.linalg.inv(design.T @ design)
        coefficients = covariance @ design.T @ y
        variance = ((y - design @ coefficients) ** 2).sum() / 2.0 * covariance[1, 1]
        found = growth.fit_slope(np.exp(x), np.exp(y))
        assert found.value == pytest.approx(coefficients[1])
        assert found.error == pytest.approx(variance**0.5)

    def test_two_points_are_too_few(self):
        with pytest.raises(ValueError, match="three points"):
            growth.fit_slope([1.0, 2.0], [1.0, 2.0])


class TestTiming:
    def test_contenders_take_turns_on_fresh_preparations(self):
        log = []
        found = race([Contender("a", lambda made: log.append(("a", made)), lambda: len(log)),
                      Contender("b", lambda made: log.append(("b", made)))], Pace(3, 10.0))
        assert log == [("a", 0), ("b", None), ("a", 2), ("b", None), ("a", 4), ("b", None)]
        assert [len(times) for times in found.seconds.values()] == [3, 3]

    def test_the_collector_runs_only_where_asked_and_is_back_afterwards(self):
        found = []
        race([Contender("off", lambda _: found.append(gc.isenabled())),
              Contender("on", lambda _: found.append(gc.isenabled()), collected=True)],
             Pace(1, 1.0))
        assert found == [False, True]
        assert gc.isenabled()

    def test_who_has_used_up_its_patience_sits_out(self):
        found = race([Contender("slow", lambda _: sum(range(200_000)))], Pace(50, 1e-9))
        assert len(found.seconds["slow"]) == 1

    def test_ratios_are_taken_round_by_round(self):
        found = race([], Pace(1, 1.0))
        found.seconds.update(a=[2.0, 30.0, 4.0], b=[1.0, 10.0, 1.0])
        assert found.ratio("a", "b") == 3.0
        assert found.milliseconds("a") == 4000.0


def test_quick_runs_are_not_stored(capsys):
    with pytest.raises(SystemExit):
        core.main(["--quick", "--write"])
    assert "--write stores full runs" in capsys.readouterr().err


@pytest.mark.parametrize(("value", "text"), [
    (0.04226, "0.0423"), (4.238, "4.24"), (22.23, "22.2"), (1633.4, "1 633"), (19961, "19 961"),
    ("word", "word"), (0.0, "0"), (999.9, "1 000"),
])
def test_cells_show_three_digits(value, text):
    assert format_cell(value) == text
