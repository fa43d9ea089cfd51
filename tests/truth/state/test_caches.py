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

"""What is kept in the user's cache: bounded, and of nobody else."""

import os
import shutil
from pathlib import Path

import pytest

from ros_pose_stats.base.caches import BoundedCache
from ros_pose_stats.base.files import PREFIX

NOBODY = 65534


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """A cache for three files of a hundred bytes, and its folder."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    for name in ("XDG_CACHE_HOME", "HOME"):  # where it would look then
        monkeypatch.setenv(name, os.devnull)
    return BoundedCache("meshes", 400), tmp_path / "cache" / "ros_pose_stats" / "meshes"


def test_what_was_not_used_for_longest_goes(cache):
    meshes, folder = cache
    for number, key in enumerate("abc"):
        meshes.keep(key, 90 * key.encode())
        os.utime(folder / key, (number, number))
    assert meshes.find("a") == 90 * b"a"
    meshes.keep("d", 90 * b"d")
    assert sorted(file.name for file in folder.iterdir()) == ["a", "c", "d"]
    meshes.keep("e", 500 * b"e")
    assert meshes.find("e") is None and meshes.find("d") is not None


def test_what_killed_writers_leave_goes_and_what_is_being_written_stays(cache):
    meshes, folder = cache
    meshes.keep("a", b"content")
    for name in ("killed", "writing"):
        unfinished = folder / f"{PREFIX}{name}"
        unfinished.mkdir()
        (unfinished / "b").write_bytes(100 * b"b")
    os.utime(folder / f"{PREFIX}killed", (0, 0))
    meshes.keep("c", b"content")
    assert {file.name for file in folder.iterdir()} == {"a", "c", f"{PREFIX}writing"}


def test_damaged_files_are_not_used(cache):
    meshes, folder = cache
    meshes.keep("a", b"content")
    for content in (b"", (folder / "a").read_bytes()[:-1] + b"?"):
        (folder / "a").write_bytes(content)
        assert meshes.find("a") is None


def test_a_file_under_the_name_of_another_is_not_used(cache):
    """As after a careless copy: it would be the mesh of another part."""
    meshes, folder = cache
    meshes.keep("a", b"content")
    (folder / "b").write_bytes((folder / "a").read_bytes())
    assert meshes.find("b") is None and meshes.find("a") == b"content"


@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir, Path.touch])
def test_what_else_lies_in_its_place_costs_only_the_cache(cache, make):
    meshes, folder = cache
    for place in (folder.parent.parent, folder.parent, folder, folder / "a"):
        place.parent.mkdir(parents=True, exist_ok=True)
        make(place)
        meshes.keep("a", b"content")
        assert meshes.find("a") in (None, b"content")
        if place.is_dir():
            shutil.rmtree(place)
        else:
            place.unlink()


def test_links_are_not_followed(cache, tmp_path):
    meshes, folder = cache
    meshes.keep("a", b"content")
    (folder / "a").rename(tmp_path / "a")
    (folder / "a").symlink_to(tmp_path / "a")
    assert meshes.find("a") is None
    (folder / "a").unlink()
    (tmp_path / "a").rename(folder / "a")
    assert meshes.find("a") == b"content"
    folder.rename(tmp_path / "elsewhere")
    folder.symlink_to(tmp_path / "elsewhere")
    assert meshes.find("a") is None


def test_nobody_else_may_write_there(cache):
    meshes, folder = cache
    meshes.keep("a", b"content")
    for path in (folder, folder.parent):
        path.chmod(0o777)
    assert meshes.find("a") == b"content"
    assert folder.stat().st_mode & 0o22 == 0
    (folder / "a").chmod(0o622)
    assert meshes.find("a") is None


@pytest.mark.skipif(os.getuid() != 0, reason="only root gives files away")
@pytest.mark.parametrize("name", [".", "a", "..", "../..", "../../.."])
def test_what_another_user_owns_is_not_used(cache, name):
    """Nor what lies in a folder of that user, where it may have been put."""
    meshes, folder = cache
    meshes.keep("a", b"content")
    os.chown(folder / name, NOBODY, NOBODY)
    assert meshes.find("a") is None


@pytest.mark.parametrize(
    ("mode", "content"), [(0o777, None), (0o775, None), (0o1777, b"content")]
)
def test_a_folder_on_the_way_where_others_may_rename_is_not_passed(
    cache, mode, content
):
    """Where the sticky bit is set, as in /tmp, they may not."""
    meshes, folder = cache
    meshes.keep("a", b"content")
    folder.parent.parent.chmod(mode)
    assert meshes.find("a") == content


@pytest.mark.skipif(os.getuid() != 0, reason="only root gives files away")
def test_a_link_of_another_user_is_not_followed_on_the_way(
    cache, tmp_path, monkeypatch
):
    meshes, _ = cache
    meshes.keep("a", b"content")
    link = tmp_path / "link"
    link.symlink_to(tmp_path / "cache")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(link))
    assert meshes.find("a") == b"content"
    os.chown(link, NOBODY, NOBODY, follow_symlinks=False)
    assert meshes.find("a") is None
