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

"""What built parts take in memory is bounded; what leaves it is built again."""

import gc
import threading
import weakref
from concurrent.futures import Future, ProcessPoolExecutor
from multiprocessing import get_context
from types import SimpleNamespace
from unittest.mock import MagicMock, Mock

import numpy as np
import pytest
from geometry_msgs.msg import Pose
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import ObservedParts, PoseStatistics, StablePose

from lab.bodies.slow import ROUND
from ros_pose_stats import estimate, part_from_mesh
from ros_pose_stats.base.errors import MeshError
from ros_pose_stats.core.mesh.decimation import thin_out
from ros_pose_stats.core.records.part import memory_bytes
from ros_pose_stats.core.records.scene import DropScene
from ros_pose_stats.node import camera_counts
from ros_pose_stats.node.lanes import Lanes, Rank
from ros_pose_stats.node.messages.part_requests import PartRequest, build_part
from ros_pose_stats.node.parts.intake import Intake
from ros_pose_stats.node.parts.known_part import LatchedResult
from ros_pose_stats.node.parts.registry import PartRegistry
from ros_pose_stats.node.state import State
from tests.contract.node.harness.parts import WEDGE, fine_box, scaled

from .parts import NODE_SCENE, equipment_of
from .weighing import sent_part, used_part, weigh

pytestmark = pytest.mark.filterwarnings(
    "ignore:module 'sre_:DeprecationWarning"  # of a parser that rclpy imports
)

BODIES = {
    "wedge": (WEDGE, used_part),
    "ellipsoid": (ROUND, used_part),
    "box out of a process": (fine_box(3000), sent_part),
    "ellipsoid out of one": (ROUND, sent_part),
}


def test_a_part_weighs_what_it_takes():
    # In a process of its own: threads of other tests would be counted with it.
    with ProcessPoolExecutor(1, get_context("spawn")) as process:
        for name, body in BODIES.items():
            weight, taken = process.submit(weigh, *body).result()
            assert weight == pytest.approx(taken, rel=0.2), name


@pytest.fixture
def registry_of(tmp_path):
    """Makes a registry with a bound, and the state of its parts."""
    states = []

    def begin(most_bytes):
        for earlier_state in states:
            earlier_state.close()
        state = State(tmp_path / "state.sqlite3")
        states.append(state)
        equipment = equipment_of(state=state, max_part_bytes=most_bytes, max_parts=100)
        equipment = equipment._replace(recorder=Mock(bag=tmp_path))
        return PartRegistry(equipment, SimpleNamespace(build=build_part))

    yield begin
    for state in states:
        state.close()


def known_part(registry, surface, part_id, scene_override=NODE_SCENE):
    vertices, triangles = surface
    request = PartRequest(
        part_id,
        np.array(vertices),
        np.array(triangles, np.uint32),
        scene_override=scene_override,
    )
    part, is_new = registry.identify(request)
    assert is_new
    estimate(part.geometry, "split")
    registry.put(part, request)
    return part


def test_parts_beyond_the_bound_leave_memory_and_nothing_else(registry_of):
    part_bytes = memory_bytes(used_part(WEDGE))
    registry = registry_of(3 * part_bytes)
    parts = [
        known_part(registry, scaled(factor), f"part {factor}")
        for factor in np.linspace(1.0, 1.1, 12)
    ]
    is_built = [part.is_built for part in parts]
    assert 1 <= sum(is_built) <= 3 and is_built[-1]
    assert registry.all() == parts
    digests = [part.digest for part in parts]
    assert [part.geometry.digest for part in parts] == digests


def test_a_part_that_leaves_memory_is_freed(registry_of):
    registry = registry_of(10_000)
    reference = weakref.ref(known_part(registry, WEDGE, "first").geometry)
    known_part(registry, scaled(1.1), "second")
    gc.collect()
    assert reference() is None


