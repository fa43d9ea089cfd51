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

"""What a catalogue refuses, and that it leaves files as they were."""

import os
import sys

import pytest

from tests.running import call, refusal

from .parts import ASKED


@pytest.mark.parametrize("name", ["index.html", "catalogue.parquet"])
def test_a_file_of_somebody_else_is_kept(home, tmp_path, name):
    (tmp_path / name).write_text("mine")
    assert "files without a readable request.json" in refusal(*ASKED, "-o", tmp_path)
    assert (tmp_path / name).read_text() == "mine"


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--target-error", "1"), "target error"),
        (("--density", "0"), "density"),
        (("--workers", "0"), "workers"),
        (("--workers", "1025"), "workers"),
        (("--restitution", "1"), "restitution"),
        (("--round-sides", "3"), "sides"),
    ],
)
def test_values_out_of_range_are_refused(home, tmp_path, options, words):
    assert words in refusal(
        "catalogue", home / "parts", "-o", tmp_path / "out", *options
    )
    assert not (tmp_path / "out").exists()


def test_a_package_that_is_missing_is_named(home, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    line = refusal(*ASKED, "-o", tmp_path / "out", "--parquet")
    assert "the module pyarrow" in line
    assert "pip install 'ros_pose_stats[parquet]'" in line
    assert not (tmp_path / "out").exists()


def test_a_scheduler_that_is_none_leaves_the_folder_to_others(home, tmp_path):
    pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
    request = "catalogue", home / "parts" / "box.stl", "-o", tmp_path / "out"
    assert "a scheduler that answers" in refusal(*request, "--scheduler", "nowhere://")
    assert not (tmp_path / "out").exists()


def test_no_parts_are_refused(tmp_path):
    (tmp_path / "notes.txt").touch()
    assert "none in" in refusal("catalogue", tmp_path, "-o", tmp_path / "out")
    assert "no file" in refusal(
        "catalogue", tmp_path / "\x1bgone", "-o", tmp_path / "out"
    )
    assert [file.name for file in tmp_path.iterdir()] == ["notes.txt"]


@pytest.mark.parametrize("change", ["pages", "row"])
def test_damaged_rows_are_refused_with_what_to_do(made, change):
    folder, request = made
    rows = folder / "parts.sqlite3"
    content = bytearray(rows.read_bytes())
    if change == "row":
        share = content.rfind(b'"best_share": 0.')
        content[share + len('"best_share": 0.')] ^= 1
    else:
        content[4096:] = bytes(len(content) - 4096)
    rows.write_bytes(content)
    line = refusal(*request)
    assert "the rows of an earlier run" in line and "delete it" in line


def test_a_request_nested_without_end_is_refused(made):
    folder, request = made
    (folder / "request.json").write_text("[" * 100_000)
    assert "files without a readable request.json" in refusal(*request)


def test_what_lies_under_the_name_of_a_picture_is_replaced(made, tmp_path):
    """A pipe would be written to for ever, and a link leads to a file of somebody."""
    folder, request = made
    pictures = sorted((folder / "pictures").rglob("*.png"))
    contents = [picture.read_bytes() for picture in pictures]
    piped, linked = pictures
    piped.unlink()
    os.mkfifo(piped)
    (tmp_path / "mine").touch()
    linked.unlink()
    linked.symlink_to(tmp_path / "mine")
    assert call(*request).returncode == 0
    assert [picture.read_bytes() for picture in pictures] == contents
    assert not linked.is_symlink()
    assert (tmp_path / "mine").read_bytes() == b""
