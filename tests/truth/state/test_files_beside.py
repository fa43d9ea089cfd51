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

"""A state touches nothing but its own files, and no two nodes have one file."""

import hashlib
import os
import shutil
import sqlite3
from pathlib import Path

import pytest

from ros_pose_stats.base.errors import RequestError
from ros_pose_stats.node.state import Change, State, StateInUseError

MESHES = [bytes([number]) * 2**17 for number in range(4)]
DIGESTS = [hashlib.sha256(mesh).hexdigest() for mesh in MESHES]


@pytest.fixture
def file(tmp_path):
    return tmp_path / "cell.sqlite3"


@pytest.fixture
def opened(file):
    """Opens states, and closes them."""
    states = []

    def open_state(path=file, **options):
        states.append(State(path, patience=0.0, **options))
        return states[-1]

    yield open_state
    for state in states:
        state.close()


def folder_of(file):
    return file.with_name(f"{file.name}.meshes")


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


def picture(*paths):
    """What a change would show in: content, age and identity of files and links."""
    return {
        path: (
            path.readlink() if path.is_symlink() else path.read_bytes(),
            path.lstat().st_mtime_ns,
            path.lstat().st_ino,
        )
        for path in paths
    }


def put_stored(state, part_id, mesh):
    assert state.commit(state.put_mesh(part_id, mesh))


def lives(file):
    """Parts that come, change and go, a start after it, and a file cut to half."""
    for number in range(2):
        state = State(file)
        for mesh in MESHES:
            put_stored(state, "one", mesh)
        put_stored(state, f"part {number}", MESHES[number])
        state.put(Change("meshes", "one", None))
        state.close()
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    state = State(file)
    assert state.set_aside
    state.close()


def test_files_of_others_stay_as_they_are(file):
    """Also of names as the state's own, in its folder, in the older one and beside."""
    others = []
    for folder in (folder_of(file), file.with_name("cell.meshes")):
        folder.mkdir()
        names = "bracket.stl", "0" * 64, hashlib.sha256(b"theirs").hexdigest()
        for path in (folder / name for name in (*names, f"{DIGESTS[0]}.half")):
            path.write_bytes(b"theirs")
            others.append(path)
        (folder / ("1" * 64)).symlink_to(folder / names[0])
        others.append(folder / ("1" * 64))
    for end in (".half", ".lock", ".meshes.zip"):
        path = Path(f"{file}{end}")
        path.write_text("theirs")
        others.append(path)
    before = picture(*others)
    lives(file)
    assert picture(*others) == before


def test_a_file_of_others_under_the_name_of_a_mesh_stays_and_the_mesh_is_kept(
    file, opened
):
    folder_of(file).mkdir()
    other = folder_of(file) / DIGESTS[0]
    other.write_bytes(b"theirs")
    state = opened()
    put_stored(state, "one", MESHES[0])
    assert state.mesh("one") == MESHES[0]
    put_stored(state, "one", MESHES[1])
    assert other.read_bytes() == b"theirs"


def test_a_mesh_that_others_put_there_is_used_and_stays(file, opened):
    folder_of(file).mkdir()
    other = folder_of(file) / DIGESTS[0]
    other.write_bytes(MESHES[0])
    before = picture(other)
    state = opened()
    put_stored(state, "one", MESHES[0])
    put_stored(state, "one", b"small")
    assert picture(other) == before


def test_a_damaged_mesh_that_comes_again_is_written_anew(file, opened):
    state = opened()
    put_stored(state, "one", MESHES[0])
    (folder_of(file) / DIGESTS[0]).write_bytes(b"damage")
    assert state.mesh("one") is None
    put_stored(state, "one", MESHES[0])
    assert state.mesh("one") == MESHES[0]


@pytest.mark.parametrize("length", [0, 1000, 2**17])
def test_what_a_kill_leaves_of_a_mesh_goes_at_the_next_start(file, opened, length):
    """The mesh is in its file, or half of it is, and its part was not acknowledged."""
    state = opened()
    put_stored(state, "one", MESHES[0])
    state.put_mesh("two", MESHES[1])
    image = file.parent / "image"
    shutil.copytree(folder_of(file), folder_of(image / file.name))
    for end in ("", "-wal"):
        shutil.copy(f"{file}{end}", image)
    os.truncate(folder_of(image / file.name) / DIGESTS[1], length)
    state = opened(image / file.name)
    assert names_in(folder_of(image / file.name)) == DIGESTS[:1]
    assert (state.mesh("one"), state.mesh("two")) == (MESHES[0], None)


def test_two_states_of_like_names_share_nothing(file, opened):
    states = [opened(), opened(file.with_suffix(".db"))]
    for state in states:
        put_stored(state, "one", MESHES[0])
    put_stored(states[0], "one", MESHES[1])
    states[0].close()
    opened()
    assert states[1].mesh("one") == MESHES[0]


def test_a_symbolic_link_is_the_file_that_it_leads_to(file, opened, tmp_path):
    link = tmp_path / "elsewhere" / "other name.db"
    link.parent.mkdir()
    link.symlink_to(file)
    state = opened(link)  # of a file that is made by that
    put_stored(state, "one", MESHES[0])
    for name in (file, link):
        with pytest.raises(StateInUseError, match=f"process {os.getpid()} has in use"):
            opened(name)
    state.close()
    assert opened().mesh("one") == MESHES[0]
    assert names_in(link.parent) == [link.name]