@pytest.mark.parametrize(
    "unname",
    [
        lambda registry, part: known_part(registry, scaled(1.1), part.part_id),
        lambda registry, part: registry.forget(part),
    ],
    ids=["another mesh", "forgotten"],
)
def test_a_part_whose_name_is_gone_leaves_memory(registry_of, unname):
    registry = registry_of(10**7)
    part = known_part(registry, WEDGE, "part")
    shifted = registry.shift(part, np.array([0.0, 0.0, 1e-4]))
    references = [weakref.ref(each.geometry) for each in (part, shifted)]
    unname(registry, part)
    del part, shifted
    gc.collect()
    assert [reference() for reference in references] == [None, None]


def test_what_a_part_grows_by_counts(registry_of):
    first_surface, second_surface = fine_box(1000), scaled(1.1)
    registry = registry_of(3 * memory_bytes(used_part(fine_box(1000))) // 2)
    first = known_part(registry, first_surface, "first")
    second = known_part(registry, second_surface, "second")
    assert first.is_built
    for sides in range(20, 40):
        estimate(second.geometry, "split", round_sides=sides)
    for _ in range(100):
        registry._look_after_topics()
    assert second.is_built and not first.is_built


def test_a_part_in_work_stays_when_another_mesh_takes_its_name(registry_of):
    registry = registry_of(10_000)
    part = known_part(registry, WEDGE, "part")
    known_part(registry, scaled(1.1), "part")
    known_part(registry, scaled(1.2), "other")
    assert part.geometry.digest == part.digest


@pytest.mark.parametrize(
    "unname",
    [
        lambda registry, part: known_part(registry, scaled(1.1), part.part_id),
        lambda registry, part: registry.forget(part),
    ],
    ids=["another mesh", "forgotten"],
)
def test_a_part_that_has_left_memory_is_built_when_its_name_is_gone(
    registry_of, unname
):
    registry = registry_of(10_000)
    part = known_part(registry, WEDGE, "part")
    known_part(registry, scaled(1.2), "other")
    assert not part.is_built
    unname(registry, part)
    assert part.geometry.digest == part.digest


def stored_file(folder):
    """Of the only large mesh of a state."""
    (file,) = (folder / "state.sqlite3.meshes").iterdir()
    return file


def test_a_damaged_file_of_a_part_that_is_forgotten_is_no_mesh(registry_of, tmp_path):
    registry = registry_of(100_000)
    part = known_part(registry, fine_box(3000), "part")
    known_part(registry, WEDGE, "other")
    file = stored_file(tmp_path)
    content = file.read_bytes()
    registry.forget(part)
    assert part.source.mesh() == content
    with file.open("r+b") as stream:
        stream.write(bytes(100))
    assert part.source.mesh() is None
    with pytest.raises(MeshError, match="none that is as it was written"):
        _ = part.geometry


def test_nobody_waits_for_a_part_while_its_mesh_is_read_for_the_bag(registry_of):
    registry = registry_of(10**7)
    part = known_part(registry, WEDGE, "part")
    part.commons.introduced.drop(lambda key: True)
    begun = threading.Event()
    may_end = threading.Event()

    def read():
        begun.set()
        may_end.wait()
        return b"mesh"

    part.source.mesh = read
    thread = threading.Thread(target=part.introduce)
    thread.start()
    assert begun.wait(60.0)
    is_free = part.lock.acquire(blocking=False)
    if is_free:
        part.lock.release()
    may_end.set()
    thread.join()
    assert is_free


def test_a_part_is_drawn_when_it_has_left_memory(registry_of):
    registry = registry_of(100_000)
    part = known_part(registry, fine_box(3000), "part")
    triangles = part.draw(2000)
    known_part(registry, WEDGE, "other")
    assert not part.is_built and part.can_be_drawn
    np.testing.assert_array_equal(part.draw(2000), triangles)
    coarse = part.draw(100)
    assert 0 < len(coarse) <= 100
    np.testing.assert_allclose(np.ptp(coarse, (0, 1)), np.ptp(triangles, (0, 1)))


def test_a_start_builds_the_parts_used_last_as_far_as_there_is_room(registry_of):
    first_registry = registry_of(10**7)
    for factor in np.linspace(1.0, 1.1, 12):
        known_part(first_registry, scaled(factor), f"part {factor}")
    registry = registry_of(150_000)
    registry.restore()
    parts = registry.all()
    for part in parts:
        part.latched = Mock()
        part.lacks_check = lambda: False
    lanes = Lanes(lambda: 2**20)
    lanes.start()
    try:
        Intake(equipment_of(lanes), registry, Mock(), Mock()).restore()
        lanes.put(lambda: None, Rank.WHEN_IDLE).result(60.0)
    finally:
        lanes.close()
    is_built = [part.is_built for part in parts]
    assert is_built == sorted(is_built) and is_built[-1] and not is_built[0]


def test_a_part_that_somebody_works_on_is_not_built_a_second_time(registry_of):
    registry = registry_of(10_000)
    part = known_part(registry, WEDGE, "part")
    geometry = part.geometry
    known_part(registry, scaled(1.1), "other")
    assert part.is_built and part.geometry is geometry


class Camera:
    """What sends pictures of a part that is not in memory."""

    def __init__(self):
        self.build = Future()
        self.equipment = equipment_of(
            state=Mock(), node=MagicMock(), plate="", plate_frame="plate"
        )._replace(recorder=Mock())
        pose = StablePose()
        result = PoseStatistics(
            cluster_tolerance=0.0025, round_sides=192, poses=6 * [pose]
        )
        self.part = Mock(
            part_id="clamp", latched=LatchedResult(result, result, DropScene())
        )
        self.part.lock = threading.Lock()
        camera_counts.Cameras(
            self.equipment,
            Mock(current=lambda name: self.part),
            lambda part, scene: self.build,
        )
        node = self.equipment.node
        node.create_subscription().handle.take_message.return_value = None
        self._take = node.create_subscription.call_args_list[0].args[2]
        self._sent = 0

    def see(self, parts=1):
        """Send that parts are seen as their mesh is, with z up."""
        self._sent += 1
        self._take(
            serialize_message(ObservedParts(part_id="clamp", poses=parts * [Pose()])),
            {"publication_sequence_number": self._sent, "source_timestamp": self._sent},
        )

    def refusals(self):
        return [call.args[1] for call in self.equipment.refusals.refuse.call_args_list]


def test_what_is_seen_of_a_part_that_has_left_memory_is_counted_once_it_is_built():
    camera = Camera()
    for _ in range(3):
        camera.see()
    assert not camera.part.add_counts.called
    camera.build.set_result(part_from_mesh(*fine_box(100)))
    camera.see()
    counts = [call.args[0] for call in camera.part.add_counts.call_args_list]
    assert [sum(message.count) for message in counts] == [1] * 4
    assert camera.refusals() == []


def test_what_is_seen_of_a_part_that_cannot_be_built_is_refused():
    camera = Camera()
    for _ in range(2):
        camera.see()
    camera.build.set_exception(MeshError("a mesh", "none", "send it again"))
    camera.see()
    assert len(camera.refusals()) == 3
    assert all("send it again" in reason for reason in camera.refusals())
    assert not camera.part.add_counts.called


def test_pictures_wait_for_a_part_within_a_bound():
    """Of 4 MiB, where the largest has one."""
    camera = Camera()
    for _ in range(5):
        camera.see(parts=18_000)
    (reason,) = camera.refusals()
    assert "wait for parts to be built" in reason
    camera.build.set_result(part_from_mesh(*fine_box(100)))
    camera.see()
    counts = [call.args[0] for call in camera.part.add_counts.call_args_list]
    assert [sum(message.count) for message in counts] == [18_000] * 4 + [1]


def test_a_drawing_of_loose_triangles_thins_out():
    corners = np.random.default_rng(1).normal(size=(300, 3, 3))
    assert len(thin_out(corners, 50)) == 50
