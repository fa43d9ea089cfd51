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

"""The command `bag`: what it prints and writes, and the Python of its page."""

import csv
import re
from pathlib import Path

import pytest

from lab.bodies import shapes
from ros_pose_stats import estimate, load_part
from tests.answers import write_stl
from tests.running import ROOT, answer, answer_json, refusal

from .messages import counts, event, result
from .recorders import write_mcap, write_run


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    """A log directory with one run, which was killed while its second job ran."""
    folder = tmp_path_factory.mktemp("log")
    write_run(folder, closed=False)
    return folder


class TestReport:
    def test_it_says_everything_in_a_hundred_columns(self, log):
        text = answer("bag", log)
        for words in (
            "== clamp (digest 3fa9c1d23fa9, radius 20 mm)",
            "5 poses in 4 groups at cluster_tolerance 0.005 and round_sides 192, by "
            "simulation, 2000 drops",
            "4 results by combined, simulation, meae",
            "2 accepted, 1 done, 0 cancelled, 0 failed, 1 unfinished",
            "estimates against simulation",
            "480 parts in stable poses",
            "unclassified: 10 of 490, 2.04 %",
            "LOW_DROP: released low.",
            "was never closed",
            "within chance",
            "beyond chance",
        ):
            assert words in text
        assert (
            max(len(line) for line in text.splitlines() if str(log) not in line) <= 100
        )

    def test_long_and_hostile_names_stay_within_the_page(self, tmp_path):
        long = "a_very_long_name_of_something_" * 4
        write_run(
            tmp_path,
            [
                ("answers", result(0.0, part_id=long)),
                (
                    "answers",
                    result(
                        1.0,
                        method="simulation",
                        part_id=long,
                        count=(51234567, 25234567, 12234567, 6234567, 2234567),
                    ),
                ),
                (
                    "job_events",
                    event(
                        30.0, "QUEUED", "job" * 20, drops_total=10_000_000, part_id=long
                    ),
                ),
                (
                    "job_events",
                    event(
                        31.0,
                        "FAILED",
                        "job" * 20,
                        part_id=long,
                        message="no memory " * 20,
                    ),
                ),
                (
                    "pose_counts",
                    counts(
                        41.0,
                        (4000000, 20),
                        plate="\x1b[31m\n",
                        part_id=long,
                        numbering=7,
                    ),
                ),
            ],
        )
        text = answer("bag", tmp_path)
        assert all(
            str(tmp_path) in line for line in text.splitlines() if len(line) > 100
        )
        assert "\x1b" not in text and "not compared" in text


class TestJson:
    def test_it_is_strict_and_complete(self, log):
        values = answer_json("bag", log)
        assert values["files"][0]["state"] == "open"
        assert values["messages"]["PoseStatistics"] == 5
        (part,) = values["parts"]
        (numbering,) = part["numberings"]
        for entry in (numbering, *part["jobs"], *part["counts"]):
            assert (entry["cluster_tolerance"], entry["round_sides"]) == (0.005, 192)
        assert [entry["method"] for entry in numbering["results"]] == [
            "combined",
            "simulation",
            "meae",
            "simulation",
        ]
        assert numbering["results"][0]["largest_change"] is None
        assert numbering["results"][0]["time"] == 1_770_000_000.0
        assert numbering["predictions"][1]["poses"][0]["count"] == 1120
        assert numbering["simulations"][0]["simulation"] == 1
        assert [
            entry["prediction"] for entry in numbering["simulations"][0]["estimates"]
        ] == [0, 2]
        assert part["job_counts"] == {
            "accepted": 2,
            "done": 1,
            "cancelled": 0,
            "failed": 0,
            "unfinished": 1,
        }
        assert [job["state"] for job in part["jobs"]] == ["done", "running"]
        assert part["jobs"][0]["ended"] - part["jobs"][0]["started"] == pytest.approx(
            3.0
        )
        assert part["drop_log"] == {
            "drops": 5,
            "unsettled": 1,
            "impacts": 60,
            "seconds": 2.5,
        }
        (counted,) = part["counts"]
        assert counted["compared"] is True and counted["unclassified"] == 10
        assert counted["count"] == [276, 118, 62, 20, 4]
        test = counted["predictions"][0]["by_pose"]
        assert test["degrees_of_freedom"] == 4 and 0.0 < test["p_value"] < 1.0

    def test_too_few_is_null_and_said(self, tmp_path):
        write_run(
            tmp_path,
            [
                ("pose_statistics", result(1.0)),
                ("pose_counts", counts(2.0, (2, 1, 0, 0, 0))),
            ],
        )
        (part,) = answer_json("bag", tmp_path)["parts"]
        test = part["counts"][0]["predictions"][0]["by_pose"]
        assert test["p_value"] is None and test["too_few"] is True


def tables(log, folder):
    """The tables that the command writes, read again."""
    written = answer_json("bag", log, "--csv", folder)["csv"]
    assert sorted(written) == sorted(str(path) for path in folder.iterdir())
    rows = {}
    for path in folder.iterdir():
        with path.open(newline="", encoding="utf-8") as stream:
            rows[path.stem] = list(csv.DictReader(stream))
    return rows


