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

"""Parameters while the node runs: what is refused, and what a change changes."""

import math
from itertools import pairwise

import pytest
import yaml
from rclpy.parameter import Parameter

from .contract import DEFAULTS, FIXED
from .harness.cell import latched
from .harness.client import RUNNING, until
from .harness.jobs import LONG, cancelled, finished, get, known_part, reached, start
from .harness.parts import WEDGE, flat, new_id

GLASS = {
    "restitution": 0.3,
    "restitution_low": 0.2,
    "restitution_high": 0.4,
    "drop_height": 0.15,
    "drop_height_low": 0.1,
    "drop_height_high": 0.2,
    "plate_error": 0.021,
    "p_value": 0.5,
    "parts": ["box"],
    "counted": 300,
    "date": "2026-11-23T10:00:00+00:00",
    "version": "2.0",
}


def value_of(client, name):
    (value,) = client.call("get_parameters", names=[name]).values
    return value


def assert_refused(client, name, value, *words):
    """In one line that names it, and nothing changes."""
    value_before = value_of(client, name)
    reason = client.set(**{name: value}).get(name)
    assert reason is not None, f"{name} = {value} was accepted"
    assert "\n" not in reason and name.replace("_", " ") in reason.replace("_", " ")
    assert all(word in reason for word in words), reason
    assert value_of(client, name) == value_before


class TestRefusals:
    @pytest.mark.parametrize(
        "name",
        [
            name
            for name, value in DEFAULTS.items()
            if type(value) in (int, float) and name not in FIXED
        ],
    )
    def test_both_bounds_are_allowed_and_what_is_beyond_is_not(self, tuned, name):
        (described,) = tuned.call("describe_parameters", names=[name]).descriptors
        [bounds] = [*described.floating_point_range, *described.integer_range]
        low = bounds.from_value
        high = bounds.to_value
        step = 1 if isinstance(low, int) else 1e-6 * max(1.0, abs(high))
        for value in (low - step, high + step):
            assert_refused(tuned, name, value, str(value))
        if isinstance(low, float):
            assert_refused(tuned, name, math.nan, "nan")
        ends = (high,) if name == "mesh_unit" else (low, high)
        for value in ends:
            assert tuned.set(**{name: value}) == {}

    @pytest.mark.parametrize(
        ("name", "value", "words"),
        [
            ("restitution", 1.0, "below 1"),
            ("drop_height", 0.0, "0.0"),
            ("mesh_unit", 0.0, "0"),
            ("restitution", "high", "double"),
            ("drops", 1.5, "integer"),
            ("log_drops", "yes", "bool"),
            ("plate", 7, "string"),
            ("default_method", "guess", "auto"),
            ("default_method", "hybrid", "auto"),
            ("plate", "x" * 501, "500 printable"),
            ("plate_frame", "red\x1b[2J", "500 printable"),
        ],
    )
    def test_wrong_types_and_words(self, tuned, name, value, words):
        assert_refused(tuned, name, value, words)

    @pytest.mark.parametrize("name", sorted(FIXED))
    def test_what_holds_for_the_run_cannot_be_changed(self, tuned, name):
        value = {
            "mesh_topics": ["/other"],
            "mesh_folders": ["/"],
            "log_directory": "/tmp",
            "restore": False,
            "state_file": "/tmp/state",
        }.get(name, 10**6)
        assert_refused(tuned, name, value, "at the start")

    def test_several_at_once_are_judged_one_by_one(self, tuned):
        messages = [
            Parameter("restitution", value=0.1).to_parameter_msg(),
            Parameter("drops", value=-1).to_parameter_msg(),
            Parameter("plate", Parameter.Type.NOT_SET).to_parameter_msg(),
            Parameter("no_such", value=1).to_parameter_msg(),
        ]
        results = tuned.call("set_parameters", parameters=messages).results
        assert [result.successful for result in results] == [True, False, False, False]


