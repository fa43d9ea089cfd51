"""The benchmark of the node: what is measured and reported, never how long it took."""

from __future__ import annotations

import os

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from rclpy.serialization import deserialize_message, serialize_message
from ros_pose_stats_msgs.msg import PartMesh
from ros_pose_stats_msgs.srv import StartDropSimulation
from scipy.spatial import ConvexHull
from shape_msgs.msg import Mesh, MeshTriangle

from benchmarks.node import drop_jobs, jobs, measure, recording, spread
from benchmarks.node.mesh_to_estimate import (
    HULL,
    LIBRARY,
    Fresh,
    _row,
    mesh_bytes,
    part_mesh_bytes,
    ring,
    rounded,
)
from benchmarks.node.processes import says_ready, surroundings
from benchmarks.node.services import OTHERS, START, call_row
from benchmarks.report import render_page, write_page
from benchmarks.results import Results, Row, Section, Target, load, save
from benchmarks.timing import Timings
from ros_pose_stats import estimate, part_from_mesh
from ros_pose_stats.recording.reader.raw_reader import RawMessage


class TestSpread:
    @pytest.mark.parametrize(("count", "share", "expected"), [
        (1, 0.5, 1), (4, 0.5, 2), (5, 0.5, 3), (10, 0.99, 10), (99, 0.99, 99), (100, 0.99, 99),
        (200, 0.99, 198), (7, 1.0, 7)])
    def test_a_percentile_is_one_of_the_values(self, count, share, expected):
        values = [float(value) for value in range(count, 0, -1)]
        assert spread.percentile(values, share) == expected

    @pytest.mark.parametrize(("values", "share"), [([], 0.5), ([1.0], 0.0), ([1.0], 1.1)])
    def test_no_percentile_of_nothing(self, values, share):
        with pytest.raises(ValueError, match="no percentile"):
            spread.percentile(values, share)

    def test_cells_are_in_milliseconds(self):
        assert spread.spread([0.003, 0.001, 0.002]) == {
            "runs": 3, "least, ms": 1.0, "median, ms": 2.0, "p99, ms": 3.0}

    def test_a_difference_is_taken_round_by_round(self):
        assert spread.beyond([5.0, 9.0, 2.0], [4.0, 2.0]) == pytest.approx(4000.0)

    def test_a_rate_counts_the_gaps(self):
        times = [1.0, 1.5, 1.75, 3.0]
        assert spread.per_second(times) == pytest.approx(1.5)
        assert spread.gaps(times) == [0.5, 0.25, 1.25]


class TestMeshes:
    @pytest.mark.parametrize("triangles", [1000, 10_000])
    @pytest.mark.parametrize("make", [ring, rounded])
    def test_bodies_are_closed_and_about_that_large(self, make, triangles):
        body = make(triangles)
        assert len(body.triangles) == pytest.approx(triangles, rel=0.1)
        assert str(len(body.triangles)) in body.name
        part = part_from_mesh(body.vertices, body.triangles)
        assert not part.warnings
        assert len(estimate(part).poses) >= 2

    def test_all_vertices_of_a_rounded_box_are_on_the_hull_and_half_of_a_rings(self):
        box, torus = rounded(1000), ring(1000)
        assert len(ConvexHull(box.vertices).vertices) == len(box.vertices)
        assert len(ConvexHull(torus.vertices).vertices) == pytest.approx(
            len(torus.vertices) / 2, rel=0.15)

    @pytest.mark.parametrize("cut", [0, 1])  # an odd number of triangles needs padding
    def test_a_mesh_is_serialised_as_rclpy_does(self, cut):
        body = ring(100)
        triangles = body.triangles[cut:]
        message = deserialize_message(mesh_bytes(body.vertices, triangles), Mesh)
        assert_array_equal([t.vertex_indices for t in message.triangles], triangles)
        assert_array_equal([(p.x, p.y, p.z) for p in message.vertices], body.vertices)
        again = Mesh(vertices=message.vertices, triangles=[
            MeshTriangle(vertex_indices=row.astype(np.uint32)) for row in triangles])
        assert len(serialize_message(again)) == len(mesh_bytes(body.vertices, triangles))

    def test_a_part_mesh_has_flat_arrays(self):
        body = ring(100)
        message = deserialize_message(
            part_mesh_bytes("a ring", body.vertices, body.triangles), PartMesh)
        assert message.part_id == "a ring"
        assert_array_equal(message.vertices, body.vertices.ravel())
        assert_array_equal(message.triangles, body.triangles.ravel())

    def test_fresh_meshes_differ_also_between_two_makers(self):
        body = ring(100)
        first, second = Fresh(body), Fresh(body)
        made = [first(), second(), first()]
        digests = {part_from_mesh(vertices, body.triangles).digest for vertices in made}
        assert len(digests) == 3
        assert np.allclose(made, body.vertices, rtol=1e-2)

    def test_a_request_carries_the_part(self):
        body = ring(100)
        request = jobs.carry(StartDropSimulation.Request(), "a ring", body.vertices,
                             body.triangles)
        assert_array_equal(request.part.vertices, body.vertices.ravel())
        assert_array_equal(request.part.triangles, body.triangles.ravel())
        assert jobs.start_request("a", 1).seed != jobs.start_request("a", 1).seed


