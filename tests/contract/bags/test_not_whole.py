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

"""Bags that are cut, damaged, foreign or none: read as far as they are, or refused in a
line.
"""

import sqlite3

import numpy as np
import pytest
import zstandard
from mcap.reader import make_reader
from mcap.writer import CompressionType
from rosbags.rosbag2.enums import CompressionMode

from ros_pose_stats import PoseStatsError, analyse_bags
from tests.running import refusal

from .messages import counts, result, run_of_a_node
from .recorders import write_mcap, write_recorded, write_run, write_sqlite


def only_file(folder):
    (file,) = folder.rglob("*.mcap")
    return file


def test_cut_anywhere_the_whole_messages_before_it_are_read(tmp_path):
    file = only_file(write_run(tmp_path / "whole", closed=False))
    content = file.read_bytes()
    counts = []
    places = np.sort(np.random.default_rng(0).integers(0, len(content), 40))
    for offset in places.tolist():
        (tmp_path / "cut.mcap").write_bytes(content[:offset])
        try:
            contents = analyse_bags(tmp_path / "cut.mcap").contents
        except PoseStatsError:  # as long as no message is whole
            counts.append(0)
            continue
        assert contents.files[0].state in ("cut", "open") and contents.files[0].note
        counts.append(sum(contents.messages.values()))
    assert counts == sorted(counts)
    assert counts[0] == 0 and counts[-1] >= 12


def test_only_the_last_file_of_a_bag_is_cut(tmp_path):
    """Files are in the order of their numbers, not of their names."""
    run = run_of_a_node()
    copy = tmp_path / "there"
    links = tmp_path / "links"
    write_mcap(copy / "bag_9.mcap", run[:8])
    last = write_mcap(copy / "bag_10.mcap", run[8:])
    last.write_bytes(last.read_bytes()[: last.stat().st_size * 2 // 3])
    links.mkdir()
    (links / "there").symlink_to(copy)
    contents = analyse_bags(links).contents
    assert [(file.path.name, file.state) for file in contents.files] == [
        ("bag_9.mcap", "whole"),
        ("bag_10.mcap", "cut"),
    ]
    assert len(contents.bags) == 1 and contents.messages["PoseStatistics"] >= 4


@pytest.mark.parametrize("compression", [CompressionType.NONE, CompressionType.ZSTD])
@pytest.mark.parametrize("pack", [bytes, zstandard.compress])
def test_a_flipped_bit_costs_its_chunk_alone(tmp_path, compression, pack):
    run = [("pose_statistics", result(float(k))) for k in range(40)]
    write_run(
        tmp_path, run, use_chunking=True, chunk_size=4000, compression=compression
    )
    file = only_file(tmp_path)
    content = bytearray(file.read_bytes())
    with file.open("rb") as stream:
        chunks = make_reader(stream).get_summary().chunk_indexes
    chunk = chunks[len(chunks) // 3]  # between chunks is what has no checksum
    content[chunk.chunk_start_offset + chunk.chunk_length // 2] ^= 1
    file.rename(f"{file}{'' if pack is bytes else '.zstd'}").write_bytes(pack(content))
    contents = analyse_bags(tmp_path).contents
    assert contents.files[0].state == "damaged" and "chunk" in contents.files[0].note
    times = contents.parts[0].histories[0].time
    assert 20 < len(times) < 40 and np.all(np.diff(times) > 0)


@pytest.mark.parametrize("content", [b"", b"\0" * 5000, b"something else " * 40])
def test_another_file_in_the_way_is_passed_over_and_named(tmp_path, content):
    write_run(tmp_path)
    state = "unreadable" if content else "cut"
    others = ["other.mcap", "other.mcap.zstd"]
    for name in others:
        (tmp_path / name).write_bytes(content)
    contents = analyse_bags(tmp_path).contents
    assert sum(contents.messages.values()) == 14
    assert [file.path.name for file in contents.files if file.state == state] == others


class TestBrokenMessages:
    def test_one_whose_bytes_end_early_is_left_out(self, tmp_path):
        write_run(tmp_path)
        file = write_mcap(tmp_path / "short.mcap", [("pose_statistics", result(20.0))])
        content = file.read_bytes()
        offset = content.index(b"combined\0")
        file.write_bytes(content[: offset - 4] + b"\xff\xff\xff\x7f" + content[offset:])
        contents = analyse_bags(tmp_path).contents
        assert "1 message " in contents.notes[0]
        assert len(contents.parts[0].histories[0].time) == 4

    @pytest.mark.parametrize(
        ("topic", "message"),
        [
            ("pose_counts", counts(1.0, (2**64 - 1, 3))),
            ("pose_counts", counts(1.0, (2, 3), unclassified=2**64 - 1)),
            ("pose_statistics", result(1.0, drops=2**64 - 1)),
        ],
    )
    def test_numbers_that_cannot_be_are_left_out(self, tmp_path, topic, message):
        write_run(tmp_path, [(topic, message)], "damaged")
        analysis = analyse_bags(tmp_path)
        assert (analysis.parts, analysis.contents.counts) == ((), ())
        write_run(tmp_path)
        analysis = analyse_bags(tmp_path)
        assert len(analysis.parts[0].record.histories[0].time) == 4
        assert "1 message left out, broken" in analysis.contents.notes[0]

    def test_arrays_that_do_not_fit_are_left_out(self, tmp_path):
        broken = counts(2.0, (5, 6))
        broken.index.append(3)
        write_run(
            tmp_path,
            [
                ("pose_statistics", result(1.0)),
                ("pose_counts", broken),
                ("pose_statistics", result(2.0, probability=())),
            ],
        )
        contents = analyse_bags(tmp_path).contents
        assert contents.counts == () and len(contents.parts[0].histories[0].time) == 1
        for words in ("1 camera count left out", "1 result left out, without poses"):
            assert words in " ".join(contents.notes)


def without_definitions(folder):
    """As before ROS 2 Iron."""
    base = sqlite3.connect(next(write_sqlite(folder / "bag").glob("*.db3")))
    base.execute("DROP TABLE message_definitions")
    base.commit()
    base.close()
    return folder / "bag"


def written(file, content):
    file.write_bytes(content)
    return file


class TestRefusals:
    @pytest.mark.parametrize(
        ("make", "words"),
        [
            (lambda folder: folder / "nowhere", "does not exist"),
            (lambda folder: folder, "none under"),
            (lambda folder: write_run(folder, []), "none in 1 file"),
            (
                lambda folder: written(folder / "a.mcap", b"no bag" * 50),
                "not an MCAP file",
            ),
            (lambda folder: written(folder / "a.db3.zstd", b""), "ros2 bag convert"),
            (lambda folder: written(folder / "a.db3", b"x" * 5000), "none in 1 file"),
            (
                lambda folder: write_recorded(
                    folder / "bag", mode=CompressionMode.MESSAGE
                ),
                "ros2 bag convert",
            ),
            (without_definitions, "ros2 bag convert"),
        ],
    )
    def test_what_holds_nothing_is_refused_in_one_line(self, tmp_path, make, words):
        line = refusal("bag", make(tmp_path))
        assert line.startswith("ros_pose_stats: expected ") and words in line

    def test_no_bag_at_all_and_a_wrong_path_beside_a_good_one(self, tmp_path):
        with pytest.raises(PoseStatsError, match="at least one bag"):
            analyse_bags([])
        write_run(tmp_path / "log")
        (tmp_path / "file").touch()
        assert "file" in refusal("bag", tmp_path / "log", "--csv", tmp_path / "file")
        assert "nowhere" in refusal("bag", tmp_path / "log", tmp_path / "nowhere")