class TestScene:
    def test_known_parts_are_estimated_again_and_latched(self, tuned):
        parts = [known_part(tuned) for _ in range(3)]
        with tuned.late_joiner() as joiner:
            results_before = {part_id: joiner.wait(part_id) for part_id in parts}
            assert tuned.set(restitution=0, max_job_seconds=5, drop_height=2) == {}
            for part_id in parts:
                new = joiner.wait(part_id, lambda result: result.restitution == 0.0)
                assert new.revision > results_before[part_id].revision
        assert tuned.good("estimate", part_id=parts[0]).statistics.restitution == 0.0

    def test_a_simulation_of_the_old_scene_makes_room_and_comes_back_with_it(
        self, tuned
    ):
        part_id = known_part(tuned)
        finished(tuned, start(tuned, part_id, 5000))
        with tuned.late_joiner() as joiner:
            assert joiner.wait(part_id).drops == 5000
            tuned.set(restitution=0.25)
            result = joiner.wait(
                part_id, lambda result: result.restitution == 0.25 and result.drops
            )
            assert not result.job_id
            tuned.set(restitution=0.5)
            result = joiner.wait(
                part_id, lambda later_result: later_result.revision > result.revision
            )
            assert (result.restitution, result.drops) == (0.5, 5000)

    def test_method_plate_frame_and_numbering(self, tuned):
        part_id = known_part(tuned)
        with tuned.late_joiner() as joiner:
            first = joiner.wait(part_id)
            tuned.set(default_method="csae")
            joiner.wait(part_id, lambda result: result.method == "csae")
            tuned.set(plate="brass")
            joiner.wait(part_id, lambda result: result.plate == "brass")
            tuned.set(plate_frame="tray")
            joiner.wait(part_id, lambda result: result.header.frame_id == "tray")
            tuned.set(cluster_tolerance=0.1)
            coarse = joiner.wait(
                part_id, lambda result: result.cluster_tolerance == 0.1
            )
            assert all(b.revision > a.revision for a, b in pairwise(joiner.of(part_id)))
        assert len(coarse.poses) < len(first.poses)

    def test_running_jobs_keep_their_snapshot(self, tuned):
        tuned.set(plate="brass")
        job_id = start(tuned, known_part(tuned), LONG, seed=1)
        reached(tuned, job_id, RUNNING)
        tuned.set(
            restitution=0.25, plate="oak", max_job_seconds=1.0, cluster_tolerance=0.0
        )
        until(lambda: get(tuned, job_id).status.drops_done > 500)
        statistics = cancelled(tuned, job_id).statistics
        assert (
            statistics.restitution,
            statistics.cluster_tolerance,
            statistics.plate,
        ) == (
            0.5,
            0.0025,
            "brass",
        )


class TestPlates:
    """A profile stands in for the node's own restitution and drop height."""

    @pytest.fixture
    def plates(self, tmp_path):
        file = tmp_path / "plates.yaml"

        def write(**profiles):
            file.write_text(yaml.safe_dump({"plates": profiles}))
            return str(file)

        return write

    def test_a_profile_takes_the_place_of_the_parameters(self, tuned, plates):
        file = plates(glass={**GLASS, "round_sides": 96}, felt=GLASS)  # none excluded
        part_id = known_part(tuned)
        for values in ({"plates": file}, {"plate": "glass"}):
            assert tuned.set(restitution=0.7, drop_height=2.0, **values) == {}
        result = until(
            lambda: (
                (candidate := latched(tuned, part_id)).plate == "glass" and candidate
            )
        )
        assert (result.restitution, result.plate_error, result.round_sides) == (
            0.3,
            0.021,
            96,
        )
        result = tuned.good(
            "estimate", part_id=part_id, method="split", drop_height=1.0
        ).statistics
        assert (result.restitution, result.drop_height) == (0.3, 1.0)
        assert tuned.set(plate="felt") == {}
        assert (
            until(
                lambda: (
                    (candidate := latched(tuned, part_id)).plate == "felt" and candidate
                )
            ).round_sides
            == 192
        )
        assert_refused(tuned, "plate", "oak", "'oak'", "fit_plate", "glass")

    def test_a_file_that_is_still_to_be_written_or_has_no_plate_named(
        self, tuned, plates, tmp_path
    ):
        assert tuned.set(plates=str(tmp_path / "none.yaml")) == {}
        assert tuned.set(plates=plates(glass=GLASS)) == {}
        statistics = tuned.good("estimate", part_id=known_part(tuned)).statistics
        assert (statistics.restitution, statistics.plate_error) == (0.5, 0.05)

    @pytest.mark.parametrize(
        ("text", "words"),
        [
            ("plates: {glass", "YAML"),
            ("[1, 2]", "top"),
            ("plates: {oak: 1}", "oak"),
            ("plates: {glass: {restitution: 1.5}}", "glass"),
            (
                yaml.safe_dump({"plates": {"glass": {**GLASS, "drop_height": -7.0}}}),
                "above 0 m",
            ),
            (
                yaml.safe_dump({"plates": {"glass": {**GLASS, "round_sides": 96.5}}}),
                "96.5",
            ),
        ],
    )
    def test_what_is_no_file_of_plates(self, tuned, tmp_path, text, words):
        (tmp_path / "plates.yaml").write_text(text)
        assert_refused(tuned, "plates", str(tmp_path / "plates.yaml"), words)


class TestBoundsOfWork:
    def test_numbers_of_jobs(self, tuned):
        part_id = known_part(tuned)
        tuned.set(drops=123, max_drops=1000, max_queued_jobs=0)
        assert finished(tuned, start(tuned, part_id, 0)).status.drops_total == 123
        assert "1000" in tuned.refused(
            "start_drop_simulation", part_id=part_id, drops=1001
        )
        tuned.set(max_drops=LONG)
        job_id = start(tuned, part_id, LONG)
        assert "max_queued_jobs" in tuned.refused(
            "start_drop_simulation", part_id=part_id, drops=10
        )
        cancelled(tuned, job_id)
        tuned.set(max_job_seconds=0.5)
        ended = finished(tuned, start(tuned, part_id, LONG))
        assert any("0.5 s" in warning.text for warning in ended.statistics.warnings)

    def test_max_mesh_bytes(self, tuned):
        tuned.set(max_mesh_bytes=100)
        message = tuned.refused("estimate", part=flat(WEDGE, new_id()))
        assert "max_mesh_bytes" in message and "100" in message
