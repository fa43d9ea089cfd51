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

"""`animate`: a moving picture, a recording for other tools, and refusals."""

import os

import numpy as np
import pytest
from mcap.reader import make_reader
from PIL import Image, ImageSequence

from ros_pose_stats import load_part, simulate
from tests.running import answer, refusal

SCENE = "--drop", 2, "--seed", 5, "--restitution", 0.1


def test_a_gif_moves_and_ends_at_rest_on_white_paper(box, tmp_path):
    file = tmp_path / "out" / "drop.gif"
    text = answer("animate", *box, *SCENE, "--drop-height", "60mm", "-o", file)
    counted = []
    simulate(
        load_part(box[0], unit="mm"),
        3,
        0.1,
        5,
        0.06,
        workers=1,
        on_drops=lambda chunk: counted.extend(chunk.outcomes.pose.tolist()),
    )
    assert f"at rest in pose {counted[2]}" in text and str(file) in text
    with Image.open(file) as gif:
        frames = [
            np.asarray(frame.convert("RGB")) for frame in ImageSequence.Iterator(gif)
        ]
    assert len(frames) > 5 and all((frame[0] == 255).all() for frame in frames)
    moved = [
        (np.abs(frame.astype(int) - frames[-1]).max(axis=2) > 60).mean()
        for frame in (frames[0], frames[-2])
    ]
    assert moved[0] > 0.01 and moved[1] < moved[0]
    assert [path.name for path in file.parent.iterdir()] == ["drop.gif"]


def test_an_mcap_plays_in_other_tools(box, tmp_path):
    file = tmp_path / "drop.mcap"
    assert "HEIGHT_SUSPECT" in answer(
        "animate", *box, *SCENE, "--drop-height", 20, "-o", file
    )
    with file.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    topics = {
        channel.topic: summary.schemas[channel.schema_id].name
        for channel in summary.channels.values()
    }
    assert topics["/tf"] == "tf2_msgs/msg/TFMessage"
    assert topics["/drop/markers"] == "visualization_msgs/msg/MarkerArray"
    assert all(
        count > 0 for count in summary.statistics.channel_message_counts.values()
    )


def test_an_mp4_without_ffmpeg_is_refused(box, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    line = refusal("animate", *box, "-o", tmp_path / "a.mp4")
    assert "expected ffmpeg for an .mp4, got none" in line
    assert not list(tmp_path.iterdir())


@pytest.mark.long
def test_an_mp4_hands_ffmpeg_every_pixel(box, tmp_path, monkeypatch):
    stand_in = tmp_path / "ffmpeg"
    stand_in.write_text(
        '#!/bin/sh\nfor last; do :; done\nwc -c >"$last"\necho "$@" >"$last.words"\n'
    )
    stand_in.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    answer("animate", *box, *SCENE, "-o", tmp_path / "a.mp4")
    words = (tmp_path / "a.mp4.words").read_text().split()
    width, height = map(int, words[words.index("-s") + 1].split("x"))
    frames, rest = divmod(int((tmp_path / "a.mp4").read_text()), 3 * width * height)
    assert frames > 5 and rest == 0 and float(words[words.index("-r") + 1]) > 0.0


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("-o", "drop.avi"), "ends in .gif or .mp4 or .mcap"),
        (("-o", "drop.gif", "--drop", "-1"), "the number of a drop"),
        (("-o", "drop.gif", "--restitution", "1"), "a coefficient of restitution"),
        (("-o", "/proc/none/drop.gif"), "/proc/none"),
    ],
)
def test_refused_before_anything_is_written(box, tmp_path, monkeypatch, options, words):
    monkeypatch.chdir(tmp_path)
    assert words in refusal("animate", *box, *options)
    assert not list(tmp_path.iterdir())
