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

"""What cameras count and see: on record as it came, and what the node learns from
it.
"""

import itertools
import math
import signal
import sqlite3
from contextlib import closing

import numpy as np
import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Pose, Quaternion
from rclpy.qos import qos_profile_sensor_data
from ros_pose_stats_msgs.msg import ObservedParts

from tests.running import answer

from .harness.bags import on_topic, raw_of, recorded
from .harness.camera import counted, counting, learnt, lying, picture, seeing
from .harness.cell import Health, latched
from .harness.client import until
from .harness.goals import planned
from .harness.parts import WEDGE, counts, flat, new_id, prism, probabilities


@pytest.fixture
def model(tuned):
    """What the node has of a part on a plate of glass, before anything was seen of
    it.
    """
    assert tuned.set(plate="glass", plate_frame="table") == {}
    return tuned.good("estimate", part=flat(WEDGE, new_id())).statistics


def counts_of(node, part_id, number=1):
    """The recorded counts of a part, once there are so many."""

    def there():
        counts = [
            message
            for message in recorded(node.log_directory, "pose_counts")
            if message.part_id == part_id
        ]
        return counts if len(counts) >= number else None

    return until(there, f"{number} counts in the bag")


def test_counts_that_cannot_be_compared_are_recorded_and_told(node, tuned, model):
    bad = {
        "2 pose indices and 1 counts": {"index": [0, 1], "count": [5]},
        "is known": {"part_id": "nobody"},
        "it names the plate 'steel', and the node's is 'glass'": {"plate": "steel"},
        "it counts more than 1000000 parts": {"count": [10**6, 1]},
        "more than 1000000 parts": {
            "index": [2**32 - 1, 0],
            "count": 2 * [2**64 - 1],
            "unclassified": 2**64 - 1,
        },
        "it has the drop_height nan; a negative one": {"drop_height": math.nan},
        f"{model.part_id}' has no pose 99": {"index": [0, 99]},
        f"{model.part_id}' has no pose 77": {"from_pose": 77, "feeder_setting": "slow"},
        "a from_pose and 0 characters of feeder_setting": {"from_pose": 1},
    }
    camera = counting(tuned)
    for words, fields in bad.items():
        camera.publish(counted(model, [50, 50], **fields))
        node.says(f"{tuned.prefix}/pose_counts: recorded, but ")
        node.says(words)
    counts_of(node, model.part_id, len(bad) - 1)
    camera.publish(
        b"\0\1\0\0" + b"\xee" * 40,
        counted(model, [], index=2**18 * [7]),
        counted(model, [7], numbering=0, plate=""),
    )
    node.says(
        f"{tuned.prefix}/pose_counts: count refused: expected a serialised PoseCounts"
    )
    learnt(tuned, model.part_id, 7)
    messages = raw_of(node.log_directory, on_topic("pose_counts"))
    assert not any(b"\xee" * 40 in data or len(data) > 2**20 for data in messages)


def test_counts_under_another_numbering_are_refused_with_a_code(node, tuned, model):
    """On /diagnostics, too; those of no numbering are of the present one."""
    other = model.numbering ^ 1
    reason = (
        f"OTHER_NUMBERING: expected {model.numbering} of the present result of "
        f"'{model.part_id}', or 0 for it, got {other}"
    )
    health = Health(tuned)
    camera = counting(tuned)
    camera.publish(counted(model, [50, 50], numbering=other))
    node.says(f"{tuned.prefix}/pose_counts: count refused: {reason}")
    counts_of(node, model.part_id)
    health.eventually(
        "parts", lambda _, values: any(reason in value for value in values.values())
    )
    eyes = seeing(tuned)
    pose = lying(model.poses[0])
    eyes.publish(picture(model.part_id, pose, numbering=other))
    node.says(f"{tuned.prefix}/observed_parts: message refused: {reason}")
    eyes.publish(picture(model.part_id, pose, numbering=model.numbering))
    camera.publish(counted(model, [7], numbering=0))
    learnt(tuned, model.part_id, 8)


