"""Bags by several recorders give the same numbers; what is not whole is read as far as it is."""

from __future__ import annotations

import math
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import CompressionType
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2.enums import CompressionMode

from ros_pose_stats.errors import BagError
from ros_pose_stats.recording.analysis import analyse_bags, read_bags
from ros_pose_stats.recording.analysis.plain import as_dict, plain
from tests.recording.analysis.bags import (
    COUNTED,
    SIMULATED,
    run_of_a_node,
    write_by_run_log,
    write_mcap,
    write_recorded,
    write_run,
)
from tests.recording.analysis.messages import (
    PROBABILITY,
    SECOND,
    START,
    counts,
    definition,
    event,
    result,
)

ROOT = Path(__file__).resolve().parents[3]
STATISTICS = "ros_pose_stats_msgs/msg/PoseStatistics"

RECORDERS = {
    "node": write_by_run_log,
    "plain_mcap": write_run,
    "never_closed": lambda folder: write_run(folder, closed=False),
    "chunked_zstd": lambda folder: write_run(folder, use_chunking=True, chunk_size=4000,
                                             compression=CompressionType.ZSTD),
    "chunked_lz4": lambda folder: write_run(folder, use_chunking=True,
                                            compression=CompressionType.LZ4),
    "chunked_plain": lambda folder: write_run(folder, use_chunking=True, chunk_size=4000),
    "third_party": lambda folder: write_recorded(folder / "bag"),
    "third_party_packed": lambda folder: write_recorded(folder / "bag",
                                                        mode=CompressionMode.FILE),
    "third_party_sqlite": lambda folder: write_recorded(
        folder / "bag", storage=StoragePlugin.SQLITE3, mode=CompressionMode.NONE),
    "own_namespace": lambda folder: write_run(folder, namespace="/cell2/feeder/pose_stats"),
}


@pytest.mark.parametrize("recorder", RECORDERS)
def test_every_recorder_gives_the_same(recorder, tmp_path):
    RECORDERS[recorder](tmp_path / "found")
    found = read_bags(tmp_path / "found")
    assert found.messages == {"DropRecords": 1, "JobEvent": 5, "PartMesh": 1,
                              "PoseCounts": 2, "PoseStatistics": 5}
    (file,) = found.files
    assert file.messages == 14
    assert file.state == ("open" if recorder == "never_closed" else "whole")
    assert found.notes == ()
    write_run(tmp_path / "plain")
    assert everything_but_the_files(found) == everything_but_the_files(
        read_bags(tmp_path / "plain"))


@pytest.mark.parametrize("recorder", ["node", "chunked_zstd", "third_party_packed",
                                      "third_party_sqlite"])
def test_progress_goes_by_bytes(recorder, tmp_path, monkeypatch):
    monkeypatch.setattr("ros_pose_stats.recording.reader.raw_reader._STEP", 0)
    for name in ("a", "b"):
        RECORDERS[recorder](tmp_path / name)
    told = []
    found = analyse_bags(tmp_path, lambda *progress: told.append(progress))
    size = sum(file.path.stat().st_size for file in found.contents.files)
    assert {total for _, total in told} == {size}
    done = [one for one, _ in told]
    assert done == sorted(done) and 0 < done[0] < 0.5 * size < done[-1] <= size


