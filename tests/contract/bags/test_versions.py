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

"""Messages of older and newer versions, and poses that are numbered in several ways."""

import math
import re

import numpy as np

from ros_pose_stats import analyse_bags

from .messages import DIGEST, PACKAGE, PROBABILITY, counts, definition, result
from .recorders import write_plain, write_run

STATISTICS = definition(f"{PACKAGE}/PoseStatistics")
LINE = "=" * 80
HEADER = f"""{LINE}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{LINE}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
OLD = f"""std_msgs/Header header
string part_id
string part_digest
string method
float64 cluster_tolerance
StablePose[] poses
{LINE}
MSG: ros_pose_stats_msgs/StablePose
uint32 index
float64 probability
{HEADER}"""
EVENT = f"""uint8 event
std_msgs/Header header
string job_id
string part_id
string part_digest
bool refinement
uint64 drops
uint64 drops_done
float64 restitution
float64 drop_height
float64 cluster_tolerance
uint32 round_sides
uint64 seed
float64 target_error
float64 max_seconds
string message
{HEADER}"""
COUNTS = f"""std_msgs/Header header
string part_id
string part_digest
float64 cluster_tolerance
uint32 round_sides
string plate
float64 drop_height
uint32[] index
uint64[] count
uint64 unclassified
int32 from_pose -1
string feeder_speed
{HEADER}"""
"""As version 0.2.0 had them."""
ABOUT = {"part_id": "clamp", "part_digest": "d", "cluster_tolerance": 0.005}
POSES = [{"index": 1, "probability": 0.25}, {"index": 0, "probability": 0.75}]


def test_fields_that_an_older_version_lacks_are_unknown(tmp_path):
    write_plain(
        tmp_path / "old.mcap",
        [
            (
                "PoseStatistics",
                OLD,
                {
                    **ABOUT,
                    "method": "combined",
                    "poses": POSES,
                    "header": {"stamp": {"sec": 3, "nanosec": 0}},
                },
            )
        ],
    )
    (part,) = analyse_bags(tmp_path).contents.parts
    (history,) = part.histories
    assert history.probability.tolist() == [[0.75, 0.25]]
    assert history.poses.group.tolist() == [0, 1] and history.final.tolist() == [True]
    assert (
        np.isnan(history.poses.height).all() and np.isnan(history.expected_error).all()
    )
    assert math.isnan(part.radius)


def test_older_versions_took_round_surfaces_as_the_file_has_them(tmp_path):
    """Their counts are compared with their results, and with none of today's."""
    write_plain(
        tmp_path / "old.mcap",
        [
            (
                name,
                re.sub("(uint32 round_sides|uint64 numbering)\n", "", text),
                {**ABOUT, **fields},
            )
            for name, text, fields in (
                (
                    "PoseStatistics",
                    STATISTICS,
                    {"method": "combined", "poses": POSES},
                ),
                (
                    "JobEvent",
                    definition(f"{PACKAGE}/JobEvent"),
                    {
                        "status": {"state": 2, "job_id": "job_1", "part_id": "clamp"},
                        "seed": 192,
                        "drop_height": 0.4,
                    },
                ),
                ("PoseCounts", COUNTS, {"index": [0, 1], "count": [3, 1]}),
            )
        ],
    )
    (part,) = analyse_bags(tmp_path).parts
    (history,), (job,), (compared,) = (
        part.record.histories,
        part.record.jobs,
        part.counts,
    )
    assert history.numbering == compared.counts.numbering == (0.005, 0)
    assert (job.state, job.cluster_tolerance, job.round_sides) == ("running", 0.005, 0)
    assert (compared.problem, compared.count.tolist()) == ("", [3, 1])
    write_run(tmp_path, [("pose_statistics", result(1.0, part_digest="d"))])
    (part,) = analyse_bags(tmp_path).contents.parts
    assert {history.numbering for history in part.histories} == {
        (0.005, 0),
        (0.005, 192),
    }