def test_each_part_seen_is_counted_in_its_pose(node, tuned, model):
    """Whatever its yaw, and though it leans a little."""
    poses = {pose.index: pose for pose in model.poses}
    first = min(poses)
    last = max(poses)
    unknown = Pose(orientation=Quaternion(x=math.nan, y=0.0, z=0.0, w=0.0))
    yaws = np.linspace(-3.0, 3.0, 7).tolist()
    message = picture(
        model.part_id,
        *(lying(poses[first], yaw, math.radians(4.0)) for yaw in yaws),
        lying(poses[last], 1.0),
        lying(poses[last], 2.0),
        unknown,
        frame="table",
        confidence=[0.9] * 7 + [0.8, 0.3, 1.0],
    )
    seeing(tuned).publish(message)
    (counts,) = counts_of(node, model.part_id)
    assert dict(zip(counts.index, counts.count, strict=True)) == {first: 7, last: 1}
    assert counts.unclassified == 2 and counts.header == message.header
    for name in ("numbering", "plate"):
        assert getattr(counts, name) == getattr(model, name)
    assert counts.drop_height == -1.0  # the node was told none
    assert learnt(tuned, model.part_id, 8).method == "observed"


def test_a_best_effort_camera_is_heard_and_a_reliable_one_once(node, tuned, model):
    eager = tuned.node.create_publisher(
        ObservedParts, f"{tuned.prefix}/observed_parts", qos_profile_sensor_data
    )
    message = picture(model.part_id, lying(model.poses[0]))
    polls = itertools.count()
    # Sent again, for the node may not know the camera yet; the same message counts
    # once.
    until(
        lambda: (
            (next(polls) % 20 or eager.publish(message))
            and latched(tuned, model.part_id).counted_parts == 1
        )
    )
    reliable = [picture(model.part_id, lying(model.poses[0])) for _ in range(5)]
    seeing(tuned).publish(*reliable)
    learnt(tuned, model.part_id, 6)
    stamps = [counts.header.stamp for counts in counts_of(node, model.part_id, 6)]
    assert [stamps.count(counts.header.stamp) for counts in reliable] == [1] * 5


def test_the_height_that_the_node_was_told_and_the_flip_go_along(node, tuned, model):
    assert tuned.set(drop_height=0.25) == {}
    until(lambda: tuned.good("get_statistics").statistics[0].drop_height == 0.25)
    seeing(tuned).publish(
        picture(
            model.part_id, lying(model.poses[0]), from_pose=2, feeder_setting="slow"
        )
    )
    (flips,) = counts_of(node, model.part_id)
    assert (flips.drop_height, flips.from_pose, flips.feeder_setting) == (
        0.25,
        2,
        "slow",
    )


def test_what_cannot_be_counted_is_refused_and_the_next_one_served(node, tuned, model):
    pose = lying(model.poses[0])
    long = lying(model.poses[0])
    for axis in "xyzw":
        setattr(long.orientation, axis, 2.0 * getattr(long.orientation, axis))
    pictures = {
        "a serialised ObservedParts": b"\0\1\0\0" + b"\xee" * 40,
        "at most 1048576 bytes": b"\0\1\0\0" + bytes(2**20),
        "'nobody'; publish its mesh": picture("nobody", pose),
        "a confidence for each": picture(model.part_id, pose, pose, confidence=[1.0]),
        "confidences from 0 to 1, got 87": picture(
            model.part_id, pose, confidence=[87.0]
        ),
        "length 2 in row 1": picture(model.part_id, pose, long),
        "frame 'table'": picture(model.part_id, pose, frame="camera_optical_frame"),
    }
    camera = seeing(tuned)
    health = Health(tuned)
    refused_before = int(health.line("parts")[1]["refused"])
    for words, message in pictures.items():
        camera.publish(message)
        node.says(words)
    health.eventually(
        "parts",
        lambda _, values: int(values["refused"]) == refused_before + len(pictures),
    )
    camera.publish(picture(model.part_id), picture(model.part_id, pose))
    assert list(counts_of(node, model.part_id)[0].count) == [1]


def test_what_comes_faster_than_it_can_be_recorded_is_told_as_lost(node, tuned, model):
    """While the node stands still; messages of other tests blur the number a bit."""
    pose = lying(model.poses[0])
    health = Health(tuned)
    eyes = seeing(tuned)
    counter = counting(tuned)

    # what a publisher sends before the node has found it is lost in silence
    def both_known():
        counter.publish(counted(model, [7]))
        eyes.publish(picture(model.part_id, pose))
        return {7, 1} <= {
            sum(message.count) for message in counts_of(node, model.part_id)
        }

    until(both_known, "the publishers to be found")
    lost_before = int(health.eventually("recording")[1]["counts lost"])
    node.send(signal.SIGSTOP)
    for number in range(2000):
        counter.publish(counted(model, [number]))
        eyes.publish(picture(model.part_id, *[pose] * 3))
    node.send(signal.SIGCONT)

    def all_there():
        lost = int(health.latest("recording")[1]["counts lost"]) - lost_before
        return lost > 0 and abs(lost + len(counts_of(node, model.part_id)) - 4000) < 40

    until(all_there, "all counts")
    node.says("counts lost so far")

    def both_flood():  # what came may have been just what is usual
        counter.publish(counted(model, [0]))
        eyes.publish(picture(model.part_id, pose))
        floods = health.latest("parts")[1]["floods"]
        return (
            f"messages on {tuned.prefix}/observed_parts" in floods
            and f"of counts on {tuned.prefix}/pose_counts" in floods
        )

    until(both_flood, "floods of both")


