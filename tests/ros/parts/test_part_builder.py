"""Large meshes are built in a process of their own, within a time; without a node."""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest

from ros_pose_stats import estimate, shapes
from ros_pose_stats.errors import PoseStatsError
from ros_pose_stats.mesh.patience import TakesLongError
from ros_pose_stats.records import DropScene
from ros_pose_stats.records.scene import DEFAULT_CLUSTER_TOLERANCE, DEFAULT_ROUND_SIDES
from ros_pose_stats.resting.poses import are_found
from ros_pose_stats.ros.parts import part_builder
from ros_pose_stats.ros.parts.lanes import Pace
from ros_pose_stats.ros.parts.part_builder import NotBuiltError, PartBuilder, is_large
from ros_pose_stats.ros.parts.part_requests import PartRequest, part_of

from ..harness.client import until
from ..harness.slow import ellipsoid, is_gone, kill, slivers

PATIENCE = 120.0
LARGE, SLOW = 12_000, 250_000


def request(triangles):
    vertices, faces = ellipsoid(triangles)
    return PartRequest("round", np.asarray(vertices), np.asarray(faces, dtype=np.uint32))


@pytest.fixture
def builder():
    found = PartBuilder()
    yield found
    found.close()


class Attempt:
    """A part that a thread builds."""

    def __init__(self, builder, asked):
        self._builder, self._asked = builder, asked
        self.error = None
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self):
        try:
            build(self._builder, self._asked)
        except Exception as error:
            self.error = error

    def over(self):
        self._thread.join(PATIENCE)
        assert not self._thread.is_alive()
        return self.error


def build(builder, asked):
    return builder.build(asked, DropScene())


def processes(builder, pace=Pace.SLOW):
    """What starts its processes at a pace."""
    return builder._builders[pace]


def process_of(builder):
    """The id of its process, once that has begun."""
    return until(lambda: processes(builder)._process, "a process").process.pid


class TestParts:
    def test_a_small_one_needs_no_process(self, builder):
        vertices, triangles = shapes.box(0.01, 0.02, 0.03)
        part = build(builder, PartRequest("box", vertices, np.asarray(triangles, np.uint32)))
        assert len(estimate(part).poses) == 6
        assert processes(builder)._process is None

    def test_a_large_one_is_the_same_as_here_with_its_poses_at_hand(self, builder):
        asked = request(LARGE)
        assert is_large(asked)
        part, here = build(builder, asked), part_of(asked)
        assert (part.digest, part.part_id) == (here.digest, "round")
        assert are_found(part, DEFAULT_CLUSTER_TOLERANCE, DEFAULT_ROUND_SIDES)
        assert not are_found(here, DEFAULT_CLUSTER_TOLERANCE, DEFAULT_ROUND_SIDES)
        assert [pose.probability for pose in estimate(part).poses] == [
            pose.probability for pose in estimate(here).poses]

    def test_a_bad_one_is_refused_and_the_process_goes_on(self, builder):
        asked = request(LARGE)
        flat = PartRequest("flat", asked.vertices * (1.0, 1.0, 0.0), asked.triangles)
        with pytest.raises(PoseStatsError, match="thick"):
            build(builder, flat)
        process = process_of(builder)
        build(builder, asked)
        assert process_of(builder) == process


class TestTime:
    def test_needles_do_not_keep_the_node(self, builder):
        asked = PartRequest("needles", *slivers(4000))
        assert not is_large(asked)
        begin = time.monotonic()
        with pytest.raises(TakesLongError):
            builder.build(asked, DropScene(), Pace.QUICK)
        tried = time.monotonic()
        here = part_of(asked)
        assert tried - begin < 0.5 * (time.monotonic() - tried)
        part = build(builder, asked)
        assert (part.digest, part.warnings) == (here.digest, here.warnings)

    def test_a_try_is_short(self, builder, monkeypatch):
        monkeypatch.setattr(part_builder, "TRY_SECONDS", 0.2)
        with pytest.raises(TakesLongError):
            builder.build(request(SLOW), DropScene(), Pace.MIDDLE)
        assert processes(builder)._process is None

    def test_poses_of_another_tolerance_are_found_in_the_process_too(self, builder, monkeypatch):
        part, tolerance = build(builder, request(LARGE)), 4.0 * DEFAULT_CLUSTER_TOLERANCE
        assert not are_found(part, tolerance, DEFAULT_ROUND_SIDES)
        builder.find_poses(part, DropScene(cluster_tolerance=tolerance), Pace.SLOW)
        assert are_found(part, tolerance, DEFAULT_ROUND_SIDES)
        monkeypatch.setattr(part_builder, "BUDGET_SECONDS", 1e-4)
        with pytest.raises(PoseStatsError, match="checked within"):
            builder.find_poses(part, DropScene(cluster_tolerance=2.0 * tolerance))


class TestEnds:
    def test_the_time_for_one_mesh(self, builder, monkeypatch):
        monkeypatch.setattr(part_builder, "BUDGET_SECONDS", 0.2)
        asked = request(SLOW)
        with pytest.raises(PoseStatsError) as refusal:
            build(builder, asked)
        assert str(refusal.value) == (
            f"expected a mesh that is checked within 0.2 s, got {len(asked.triangles)} "
            f"triangles; decimate it")
        monkeypatch.undo()
        assert build(builder, request(LARGE)).part_id == "round"

    def test_killed_in_the_middle(self, builder):
        attempt = Attempt(builder, request(SLOW))
        time.sleep(0.1)
        kill(process_of(builder))
        assert isinstance(attempt.over(), NotBuiltError)
        assert "send the mesh again" in str(attempt.error)
        assert build(builder, request(LARGE)).part_id == "round"

    def test_killed_while_it_rests(self, builder):
        build(builder, request(LARGE))
        processes(builder)._process.end()
        assert build(builder, request(LARGE)).part_id == "round"

    def test_closed_in_the_middle(self, builder):
        attempt = Attempt(builder, request(SLOW))
        process = process_of(builder)
        builder.close()
        assert "a running node" in str(attempt.over())
        assert until(lambda: is_gone(process))
        assert "a running node" in str(Attempt(builder, request(LARGE)).over())

    def test_it_ends_when_nothing_comes(self, builder, monkeypatch):
        monkeypatch.setattr(part_builder, "IDLE_SECONDS", 0.1)
        build(builder, request(LARGE))
        assert until(lambda: processes(builder)._process is None)