class TestContents:
    @pytest.fixture
    def contents(self, tmp_path):
        write_run(tmp_path)
        return read_bags(tmp_path)

    def test_results(self, contents):
        (part,) = contents.parts
        assert (part.part_id, part.radius) == ("clamp", 0.02)
        (history,) = part.histories
        assert history.numbering == (0.005, 192)
        assert history.poses.index.tolist() == [0, 1, 2, 3, 4]
        assert history.poses.group.tolist() == [0, 1, 0, 2, 3]
        assert history.poses.height == pytest.approx([0.005, 0.006, 0.007, 0.008, 0.009])
        assert history.poses.down.tolist() == [[0.0, 0.0, -1.0]] * 5
        assert history.method.tolist() == ["combined", "simulation", "meae", "simulation"]
        assert history.drops.tolist() == [0, 100, 0, 2000]
        assert history.final.tolist() == [True, False, True, True]
        assert history.latched.tolist() == [True, True, False, True]
        assert history.probability[0].tolist() == list(PROBABILITY)
        assert history.probability[3] == pytest.approx(np.array(SIMULATED) / 2000)
        assert ((history.time - START) / SECOND).tolist() == [0.0, 2.0, 3.0, 4.0]
        assert history.largest_change[1:] == pytest.approx([0.05, 0.1, 0.065])
        assert math.isnan(history.largest_change[0])

    def test_predictions(self, contents):
        (history,) = contents.parts[0].histories
        combined, simulation, meae = history.predictions
        assert [combined.method, meae.method] == ["combined", "meae"]
        assert simulation.count.tolist() == list(SIMULATED)
        assert (simulation.restitution, simulation.drop_height) == (0.5, 0.4)
        assert np.all(simulation.probability_low < simulation.probability)
        assert history.leading is simulation

    def test_jobs(self, contents):
        done, unfinished = contents.parts[0].jobs
        assert (done.job_id, done.state, done.drops_done) == ("job_1", "done", 2000)
        assert (done.ended - done.started) / SECOND == pytest.approx(3.0)
        assert (unfinished.state, unfinished.unfinished) == ("running", True)
        assert {(job.cluster_tolerance, job.round_sides) for job in (done, unfinished)} == {
            (0.005, 192)}

    def test_counts(self, contents):
        (counted,) = contents.counts
        assert counted.count.tolist() == [276, 118, 62, 20, 4]
        assert (counted.unclassified, counted.messages) == (10, 2)
        assert (counted.plate, counted.drop_height) == ("steel", 0.4)
        assert counted.unclassified_share == pytest.approx(10 / 490)

    def test_drops(self, contents):
        log = contents.parts[0].drop_log
        assert (log.drops, log.unsettled, log.impacts, log.seconds) == (5, 1, 60, 2.5)

    def test_warnings(self, contents):
        assert contents.parts[0].warnings == ("LOW_DROP: released low.",)


def everything_but_the_files(contents):
    """Plain values of parts and counts, to be compared."""
    from ros_pose_stats.recording.analysis import analyse

    found = as_dict(analyse(contents))
    return {name: found[name] for name in ("parts", "stray_counts")}


class TestSeveralBags:
    def test_two_recordings_of_a_run_say_no_more_than_one(self, tmp_path):
        write_run(tmp_path / "log")
        write_recorded(tmp_path / "recorded")
        both = read_bags([tmp_path / "log", tmp_path / "recorded"])
        assert everything_but_the_files(both) == everything_but_the_files(
            read_bags(tmp_path / "log"))
        assert both.messages["PoseCounts"] == 4
        assert "2 camera counts in several bags, counted once" in both.notes

    def test_the_order_does_not_matter(self, tmp_path):
        write_run(tmp_path / "log")
        write_recorded(tmp_path / "recorded", run_of_a_node()[:9])
        paths = [tmp_path / "log", tmp_path / "recorded"]
        assert everything_but_the_files(read_bags(paths)) == everything_but_the_files(
            read_bags(paths[::-1]))

    def test_a_path_twice_is_read_once(self, tmp_path):
        run = write_run(tmp_path)
        found = read_bags([tmp_path, run, next(run.glob("*.mcap"))])
        assert len(found.files) == 1
        assert found.messages["PoseCounts"] == 2

    def test_runs_add_up(self, tmp_path):
        write_run(tmp_path, [("pose_counts", counts(1.0, COUNTED))], "run_1")
        write_run(tmp_path, [("pose_counts", counts(2.0, COUNTED)),
                             ("pose_statistics", result(3.0))], "run_2")
        found = read_bags(str(tmp_path))
        assert len(found.bags) == 2
        assert found.counts[0].count.tolist() == [2 * one for one in COUNTED]

    def test_equal_counts_within_a_recording_are_no_copies(self, tmp_path):
        # Two parts that land alike in one picture, told one by one.
        messages = [("pose_counts", counts(1.0, (1,)))] * 2
        write_run(tmp_path / "log", messages)
        assert read_bags(tmp_path / "log").counts[0].count.tolist() == [2]
        write_recorded(tmp_path / "recorded", messages)
        assert read_bags(tmp_path).counts[0].count.tolist() == [2]

    def test_counts_without_a_stamp_are_told_by_the_time_of_recording(self, tmp_path):
        messages = [("pose_counts", counts(None, (1, 0)))] * 40  # a fifth of a second apart
        write_run(tmp_path / "log", messages)
        write_recorded(tmp_path / "recorded", messages, later=0.15)
        found = read_bags(tmp_path)
        assert found.counts[0].count.tolist() == [40, 0]
        assert any("without a time stamp" in note for note in found.notes)
        write_recorded(tmp_path / "next_shift", messages, later=3600.0)
        assert read_bags(tmp_path).counts[0].count.tolist() == [80, 0]

    def test_a_job_ends_in_the_bag_of_the_next_start(self, tmp_path):
        write_run(tmp_path, [("job_events", event(1.0, "QUEUED")),
                             ("job_events", event(2.0, "RUNNING"))], "run_1")
        (job,) = read_bags(tmp_path).parts[0].jobs
        assert job.unfinished
        write_run(tmp_path, [("job_events", event(9.0, "CANCELLED", drops_done=50))], "run_2")
        (job,) = read_bags(tmp_path).parts[0].jobs
        assert (job.state, job.drops_done, job.unfinished) == ("cancelled", 50, False)

    def test_parts_with_one_name_and_two_digests(self, tmp_path):
        write_run(tmp_path, [("pose_statistics", result(1.0)),
                             ("pose_statistics", result(2.0, part_digest="b" * 64)),
                             ("job_events", event(3.0, "PART_FORGOTTEN", ""))])
        found = read_bags(tmp_path)
        assert [part.part_digest[0] for part in found.parts] == ["3", "b"]
        assert [len(part.forgotten) for part in found.parts] == [1, 0]


    def test_a_part_that_was_forgotten_as_its_subscribers_were_told(self, tmp_path):
        """The node's own bag tells it in a second way, at the same time."""
        told = result(3.0, probability=(), warnings=["FORGOTTEN: a client had it forgotten."])
        write_recorded(tmp_path / "bag", [("pose_statistics", result(1.0)),
                                          ("pose_statistics", told)])
        for number in range(2):
            found = read_bags(tmp_path)
            (part,) = found.parts
            assert part.forgotten == (START + 3 * SECOND,) and not found.notes
            assert part.histories[0].time.tolist() == [START + SECOND]
            write_run(tmp_path, [
                ("pose_statistics", told),
                ("job_events", event(3.0, "PART_FORGOTTEN", ""))], f"run_{number}")

    def test_a_result_without_poses_for_no_reason_is_told(self, tmp_path):
        write_run(tmp_path, [("pose_statistics", result(1.0)),
                             ("pose_statistics", result(2.0, probability=()))])
        assert read_bags(tmp_path).notes == ("1 result left out, without poses",)


