"""Bags that were cut, damaged or left unfinished."""

from __future__ import annotations

import os
import shutil
import tempfile
from bisect import bisect_right
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader

from ros_pose_stats.recording import durable
from ros_pose_stats.recording.directory_lock import DirectoryLock
from ros_pose_stats.recording.finished import is_finished
from ros_pose_stats.recording.repair.repair import repair_bags
from tests.recording.bags import (
    LATER_RUN,
    RUN,
    data_of,
    finished_bag,
    let_die,
    new_log,
    numbered,
    only_file,
    undamaged,
    unfinished_bag,
)

MESSAGES = [numbered(number, 10 * number) for number in range(6)]


@pytest.fixture(scope="module")
def no_waiting():
    """Thousands of repairs need not wait for the disk."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(durable.os, "fsync", lambda number: None)
        yield


@pytest.fixture(scope="module")
def cut(tmp_path_factory, no_waiting):
    """Makes a bag of some bytes and repairs it; returns the repair and the messages."""
    folder = tmp_path_factory.mktemp("cut")

    def repaired(content: bytes, metadata: str | None = None):
        directory = folder / RUN
        shutil.rmtree(directory, ignore_errors=True)
        directory.mkdir()
        file = directory / f"{RUN}_0.mcap"
        file.write_bytes(content)
        if metadata is not None:
            (directory / "metadata.yaml").write_text(metadata)
        readable = data_of(directory)
        repairs = repair_bags(folder)
        messages = undamaged(directory)
        assert readable == messages
        assert is_finished(directory) and repair_bags(folder) == []
        with file.open("rb") as stream:
            assert [one.data for _, _, one in make_reader(stream).iter_messages()] == messages
        return repairs, messages

    return repaired


@pytest.fixture(scope="module")
def unfinished(tmp_path_factory):
    """Bytes of an unfinished file, and its size after each message."""
    directory, sizes = unfinished_bag(tmp_path_factory.mktemp("unfinished"), MESSAGES)
    return only_file(directory).read_bytes(), sizes


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """Bytes of the same file when it is finished, and its description."""
    directory = finished_bag(tmp_path_factory.mktemp("finished"), MESSAGES)
    return only_file(directory).read_bytes(), (directory / "metadata.yaml").read_text()


class TestCut:
    @pytest.mark.long
    def test_at_every_byte_of_the_last_messages(self, cut, unfinished):
        content, sizes = unfinished
        for end in range(sizes[1] - 1, len(content) + 1):
            [repair], messages = cut(content[:end])
            whole = bisect_right(sizes, end)
            assert messages == MESSAGES[:whole]
            assert repair.kept == whole and repair.problem == ""
            assert repair.cut_bytes == end - sizes[whole - 1]

    def test_anywhere_in_the_end(self, cut, unfinished, finished):
        content, metadata = finished
        start, stop = unfinished[1][-1], len(content)
        for end in (*range(start, stop - 80, 11), *range(stop - 80, stop)):
            [repair], messages = cut(content[:end], metadata)
            assert messages == MESSAGES
            assert repair.kept == len(MESSAGES)

    def test_at_every_byte_of_the_beginning(self, cut, unfinished):
        content, sizes = unfinished
        for end in range(0, sizes[0], 7):
            [repair], messages = cut(content[:end])
            assert messages == [] and repair.kept == 0 and repair.problem == ""

    @given(st.data())
    def test_with_zeros_or_noise_behind(self, cut, unfinished, data):
        content, sizes = unfinished
        end = data.draw(st.integers(0, len(content)))
        noise = data.draw(st.one_of(
            st.integers(1, 10_000).map(bytes), st.binary(min_size=1, max_size=100)))
        _, messages = cut(content[:end] + noise)
        whole = bisect_right(sizes, end)
        assert messages[:whole] == MESSAGES[:whole]
        # Noise may by chance be what was cut away, but never a message that was not written.
        assert messages == MESSAGES[:len(messages)]

    @given(st.data())
    def test_a_block_that_never_reached_the_disk(self, cut, unfinished, data):
        content, sizes = unfinished
        start = data.draw(st.integers(sizes[0], len(content) - 1))
        end = data.draw(st.integers(start + 1, len(content)))
        _, messages = cut(content[:start] + bytes(end - start) + content[end:])
        hit = [number for number, size in enumerate(sizes)
               if number and size > start and sizes[number - 1] < end]
        kept = [one for number, one in enumerate(MESSAGES) if number not in hit]
        # A hit message survives only where zeros took the place of zeros.
        assert [one for one in messages if one in kept] == kept
        assert all(one in MESSAGES for one in messages)

    def test_messages_whose_type_got_lost_are_not_thrown_away(self, tmp_path, no_waiting):
        directory, _ = unfinished_bag(tmp_path, MESSAGES, RUN)
        file = only_file(directory)
        content = file.read_bytes()
        for name in (b"std_msgs/msg/String", b"/pose_stats/answers\3"):
            damaged = content.replace(name, name.upper())
            file.write_bytes(damaged)
            [repair] = repair_bags(tmp_path)
            assert repair.problem == (
                f"cannot mend {directory}: the description of a topic in it is damaged")
            assert file.read_bytes() == damaged
            assert list(directory.glob("*.half")) == []

    def test_damage_to_the_beginning_is_survived(self, cut, unfinished):
        content, _ = unfinished
        metadata = content.index(b"rosbag2"), content.index(b"ros_distro")
        for place in (*range(60), *range(*metadata, 20)):
            damaged = bytearray(content)
            damaged[place] ^= 0x41
            _, messages = cut(bytes(damaged))
            assert messages == MESSAGES

    def test_a_flipped_bit_costs_its_message_only(self, cut, unfinished):
        content, sizes = unfinished
        for place in range(sizes[2], sizes[3]):
            damaged = bytearray(content)
            damaged[place] ^= 4
            [repair], messages = cut(bytes(damaged))
            # In the place where a checksum belongs to the message it makes it an unknown one.
            assert messages in ([*MESSAGES[:3], *MESSAGES[4:]], MESSAGES)
            assert repair.kept == len(messages)


class TestBags:
    def test_a_missing_log_directory_holds_none(self, tmp_path):
        assert repair_bags(tmp_path / "missing") == []

    def test_a_finished_bag_is_left_alone(self, tmp_path):
        directory = finished_bag(tmp_path, MESSAGES, RUN)
        before = {file: (file.stat().st_ino, file.read_bytes()) for file in directory.iterdir()}
        assert repair_bags(tmp_path) == []
        assert before == {
            file: (file.stat().st_ino, file.read_bytes()) for file in directory.iterdir()}

    @pytest.mark.parametrize("metadata", [None, "", "rosbag2_bagfile_information:\n", b"\xff",
                                          "rosbag2_bagfile_information:\n  message_count: 5\n"])
    def test_a_missing_or_stale_description_is_written(self, tmp_path, metadata):
        directory = finished_bag(tmp_path, MESSAGES, RUN)
        file = directory / "metadata.yaml"
        right = file.read_text()
        file.unlink()
        if metadata is not None:
            file.write_bytes(metadata if isinstance(metadata, bytes) else metadata.encode())
        content = only_file(directory).read_bytes()
        [repair] = repair_bags(tmp_path)
        assert (repair.directory, repair.kept, repair.cut_bytes) == (directory, 6, 0)
        assert file.read_text() == right
        assert only_file(directory).read_bytes() == content

    def test_somebody_elses_notes_in_the_description_stay(self, tmp_path):
        file = finished_bag(tmp_path, MESSAGES, RUN) / "metadata.yaml"
        noted = file.read_text().replace("custom_data: ~", "custom_data:\n    part: clamp")
        file.write_text(noted)
        assert repair_bags(tmp_path) == []
        assert file.read_text() == noted

    def test_several_files_and_bags(self, tmp_path):
        for name in (RUN, LATER_RUN):
            log = new_log(tmp_path, name=name, max_bag_bytes=9_000)
            for number in range(12):
                log.write("/pose_stats/answers", numbered(number, 1000), durable=False)
            assert len(list(log.directory.glob("*.mcap"))) > 2
            let_die(log)
        repairs = repair_bags(tmp_path)
        assert [(one.directory.name, one.kept, one.cut_bytes) for one in repairs] == [
            (RUN, 12, 0), (LATER_RUN, 12, 0)]
        for repair in repairs:
            assert undamaged(repair.directory) == [numbered(one, 1000) for one in range(12)]

    def test_the_bag_of_a_living_node_is_left_alone(self, tmp_path):
        log = new_log(tmp_path, name=RUN)
        log.write("/pose_stats/answers", MESSAGES[0], durable=True)
        content = only_file(log.directory).read_bytes()
        assert repair_bags(tmp_path) == []
        assert only_file(log.directory).read_bytes() == content
        log.write("/pose_stats/answers", MESSAGES[1], durable=True)
        log.close()
        assert undamaged(log.directory) == MESSAGES[:2]

    def test_other_names_are_left_alone(self, tmp_path):
        unfinished_bag(tmp_path, MESSAGES, "my_favourite_run")
        (tmp_path / "notes.txt").write_text("mine")
        (tmp_path / f"{RUN}.txt").write_text("mine")
        directory, _ = unfinished_bag(tmp_path, MESSAGES, RUN)
        (directory / "other.mcap").write_text("mine")
        (directory / "other_0.mcap.half").write_text("mine")
        [repair] = repair_bags(tmp_path)
        assert repair.directory == directory
        assert (directory / "other.mcap").read_text() == "mine"
        assert (directory / "other_0.mcap.half").read_text() == "mine"
        assert not is_finished(tmp_path / "my_favourite_run")

    def test_an_interrupted_repair_leaves_nothing_behind(self, tmp_path):
        directory, _ = unfinished_bag(tmp_path, MESSAGES, RUN)
        for name in (f"{RUN}_0.mcap.half", "metadata.yaml.half"):
            (directory / name).write_bytes(b"half")
        assert repair_bags(tmp_path)[0].kept == 6
        assert list(directory.glob("*.half")) == []
        assert undamaged(directory) == MESSAGES

    def test_permissions_stay(self, tmp_path):
        directory, _ = unfinished_bag(tmp_path, MESSAGES, RUN)
        only_file(directory).chmod(0o640)
        repair_bags(tmp_path)
        assert only_file(directory).stat().st_mode & 0o777 == 0o640


class TestLeftovers:
    @pytest.fixture
    def old(self, monkeypatch):
        """What is there is taken to be there for long."""
        monkeypatch.setattr("ros_pose_stats.recording.repair.removal._YOUNG", -1.0)

    @pytest.mark.parametrize("names", [
        [".lock"], [], [".lock", "metadata.yaml", f"{RUN}_3.mcap", f"{RUN}_0.mcap.half"]])
    def test_a_half_deleted_or_half_made_run_goes(self, tmp_path, old, names):
        for ending in ("new", "old"):
            directory = tmp_path / f".{RUN}.{ending}"
            directory.mkdir()
            for name in names:
                (directory / name).touch()
        assert repair_bags(tmp_path) == []
        assert list(tmp_path.iterdir()) == []

    def test_somebody_elses_files_stay(self, tmp_path, old):
        directory = tmp_path / f".{RUN}.old"
        directory.mkdir()
        (directory / "notes.txt").touch()
        repair_bags(tmp_path)
        assert (directory / "notes.txt").exists()

    def test_what_somebody_is_busy_with_stays(self, tmp_path, old):
        directory = tmp_path / f".{RUN}.new"
        directory.mkdir()
        with DirectoryLock.take(directory):
            repair_bags(tmp_path)
            assert directory.exists()

    def test_what_was_just_made_stays(self, tmp_path):
        (tmp_path / f".{RUN}.new").mkdir()
        repair_bags(tmp_path)
        assert (tmp_path / f".{RUN}.new").exists()


@pytest.fixture
def unprivileged():
    """A log directory of a user for whom permissions count; root works as nobody meanwhile."""
    nobody = 65534
    with tempfile.TemporaryDirectory() as folder:
        log_directory = Path(folder) / "log"
        log_directory.mkdir()
        Path(folder).chmod(0o755)
        was_root = os.geteuid() == 0
        if was_root:
            os.chown(log_directory, nobody, nobody)
            os.seteuid(nobody)
        try:
            yield log_directory
        finally:
            if was_root:
                os.seteuid(0)
            for run in log_directory.iterdir():
                run.chmod(0o755)


class TestTrouble:
    def test_a_read_only_bag_is_told_and_still_readable(self, unprivileged):
        log_directory = unprivileged
        finished_bag(log_directory, MESSAGES, LATER_RUN)
        directory, _ = unfinished_bag(log_directory, MESSAGES, RUN)
        for run in (directory, log_directory / LATER_RUN):
            (run / ".lock").unlink()
            run.chmod(0o555)
        [repair] = repair_bags(log_directory)
        assert repair.directory == directory
        assert repair.problem == f"cannot mend {directory}: Permission denied"
        assert data_of(directory) == MESSAGES
        directory.chmod(0o755)
        assert repair_bags(log_directory)[0].problem == ""
        assert undamaged(directory) == MESSAGES