RECENT = 400
"""Parts that are compared with all those before."""


def test_counts_sharpen_what_is_latched(tuned, model):
    camera = counting(tuned)
    latched_before = latched(tuned, model.part_id)
    camera.publish(counted(model, [3, 7]))
    first = learnt(tuned, model.part_id, 10)
    assert (first.method, first.drops, first.final) == ("observed", 0, True)
    assert first.revision > latched_before.revision
    camera.publish(*(counted(model, [3, 7]) for _ in range(30)))
    later = learnt(tuned, model.part_id, 310)
    assert math.isnan(latched_before.model_gap)
    shares = counts(later.poses)
    gaps = [
        pose.probability - shares[pose.index] / 310 for pose in latched_before.poses
    ]
    assert later.model_gap == pytest.approx(np.sqrt(np.mean(np.square(gaps))))
    assert later.plate_error == later.expected_error < 0.6 * first.expected_error
    result, plain = (pose.index for pose in model.poses[:2])
    assert counts(later.poses)[result] == 93 and counts(later.poses)[plain] == 217
    assert probabilities(later.poses)[plain] > probabilities(first.poses)[plain]
    # 217 of 310 parts: 0.70 with a standard error of 0.026, drawn a little to the
    # model.
    assert probabilities(later.poses)[plain] == pytest.approx(0.7, abs=0.06)
    fed = planned(
        tuned, part_id=model.part_id, wanted=[result], dropped_per_minute=60.0
    )
    assert fed.message.endswith(" From 310 parts seen (observed).")
    estimated = tuned.good("estimate", part_id=model.part_id).statistics
    assert estimated.counted_parts == 0 and probabilities(
        estimated.poses
    ) == probabilities(model.poses)


def test_node_and_bag_say_the_same_of_a_cell_that_is_far_from_the_model(
    node, tuned, model
):
    """Twelve points too many in one pose, of two thousand parts."""
    shares = np.array([pose.probability for pose in model.poses])
    seen = np.round(2000 * shares).astype(int)
    seen[0] += 240
    seen[1] -= 240
    counting(tuned).publish(counted(model, seen.tolist()))
    later = learnt(tuned, model.part_id, seen.sum())
    (note,) = (note for note in later.warnings if note.code == "MODEL_GAP")
    assert "where a plate usually is 5 points off" not in note.text
    assert note.text.startswith(
        f"what the cell counted is {100 * later.model_gap:.2g} "
    )
    sentence = note.text.removesuffix("; the answer has learnt from the counts.")
    text = " ".join(answer("bag", node.log_directory).split())
    assert f": {sentence}" in text


def test_a_message_counts_once_however_often_it_comes(node, tuned, model):
    """Stamp and content tell that it is the same; a played bag brings the bytes
    again.
    """
    camera = counting(tuned)
    message = counted(model, [30, 70])
    camera.publish(*[message] * 3)
    learnt(tuned, model.part_id, 100)
    camera.publish(message, counted(model, [30, 70]))
    learnt(tuned, model.part_id, 200)
    node.says("recorded, but it came before, and counts once")
    unstamped = counted(model, [1])
    unstamped.header.stamp = type(unstamped.header.stamp)()
    camera.publish(unstamped, unstamped)
    node.says("fill in header.stamp")
    learnt(tuned, model.part_id, 201)


