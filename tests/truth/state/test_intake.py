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

"""What takes long in building a part holds up nothing quick, and not for ever."""

import os
import threading
import weakref
from collections import Counter
from functools import partial
from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest
from geometry_msgs.msg import Vector3
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs import srv
from ros_pose_stats_msgs.msg import (
    Code,
    PoseCounts,
    PoseStatistics,
    StablePose,
)

from lab.bodies import exports
from ros_pose_stats import part_from_mesh, resting_poses
from ros_pose_stats.base import errors
from ros_pose_stats.base.errors import BatchError, MeshError, RequestError
from ros_pose_stats.base.worker import WorkerProcess
from ros_pose_stats.core.mesh.bodies.overlap import TakesLongError
from ros_pose_stats.core.records.scene import DropScene, Numbering
from ros_pose_stats.node.answering_node import advance, answer_request
from ros_pose_stats.node.jobs.refinement import Refinement
from ros_pose_stats.node.lanes import Lane, Lanes, Rank
from ros_pose_stats.node.messages.codes import refusal_at_end
from ros_pose_stats.node.messages.part_requests import PartRequest
from ros_pose_stats.node.parts.intake import LARGE_BYTES, Intake
from ros_pose_stats.node.parts.part_counts import Ground, PartCounts, Tally
from ros_pose_stats.node.parts.registry import PartRegistry
from ros_pose_stats.node.services.plate_fits import PlateFits

from .parts import equipment_of, known_part, source_of