def test_counts_of_0_2_0_have_the_numbering_in_three_fields(tmp_path):
    """Beside those of today, of the same poses, they add up with these."""
    numbered = {"part_digest": DIGEST, "cluster_tolerance": 0.005, "round_sides": 192}
    write_plain(
        tmp_path / "old.mcap",
        [
            (
                "PoseCounts",
                COUNTS,
                {
                    "part_id": "clamp",
                    "plate": "steel",
                    "drop_height": 0.4,
                    "index": [0, 4],
                    "count": [3, 1],
                    "from_pose": from_pose,
                    "feeder_speed": "slow",
                    **numbered,
                    **other,
                },
            )
            for from_pose, other in (
                (-1, {}),
                (2, {}),
                (-1, {"round_sides": 0}),
                (-1, {"cluster_tolerance": math.nan}),
            )
        ],
    )
    messages = [
        ("pose_statistics", result(1.0)),
        ("pose_counts", counts(2.0, (5, 0, 0, 0, 2))),
    ]
    write_run(tmp_path, messages)
    analysis = analyse_bags(tmp_path)
    (part,) = analysis.parts
    counted, rounded, unknown = sorted(
        part.counts, key=lambda comparison: comparison.problem
    )
    assert (counted.problem, counted.count.tolist()) == ("", [8, 0, 0, 0, 3])
    assert "round_sides 0, results are at" in rounded.problem
    assert "cluster_tolerance unknown" in unknown.problem
    assert any(
        "1 camera count left out, of flips" in note for note in analysis.contents.notes
    )


def test_fields_that_a_newer_version_adds_are_passed_over(tmp_path):
    head, rest = STATISTICS.split(LINE, 1)
    write_plain(
        tmp_path / "new.mcap",
        [
            (
                "PoseStatistics",
                f"{head}float64 mood\n{LINE}{rest}",
                {**ABOUT, "method": "auto", "mood": 1.0, "poses": POSES[1:]},
            )
        ],
    )
    (part,) = analyse_bags(tmp_path).contents.parts
    assert part.histories[0].method.tolist() == ["auto"]


def test_each_numbering_has_a_history_of_its_own(tmp_path):
    write_run(
        tmp_path,
        [
            (
                "pose_statistics",
                result(1.0, cluster_tolerance=0.0, probability=(0.5, 0.5)),
            ),
            *(("pose_statistics", result(2.0 + k)) for k in range(3)),
            *(
                ("pose_statistics", result(6.0 + k, (0.5, 0.3, 0.2), round_sides=0))
                for k in range(2)
            ),
        ],
    )
    histories = analyse_bags(tmp_path).contents.parts[0].histories
    assert [history.numbering for history in histories] == [
        (0.005, 192),
        (0.005, 0),
        (0.0, 192),
    ]
    assert [history.probability.shape for history in histories] == [
        (3, 5),
        (2, 3),
        (1, 2),
    ]


def test_another_number_of_poses_under_the_same_numbering_is_left_out(tmp_path):
    write_run(
        tmp_path,
        [
            ("pose_statistics", result(1.0)),
            ("pose_statistics", result(2.0, PROBABILITY[:4])),
        ],
    )
    contents = analyse_bags(tmp_path).contents
    assert len(contents.parts[0].histories[0].time) == 1
    assert "1 result left out, numbering" in contents.notes[0]


def events_of_0_2(folder):
    """A bag with the life of a simulation, and a part that was forgotten."""
    job = {**ABOUT, "job_id": "job_1", "drops": 9, "seed": 7}
    return write_plain(
        folder / "events.mcap",
        [
            ("JobEvent", EVENT, {**job, "event": 1}),
            ("JobEvent", EVENT, {**job, "event": 2}),
            ("JobEvent", EVENT, {**job, "event": 5, "drops_done": 4, "message": "no"}),
            ("JobEvent", EVENT, {**ABOUT, "event": 0}),
        ],
    )


def test_events_of_0_2_are_read_with_the_states_of_today(tmp_path):
    (part,) = analyse_bags(events_of_0_2(tmp_path)).contents.parts
    (job,) = part.jobs
    assert (job.state, job.drops, job.drops_done, job.seed) == ("failed", 9, 4, 7)
    assert (job.part_id, job.message) == ("clamp", "no")
    assert 0 < job.queued == job.started == job.ended
    assert part.forgotten == (job.ended,)


def result_of_0_2(folder):
    """A bag with a result whose warnings are sentences."""
    sentences = "string[] warnings\nstring[] notes\nStablePose[] poses"
    return write_plain(
        folder / "result.mcap",
        [
            (
                "PoseStatistics",
                OLD.replace("StablePose[] poses", sentences),
                {
                    **ABOUT,
                    "method": "meae",
                    "poses": POSES,
                    "warnings": ["LOW_DROP: released 2: low.", "FADED: not today."],
                    "notes": ["CLUSTERED: some."],
                },
            )
        ],
    )


NOTES_OF_0_2 = [
    ("LOW_DROP", "released 2: low.", True),
    ("FADED", "not today.", True),
    ("CLUSTERED", "some.", False),
]


def test_warnings_of_0_2_are_notes(tmp_path):
    (part,) = analyse_bags(result_of_0_2(tmp_path)).contents.parts
    assert list(part.warnings) == NOTES_OF_0_2
