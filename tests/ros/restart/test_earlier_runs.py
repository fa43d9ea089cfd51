"""Each run is taken in once, whatever its directory is called, without a node."""

from __future__ import annotations

import shutil

import pytest
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import JobEvent

from ros_pose_stats.errors import BagError
from ros_pose_stats.recording.reader.run_identity import identity_of
from ros_pose_stats.recording.repair.repair import repair_bags
from ros_pose_stats.recording.run_names import bag_files
from ros_pose_stats.ros.restart.earlier_runs import RUNS_TAKEN_IN, Taken, earlier_runs
from ros_pose_stats.ros.restart.last_run import PART_RESTORED, last_run
from ros_pose_stats.ros.restart.places import place_text, read_at

from .test_last_run import RUNS, Writing, factors, found

NODE = "/pose_stats"
RENAMED = "pose_stats_20270102T030405_000000_9"


def say(writing, message):
    writing.log.write("/pose_stats/job_events", serialize_message(message), durable=False)


def takes_in(folder, number, *, done=True):
    """A run that takes over what earlier ones left, as a node does."""
    earlier = earlier_runs(folder, NODE)
    run = last_run(earlier.bags, 1000)
    writing = Writing(folder, number)
    say(writing, JobEvent(event=RUNS_TAKEN_IN, message=earlier.taken._replace(done=False).text()))
    for job_id in run.unfinished:
        writing.event(JobEvent.CANCELLED, job_id)
    for part_id, mesh in run.parts.items():
        say(writing, JobEvent(event=PART_RESTORED, part_id=part_id, part_digest=mesh.digest,
                              message=place_text(mesh.place)))
    if done:
        say(writing, JobEvent(event=RUNS_TAKEN_IN, message=earlier.taken.text()))
    return writing


def read(folder):
    return list(earlier_runs(folder, NODE).bags)


@pytest.fixture
def first(tmp_path):
    """A run that was killed, with two parts and a job."""
    writing = Writing(tmp_path, 0)
    writing.part("kept", 1.0)
    writing.part("forgotten", 2.0)
    writing.event(JobEvent.QUEUED, "job")
    writing.die()
    return tmp_path / RUNS[0]


@pytest.fixture
def second(first, tmp_path):
    """The run after it, in which a part was forgotten."""
    writing = takes_in(tmp_path, 1)
    writing.event(JobEvent.PART_FORGOTTEN, part_id="forgotten")
    writing.end()
    return tmp_path / RUNS[1]


class TestTakenInOnce:
    def test_though_it_was_never_mended(self, second, tmp_path):
        run = found(tmp_path)
        assert read(tmp_path) == [RUNS[1]]
        assert factors(tmp_path, run) == {"kept": 1.0} and run.unfinished == {}

    @pytest.mark.parametrize("name", [RENAMED, "monday"])
    @pytest.mark.parametrize("move", [shutil.copytree, shutil.move])
    @pytest.mark.parametrize("number", [0, 1])
    def test_copied_or_renamed(self, second, tmp_path, name, move, number):
        move(tmp_path / RUNS[number], tmp_path / name)
        run = found(tmp_path)
        assert read(tmp_path) == [RUNS[1]]
        assert factors(tmp_path, run) == {"kept": 1.0} and run.unfinished == {}

    def test_copied_and_mended_under_its_new_name(self, first, second, tmp_path):
        shutil.copytree(first, tmp_path / RENAMED)
        for path in bag_files(first):
            shutil.move(tmp_path / RENAMED / path.name,
                        tmp_path / RENAMED / path.name.replace(RUNS[0], RENAMED))
        assert len(repair_bags(tmp_path)) == 2
        assert identity_of(tmp_path / RENAMED) == (RUNS[0], NODE)
        assert read(tmp_path) == [RUNS[1]]

    def test_once_all_that_it_leaves_is_on_record(self, first, tmp_path):
        takes_in(tmp_path, 1, done=False).end()
        repair_bags(tmp_path)  # by another node
        run = found(tmp_path)
        assert read(tmp_path) == RUNS[:2]
        assert sorted(run.parts) == ["forgotten", "kept"] and run.unfinished == {}

    def test_one_that_was_still_written_later(self, second, tmp_path):
        living = Writing(tmp_path, 2)
        living.part("late", 3.0)
        living.log.sync()
        third = takes_in(tmp_path, 3)
        third.end()
        assert read(tmp_path) == [RUNS[3]]
        living.die()
        assert read(tmp_path) == RUNS[2:4]
        third = takes_in(tmp_path, 4)
        third.end()
        assert read(tmp_path) == [RUNS[4]]
        assert sorted(found(tmp_path).parts) == ["kept", "late"]

    def test_a_chain_does_not_grow(self, second, tmp_path):
        sizes = []
        for number in range(2, 6):
            takes_in(tmp_path, number).end()
            (file,) = bag_files(tmp_path / RUNS[number])
            sizes.append(file.stat().st_size)
            assert read(tmp_path) == [RUNS[number]]
            assert factors(tmp_path, found(tmp_path)) == {"kept": 1.0}
        assert max(sizes) - min(sizes) < 100


def test_covers():
    taken = Taken(True, "b", ("a",))
    assert taken.covers("b") and not taken.covers("a") and not taken.covers("c")


class TestPlaces:
    def test_found_where_mending_has_moved_it(self, tmp_path):
        writing = Writing(tmp_path, 0)
        for number in range(5):
            writing.part(f"part {number}", 1.0 + number)
        writing.die()
        run = found(tmp_path)
        (file,) = bag_files(tmp_path / RUNS[0])
        data = bytearray(file.read_bytes())
        data[run.parts["part 1"].place.offset + 50] ^= 1
        file.write_bytes(data)
        repair_bags(tmp_path)
        for number in (0, 2, 3, 4):
            assert read_at(tmp_path, run.parts[f"part {number}"].place)
        with pytest.raises(BagError, match=RUNS[0]):
            read_at(tmp_path, run.parts["part 1"].place)

    def test_gone(self, first, tmp_path):
        run = found(tmp_path)
        shutil.rmtree(first)
        with pytest.raises(BagError):
            read_at(tmp_path, run.parts["kept"].place)


def test_the_most_recently_used_parts(tmp_path):
    writing = Writing(tmp_path, 0)
    for name in "abcd":
        writing.part(name, 1.0)
    writing.event(JobEvent.QUEUED, "job", "a")
    writing.end()
    run = last_run(earlier_runs(tmp_path, NODE).bags, 2)
    assert list(run.parts) == ["d", "a"] and set(run.results) == {"d", "a"}
