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

"""Bags say the same whoever recorded them, and several bags no more than happened."""

import math

import numpy as np
import pytest
from ros_pose_stats_msgs.msg import Note

from ros_pose_stats import analyse_bags
from tests.running import answer_json

from .messages import (
    COUNTED,
    PROBABILITY,
    SECOND,
    SIMULATED,
    START,
    counts,
    event,
    mesh,
    result,
    run_of_a_node,
)
from .recorders import RECORDERS, write_recorded, write_run


def said(*bags):
    """All that the command says of parts and counts."""
    values = answer_json("bag", *bags)
    return {name: values[name] for name in ("parts", "stray_counts")}


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plain")
    write_run(folder)
    return said(folder)


@pytest.mark.parametrize("recorder", RECORDERS)
def test_every_recorder_gives_the_same(recorder, tmp_path, plain):
    RECORDERS[recorder](tmp_path / "log")
    contents = analyse_bags(tmp_path / "log").contents
    assert contents.messages == {
        "DropRecords": 1,
        "JobEvent": 5,
        "PartMesh": 1,
        "PoseCounts": 2,
        "PoseStatistics": 5,
    }
    (file,) = contents.files
    assert file.messages == 14 and contents.notes == ()
    assert file.state == ("open" if recorder == "never_closed" else "whole")
    assert said(tmp_path / "log") == plain


def test_results_are_a_history_led_by_most_drops(tmp_path):
    (part,) = analyse_bags(write_run(tmp_path)).contents.parts
    assert (part.part_id, part.radius) == ("clamp", 0.02)
    assert list(map(str, part.warnings)) == ["LOW_DROP: released low."]
    (history,) = part.histories
    assert history.numbering == (0.005, 192)
    assert history.poses.index.tolist() == [0, 1, 2, 3, 4]
    assert history.poses.group.tolist() == [0, 1, 0, 2, 3]
    assert history.poses.height == pytest.approx([0.005, 0.006, 0.007, 0.008, 0.009])
    assert history.method.tolist() == ["combined", "simulation", "meae", "simulation"]
    assert history.drops.tolist() == [0, 100, 0, 2000]
    assert history.final.tolist() == [True, False, True, True]
    assert history.latched.tolist() == [True, True, False, True]
    assert history.probability[0].tolist() == list(PROBABILITY)
    assert history.probability[3] == pytest.approx(np.array(SIMULATED) / 2000)
    assert ((history.time - START) / SECOND).tolist() == [0.0, 2.0, 3.0, 4.0]
    assert history.largest_change[1:] == pytest.approx([0.05, 0.1, 0.065])
    assert math.isnan(history.largest_change[0])
    assert history.leading.count.tolist() == list(SIMULATED)


def test_of_warnings_whose_figures_change_the_newest_is_told(tmp_path):
    """In each scene and method, whichever comes first."""
    texts = {1.0: "11 points off", 3.0: "6 points off", 2.0: "9 points off"}
    messages = [
        (
            "pose_statistics",
            result(seconds, warnings=[Note(code="MODEL_GAP", text=text)]),
        )
        for seconds, text in texts.items()
    ]
    other = [Note(code="MODEL_GAP", text="2 points off"), Note(code="LOW_DROP")]
    messages.append(("pose_statistics", result(4.0, method="meae", warnings=other)))
    messages.append(("pose_statistics", result(5.0)))
    (part,) = analyse_bags(write_run(tmp_path, messages)).contents.parts
    warnings = [(note.code, note.text) for note in part.warnings]
    assert warnings == [
        ("MODEL_GAP", "6 points off"),
        ("MODEL_GAP", "2 points off"),
        ("LOW_DROP", ""),
    ]


