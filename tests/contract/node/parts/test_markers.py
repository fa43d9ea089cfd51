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

"""~/markers: parts rest on the plate, side by side, and there are not too many
triangles.
"""

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from visualization_msgs.msg import Marker, MarkerArray

from lab.bodies import shapes
from lab.bodies.samples import clamp_hull
from lab.bodies.slow import smooth_body
from lab.bodies.variants import moved

from ..harness.client import until
from ..harness.parts import WEDGE, fine_box, flat, new_id

SURFACES = {
    "wedge": WEDGE,
    "box": shapes.box(0.02, 0.03, 0.05),
    "prism": shapes.prism(7, 0.02, 0.01),
    "needle": shapes.box(0.06, 0.003, 0.002),
    "clamp": moved(clamp_hull(), scale=0.001),
}


class Drawing:
    """What a late joiner gets on ~/markers."""

    def __init__(self, client):
        self._client = client
        self._arrays = []
        self._subscription = client.subscribe(
            MarkerArray,
            f"{client.prefix}/markers",
            self._arrays.append,
            latched=True,
            depth=1,
        )

    def wait(self, condition):
        """The first array that fulfils a condition."""
        return until(lambda: next(filter(condition, self._arrays), None), "markers")

    def of(self, parts):
        """The first array that shows these parts and no others."""
        namespaces = {f"{part_id}/poses" for part_id in parts}
        return self.wait(
            lambda array: {body.ns for body in bodies(array)} == namespaces
        )

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._client.node.destroy_subscription(self._subscription)


def bodies(array, part_id=None):
    """Drawn bodies, of one part or of all."""
    return [
        marker
        for marker in array.markers
        if marker.type == Marker.TRIANGLE_LIST
        and part_id in (None, marker.ns.removesuffix("/poses"))
    ]


def labels(array, part_id):
    return [
        marker
        for marker in array.markers
        if marker.type == Marker.TEXT_VIEW_FACING and marker.ns == f"{part_id}/labels"
    ]


def placed(marker):
    """Corners of a drawn body in the plate's frame."""
    turn = marker.pose.orientation
    position = marker.pose.position
    turned = Rotation.from_quat((turn.x, turn.y, turn.z, turn.w)).apply(
        [(point.x, point.y, point.z) for point in marker.points]
    )
    return turned + np.array((position.x, position.y, position.z))


@pytest.fixture
def results(tuned):
    """Of a part of each body, by name."""
    messages = [
        tuned.good("estimate", part=flat(surface, new_id())).statistics
        for surface in SURFACES.values()
    ]
    return {message.part_id: message for message in messages}


def test_every_pose_rests_on_the_plate_beside_the_others_and_says_its_share(
    tuned, results
):
    def says_all(array):
        return all(
            [label.text for label in labels(array, part_id)]
            == [
                part_id,
                *(
                    f"{pose.index}: {100.0 * pose.probability:.1f} %"
                    for pose in statistics.poses[:16]
                ),
            ]
            for part_id, statistics in results.items()
        )

    with Drawing(tuned) as drawing:
        array = drawing.wait(says_all)  # once the checked estimates are drawn
    assert array.markers[0].action == Marker.DELETEALL
    assert {marker.action for marker in array.markers[1:]} == {Marker.ADD}
    assert {marker.header.frame_id for marker in array.markers[1:]} == {"plate"}
    names = [(marker.ns, marker.id) for marker in array.markers[1:]]
    assert len(names) == len(set(names))
    boxes = []
    for part_id, result in results.items():
        row = bodies(array, part_id)
        texts = labels(array, part_id)
        poses = result.poses[: len(row)]
        assert len(row) == min(len(result.poses), 16)
        assert [marker.id for marker in row] == [pose.index for pose in poses]
        for body, label, pose in zip(row, texts[1:], poses, strict=True):
            corners = placed(body)
            assert corners[:, 2].min() == pytest.approx(0.0, abs=1e-7 * result.radius)
            assert corners[:, 2].max() == pytest.approx(pose.top)
            position = label.pose.position
            offset = np.array((position.x, position.y)) - corners[:, :2].mean(axis=0)
            assert np.linalg.norm(offset) < result.radius and position.z > pose.top
            assert_seen_from_outside(corners.reshape(-1, 3, 3))
            boxes.append((corners[:, :2].min(axis=0), corners[:, :2].max(axis=0)))
        middles = [placed(marker)[:, 0].mean() for marker in row]
        assert all(right > first for first, right in pairwise(middles))
    for position, (low, high) in enumerate(boxes):
        assert all(
            (low > box[1]).any() or (high < box[0]).any() for box in boxes[:position]
        )


def assert_seen_from_outside(triangles):
    """They are counter-clockwise: true of convex bodies only."""
    normals = np.cross(
        triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    )
    outward = triangles.mean(axis=1) - triangles.mean(axis=(0, 1))
    assert (np.einsum("ij,ij->i", normals, outward) > 0.0).all()


def test_fine_meshes_are_thinned_and_still_rest_on_the_plate(tuned):
    """What is drawn is thinned; so is, otherwise, the hull that rests."""
    statistics = tuned.good(
        "estimate", part=flat(smooth_body(12_000), new_id())
    ).statistics
    with Drawing(tuned) as drawing:
        row = bodies(drawing.of([statistics.part_id]))
    for marker in row:
        assert 1000 <= len(marker.points) / 3 <= 4000
        assert abs(placed(marker)[:, 2].min()) < 0.02 * statistics.radius


def test_however_many_parts_there_are_the_drawing_is_bounded(tuned):
    """Undiminished these would be 180 000 triangles."""
    parts, (vertices, triangles) = [new_id() for _ in range(10)], fine_box(3000)
    for number, part_id in enumerate(parts):
        surface = (1.0 + 0.1 * number) * vertices, triangles
        tuned.good("estimate", part=flat(surface, part_id))
    with Drawing(tuned) as drawing:
        row = bodies(drawing.of(parts))
    assert len(row) == 60
    assert all(len(marker.points) / 3 >= 12 for marker in row)  # as many as a box takes
    assert sum(len(marker.points) for marker in row) / 3 <= 40_000


def test_it_follows_parts_and_frame(tuned):
    statistics = tuned.good("estimate", part=flat(WEDGE, new_id())).statistics
    with Drawing(tuned) as drawing:
        drawing.of([statistics.part_id])
        assert tuned.set(plate_frame="feeder") == {}
        drawing.wait(
            lambda array: (
                {marker.header.frame_id for marker in array.markers[1:]} == {"feeder"}
            )
        )
        tuned.good("forget_part", part_id=statistics.part_id)
        drawing.wait(
            lambda array: (
                [marker.action for marker in array.markers] == [Marker.DELETEALL]
            )
        )
