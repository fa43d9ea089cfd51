"""Between part messages and requests, without a node."""

from __future__ import annotations

import numpy as np
import pytest
from geometry_msgs.msg import Inertia, Vector3
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import PartMesh

from ros_pose_stats.errors import MeshError, RequestError
from ros_pose_stats.ros.messages.part_messages import (
    is_given,
    part_message,
    request_of_message,
    request_of_part_bytes,
    taken_request,
)
from ros_pose_stats.ros.parts.part_requests import PartRequest, check_name, check_request, part_of

from ..harness.parts import WEDGE, flat, library_part, mesh, nested

FINITE = st.floats(-1e6, 1e6)
INERTIA = Inertia(m=0.4, com=Vector3(x=0.02, y=0.012, z=0.006), ixx=3e-5, iyy=4e-5, izz=5e-5,
                  ixy=1e-6, ixz=-2e-6, iyz=5e-7)


def request(**changes):
    return PartRequest("part", WEDGE[0], WEDGE[1].astype(np.uint32), **changes)


def assert_equal(one, other):
    for name in ("part_id", "unit", "mass", "restitution", "drop_height"):
        assert getattr(one, name) == getattr(other, name), name
    for name in ("vertices", "triangles", "center_of_mass", "inertia"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert one.content == other.content


class TestRoundTrip:
    @given(st.lists(FINITE, min_size=3, max_size=3), st.lists(FINITE, min_size=6, max_size=6),
           st.floats(1e-9, 1e6), FINITE, FINITE, st.integers(1, 2**31 * 10**9 - 1))
    def test_a_request_comes_back(self, center, tensor, unit, restitution, height, stamp):
        xx, xy, xz, yy, yz, zz = tensor
        sent = request(
            unit=unit, mass=2.0, center_of_mass=np.array(center), restitution=restitution,
            drop_height=height, inertia=np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
        message = part_message(sent, "part", stamp)
        assert_equal(request_of_message(message), sent)
        found = request_of_part_bytes(bytes(serialize_message(message)))
        assert_equal(found, sent)
        assert found.stamp == stamp

    @pytest.mark.parametrize("make", [flat, nested])
    def test_what_a_client_sends(self, make):
        message = make(WEDGE, "part", inertia=INERTIA, restitution=0.25)
        found = request_of_message(message)
        part = part_of(found)
        assert part.digest == library_part(
            WEDGE, mass=0.4, center_of_mass=(0.02, 0.012, 0.006),
            inertia=[[3e-5, 1e-6, -2e-6], [1e-6, 4e-5, 5e-7], [-2e-6, 5e-7, 5e-5]]).digest
        assert found.restitution == 0.25

    def test_flat_and_nested_are_the_same_content(self):
        assert (request_of_message(flat(WEDGE)).content
                == request_of_message(nested(WEDGE)).content)

    @pytest.mark.parametrize("change", [
        {"unit": 0.5}, {"mass": 1.0}, {"inertia": np.eye(3)}, {"center_of_mass": np.ones(3)}])
    def test_content_is_all_that_makes_the_part(self, change):
        assert request(**change).content != request().content

    def test_and_not_its_name_and_scene(self):
        other = PartRequest("other", *WEDGE[:1], WEDGE[1].astype(np.uint32), restitution=0.1,
                            drop_height=3.0, stamp=5)
        assert other.content == request().content


class TestTaken:
    @pytest.mark.parametrize("make", [flat, nested])
    def test_a_message_does_not_keep_its_mesh(self, make):
        message = make(WEDGE, "wedge")
        found = taken_request(message)
        assert part_of(found).digest == library_part(WEDGE).digest
        assert not is_given(message) and message.part_id == "wedge"

    def test_nor_does_one_that_is_refused(self):
        message = flat(WEDGE)
        message.triangles.append(1)
        with pytest.raises(MeshError, match="multiple of three"):
            taken_request(message)
        assert not is_given(message)


class TestGiven:
    def test_nothing(self):
        assert not is_given(PartMesh(part_id="part", restitution=0.5))

    @pytest.mark.parametrize("part", [
        flat(WEDGE), nested(WEDGE), PartMesh(vertices=[1.0]), PartMesh(triangles=[1]),
        PartMesh(mesh=mesh((WEDGE[0], WEDGE[1][:0]))),
        PartMesh(mesh=mesh((WEDGE[0][:0], WEDGE[1])))])
    def test_something(self, part):
        assert is_given(part)


class TestRefusals:
    def test_names(self):
        check_name("clamp 4×5, left")
        for name in ("x" * 201, "tab\there", "line\nhere", "bell\a"):
            with pytest.raises(RequestError, match="printable"):
                check_name(name)

    @pytest.mark.parametrize("change", [
        {"unit": 0.0}, {"unit": float("nan")}, {"inertia": np.eye(3)},
        {"center_of_mass": np.ones(3)}])
    def test_requests(self, change):
        check_request(request(), 10**6)
        with pytest.raises(RequestError):
            check_request(request(**change), 10**6)

    def test_a_mesh_that_is_too_large(self):
        size = request().bytes()
        check_request(request(), size)
        with pytest.raises(MeshError, match="max_mesh_bytes"):
            check_request(request(), size - 1)