class TestRows:
    @pytest.mark.parametrize(("name", "bound"), [
        ("start, known part", START), ("get", OTHERS), ("bare", None)])
    def test_calls_are_held_against_their_bound(self, name, bound):
        timings = Timings({name: [0.004, 0.012], "bare": [0.002, 0.002]})
        row = call_row(timings, name, "in the table", "bare")
        assert [target.limit for target in row.targets] == ([bound] if bound else [])
        assert row.cells["times bare"] == pytest.approx(1.0 if name == "bare" else 4.0)

    def test_a_mesh_is_set_beside_its_hull(self):
        timings = Timings({"sent": [0.005, 0.007], HULL: [0.001, 0.002], LIBRARY: [0.004, 0.004]})
        cells = _row(timings, ring(100), "sent").cells
        assert cells["beyond the hull, ms"] == pytest.approx(4.5)
        assert cells["beyond the library, ms"] == pytest.approx(2.0)

    def test_answer_and_end_of_a_cancel_are_judged(self):
        row = drop_jobs._cancelling_row("service", [drop_jobs.Ending(0.01, 0.2)])
        assert [target.met for target in row.targets] == [True, False]

    def test_bytes_in_the_bag_are_summed_by_topic(self):
        messages = [RawMessage(topic, "", bytes(size), 0, "")
                    for topic, size in (("/a", 100), ("/b", 7), ("/a", 50))]
        a, b = recording._rows("job", messages)
        assert (a.name, a.cells["messages"], b.cells["messages"]) == ("job, /a", 2, 1)
        around = b.cells["bytes"] - 7  # what a record has beside its message
        assert a.cells["bytes"] == 150 + 2 * around

    @pytest.mark.parametrize(("line", "said"), [
        ("[INFO] [1.2] [pose_stats]: ready\n", True), ("ready", True), ("", False),
        ("not ready yet", False)])
    def test_a_process_says_that_it_is_ready(self, line, said):
        assert says_ready(line) == said


class TestSurroundings:
    def test_the_environment_is_given_back(self, monkeypatch):
        monkeypatch.setenv("ROS_DOMAIN_ID", "0")
        with surroundings() as folder:
            assert folder.is_dir()
            assert 1 <= int(os.environ["ROS_DOMAIN_ID"]) <= 100
        assert os.environ["ROS_DOMAIN_ID"] == "0"
        assert not folder.exists()

    def test_a_failure_comes_out_as_it_is(self):
        with pytest.raises(FileNotFoundError), surroundings() as folder:
            (folder / "nothing").stat()


def test_stored_results_get_their_sections_on_the_page(tmp_path):
    found = Results({"processor": "one"}, (Section("services", "Services", "What is timed.", (
        Row("list, idle", {"runs": 3, "p99, ms": 60.0}, (Target("p99, ms", 60.0, OTHERS),)),)),))
    save(found, tmp_path / "benchmarks" / "node.json")
    assert load(tmp_path / "benchmarks" / "node.json") == found
    page = write_page(tmp_path).read_text(encoding="utf-8")
    assert page == render_page([found])
    assert "## Services" in page
    assert "**p99, ms 60.0, limit 50: short of target**" in page


def test_quick_runs_are_not_stored(capsys):
    with pytest.raises(SystemExit):
        measure.main(["--quick", "--write"])
    assert "--write stores full runs" in capsys.readouterr().err