class TestWhatIsNotWhole:
    def test_cut_anywhere(self, tmp_path):
        (file,) = write_run(tmp_path / "whole", closed=False).glob("*.mcap")
        size = file.stat().st_size
        cuts = np.sort(np.random.default_rng(0).integers(0, size, 60))
        seen = []
        for place in cuts.tolist():
            (tmp_path / "cut").mkdir(exist_ok=True)
            cut = shutil.copyfile(file, tmp_path / "cut" / file.name)
            with cut.open("r+b") as stream:
                stream.truncate(place)
            try:
                found = read_bags(tmp_path / "cut")
            except BagError:  # as long as no message is whole
                seen.append(0)
                continue
            assert found.files[0].state in ("cut", "open")
            assert found.files[0].note
            seen.append(sum(found.messages.values()))
        assert seen == sorted(seen)
        assert seen[0] == 0 and seen[-1] >= 12

    def test_the_last_file_of_a_bag_is_cut(self, tmp_path):
        run = run_of_a_node()
        write_mcap(tmp_path / "bag_9.mcap", run[:8])
        last = write_mcap(tmp_path / "bag_10.mcap", run[8:])
        with last.open("r+b") as stream:
            stream.truncate(last.stat().st_size * 2 // 3)
        found = read_bags(tmp_path)
        assert [file.path.name for file in found.files] == ["bag_9.mcap", "bag_10.mcap"]
        assert [file.state for file in found.files] == ["whole", "cut"]
        assert len(found.bags) == 1
        assert found.messages["PoseStatistics"] >= 4

    @pytest.mark.parametrize("content", [b"", b"\0" * 5000, b"something else " * 40])
    def test_another_file_in_the_way(self, tmp_path, content):
        write_run(tmp_path)
        (tmp_path / "other.mcap").write_bytes(content)
        found = read_bags(tmp_path)
        assert sum(found.messages.values()) == 14
        assert sorted(file.state == "whole" for file in found.files) == [False, True]

    def test_a_message_that_is_too_short(self, tmp_path):
        write_run(tmp_path)
        file = write_mcap(tmp_path / "short.mcap", [("pose_statistics", result(20.0))])
        content = file.read_bytes()
        place = content.index(b"combined\0")
        file.write_bytes(content[:place - 4] + b"\xff\xff\xff\x7f" + content[place:])
        found = read_bags(tmp_path)
        assert "1 message " in found.notes[0]
        assert len(found.parts[0].histories[0].time) == 4


    @pytest.mark.parametrize(("topic", "message"), [
        ("pose_counts", counts(1.0, (2 ** 64 - 1, 3))),
        ("pose_counts", counts(1.0, (2, 3), unclassified=2 ** 64 - 1)),
        ("pose_statistics", result(1.0, drops=2 ** 64 - 1)),
        ("pose_statistics", result(1.0, unsettled=2 ** 63)),
    ])
    def test_numbers_that_cannot_be(self, tmp_path, topic, message):
        write_run(tmp_path, [(topic, message)], "damaged")
        found = analyse_bags(tmp_path)
        assert (found.parts, found.contents.counts) == ((), ())
        write_run(tmp_path)
        found = analyse_bags(tmp_path)
        assert len(found.parts[0].record.histories[0].time) == 4
        assert "1 message left out, broken" in found.contents.notes[0]


class TestOtherVersions:
    def test_older_definitions_lack_fields(self, tmp_path):
        old = ("std_msgs/Header header\nstring part_id\nstring part_digest\nstring method\n"
               "float64 cluster_tolerance\nStablePose[] poses\n" + "=" * 80
               + "\nMSG: ros_pose_stats_msgs/StablePose\nuint32 index\nfloat64 probability\n"
               + "=" * 80 + "\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\n"
               "string frame_id\n" + "=" * 80
               + "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n")
        write_old(tmp_path / "old.mcap", old)
        (part,) = read_bags(tmp_path).parts
        (history,) = part.histories
        assert history.probability.tolist() == [[0.75, 0.25]]
        assert history.poses.group.tolist() == [0, 1]
        assert np.isnan(history.poses.height).all()
        assert np.isnan(history.expected_error).all()
        assert history.final.tolist() == [True]
        assert math.isnan(part.radius)

    def test_older_ones_took_round_surfaces_as_they_are(self, tmp_path):
        write_without_round_sides(tmp_path / "old.mcap")
        found = analyse_bags(tmp_path)
        (part,) = found.parts
        (history,), (job,), (compared,) = part.record.histories, part.record.jobs, part.counts
        assert history.numbering == compared.counts.numbering == (0.005, 0)
        assert (job.state, job.cluster_tolerance, job.round_sides) == ("running", 0.005, 0)
        assert (compared.problem, compared.count.tolist()) == ("", [3, 1])
        # Results of today number other poses.
        write_run(tmp_path, [("pose_statistics", result(1.0, part_digest="d"))])
        (part,) = read_bags(tmp_path).parts
        assert {one.numbering for one in part.histories} == {(0.005, 0), (0.005, 192)}

    def test_newer_definitions_have_more_fields(self, tmp_path):
        text = definition(STATISTICS)
        head, rest = text.split("=" * 80, 1)
        newer = f"{head}\nfloat64 mood\n" + "=" * 80 + rest
        from mcap_ros2.writer import Writer

        plain_message = {"part_id": "clamp", "part_digest": "d", "method": "auto", "mood": 1.0,
                         "cluster_tolerance": 0.005, "poses": [{"index": 0, "probability": 1.0}]}
        with (tmp_path / "new.mcap").open("wb") as stream, Writer(stream) as writer:
            schema = writer.register_msgdef(STATISTICS, newer)
            writer.write_message("/pose_stats/pose_statistics", schema, plain_message, 5, 5)
        (part,) = read_bags(tmp_path).parts
        assert part.histories[0].method.tolist() == ["auto"]

    def test_another_numbering_is_left_out(self, tmp_path):
        write_run(tmp_path, [("pose_statistics", result(1.0)),
                             ("pose_statistics", result(2.0, PROBABILITY[:4]))])
        found = read_bags(tmp_path)
        assert len(found.parts[0].histories[0].time) == 1
        assert "1 result left out, numbering" in found.notes[0]

    def test_each_numbering_is_a_history(self, tmp_path):
        write_run(tmp_path, [
            ("pose_statistics", result(1.0, cluster_tolerance=0.0, probability=(0.5, 0.5))),
            *(("pose_statistics", result(2.0 + k)) for k in range(3)),
            *(("pose_statistics", result(6.0 + k, (0.5, 0.3, 0.2), round_sides=0))
              for k in range(2))])
        histories = read_bags(tmp_path).parts[0].histories
        assert [one.numbering for one in histories] == [(0.005, 192), (0.005, 0), (0.0, 192)]
        assert [one.probability.shape for one in histories] == [(3, 5), (2, 3), (1, 2)]


def write_old(file, text):
    """A bag of another tool with a short definition, by the library's own encoder."""
    from mcap_ros2.writer import Writer

    message = {"header": {"stamp": {"sec": 3, "nanosec": 0}}, "part_id": "clamp",
               "part_digest": "d", "method": "combined", "cluster_tolerance": 0.005,
               "poses": [{"index": 1, "probability": 0.25}, {"index": 0, "probability": 0.75}]}
    with file.open("wb") as stream, Writer(stream) as writer:
        schema = writer.register_msgdef(STATISTICS, text)
        writer.write_message("/pose_stats/pose_statistics", schema, message, 5, 5)


def write_without_round_sides(file):
    """A bag from before messages said them, by the library's own encoder."""
    from mcap_ros2.writer import Writer

    about = {"part_id": "clamp", "part_digest": "d", "cluster_tolerance": 0.005}
    messages = {
        "PoseStatistics": {"method": "combined", "poses": [
            {"index": 0, "probability": 0.75}, {"index": 1, "probability": 0.25}]},
        "JobEvent": {"event": 2, "job_id": "job_1", "seed": 192, "drop_height": 0.4},
        "PoseCounts": {"index": [0, 1], "count": [3, 1]},
    }
    with file.open("wb") as stream, Writer(stream) as writer:
        for name, fields in messages.items():
            kind = f"ros_pose_stats_msgs/msg/{name}"
            text = definition(kind)
            assert text.count("uint32 round_sides\n") == 1
            schema = writer.register_msgdef(kind, text.replace("uint32 round_sides\n", ""))
            writer.write_message(f"/pose_stats/{name}", schema, {**about, **fields}, 5, 5)


class TestRefusals:
    @pytest.mark.parametrize(("make", "said"), [
        (lambda folder: folder / "nowhere", "does not exist"),
        (lambda folder: folder, "none under"),
        (lambda folder: write_run(folder, []), "none in 1 file"),
        (lambda folder: (folder / "a.mcap", (folder / "a.mcap").write_text("no bag" * 50))[0],
         "not an MCAP file"),
        (lambda folder: (folder / "a.db3.zstd", (folder / "a.db3.zstd").touch())[0],
         "ros2 bag convert"),
        (lambda folder: (folder / "a.db3", (folder / "a.db3").write_bytes(b"x" * 5000))[0],
         "none in 1 file"),
        (lambda folder: write_recorded(folder / "bag", mode=CompressionMode.MESSAGE),
         "ros2 bag convert"),
    ])
    def test_one_sentence(self, tmp_path, make, said):
        with pytest.raises(BagError) as refusal:
            read_bags(make(tmp_path))
        assert said in str(refusal.value)
        assert "\n" not in str(refusal.value)

    def test_no_path(self):
        with pytest.raises(BagError, match="at least one bag"):
            read_bags([])

    def test_a_file_that_cannot_be_read(self, tmp_path, monkeypatch):
        run = write_run(tmp_path)

        def refused(*_args, **_options):
            raise PermissionError(13, "Permission denied")

        monkeypatch.setattr("ros_pose_stats.recording.reader.raw_reader._opened", refused)
        with pytest.raises(BagError, match="Permission denied"):
            read_bags(run)

    def test_sqlite_without_definitions(self, tmp_path):
        import sqlite3

        bag = write_recorded(tmp_path / "bag", storage=StoragePlugin.SQLITE3,
                             mode=CompressionMode.NONE)
        base = sqlite3.connect(next(bag.glob("*.db3")))
        base.execute("DROP TABLE message_definitions")
        base.commit()
        base.close()
        with pytest.raises(BagError, match="ros2 bag convert"):
            read_bags(bag)


def test_python_of_the_document_runs(tmp_path, monkeypatch, capsys):
    text = (ROOT / "docs" / "bags.md").read_text(encoding="utf-8")
    write_run(tmp_path / "log")
    write_mcap(tmp_path / "run_0.mcap", run_of_a_node())
    monkeypatch.chdir(tmp_path)
    codes = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert len(codes) == 2
    for code in codes:
        exec(code, {})
        assert "simulation" in capsys.readouterr().out


def test_plain_values():
    values = {"a": np.array([1.0, math.nan]), "b": (np.float64(math.inf), np.int64(3)),
              "c": np.bool_(True)}
    assert plain(values) == {"a": [1.0, None], "b": [None, 3], "c": True}