class TestCsv:
    @pytest.mark.parametrize("name", ["=1+1", " =1+1", "\ufeff=1+1", "\u200b\t@a"])
    def test_no_name_is_a_formula(self, tmp_path, monkeypatch, name):
        """Spreadsheets would compute it, also behind what has no width."""
        monkeypatch.chdir(tmp_path)
        write_run(
            Path("=log"),
            [
                ("pose_statistics", result(1.0, part_id=name)),
                ("pose_counts", counts(2.0, (2, 1, 0, 0, 0), part_id=name)),
            ],
        )
        rows = tables(Path("=log"), tmp_path / "csv")
        assert rows["files"][0]["bag"].startswith("'=")
        assert {
            row["part_id"]
            for name in ("poses", "answers", "counts")
            for row in rows[name]
        } == {f"'{name}"}

    def test_values_come_back(self, log, tmp_path):
        (tmp_path / "poses.csv").write_text("old")  # is replaced
        rows = tables(log, tmp_path)
        assert set(rows) == {
            "files",
            "poses",
            "answers",
            "jobs",
            "counts",
            "comparison",
        }
        assert [float(row["probability"]) for row in rows["poses"][:5]] == [
            0.55,
            0.25,
            0.12,
            0.06,
            0.02,
        ]
        assert [row["height_m"] for row in rows["poses"][:2]] == ["0.005", "0.006"]
        answers = rows["answers"][::5]  # of five poses
        assert [row["result"] for row in answers] == ["1", "2", "3", "4"]
        assert [row["drops"] for row in answers] == ["0", "100", "0", "2000"]
        assert rows["answers"][0]["time_utc"] == "2026-02-02T02:40:00.000000000Z"
        assert rows["answers"][0]["expected_error"] == ""
        assert [row["state"] for row in rows["jobs"]] == ["done", "running"]
        assert {row["pose"]: row["count"] for row in rows["counts"]} == {
            "0": "276",
            "1": "118",
            "2": "62",
            "3": "20",
            "4": "4",
            "unclassified": "10",
        }
        kinds = {
            (row["counts_of"], row["method"], row["by"]) for row in rows["comparison"]
        }
        assert ("camera", "simulation", "group") in kinds
        assert ("simulation", "meae", "pose") in kinds

    def test_every_row_of_the_answers_joins_one_of_the_poses(self, tmp_path):
        simulated = {"method": "simulation", "count": (5, 3, 2, 0, 0)}
        write_run(
            tmp_path / "log",
            [
                ("pose_statistics", message)
                for message in (
                    result(1.0),
                    result(1.0, method="meae"),
                    result(2.0, (0.5, 0.3, 0.1, 0.1, 0.0)),
                    result(3.0, **simulated),
                    result(4.0, **simulated, restitution=0.2),
                    result(5.0, method="simulation", count=(50, 30, 20, 0, 0)),
                    result(6.0, (0.7, 0.3), cluster_tolerance=0.01),
                    result(6.0, part_digest="b" * 64),
                    result(6.0, (0.5, 0.3, 0.2), round_sides=0),
                    result(
                        7.0, method="meae", drop_height=float("nan"), restitution=0.1
                    ),
                )
            ],
        )
        rows = tables(tmp_path / "log", tmp_path / "tables")
        columns = (
            "part_id",
            "part_digest",
            "cluster_tolerance",
            "round_sides",
            "prediction",
            "pose",
        )
        poses = {tuple(row[name] for name in columns): row for row in rows["poses"]}
        answers = {
            tuple(row[name] for name in (*columns, "result")): row
            for row in rows["answers"]
        }
        assert len(poses) == len(rows["poses"])
        assert len(answers) == len(rows["answers"]) == 8 * 5 + 3 + 2
        assert {key[:-1] for key in answers} == poses.keys()
        for key, row in answers.items():
            pose = poses[key[:-1]]
            assert (row["method"], row["drop_height_m"]) == (
                pose["method"],
                pose["drop_height_m"],
            )


def test_the_python_of_the_page_runs(tmp_path, monkeypatch, capsys):
    text = (ROOT / "docs" / "bags.md").read_text(encoding="utf-8")
    write_run(tmp_path / "log")
    write_mcap(tmp_path / "run_0.mcap")
    monkeypatch.chdir(tmp_path)
    codes = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert len(codes) == 2
    for code in codes:
        exec(code, {})
        assert "simulation" in capsys.readouterr().out


def test_a_table_of_counts_by_hand_is_compared_as_a_camera_s(tmp_path):
    """Of poses that look alike one has the counts of all."""
    box = write_stl(tmp_path / "box.stl", shapes.box(20.0, 30.0, 12.0))
    part = load_part(box, unit="mm")
    model = estimate(part, "split")
    poses = list(model.by_index.values())
    write_run(
        tmp_path / "bag",
        [
            (
                "pose_statistics",
                result(
                    1.0,
                    [pose.probability for pose in poses],
                    group=[pose.group for pose in poses],
                    part_id=part.part_id,
                    part_digest=part.digest,
                    cluster_tolerance=model.cluster_tolerance,
                ),
            )
        ],
    )
    table = tmp_path / "counts.csv"
    table.write_text("part,pose,count\nbox.stl,0,61\nbox.stl,2,30\nbox.stl,4,9\n")
    # A table that is named twice counts once.
    values = answer_json("bag", tmp_path / "bag", table, table, "--unit", "mm")
    (analysed,) = values["parts"]
    (counts,) = analysed["counts"]
    assert counts["problem"] == "" and counts["part_id"] == "box"
    assert counts["index"] == [0, 1, 2, 3, 4, 5]
    assert counts["count"] == [31, 30, 15, 15, 5, 4]
    assert "expected at least one bag" in refusal("bag", table)
