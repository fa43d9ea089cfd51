"""The chart of speed against accuracy: its points, their errors, and who is left out."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
import trimesh
from trimesh.poses import compute_stable_poses

from ros_pose_stats import estimate, part_from_mesh, resting_poses, shapes
from ros_pose_stats.estimators import ESTIMATORS
from ros_pose_stats.plots.study.speed_accuracy import ChartPoint
from ros_pose_stats.study.accuracy_documents import draw_chart
from ros_pose_stats.study.chart import (
    ChartResults,
    Measured,
    Plan,
    chart,
    chart_text,
    other_software,
)
from ros_pose_stats.study.chart.bodies import ellipsoids, machined_parts, paper_size
from ros_pose_stats.study.chart.methods import (
    Effort,
    estimator_points,
    medians,
    simulation_points,
    timed,
)
from ros_pose_stats.study.chart.speed_accuracy import duration
from ros_pose_stats.study.errors.partition import accuracy
from ros_pose_stats.study.errors.simulated_poses import pooled
from ros_pose_stats.study.estimates import scene_estimates
from ros_pose_stats.study.paper import ERRORS
from tests.running import strict_json
from tests.study.tables import drawn, some, told

BODIES = 40
LITTLE = Effort(2, 20, (10, 50), combined=(10, 40))
POINTS = len(ESTIMATORS) + 5
"""The estimators, two points each of hybrid and simulation, and trimesh."""

PLANS = (Plan(0, 0, 0, LITTLE, BODIES, 0), Plan(40, 3, 60, LITTLE, 2, 0))


@pytest.fixture(scope="module")
def found():
    return chart(some(BODIES), PLANS)


@pytest.fixture(scope="module")
def size():
    return paper_size(some(BODIES))


class TestPoints:
    @pytest.mark.long
    def test_every_method_in_every_size(self, found):
        titles = [one.title for one in found.sizes]
        assert titles[1] == "40 vertices"
        assert titles[0].startswith("paper-size, 4 to ")
        for one in found.sizes:
            by_kind = {kind: [point.name for point in one.points if point.kind == kind]
                       for kind in ("paper", "estimator", "hybrid", "simulation", "outside")}
            assert by_kind["paper"] == [ESTIMATORS[name].title for name in ERRORS]
            assert by_kind["paper"] + by_kind["estimator"] == [
                entry.title for entry in ESTIMATORS.values()]
            assert by_kind["hybrid"] == ["n = 10", "n = 40"]
            assert by_kind["simulation"] == ["n = 10", "n = 50"]
            assert by_kind["outside"] == ["trimesh.poses"]

    def test_times_are_positive_and_errors_lie_in_their_intervals(self, found):
        for one in found.sizes:
            for point in one.points:
                assert 0.0 < point.seconds < 60.0
                assert 0.0 <= point.low <= point.high < 1.0
                assert point.low <= point.error <= point.high, point

    def test_bodies_and_drops(self, found):
        paper, large = found.sizes
        assert (paper.bodies, paper.reference_drops) == (BODIES, 1000)
        assert paper.mean_poses == len(some(BODIES).body) / BODIES
        assert (large.bodies, large.reference_drops) == (3, 60)

    def test_errors_are_those_of_the_table(self, size, found):
        every = pooled(list(size.simulated.values()))
        by_restitution = scene_estimates(some(BODIES), told(BODIES)[0])
        for name, point in zip(told(BODIES)[1], found.sizes[0].points, strict=False):
            expected = accuracy(
                np.concatenate([one[name] for one in by_restitution.values()]), every)
            assert (point.error, point.low, point.high) == (
                expected.error, expected.low, expected.high)

    def test_the_simulation_s_error_falls_with_the_root_of_the_drops(self, size):
        ten, fifty = simulation_points(size, LITTLE)
        assert ten.error / fifty.error == pytest.approx(math.sqrt(5.0))
        assert ten.series == fifty.series == "drop simulation"

    def test_the_simulation_s_error_is_that_of_real_drops(self, size):
        """Fresh drops of the same bodies against the reference, within 4 standard errors."""
        first = pooled([some(BODIES).simulated(one, 100) for one in size.simulated])
        rest = pooled([some(BODIES).rest(one, 100) for one in size.simulated])
        seen = accuracy(first.probability, rest)
        hundred, = simulation_points(size, Effort(1, 1, (100,)))
        assert seen.error == pytest.approx(hundred.error, abs=4.0 * seen.standard_error)

    def test_a_single_body_has_no_interval(self):
        points = list(estimator_points(paper_size(some(1)), LITTLE))
        assert all(point.low == point.error == point.high for point in points)

    @pytest.mark.long
    def test_progress_names_what_was_measured(self):
        said = []
        chart(some(2), PLANS[:1], on_progress=said.append)
        assert said[0] == "reading the dataset's bodies"
        assert [line.partition(": ")[2] for line in said[-3:]] == [
            "drop simulation, n = 10", "drop simulation, n = 50", "trimesh.poses"]


class TestFront:
    def test_no_point_on_it_is_beaten_and_all_others_are(self, found):
        for one in found.sizes:
            shown = [one.points[k] for k in one.drawn()]
            for k in one.drawn():
                point = one.points[k]
                beaten = any(other.seconds < point.seconds and other.error < point.error
                             for other in shown)
                assert (k in one.front()) != beaten

    def test_an_error_lost_in_the_noise_is_kept_but_not_drawn(self):
        points = (ChartPoint("lost", "estimator", 1e-4, 0.0, 0.0, 0.01),
                  ChartPoint("seen", "estimator", 1e-3, 0.02, 0.01, 0.03),
                  ChartPoint("slow", "estimator", 1e-2, 0.03, 0.02, 0.04))
        one = Measured("few", 3, 6.0, 100, points)
        assert one.front() == [1]
        assert [point.name for point in one.panel().points] == ["seen", "slow"]
        results = ChartResults(some(2).spec, (one,), 1.0)
        assert draw_chart(results).axes
        plain = strict_json(json.dumps(results.as_dict()))
        assert [point["error"] for point in plain["sizes"][0]["points"]] == [0.0, 0.02, 0.03]
        assert plain["sizes"][0]["pareto_front"] == [1]

    @pytest.mark.long
    def test_an_exact_estimator_makes_such_a_point(self):
        """Counts drawn from it: of a few seeds one has more noise taken off than there is."""
        _, estimated = told(20)
        for seed in range(20):
            dataset = drawn(some(20), estimated["eae"], 2, seed)
            point = next(one for one in estimator_points(paper_size(dataset), LITTLE)
                         if one.name == "EAE")
            if point.error == 0.0:
                break
        assert point.error == 0.0


class TestResults:
    def test_json(self, found):
        plain = strict_json(json.dumps(found.as_dict()))
        assert plain["dataset"]["bodies"] == BODIES
        for one, there in zip(plain["sizes"], found.sizes, strict=True):
            assert len(one["points"]) == len(there.points) == POINTS
            assert one["pareto_front"] == there.front()
            assert one["points"][0].keys() == set(ChartPoint._fields)

    def test_text(self, found):
        text = chart_text(found)
        assert text.count("\n### ") + text.startswith("### ") == 2
        rows = [line for line in text.splitlines() if line.startswith("| ")]
        assert len(rows) == 2 * (POINTS + 2)
        assert sum(line.rstrip(" |").endswith("yes") for line in rows) == sum(
            len(one.front()) for one in found.sizes)

    @pytest.mark.long
    def test_the_figure_names_the_dataset_s_restitutions(self, found):
        def says(results):
            return " ".join(text.get_text() for text in draw_chart(results).texts)

        assert "0.2, 0.5\nand 0.8" in says(found)
        other = drawn(some(2), told(2)[1]["csae"], 20, 1, (0.25, 0.75))
        assert "0.25, 0.75" in says(ChartResults(other.spec, found.sizes, 1.0))

    @pytest.mark.parametrize(("seconds", "shown"), [
        (3.2e-6, "3.2 µs"), (1.234e-3, "1.23 ms"), (0.5, "500 ms"), (12.0, "12 s")])
    def test_durations(self, seconds, shown):
        assert duration(seconds) == shown


class TestSizes:
    def test_ellipsoids(self):
        size = ellipsoids(30, 3, 40, (0.2, 0.8))
        for number, (mesh, known) in enumerate(zip(size.meshes, size.known, strict=True)):
            assert len(mesh.vertices) == 30
            radii = np.linalg.norm(mesh.vertices, axis=1)
            assert radii.max() / radii.min() > 1.05
            for simulated in size.simulated.values():
                mine = simulated.body == number
                assert mine.sum() == len(known.poses)
                assert simulated.count[mine].sum() == simulated.settled[mine][0] == 40
        again = ellipsoids(30, 3, 40, (0.2, 0.8))
        assert np.array_equal(again.simulated[0.8].count, size.simulated[0.8].count)

    def test_shapes_and_drops_differ(self):
        """Drops of a body at two restitutions start apart, or their counts would be tied."""
        size = ellipsoids(30, 2, 40, (0.5, 0.5000001))
        one, other = size.simulated.values()
        assert not np.array_equal(one.count, other.count)
        assert not np.array_equal(size.meshes[0].vertices, size.meshes[1].vertices)


    def test_machined_parts_are_taken_as_users_files_are(self):
        size = machined_parts(6, 40, (0.2, 0.8))
        assert (size.cluster_tolerance, size.round_sides) == (0.0025, 192)
        assert size.title.startswith("machined and turned parts, ")
        for number, (mesh, known) in enumerate(zip(size.meshes, size.known, strict=True)):
            assert len(known.poses) == len(resting_poses(mesh.part()).poses)
            for simulated in size.simulated.values():
                assert simulated.count[simulated.body == number].sum() == 40
        names = [point.name for point in estimator_points(size, LITTLE)]
        assert names == [entry.title for entry in ESTIMATORS.values()]


class TestTrimesh:
    def test_a_pose_of_many_facets_gets_them_all(self):
        """A cylinder of 48 sides, which stands as one of 192: CSAE of its ends and its side."""
        surface = shapes.cylinder(48, 1.0, 2.0)
        part = part_from_mesh(*surface)
        body = trimesh.Trimesh(*surface, process=False)
        theirs = other_software.matched(
            resting_poses(part), *compute_stable_poses(body, center_mass=part.center_of_mass))
        end = 0.5 * (1.0 - math.sqrt(0.5))
        assert sorted(theirs) == pytest.approx([end, end, math.sqrt(0.5)], abs=2e-3)

    @pytest.mark.parametrize("edges", [(1.0, 2.0, 3.0), (1.0, 1.0, 0.4)])
    def test_a_box_has_our_solid_angles(self, edges):
        surface = shapes.box(*edges)
        part = part_from_mesh(*surface)
        body = trimesh.Trimesh(*surface, process=False)
        theirs = other_software.matched(resting_poses(part, 0.0),
                                 *compute_stable_poses(body, center_mass=part.center_of_mass))
        ours = estimate(part, "csae", cluster_tolerance=0.0).poses
        expected = [one.probability for one in sorted(ours, key=lambda pose: pose.index)]
        assert theirs == pytest.approx(expected, abs=1e-6)

    def test_nothing_is_lost_on_random_polyhedra(self, size):
        for mesh, known in zip(size.meshes, size.known, strict=True):
            body = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)
            theirs = other_software.matched(
                known, *compute_stable_poses(body, center_mass=mesh.center_of_mass))
            assert theirs.sum() == pytest.approx(1.0, abs=1e-9)

    def test_a_pose_that_is_none_of_ours_is_lost(self):
        known = resting_poses(part_from_mesh(*shapes.box(1.0, 2.0, 3.0)), 0.0)
        tilted = np.eye(4)[None].copy()
        tilted[0, :3, :3] = ((1.0, 0.0, 0.0), (0.0, 0.8, -0.6), (0.0, 0.6, 0.8))
        assert other_software.matched(known, tilted, [1.0]).sum() == 0.0


class TestMujoco:
    def test_where_it_is_missing_it_is_left_out(self, size, monkeypatch):
        said = []
        monkeypatch.setattr(other_software, "available", lambda: False)
        assert list(other_software.mujoco_points(size, 2, said.append)) == []
        assert said == ["MuJoCo is not installed, left out"]

    def test_restitutions_beyond_its_contacts(self, monkeypatch):
        said = []
        monkeypatch.setattr(other_software, "available", lambda: True)
        dataset = drawn(some(2), told(2)[1]["csae"], 20, 1, (0.0, 0.5))
        assert list(other_software.mujoco_points(paper_size(dataset), 2, said.append)) == []
        assert said == ["MuJoCo is left out: its contacts reach restitutions from 0.1 to 0.9"]

    def test_a_drop_that_does_not_end_costs_its_points_only(self, size, monkeypatch):
        def fail(*_):
            raise RuntimeError("a drop was still going on")

        said = []
        monkeypatch.setattr(other_software, "available", lambda: True)
        monkeypatch.setattr(other_software, "_mujoco_shares", fail)
        assert list(other_software.mujoco_points(size, 2, said.append)) == []
        assert said == ["MuJoCo is left out: a drop was still going on"]

    def test_its_points(self, monkeypatch):
        pytest.importorskip("mujoco")
        monkeypatch.setattr(other_software, "MUJOCO_DROPS", (2, 4))
        monkeypatch.setattr(other_software, "MUJOCO_STEPS", 3)
        dataset = drawn(some(2), told(2)[1]["csae"], 20, 1, (0.5,))
        two, four = other_software.mujoco_points(paper_size(dataset), 1)
        assert (two.series, two.kind, two.name, four.name) == (
            "MuJoCo", "outside", "n = 2", "n = 4")
        assert four.seconds == pytest.approx(2.0 * two.seconds)
        assert two.seconds > 0.0


class TestClock:
    def test_the_median_of_parts_of_the_median_of_turns(self, monkeypatch):
        """Calls that tell the clock how long they take; the first is a warm-up."""
        now = [0.0]
        monkeypatch.setattr("ros_pose_stats.study.chart.methods.time.perf_counter",
                            lambda: now[0])

        def taking(*seconds):
            left = iter(seconds)

            def call():
                now[0] += next(left)
            return call

        parts = [{"a": taking(100.0, 1.0, 3.0, 2.0)}, {"a": taking(9.0, 8.0, 50.0)},
                 {"a": taking(4.0, 4.0, 4.0)}]
        assert medians(parts, 3) == {"a": 4.0}

    def test_result_and_time(self):
        seconds, result = timed(lambda: "done")
        assert result == "done"
        assert seconds >= 0.0
