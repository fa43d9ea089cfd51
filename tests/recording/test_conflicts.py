"""Parts whose drops contradicted an estimate, in files."""

from __future__ import annotations

import os
import zipfile
from dataclasses import replace

import numpy as np
import pytest

from ros_pose_stats import part_from_mesh, shapes, simulate
from ros_pose_stats.recording import conflicts
from ros_pose_stats.recording.conflicts import keep_conflict, read_conflicts

PART = part_from_mesh(*shapes.box(20.0, 30.0, 41.0), unit="mm", mass=0.4,
                      center_of_mass=(0.001, 0.0, 0.0), part_id="crate")
WARNING = "CONFLICT: drops contradict the estimate in 1 pose (0)."


def dropped(drops=50, told=WARNING, **scene):
    found = simulate(PART, drops, seed=2**63 + 5, workers=1, **scene)
    return replace(found, warnings=(*found.warnings, told))


def test_there_and_back(tmp_path):
    found = dropped(restitution=0.3, drop_height=0.5, round_sides=0)
    file = keep_conflict(tmp_path / "a" / "b", PART, found)
    (case,) = read_conflicts(file.parent)
    assert (case.part.digest, case.part.part_id) == (PART.digest, "crate")
    assert (case.scene.restitution, case.scene.drop_height, case.scene.cluster_tolerance,
            case.scene.round_sides) == (0.3, 0.5, found.cluster_tolerance, 0)
    by_index = sorted(found.poses, key=lambda pose: pose.index)
    assert case.counts.tolist() == [pose.count for pose in by_index]
    assert (case.unsettled, case.seed) == (found.unsettled, 2**63 + 5)
    assert (case.warning, case.version) == (WARNING, found.version)


def test_a_result_without_a_contradiction_is_not_kept(tmp_path):
    assert keep_conflict(tmp_path / "new", PART, dropped(told="CLUSTERED: one.")) is None
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("order", [(50, 80), (80, 50)])
def test_of_one_scene_the_larger_run_stays(tmp_path, order):
    for drops in order:
        keep_conflict(tmp_path, PART, dropped(drops))
    keep_conflict(tmp_path, PART, dropped(20, restitution=0.2))
    assert sorted(int(case.counts.sum()) for case in read_conflicts(tmp_path)) == [20, 80]


def test_the_oldest_go(tmp_path, monkeypatch):
    monkeypatch.setattr(conflicts, "MOST_FILES", 2)
    made = []
    for number, restitution in enumerate((0.1, 0.2, 0.3, 0.4)):
        made.append(keep_conflict(tmp_path, PART, dropped(restitution=restitution)))
        os.utime(made[-1], ns=(number, number))
    assert sorted(tmp_path.iterdir()) == sorted(made[-2:])
    monkeypatch.setattr(conflicts, "MOST_BYTES", 10)
    assert keep_conflict(tmp_path, PART, dropped()) is not None
    assert len(list(tmp_path.iterdir())) == 1  # one stays, however large


def test_what_fails_leaves_the_old_one_whole(tmp_path, monkeypatch):
    keep_conflict(tmp_path, PART, dropped(50))

    def fail(number):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(conflicts.os, "fsync", fail)
    with pytest.raises(OSError, match="No space"):
        keep_conflict(tmp_path, PART, dropped(80))
    (case,) = read_conflicts(tmp_path)
    assert case.counts.sum() == 50 and len(list(tmp_path.iterdir())) == 1


def test_a_broken_file_is_replaced_by_the_next_and_refused_by_the_reader(tmp_path):
    file = keep_conflict(tmp_path, PART, dropped(50))
    file.write_bytes(file.read_bytes()[:200])
    with pytest.raises(zipfile.BadZipFile):
        list(read_conflicts(tmp_path))
    keep_conflict(tmp_path, PART, dropped(20))
    (case,) = read_conflicts(tmp_path)
    assert np.sum(case.counts) == 20
