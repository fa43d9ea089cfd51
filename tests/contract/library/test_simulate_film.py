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

"""A drop as a film for Foxglove: where it ends, and what is never shown."""

import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.typesys import Stores, get_typestore
from scipy.spatial.transform import Rotation

from lab.bodies import shapes
from lab.bodies.samples import clamp_hull
from ros_pose_stats import load_part, record_drop, resting_poses
from tests.answers import write_stl
from tests.running import answer

BODIES = {
    "box": shapes.box(40.0, 30.0, 20.0),
    "clamp": clamp_hull(),
    "cylinder": shapes.cylinder(64, 10.0, 30.0),
}


@pytest.fixture(
    scope="module",
    params=[("box", 0.5, 3), ("clamp", 0.0, 3), ("cylinder", 0.0, 0)],
    ids=str,
)
def film(request, tmp_path_factory):
    """Part, recorded drop, seconds, places (n, 3), turns and energies (n,) of the
    frames.
    """
    name, restitution, number = request.param
    folder = tmp_path_factory.mktemp("film")
    stl = write_stl(folder / f"{name}.stl", BODIES[name])
    answer(
        "animate",
        stl,
        "--unit",
        "mm",
        "--drop",
        number,
        "--seed",
        7,
        "--restitution",
        restitution,
        "-o",
        folder / "drop.mcap",
    )
    types = get_typestore(Stores.ROS2_JAZZY)
    seconds = []
    places = []
    turns = []
    energies = []
    with (folder / "drop.mcap").open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages(
            topics=["/tf", "/drop/energy"]
        ):
            read = types.deserialize_cdr(message.data, schema.name)
            if channel.topic == "/drop/energy":
                energies.append(read.data)
                continue
            moved = read.transforms[0].transform
            seconds.append(1e-9 * message.log_time)
            places.append([getattr(moved.translation, axis) for axis in "xyz"])
            turns.append([getattr(moved.rotation, axis) for axis in "xyzw"])
    part = load_part(stl, unit="mm")
    return (
        part,
        record_drop(part, number, restitution, 7),
        np.array(seconds),
        np.array(places),
        Rotation.from_quat(turns),
        np.array(energies),
    )


def corners(film, frame):
    part, _, _, places, turns, _ = film
    return turns[frame].apply(part.vertices) + places[frame]


def test_it_ends_at_rest_in_the_pose_that_the_simulation_counts(film):
    """By a last step that is too small to be seen."""
    part, drop, _, places, turns, _ = film
    pose = resting_poses(part).poses[drop.pose]
    down = turns[-1].inv().apply((0.0, 0.0, -1.0))
    assert (
        pose.rolls or np.linalg.norm(down - pose.down) < 0.05
    )  # any facet of a rim will do
    height = (turns[-1].apply(part.center_of_mass) + places[-1])[2]
    assert height == pytest.approx(pose.height, rel=5e-3)
    assert corners(film, -1)[:, 2].min() == pytest.approx(0.0, abs=2e-3 * drop.radius)
    last_moving = int(
        np.flatnonzero(np.abs(places - places[-1]).max(axis=1) > 1e-12)[-1]
    )
    assert last_moving < len(places) - 10
    assert np.abs(places[last_moving] - places[-1]).max() < 0.15 * drop.radius
    assert (turns[last_moving] * turns[-1].inv()).magnitude() < 0.3


def test_it_is_short_never_gains_energy_and_is_never_below_the_plate(film):
    _, drop, seconds, places, _, energies = film
    assert seconds[-1] - seconds[0] < 10.0 and (np.diff(seconds) > 0.0).all()
    assert (np.diff(energies) <= 0.0).all() and energies[-1] > 0.0
    lowest = min(corners(film, frame)[:, 2].min() for frame in range(len(places)))
    assert lowest > -0.01 * drop.radius