def test_counts_that_the_state_does_not_have_are_said_to_be_unrecorded(
    node, tuned, model
):
    """While another program holds the file, as a backup may; the bag has them all the
    same.
    """
    (file,), camera, health = (
        node.log_directory.glob("*.sqlite3"),
        counting(tuned),
        Health(tuned),
    )

    def told(warning):
        return warning.code == "NOT_RECORDED" and str(file) in warning.text

    with closing(sqlite3.connect(file, isolation_level=None)) as connection:
        connection.execute("BEGIN IMMEDIATE")
        camera.publish(counted(model, [3, 7]))
        assert any(map(told, learnt(tuned, model.part_id, 10).warnings))
        health.eventually(
            "recording",
            lambda line, _: (
                line.message.startswith("NOT_RECORDED: ") and str(file) in line.message
            ),
        )
        counts_of(node, model.part_id)
        connection.execute("ROLLBACK")
        query = "SELECT 1 FROM counts WHERE part_id = ?", (model.part_id,)
        until(lambda: connection.execute(*query).fetchall(), "the counts in the state")
    camera.publish(counted(model, [1, 0]))
    assert not any(map(told, learnt(tuned, model.part_id, 11).warnings))


def test_a_cell_that_contradicts_the_model_is_believed(tuned, model):
    counting(tuned).publish(counted(model, [0, 0, 400]))
    statistics = learnt(tuned, model.part_id, 400)
    assert any(warning.code == "CONFLICT" for warning in statistics.warnings)
    assert statistics.poses[0].index == model.poses[2].index


def test_counts_stay_in_another_scene_and_begin_anew_on_another_plate(tuned, model):
    counting(tuned).publish(counted(model, [30, 70]))
    learnt(tuned, model.part_id, 100)
    assert tuned.set(restitution=0.2) == {}
    until(lambda: latched(tuned, model.part_id).restitution == 0.2)
    assert learnt(tuned, model.part_id, 100).method == "observed"
    tuned.good(
        "estimate", part=flat(WEDGE, model.part_id, restitution=0.4)
    )  # its own from now on
    assert learnt(tuned, model.part_id, 100).restitution == 0.4
    counting(tuned).publish(counted(model, [1, 0]))
    learnt(tuned, model.part_id, 101)
    assert tuned.set(plate="steel") == {}
    assert learnt(tuned, model.part_id, 0).method != "observed"


def test_counts_go_on_where_the_plate_brings_its_round_sides(tuned, tmp_path):
    """The file is fitted anew elsewhere, and the plate is set again."""
    file = tmp_path / "plates.yaml"
    glass = {
        "restitution": 0.4,
        "restitution_low": 0.3,
        "restitution_high": 0.5,
        "drop_height": 0.2,
        "drop_height_low": 0.1,
        "drop_height_high": 0.3,
        "plate_error": 0.03,
        "p_value": 0.5,
        "parts": ["drum"],
        "counted": 900,
        "date": "2026-11-23T12:00:00+00:00",
        "version": "1",
    }
    fitted = {"round_sides": 96, "round_sides_low": 48, "round_sides_high": 96}
    file.write_text(yaml.safe_dump({"plates": {"glass": glass}}))
    for values in ({"plates": str(file)}, {"plate": "glass"}):
        assert tuned.set(**values) == {}
    drum = tuned.good("estimate", part=flat(prism(64, 0.01, 0.02), new_id())).statistics
    counting(tuned).publish(counted(drum, [30, 20]))
    learnt_before = learnt(tuned, drum.part_id, 50)
    file.write_text(yaml.safe_dump({"plates": {"glass": {**glass, **fitted}}}))
    assert tuned.set(plate="glass") == {}
    learnt_after = until(
        lambda: (
            (candidate := latched(tuned, drum.part_id)).round_sides == 96 and candidate
        )
    )
    assert (
        learnt_before.round_sides,
        learnt_after.counted_parts,
        learnt_after.method,
    ) == (
        192,
        50,
        "observed",
    )
    assert counts(learnt_after.poses) == counts(learnt_before.poses)


def test_a_cell_that_changes_is_told_and_one_that_does_not_is_not(tuned, model):
    """By chance alone it alarms once in some hundred thousand parts."""
    camera = counting(tuned)
    health = Health(tuned)
    random = np.random.default_rng(1)

    def drop(parts, shares):
        for _ in range(parts // 50):
            camera.publish(counted(model, random.multinomial(50, shares).tolist()))

    drop(2000, [0.5, 0.3, 0.2])
    learnt(tuned, model.part_id, 2000)
    line, _ = health.eventually(
        "counts", lambda _, values: values["parts counted"] == "2000"
    )
    assert line.level == DiagnosticStatus.OK and line.message.startswith(
        "2000 parts counted of 1"
    )
    drop(RECENT, [0.3, 0.5, 0.2])
    line, _ = health.eventually(
        "counts", lambda line, _: line.level == DiagnosticStatus.WARN
    )
    assert f"changed '{model.part_id}'" in line.message
    assert f"the last {RECENT} parts" in line.message