TETRAHEDRON = (
    [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
    [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
)


@pytest.fixture
def lanes():
    queue = Lanes(lambda: 2**20)
    queue.start()
    yield queue
    queue.close()


def occupied(lanes, lane):
    """What ends the task that keeps a lane busy."""
    begun = threading.Event()
    may_end = threading.Event()

    def work():
        begun.set()
        may_end.wait()

    lanes.put(work, Rank.KNOWN_PART, lane)
    assert begun.wait(60.0)
    return may_end


def large_part(begun, may_end):
    def build():
        begun.set()
        may_end.wait()
        return part_from_mesh(*TETRAHEDRON)

    part = known_part(source_of(build), part_id="large")
    part.size = LARGE_BYTES + 1
    return part


def test_a_large_part_that_is_asked_for_is_built_beside_quick_ones(lanes):
    begun = threading.Event()
    may_end = threading.Event()
    large_one = large_part(begun, may_end)
    intake = Intake(equipment_of(lanes), None, None, None)
    try:
        large = intake.build_known(large_one)
        assert begun.wait(60.0)
        assert lanes.put(lambda: "quick", Rank.KNOWN_PART).result(60.0) == "quick"
        assert not large.done()
    finally:
        may_end.set()
    assert large.result(60.0) is large_one.geometry and large_one.is_built


def test_a_large_mesh_of_a_request_waits_behind_few_others(lanes):
    """Those that follow are refused, so that no client waits for an hour."""
    may_end = occupied(lanes, Lane.SLOW)
    order = []
    futures = [
        lanes.put(partial(order.append, number), Rank.KNOWN_PART, Lane.SLOW)
        for number in range(60)
    ]
    futures_of_requests = [
        lanes.put(partial(order.append, "sent"), Rank.REQUESTED_MESH, Lane.SLOW)
        for _ in range(9)
    ]
    may_end.set()
    with pytest.raises(RequestError, match="at most 8 large meshes"):
        futures_of_requests[-1].result(60.0)
    futures[-1].result(60.0)
    assert order == ["sent"] * 8 + list(range(60))


def test_checks_wait_for_meshes_that_are_soon_built_and_no_longer(lanes):
    may_end = occupied(lanes, Lane.QUICK)
    lanes.put(lambda: None, Rank.PUBLISHED_MESH)
    later = lanes.put(lanes.count_meshes, Rank.WHEN_IDLE, Lane.CHECK)
    assert (
        lanes.put(lambda: "asked for", Rank.KNOWN_PART, Lane.CHECK).result(60.0)
        == "asked for"
    )
    assert not later.done()
    may_end.set()
    assert later.result(60.0) == 0


def test_a_process_that_does_not_start_is_given_up(tmp_path, monkeypatch):
    (tmp_path / "sitecustomize.py").write_text("import time\ntime.sleep(600.0)\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    with pytest.raises(BatchError, match="took longer"):
        WorkerProcess(0.2)


@pytest.mark.parametrize("rank", [Rank.REQUESTED_MESH, Rank.PUBLISHED_MESH])
def test_an_older_mesh_of_a_name_comes_first_though_it_takes_long(lanes, rank):
    begun = threading.Event()
    may_end = threading.Event()
    order = []

    def build():
        begun.set()
        may_end.wait()
        if lanes.is_quick():
            raise TakesLongError
        order.append("older")

    older = lanes.put(build, Rank.PUBLISHED_MESH, Lane.QUICK, 0, "clamp")
    assert begun.wait(60.0)
    newer = lanes.put(partial(order.append, "newer"), rank, Lane.SLOW, 0, "clamp")
    may_end.set()
    assert [older.result(60.0), newer.result(60.0), order] == [
        None,
        None,
        ["older", "newer"],
    ]


def test_a_failing_refinement_keeps_no_other_part_from_being_checked(lanes):
    lines = []
    checked_event = threading.Event()
    node = Mock()
    jobs = Mock(cancel_refinement=Mock(side_effect=OSError("no room")))
    node.get_logger().error = lambda line: (
        checked_event.set() if lines else lines.append(line)
    )
    parts = {name: Mock(part_id=name) for name in ("first", "last")}
    equipment = equipment_of(
        lanes,
        node=node,
        refine_drops=0,
        drops=1,
        max_drops=1,
        target_error=0.0,
        scene=Mock(),
        default_method="area",
        max_job_seconds=1.0,
    )
    refinement = Refinement(equipment, Mock(current=parts.get), jobs)
    may_end = occupied(lanes, Lane.CHECK)
    for part in parts.values():
        refinement.follow(part)
    may_end.set()
    assert (
        checked_event.wait(60.0)
        and "'first' could not be refined: OSError: no room" in lines[0]
    )


def test_a_mesh_that_is_sent_waits_for_no_file_that_is_read(lanes):
    """Which file a request names is looked at where files are read, and only there."""
    may_end = occupied(lanes, Lane.FILE)
    known = object()
    equipment = equipment_of(
        lanes, max_mesh_bytes=2**20, mesh_folders=[], scene=lambda override: None
    )
    parts = Mock(identify=Mock(return_value=(known, False)))
    intake = Intake(equipment, parts, None, None)
    vertices, triangles = map(np.array, TETRAHEDRON)
    named, sent = (
        intake.queue(request, "a client", Rank.REQUESTED_MESH)
        for request in (
            PartRequest("named", vertices[:0], triangles[:0], resource="nowhere"),
            PartRequest("sent", vertices, triangles),
        )
    )
    try:
        assert sent.result(60.0) is known
        assert not named.done()
    finally:
        may_end.set()
    with pytest.raises(RequestError, match="file:///FILE"):
        named.result(60.0)


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (refusal_at_end(), Code.BUSY),
        (errors.TimedOutError("a second", "two", "wait"), Code.TIMED_OUT),
        (errors.MeshFileError("a mesh", "none", "send one"), Code.BAD_MESH),
        (errors.MassPropertiesError("a mass", "none", "give it"), Code.BAD_VALUE),
        (errors.PoseStatsError("work", "none", "see the log"), Code.INTERNAL),
        (OSError("no room"), Code.INTERNAL),
    ],
)
def test_a_failure_has_a_code_too(error, code):
    failures = []
    response = srv.ForgetPart.Response()
    request = srv.ForgetPart.Request()
    advance(answer_request(Mock(side_effect=error), failures.append, request, response))
    assert (response.success, response.code) == (False, code)
    assert len(failures) == isinstance(error, OSError)


def test_fits_hold_up_no_other_answer_and_are_refused_at_the_end(lanes):
    begun = threading.Event()
    may_end = threading.Event()
    large = large_part(begun, may_end)
    large.counts.tally = Tally(Ground(Numbering(0.0, 0), ""), np.array([50]), 1)
    service = PlateFits(
        equipment_of(lanes, plate=""),
        Mock(all=lambda: [large]),
        None,
    )
    answers = [
        SimpleNamespace(success=False, message="", is_there=threading.Event())
        for _ in range(2)
    ]

    def answer(response):
        request = SimpleNamespace(plate="", apply=False)
        yield from answer_request(service.answer, print, request, response)
        response.is_there.set()

    for response in answers:
        advance(answer(response))
    assert begun.wait(60.0)
    assert not any(response.is_there.is_set() for response in answers)
    lanes.close()
    may_end.set()
    for response in answers:
        assert response.is_there.wait(60.0)
        assert "running node" in response.message


def counts_on(sides, plate="glass", total=4):
    """Counts on a plate, of a part with four poses of which nothing else is known."""
    node = Mock()
    equipment = equipment_of(
        state=Mock(get=lambda *key: None), node=node, plate="glass", profile=None
    )
    counts = PartCounts(equipment, "clamp", "")
    counts.tally = Tally(
        Ground(Numbering(0.0025, sides), plate), np.ones(total, np.int64), 1
    )
    return counts, node.get_logger().warning


def result_of_tetrahedron():
    """A result with the file's own round surfaces, as far as counts look at it."""
    return PoseStatistics(
        cluster_tolerance=0.0025, round_sides=0, poses=[StablePose()] * 4
    )


@pytest.mark.parametrize(
    ("plate", "sides", "total", "is_lacking"),
    [
        ("oak", 0, 4, False),
        ("oak", 192, 3, False),
        ("glass", 192, 4, True),
        ("glass", 0, 3, True),
    ],
)
def test_counts_that_may_not_fit_a_result_are_left_out_until_they_are_compared(
    plate, sides, total, is_lacking
):
    """Those of another plate are never compared: that might build the part."""
    counts, _ = counts_on(sides, plate, total)
    message = result_of_tetrahedron()
    assert counts.combine(message, Mock()) is None
    assert counts.lack_comparison(message) == is_lacking


def test_counts_that_are_in_the_state_alone_are_compared_too():
    row = ("clamp", "", 0.0025, 0, "glass", np.ones(3, np.int64).tobytes(), 1)
    state = Mock(get=lambda table, key: row if table == "counts" else None)
    counts = PartCounts(
        equipment_of(state=state, plate="glass", profile=None), "clamp", ""
    )
    assert counts.lack_comparison(result_of_tetrahedron())


def test_counts_go_on_under_other_sides_once_the_part_has_compared_them():
    part = part_from_mesh(*TETRAHEDRON)
    counts, warn = counts_on(192)
    message = result_of_tetrahedron()
    counts.compare(part, Numbering(0.0025, 0))
    assert not counts.lack_comparison(message)
    assert counts.add(PoseCounts(index=[2], count=[3]), message)
    assert counts.tally.total.tolist() == [1, 1, 4, 1]
    assert counts.tally.ground.numbering == Numbering(0.0025, 0)
    warn.assert_not_called()


def test_counts_of_other_poses_are_set_aside_where_no_result_tells_their_down():
    counts, warn = counts_on(0, total=3)
    message = result_of_tetrahedron()
    counts.compare(part_from_mesh(*TETRAHEDRON), Numbering(0.0025, 0))
    assert counts.tally is None and not counts.lack_comparison(message)
    assert "0 of 3 parts" in warn.call_args.args[0]


@pytest.mark.filterwarnings(
    "ignore:module 'sre_:DeprecationWarning"
)  # messages as text
def test_counts_of_a_version_with_other_poses_go_to_those_with_their_down():
    """A gear of which an earlier version made a pose of each tooth."""
    part = part_from_mesh(*exports.gear(20), unit="mm")
    old, new = (resting_poses(part, tolerance).poses for tolerance in (0.0, 0.0025))
    assert (len(old), len(new)) == (42, 3)
    message = PoseStatistics(part_digest="gear")
    for pose in old:
        x, y, z = pose.down.tolist()
        message.poses.append(StablePose(index=pose.index, down=Vector3(x=x, y=y, z=z)))
    rows = {"results": ("gear", serialize_message(message), b"", 1)}
    stored = []
    state = Mock(get=lambda table, key: rows.get(table))
    state.put = lambda *changes: stored.extend(changes) or 7
    node = Mock()
    equipment = equipment_of(state=state, node=node, plate="", profile=None)
    counts = PartCounts(equipment, "gear", "gear")
    total = np.arange(1, 43)
    ground = Ground(Numbering(0.0025, 192), "")
    counts.tally = Tally(ground, total, 5)
    counts.tally.flips["slow"] = Counter({(0, 7): 3, (9, 8): 4})
    result = PoseStatistics(
        cluster_tolerance=0.0025, round_sides=192, poses=[StablePose()] * len(new)
    )
    assert counts.lack_comparison(result)
    counts.compare(part, ground.numbering)
    assert not counts.lack_comparison(result)
    lying = [pose.index for pose in old if abs(pose.down[2]) < 0.5]
    rim = next(pose.index for pose in new if abs(pose.down[2]) < 0.5)
    assert counts.tally.total[rim] == total[lying].sum()
    assert counts.tally.total.sum() == total.sum()
    assert counts.tally.series == 5
    assert sum(counts.tally.flips["slow"].values()) == 7
    assert {change.table for change in stored} == {"counts", "flips"}
    (note,) = node.get_logger().warning.call_args.args
    assert "had 42 poses" in note and "903 of 903 parts" in note


def failure(registry, request):
    """Words of a refusal, whose error ends here: no collection has to find it."""
    try:
        registry.identify(request)
    except MeshError as error:
        return str(error)


def test_nothing_holds_on_to_a_mesh_that_is_refused():
    def build(request):
        raise MeshError("a closed mesh", "an open one", "close it")

    equipment = equipment_of(max_part_bytes=2**20)
    registry = PartRegistry(equipment, SimpleNamespace(build=build))
    for _ in range(2):  # the second time its refusal is remembered
        request = PartRequest("clamp", *map(np.array, TETRAHEDRON))
        reference = weakref.ref(request)
        assert "an open one" in failure(registry, request)
        del request
        assert reference() is None


def test_a_part_that_the_end_of_the_node_keeps_from_being_shown_again_is_not_forgotten(
    lanes,
):
    source = source_of(lambda: part_from_mesh(*TETRAHEDRON))
    part = known_part(source, equipment_of(lanes, scene=DropScene))
    part.show_best = Mock()
    part.compare_counts = Mock()
    parts = Mock()
    parts.all.return_value = [part]
    intake = Intake(
        equipment_of(lanes, scene=DropScene),
        parts,
        Mock(),
        Mock(side_effect=refusal_at_end()),
    )
    intake.restore()
    with pytest.raises(RequestError, match="running node"):
        intake.restored[0].result(60.0)
    parts.forget.assert_not_called()


def test_a_part_is_shown_once_for_all_changes_of_settings_that_came_meanwhile(lanes):
    equipment = equipment_of(lanes, scene=DropScene)
    part = known_part(source_of(lambda: part_from_mesh(*TETRAHEDRON)), equipment)
    part.show_best = Mock()
    part.compare_counts = Mock()
    intake = Intake(equipment, Mock(all=lambda: [part]), Mock(), Mock())
    may_end = occupied(lanes, Lane.QUICK)
    for _ in range(3):
        intake.show_all_again()
    may_end.set()
    for times in (1, 2):
        lanes.put(lambda: None, Rank.WHEN_IDLE).result(60.0)  # those before are done
        assert part.show_best.call_count == times
        intake.show_all_again()
