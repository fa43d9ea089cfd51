"""Drawings of the poses: parts rest on the plate, side by side, and there are not too many."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from rclpy.serialization import deserialize_message
from scipy.spatial.transform import Rotation
from visualization_msgs.msg import Marker, MarkerArray

from ros_pose_stats import estimate, part_from_mesh, shapes
from ros_pose_stats.mesh.decimation import visible_triangles
from ros_pose_stats.ros.messages.markers import (
    FINENESS,
    MOST_TRIANGLES,
    poses_each,
    triangles_each,
)
from ros_pose_stats.ros.messages.markers import marker_array as marker_bytes
from ros_pose_stats.ros.messages.statistics_messages import Answer, statistics_message
from tests.bodies import convex_parts, subdivided

from ..harness.cell import QuickClient
from ..harness.client import until
from ..harness.jobs import known_part
from ..harness.parts import WEDGE

PARTS = {**convex_parts(), "wedge": part_from_mesh(*WEDGE, part_id="wedge")}


def marker_array(rows):
    """The markers, read by rclpy."""
    return deserialize_message(marker_bytes(rows), MarkerArray)


def drawn(part, name="part", most=1000):
    """A row of one part: its statistics as a message, and its triangles."""
    found = statistics_message(estimate(part), Answer(0, "plate", "", 1))
    found.part_id = name
    return found, visible_triangles(part, most)


def bodies(array):
    return [one for one in array.markers if one.type == Marker.TRIANGLE_LIST]


def labels(array):
    return [one for one in array.markers if one.type == Marker.TEXT_VIEW_FACING]


def placed(marker):
    """Corners of a drawn body in the plate's frame."""
    points = np.array([(p.x, p.y, p.z) for p in marker.points])
    turn, place = marker.pose.orientation, marker.pose.position
    turned = Rotation.from_quat((turn.x, turn.y, turn.z, turn.w)).apply(points)
    return turned + np.array((place.x, place.y, place.z))


@pytest.fixture(scope="module")
def array():
    """A row for every part."""
    return marker_array([drawn(part, name) for name, part in PARTS.items()])


class TestBodies:
    @pytest.mark.parametrize("name", PARTS)
    def test_rest_on_the_plate(self, name):
        found, soup = drawn(PARTS[name])
        for marker in bodies(marker_array([(found, soup)])):
            z = placed(marker)[:, 2] / found.radius
            assert z.min() == pytest.approx(0.0, abs=1e-7)

    @pytest.mark.parametrize("most", [4000, 1000, 250, 100])
    def test_of_many_triangles_are_thinned(self, most):
        surface = shapes.box(1.0, 1.0, 1.0)
        for _ in range(6):
            surface = subdivided(surface)
        vertices, triangles = surface
        vertices = vertices / np.linalg.norm(vertices, axis=1)[:, None] * (0.02, 0.03, 0.05)
        part = part_from_mesh(vertices, triangles)
        assert len(triangles) > 20_000
        found, soup = drawn(part, most=most)
        assert most // 2 < len(soup) <= most
        for marker in bodies(marker_array([(found, soup)])):
            z = placed(marker)[:, 2] / found.radius
            # Drawn are the mesh's own corners; what rests is its hull, thinned to the height of
            # an arc of 64 sides, from either side.
            assert abs(z.min()) < 2.0 * (1.0 - math.cos(math.pi / 64)) or (
                0.0 < z.min() < (0.02 if most > 250 else 0.1))

    def test_are_seen_from_outside(self):
        """Their triangles are counter-clockwise."""
        for marker in bodies(marker_array([drawn(PARTS["wedge"])])):
            points = placed(marker).reshape(-1, 3, 3)
            normals = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
            outward = points.mean(axis=1) - points.mean(axis=(0, 1))
            assert (np.einsum("ij,ij->i", normals, outward) > 0.0).all()

    def test_do_not_overlap(self, array):
        boxes = [(placed(one)[:, :2].min(axis=0), placed(one)[:, :2].max(axis=0))
                 for one in bodies(array)]
        for k, (low, high) in enumerate(boxes):
            for other_low, other_high in boxes[:k]:
                assert (low > other_high).any() or (high < other_low).any()

    def test_stand_in_a_row_a_part_most_probable_first(self, array):
        for name, part in PARTS.items():
            row = [one for one in bodies(array) if one.ns == f"{name}/poses"]
            poses = estimate(part).poses[:poses_each(len(PARTS))]
            assert [one.id for one in row] == [pose.index for pose in poses]
            middles = [placed(one).mean(axis=0) for one in row]
            assert all(b[0] > a[0] for a, b in pairwise(middles))


