"""The command `animate` as a user runs it."""

import json
import os
import stat

import numpy as np
import pytest
from mcap.reader import make_reader
from PIL import Image

from ros_pose_stats import load_part, simulate
from ros_pose_stats.cli import main
from ros_pose_stats.plots.animation import DPI, SIZE
from ros_pose_stats.plots.files import write_gif, write_mp4
from ros_pose_stats.shapes.closed_forms import box
from ros_pose_stats.simulation.frames import RATE
from tests.bodies import write_stl
from tests.running import complaints


@pytest.fixture
def block(tmp_path):
    return write_stl(tmp_path / "block.stl", box(40.0, 30.0, 20.0))


def run(capsys, *words):
    status = main([str(word) for word in words])
    return status, *capsys.readouterr()


def test_a_gif_moves_and_ends_at_rest(block, tmp_path, capsys):
    file = tmp_path / "out" / "drop.gif"
    status, said, error = run(capsys, "animate", block, "--unit", "mm", "--drop", 2, "--seed", 5,
                              "--restitution", 0.1, "-o", file)
    assert (status, complaints(error)) == (0, [])
    counted = []
    simulate(load_part(block, unit="mm"), 3, 0.1, 5, workers=1,
             on_drops=lambda chunk: counted.extend(chunk.outcomes.pose.tolist()))
    assert f"at rest in pose {counted[2]}" in said
    with Image.open(file) as gif:
        assert gif.size == (SIZE[0] * DPI, SIZE[1] * DPI)
        assert gif.n_frames > 5
        first = np.asarray(gif.convert("RGB")).astype(int)
        gif.seek(gif.n_frames - 1)
        last = np.asarray(gif.convert("RGB")).astype(int)
        assert gif.info["duration"] >= 1000 / RATE
    assert (np.abs(first - last).max(axis=2) > 60).mean() > 0.01
    assert [one.name for one in file.parent.iterdir()] == ["drop.gif"]


def test_paper_stays_white_in_a_gif_of_many_shades(tmp_path):
    shades = np.full((64, 64, 3), 255, dtype=np.uint8)
    shades[:, 32:] = np.linspace(236, 252, 32 * 64).reshape(64, 32, 1).astype(np.uint8)
    write_gif(tmp_path / "a.gif", [shades, shades[::-1]], 10)
    with Image.open(tmp_path / "a.gif") as gif:
        assert (np.asarray(gif.convert("RGB"))[:, :32] == 255).all()


def test_an_mcap_plays_elsewhere(block, tmp_path, capsys):
    file = tmp_path / "drop.mcap"
    status, _, error = run(capsys, "animate", block, "--unit", "mm", "-o", file)
    assert (status, complaints(error)) == (0, [])
    with file.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    topics = {channel.topic: summary.schemas[channel.schema_id].name
              for channel in summary.channels.values()}
    assert topics == {"/tf": "tf2_msgs/msg/TFMessage",
                      "/drop/markers": "visualization_msgs/msg/MarkerArray",
                      "/drop/energy": "std_msgs/msg/Float64",
                      "/drop/within_reach": "std_msgs/msg/String"}


def test_an_mp4_without_ffmpeg_is_refused_in_one_line(block, tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    status, said, error = run(capsys, "animate", block, "--unit", "mm", "-o", tmp_path / "a.mp4")
    (line,) = complaints(error)
    assert (status, said) == (2, "")
    assert "expected ffmpeg for an .mp4, got none" in line
    assert not (tmp_path / "a.mp4").exists()


def test_an_mp4_hands_ffmpeg_every_pixel(tmp_path, monkeypatch):
    stand_in = tmp_path / "ffmpeg"
    stand_in.write_text("#!/bin/sh\nfor last; do :; done\nwc -c >\"$last\"\n"
                        "echo \"$@\" >\"$last.words\"\n")
    stand_in.chmod(stand_in.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    pictures = [np.full((4, 6, 3), k, dtype=np.uint8) for k in range(5)]
    write_mp4(tmp_path / "a.mp4", pictures, 15)
    assert json.loads((tmp_path / "a.mp4").read_text()) == 4 * 6 * 3 * 5
    assert "-s 6x4 -r 15" in (tmp_path / "a.mp4.words").read_text()


@pytest.mark.parametrize(("words", "told"), [
    (("-o", "drop.avi"), "ends in .gif or .mp4 or .mcap"),
    (("-o", "drop.gif", "--drop", "-1"), "the number of a drop"),
    (("-o", "drop.gif", "--restitution", "1"), "a coefficient of restitution"),
])
def test_what_cannot_be_is_refused(block, tmp_path, capsys, monkeypatch, words, told):
    monkeypatch.chdir(tmp_path)
    status, said, error = run(capsys, "animate", block, "--unit", "mm", *words)
    (line,) = complaints(error)
    assert (status, said) == (2, "")
    assert told in line
    assert [file.name for file in tmp_path.iterdir()] == ["block.stl"]
