"""Names of runs: in order, whatever the clock does."""

from __future__ import annotations

import pytest

from ros_pose_stats.recording.run_names import new_run_name, runs

FUTURE = "pose_stats_29990102T030405_678999_7"


def test_is_that_of_a_run(tmp_path):
    (tmp_path / new_run_name(tmp_path)).mkdir()
    assert len(runs(tmp_path)) == 1


def test_follows_the_newest_run_where_the_clock_was_set_back(tmp_path):
    names = [FUTURE]
    for _ in range(3):
        (tmp_path / names[-1]).mkdir()
        names.append(new_run_name(tmp_path))
    assert names == sorted(names)
    assert [name[:33] for name in names[:2]] == [FUTURE[:33], "pose_stats_29990102T030405_679000"]


def test_another_runs_pid_does_not_matter(tmp_path):
    (tmp_path / FUTURE.replace("_7", "_9999999999")).mkdir()
    assert new_run_name(tmp_path) > FUTURE.replace("_7", "_9999999999")


@pytest.mark.parametrize("name", ["pose_stats_99999999T999999_999999_1", "pose_stats_x"])
def test_days_that_are_none_are_passed_over(tmp_path, name):
    (tmp_path / name).mkdir()
    assert new_run_name(tmp_path).startswith("pose_stats_2")


def test_a_folder_that_is_missing_or_none(tmp_path):
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "missing", tmp_path / "file"):
        assert new_run_name(folder).startswith("pose_stats_2")