class TestArray:
    def test_begins_by_deleting_what_was_there(self, array):
        assert array.markers[0].action == Marker.DELETEALL
        assert all(one.action == Marker.ADD for one in array.markers[1:])
        assert [one.action for one in marker_array([]).markers] == [Marker.DELETEALL]

    def test_everything_is_in_the_plates_frame_and_has_a_name_of_its_own(self, array):
        assert {one.header.frame_id for one in array.markers[1:]} == {"plate"}
        names = [(one.ns, one.id) for one in array.markers[1:]]
        assert len(names) == len(set(names))

    def test_labels_name_pose_and_share(self):
        found, soup = drawn(PARTS["wedge"], "wedge")
        array = marker_array([(found, soup)])
        texts = [one.text for one in labels(array)]
        assert texts[0] == "wedge"
        assert texts[1:] == [f"{pose.index}: {100.0 * pose.probability:.1f} %"
                             for pose in found.poses]
        for label, body, pose in zip(labels(array)[1:], bodies(array), found.poses, strict=True):
            assert label.pose.position.z > pose.top
            middle = placed(body)[:, :2].mean(axis=0)
            where = np.array((label.pose.position.x, label.pose.position.y))
            assert np.linalg.norm(where - middle) < found.radius

    def test_an_unknown_probability(self):
        found, soup = drawn(PARTS["wedge"])
        found.poses[0].probability = float("nan")
        assert labels(marker_array([(found, soup)]))[1].text == f"{found.poses[0].index}: -"

    @pytest.mark.parametrize("parts", [1, 10, 100, 256, 1000])
    def test_is_bounded(self, parts):
        poses = parts * poses_each(parts)
        assert poses * triangles_each(poses) <= max(MOST_TRIANGLES, FINENESS[-1] * poses)
        assert poses <= 400 or triangles_each(poses) == FINENESS[-1]


class Markers:
    """What a late joiner gets on ~/markers."""

    def __init__(self, client):
        self._arrays = []
        self._client = client
        self._subscription = client.subscribe(
            MarkerArray, f"{client.prefix}/markers", self._arrays.append, latched=True, depth=1)

    def wait(self, condition):
        """The first array from now on that fulfils a condition."""
        return until(lambda: next(filter(condition, self._arrays), None), "markers")


class TestTopic:
    def test_follows_the_parts(self, domain, cell):
        part_id = known_part(cell)

        def shows(array):
            return f"{part_id}/poses" in {one.ns for one in array.markers}

        with QuickClient(domain) as late:
            array = Markers(late).wait(shows)
            assert array.markers[0].action == Marker.DELETEALL
            for marker in bodies(array):
                assert placed(marker)[:, 2].min() > -1e-6
            texts = [one.text for one in labels(array) if one.ns == f"{part_id}/labels"]
            assert texts[0] == part_id and all(text.endswith(" %") for text in texts[1:])
            cell.good("forget_part", part_id=part_id)
            Markers(late).wait(lambda array: not shows(array))

    @pytest.mark.long
    def test_is_in_the_frame_that_the_parameter_names(self, domain, cell):
        part_id = known_part(cell)
        try:
            cell.set(plate_frame="feeder")
            with QuickClient(domain) as late:
                Markers(late).wait(lambda array: {
                    one.header.frame_id for one in array.markers
                    if one.ns.startswith(part_id)} == {"feeder"})
        finally:
            cell.set(plate_frame="plate")
