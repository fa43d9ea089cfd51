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

"""A drop as `animate` writes it for Foxglove, with the definitions that other tools
need.
"""

from collections import defaultdict

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from lab.bodies import shapes
from ros_pose_stats import load_part, resting_poses
from tests.answers import write_stl
from tests.running import answer

MASS = 0.3
CENTER = (1e-3, 2e-3, 3e-3)
GRAVITY = 9.80665


def test_other_tools_read_part_plate_and_energy_by_the_film_s_own_definitions(tmp_path):
    stl = write_stl(tmp_path / "box.stl", shapes.box(40.0, 30.0, 20.0))
    answer(
        "animate",
        stl,
        "--unit",
        "mm",
        "--com",
        *CENTER,
        "--mass",
        MASS,
        "--drop",
        3,
        "-o",
        tmp_path / "drop.mcap",
    )
    part = load_part(stl, unit="mm", center_of_mass=CENTER)
    by_topic = defaultdict(list)
    typestore = get_typestore(Stores.ROS2_JAZZY)
    with (tmp_path / "drop.mcap").open("rb") as stream:
        reader = make_reader(
            stream, validate_crcs=True, decoder_factories=[DecoderFactory()]
        )
        for schema, channel, _, decoded in reader.iter_decoded_messages():
            if channel.topic not in by_topic:
                store = get_typestore(Stores.EMPTY)
                store.register(get_types_from_msg(schema.data.decode(), schema.name))
                assert store.hash_rihs01(schema.name) == typestore.hash_rihs01(
                    schema.name
                )
            by_topic[channel.topic].append(decoded)
    body, plate = by_topic["/drop/markers"][0].markers
    points = np.array([[point.x, point.y, point.z] for point in body.points])
    assert points == pytest.approx(
        part.vertices[part.triangles].reshape(-1, 3), abs=1e-8
    )
    assert (body.header.frame_id, plate.header.frame_id) == ("part", "plate")
    assert plate.pose.position.z + 0.5 * plate.scale.z == pytest.approx(0.0)
    # The last energy, in joules, is that of the centre of mass in a pose.
    heights = np.array([pose.height for pose in resting_poses(part).poses])
    last = by_topic["/drop/energy"][-1].data
    assert np.abs(last / (MASS * GRAVITY * heights) - 1.0).min() < 1e-3
    assert len(by_topic["/drop/energy"]) == len(by_topic["/tf"])
