"""A drop as MCAP, read back by other people's readers."""

import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from ros_pose_stats import part_from_mesh, resting_poses
from ros_pose_stats.recording.writer.drop_film import BODY, ENERGY, REACH, TF, TYPES, write_film
from ros_pose_stats.recording.writer.message_types import (
    fields,
    message_type,
    split_definition,
)
from ros_pose_stats.resting.orientation import rotation_matrices
from ros_pose_stats.shapes.closed_forms import box
from ros_pose_stats.simulation.frames import drop_frames, watchable_drop


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    part = part_from_mesh(*box(0.04, 0.03, 0.02), center_of_mass=(0.001, 0.002, 0.003))
    found = watchable_drop(part, 3, 0.5, 7, None, 0.005, 0)
    frames = drop_frames(part, found, resting_poses(part, round_sides=0))
    file = tmp_path_factory.mktemp("film") / "drop.mcap"
    write_film(file, part, frames, lambda energy: f"{energy:.3g} J")
    return part, found, frames, file


SHARE = Path(sys.prefix) / "share"
"""Where the interface packages of the wheels are."""


def messages(file, topic):
    with file.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        return [(message.log_time, told) for _, _, message, told in
                reader.iter_decoded_messages([topic])]


def test_transforms_are_the_motion(film):
    part, found, frames, file = film
    told = messages(file, TF)
    assert len(told) == len(frames.times)
    assert all(a[0] < b[0] for a, b in pairwise(told))
    for k in (0, len(told) // 2, -1):
        (one,) = told[k][1].transforms
        assert (one.header.frame_id, one.child_frame_id) == ("plate", "part")
        turn, place = one.transform.rotation, one.transform.translation
        assert [turn.x, turn.y, turn.z, turn.w] == pytest.approx(frames.orientations[k])
        center = rotation_matrices(frames.orientations)[k] @ part.center_of_mass
        assert np.array([place.x, place.y, place.z]) + center == pytest.approx(
            [0.0, 0.0, frames.heights[k]], abs=1e-12)
    assert found.pose >= 0


def test_markers_are_the_part_and_the_plate(film):
    part, _, _, file = film
    told = messages(file, BODY)
    body, plate = told[0][1].markers
    points = np.array([[p.x, p.y, p.z] for p in body.points])
    assert points == pytest.approx(part.surface_vertices[part.surface_triangles].reshape(-1, 3))
    assert (body.header.frame_id, body.type, body.frame_locked) == ("part", 11, True)
    assert (plate.header.frame_id, plate.type) == ("plate", 1)
    assert plate.pose.position.z + 0.5 * plate.scale.z == pytest.approx(0.0)
    assert (body.pose.orientation.w, body.scale.x, body.color.a) == (1.0, 1.0, 1.0)
    assert len(told) > 1


def test_energy_falls_and_words_go_with_it(film):
    _, _, frames, file = film
    assert [one.data for _, one in messages(file, ENERGY)] == pytest.approx(frames.energies)
    assert [one.data for _, one in messages(file, REACH)] == [
        f"{energy:.3g} J" for energy in frames.energies]


def test_definitions_are_those_of_the_installed_interfaces():
    for ours in (TYPES[topic] for topic in (BODY, ENERGY, REACH)):
        theirs = split_definition(ours.name, message_type(
            ours.name, lambda package: SHARE / package).definition)
        mine = split_definition(ours.name, ours.definition)
        assert mine.keys() == theirs.keys()
        for name, text in mine.items():
            package = name.partition("/")[0]
            assert list(fields(text, package)) == list(fields(theirs[name], package)), name