class TestSeveralBags:
    def test_two_recordings_of_a_run_say_no_more_than_one_in_any_order(
        self, tmp_path, plain
    ):
        paths = [write_run(tmp_path / "log"), write_recorded(tmp_path / "recorded")]
        assert said(*paths) == said(*paths[::-1]) == plain
        contents = analyse_bags(paths).contents
        assert contents.messages["PoseCounts"] == 4
        assert "2 camera counts in several bags, counted once" in contents.notes
        assert (
            analyse_bags([*paths, *paths[0].glob("*.mcap")]).contents.files
            == contents.files
        )
        half = write_recorded(tmp_path / "half", run_of_a_node()[:9])
        assert said(*paths, half) == plain

    def test_runs_add_up(self, tmp_path):
        write_run(tmp_path, [("pose_counts", counts(1.0, COUNTED))], "run_1")
        write_run(
            tmp_path,
            [("pose_counts", counts(2.0, COUNTED)), ("pose_statistics", result(3.0))],
            "run_2",
        )
        contents = analyse_bags(str(tmp_path)).contents
        assert len(contents.bags) == 2
        assert contents.counts[0].count.tolist() == [2 * count for count in COUNTED]

    def test_equal_counts_within_a_recording_are_no_copies(self, tmp_path):
        """Two parts that land alike in one picture, sent each by itself."""
        messages = [("pose_counts", counts(1.0, (1,)))] * 2
        write_run(tmp_path, messages)
        write_recorded(tmp_path / "recorded", messages)
        assert analyse_bags(tmp_path).contents.counts[0].count.tolist() == [2]

    def test_counts_without_a_stamp_are_matched_by_the_time_of_recording(
        self, tmp_path
    ):
        messages = [
            ("pose_counts", counts(None, (1, 0)))
        ] * 40  # a fifth of a second apart
        write_run(tmp_path / "log", messages)
        write_recorded(tmp_path / "recorded", messages, later=0.15)
        contents = analyse_bags(tmp_path).contents
        assert contents.counts[0].count.tolist() == [40, 0]
        assert any("without a time stamp" in note for note in contents.notes)
        write_recorded(tmp_path / "next_shift", messages, later=3600.0)
        assert analyse_bags(tmp_path).contents.counts[0].count.tolist() == [80, 0]

    def test_a_job_ends_in_the_bag_of_the_next_start(self, tmp_path):
        write_run(
            tmp_path,
            [
                ("job_events", event(1.0, "QUEUED")),
                ("job_events", event(2.0, "RUNNING")),
            ],
            "run_1",
        )
        (job,) = analyse_bags(tmp_path).contents.parts[0].jobs
        assert job.unfinished
        write_run(
            tmp_path, [("job_events", event(9.0, "CANCELLED", drops_done=50))], "run_2"
        )
        (job,) = analyse_bags(tmp_path).contents.parts[0].jobs
        assert (job.state, job.drops_done, job.unfinished) == ("cancelled", 50, False)

    def test_a_name_with_two_digests_is_two_parts(self, tmp_path):
        write_run(
            tmp_path,
            [
                ("pose_statistics", result(1.0)),
                ("pose_statistics", result(2.0, part_digest="b" * 64)),
                ("job_events", event(3.0, "PART_FORGOTTEN", "")),
            ],
        )
        parts = analyse_bags(tmp_path).contents.parts
        assert [part.part_digest[0] for part in parts] == ["3", "b"]
        assert [len(part.forgotten) for part in parts] == [1, 0]

    def test_a_part_is_forgotten_once_by_whichever_message_says_so(self, tmp_path):
        """Subscribers hear it as a last result, the node's own bag has an event as
        well.
        """
        last = result(
            3.0, probability=(), warnings=[Note(code="FORGOTTEN", text="it went.")]
        )
        write_recorded(
            tmp_path / "bag",
            [("pose_statistics", result(1.0)), ("pose_statistics", last)],
        )
        for number in range(2):
            contents = analyse_bags(tmp_path).contents
            (part,) = contents.parts
            assert part.forgotten == (START + 3 * SECOND,) and not contents.notes
            assert part.histories[0].time.tolist() == [START + SECOND]
            write_run(
                tmp_path,
                [
                    ("pose_statistics", last),
                    ("job_events", event(3.0, "PART_FORGOTTEN", "")),
                ],
                f"run_{number}",
            )


def test_progress_goes_by_the_bytes_that_are_read(tmp_path):
    large = [("part_mesh", mesh(50_000))] * 4  # of 1.2 MB each
    for name in ("a", "b"):
        write_run(tmp_path, [*large, ("pose_statistics", result(1.0))], name)
    calls = []
    contents = analyse_bags(tmp_path, lambda *progress: calls.append(progress)).contents
    size = sum(file.path.stat().st_size for file in contents.files)
    assert {total for _, total in calls} == {size}
    parts_read = [part for part, _ in calls]
    assert (
        parts_read == sorted(parts_read)
        and 0 < parts_read[0] < 0.5 * size < parts_read[-1] <= size
    )