def test_a_file_of_two_names_is_refused_under_both(file, opened):
    state = opened()
    put_stored(state, "one", MESHES[0])
    other_name = file.with_name("other.sqlite3")
    os.link(file, other_name)
    for name in (other_name, file):
        with pytest.raises((RequestError, StateInUseError)) as refusal:
            opened(name)
        assert "\n" not in str(refusal.value)
    state.close()
    with pytest.raises(RequestError, match="2 names \\(hard links\\)"):
        opened()
    other_name.unlink()
    assert opened().mesh("one") == MESHES[0]


def test_a_link_as_lock_is_refused_and_what_it_leads_to_stays(file, opened, tmp_path):
    notes = tmp_path / "notes"
    notes.write_text("")
    Path(f"{file}.lock").symlink_to(notes)
    with pytest.raises(RequestError, match="a symbolic link; remove it"):
        opened()
    assert notes.read_text() == ""


def test_meshes_behind_a_linked_folder_are_read_and_stay(file, opened, tmp_path):
    """Two states may have been linked to one folder."""
    state = opened()
    put_stored(state, "one", MESHES[0])
    state.close()
    folder_of(file).rename(tmp_path / "disk")
    folder_of(file).symlink_to(tmp_path / "disk")
    state = opened()
    put_stored(state, "two", MESHES[1])
    assert (state.mesh("one"), state.mesh("two")) == (MESHES[0], MESHES[1])
    put_stored(state, "one", MESHES[2])
    state.close()
    assert opened().mesh("one") == MESHES[2]
    assert names_in(tmp_path / "disk") == DIGESTS[:1]


def test_a_copy_from_another_machine_is_a_state_of_its_own(file, opened, tmp_path):
    state = opened()
    put_stored(state, "one", MESHES[0])
    state.close()
    copy = tmp_path / "here" / "line 2.sqlite3"
    shutil.copytree(folder_of(file), folder_of(copy))
    shutil.copy(file, copy)
    (folder_of(copy) / DIGESTS[3]).write_bytes(MESHES[3])  # of the state before it
    copied_state = opened(copy)
    assert copied_state.mesh("one") == MESHES[0]
    put_stored(copied_state, "one", MESHES[1])
    assert names_in(folder_of(copy)) == sorted([DIGESTS[1], DIGESTS[3]])
    assert opened().mesh("one") == MESHES[0]


def state_of_0_2(file, **options):
    """Make a state as version 0.2.0 left it, with two meshes; its folder."""
    state = State(file, **options)
    for number in (0, 1):
        put_stored(state, f"part {number}", MESHES[number])
    state.close()
    with sqlite3.connect(file) as link:
        link.executescript("DROP TABLE files; PRAGMA user_version=3;")
    return folder_of(file).rename(file.with_name(f"{file.stem}.meshes"))


def test_meshes_of_an_older_state_are_copied_and_stay(file, opened):
    older_folder = state_of_0_2(file)
    (older_folder / DIGESTS[1]).write_bytes(b"damage")
    older_files = [older_folder / DIGESTS[number] for number in (0, 1)]
    before = picture(*older_files)
    lines = []
    state = opened(say=lines.append)
    (line,) = lines
    assert "1 meshes" in line and str(older_folder) in line and "deleted" in line
    assert state.mesh("part 0") == MESHES[0] and state.mesh("part 1") is None
    assert names_in(folder_of(file)) == DIGESTS[:1]
    put_stored(state, "part 0", MESHES[2])
    assert names_in(folder_of(file)) == [DIGESTS[2]]
    state.close()
    opened(say=lines.append)
    assert lines == [line] and picture(*older_files) == before


def test_meshes_of_older_definitions_are_converted_and_stay(file, opened):
    """Those of 0.2.0 lack fields that today's have; a broken one is as none."""
    kinds = dict.fromkeys(("PartMesh", "PoseStatistics", "JobEvent"), "float64 x")
    older_folder = state_of_0_2(file, definitions=kinds)
    older_files = [older_folder / DIGESTS[number] for number in (0, 1)]
    before = picture(*older_files)
    lines = []

    def convert(kind, definition, data):
        assert (kind, definition) == ("PartMesh", "float64 x")
        return None if data == MESHES[1] else data + b"body"

    for _ in range(2):  # the second time there is nothing to be done
        state = opened(
            definitions={**kinds, "PartMesh": "x y"}, convert=convert, say=lines.append
        )
        assert state.mesh("part 0") == MESHES[0] + b"body"
        assert state.mesh("part 1") is None
        state.close()
    assert picture(*older_files) == before and len(lines) == 1
    state = opened(definitions={**kinds, "PartMesh": "z"}, convert=lambda *_: MESHES[3])
    assert state.mesh("part 0") == MESHES[3]
    assert names_in(folder_of(file)) == [DIGESTS[3]]


def test_meshes_that_cannot_be_copied_are_read_where_they_are(file, opened):
    state_of_0_2(file)
    folder_of(file).write_text("in the way")
    state = opened()
    assert state.mesh("part 1") == MESHES[1]
    state.close()
    folder_of(file).unlink()
    assert opened().mesh("part 1") == MESHES[1]
    assert names_in(folder_of(file)) == sorted(DIGESTS[:2])


def test_a_state_of_0_2_behind_a_link_finds_its_meshes(file, opened, tmp_path):
    """They lie beside the link."""
    link = tmp_path / "names" / "line.sqlite3"
    link.parent.mkdir()
    state_of_0_2(file).rename(link.with_name("line.meshes"))
    link.symlink_to(file)
    assert opened(link).mesh("part 0") == MESHES[0]


def test_a_database_of_another_program_with_tables_of_such_names_stays(file, opened):
    with sqlite3.connect(file) as link:
        link.executescript("CREATE TABLE jobs (name TEXT); CREATE TABLE files (n INT);")
    before = picture(file)
    with pytest.raises(RequestError, match="another program"):
        opened()
    assert picture(file) == before
