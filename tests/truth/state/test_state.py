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

"""The state file loses nothing that was committed, and shows nothing that was not."""

import os
import random
import shutil
import sqlite3
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings, strategies

from ros_pose_stats.base.errors import RequestError
from ros_pose_stats.core.plates import PlateProfile, read_profiles, write_profile
from ros_pose_stats.node.state import Change, State, StateInUseError

NAMES = "abc"
KINDS = dict.fromkeys(("PartMesh", "PoseStatistics", "JobEvent"), "float64 x")
LARGE = bytes(range(256)) * 1000


@pytest.fixture
def file(tmp_path):
    return tmp_path / "node" / "pose_stats.sqlite3"


@pytest.fixture
def opened(file):
    """Opens states, and closes them."""
    states = []

    def open_state(path=file, **options):
        states.append(State(path, **options))
        return states[-1]

    yield open_state
    for state in states:
        state.close()


def fact(name, value):
    return Change("facts", name, None if value is None else (name, value))


def facts(state):
    return {name: value for name, value in state.rows("facts") if name in NAMES}


def part(part_id="clamp"):
    return Change(
        "parts", part_id, (part_id, "ab" * 32, b"\0" * 32, -0.0, 0.1, 1000, 1)
    )


def image(file, folder, cut):
    """The files as a power cut leaves them: the newest bytes of the log are missing."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    shutil.copy(file, folder)
    log = Path(f"{file}-wal").read_bytes()
    (folder / f"{file.name}-wal").write_bytes(log[: len(log) - min(cut, len(log))])
    return folder / file.name


CHANGES = strategies.lists(
    strategies.tuples(
        strategies.sampled_from(NAMES),
        strategies.one_of(strategies.none(), strategies.text(max_size=3)),
    ),
    min_size=1,
    max_size=3,
)
STEPS = strategies.lists(
    strategies.tuples(CHANGES, strategies.booleans()), min_size=1, max_size=8
)


@settings(
    max_examples=40,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(
    steps=STEPS,
    cut=strategies.one_of(strategies.just(0), strategies.integers(1, 20_000)),
)
def test_what_a_kill_or_a_power_cut_leaves_is_what_had_come_up_to_a_moment(
    tmp_path, steps, cut
):
    """All that was committed where the process was killed; changes of one call stay
    together.
    """
    shutil.rmtree(tmp_path / "node", ignore_errors=True)
    state = State(tmp_path / "node" / "one.sqlite3")
    moments = [{}]
    committed = 0
    for changes, waits in steps:
        number = state.put(*(fact(name, value) for name, value in changes))
        contents = dict(moments[-1])
        for name, value in changes:
            contents[name] = value
        moments.append(
            {name: value for name, value in contents.items() if value is not None}
        )
        if waits:
            assert state.commit(number)
            committed = len(moments) - 1
    with state.in_use:  # between two transactions
        image_file = image(state.file, tmp_path / "image", cut)
    remnant = State(image_file)
    assert facts(remnant) in (moments if cut else moments[committed:])
    assert remnant.set_aside == ""
    remnant.close()
    assert state.close()
    reopened = State(state.file)
    assert facts(reopened) == moments[-1]
    reopened.close()


def test_many_that_wait_share_transactions(opened):
    state = opened()
    begun = threading.Barrier(16)
    writes = state.writes

    def work(number):
        begun.wait()
        for step in range(5):
            assert state.commit(state.put(fact(f"{number}", f"{step}")))

    with ThreadPoolExecutor(16) as pool:
        list(pool.map(work, range(16)))
    assert {state.get("facts", f"{number}")[1] for number in range(16)} == {"4"}
    assert state.writes - writes < 80


def damaged(content, random_):
    """A file with a bit that is another one, or without its end."""
    if random_.random() < 0.3:
        return content[: random_.randrange(len(content))]
    offset = random_.randrange(len(content))
    changed = bytearray(content)
    changed[offset] ^= 1 << random_.randrange(8)
    return bytes(changed)


def test_a_damaged_file_is_set_aside_or_says_what_was_written(file, opened):
    state = opened()
    state.put(part(), *(fact(name, "x" * 500) for name in NAMES))
    state.put_mesh("clamp", b"mesh" * 1000)
    state.close()
    good = file.read_bytes()
    random_ = random.Random(1)
    set_aside = 0
    for _ in range(200):
        shutil.rmtree(file.parent)
        file.parent.mkdir()
        file.write_bytes(damaged(good, random_))
        try:
            reopened = State(file)
        except RequestError:  # of a version that does not exist
            continue
        if reopened.set_aside:
            set_aside += 1
            assert (
                reopened.rows("parts") == []
                and (file.parent / reopened.set_aside).is_file()
            )
        else:
            assert reopened.rows("parts") == [part().row]
            assert reopened.mesh("clamp") == b"mesh" * 1000
            assert facts(reopened) == dict.fromkeys(NAMES, "x" * 500)
        assert reopened.commit(reopened.put(fact("a", "new")))
        reopened.close()
    assert set_aside > 40


def test_no_file_at_all_is_set_aside(file, opened):
    file.parent.mkdir()
    file.write_text("notes of mine")
    lines = []
    state = opened(say=lines.append)
    assert (file.parent / state.set_aside).read_text() == "notes of mine"
    assert state.set_aside in lines[0] and state.commit(state.put(part()))


def test_a_living_owner_is_named_and_a_dead_one_is_not_waited_for(file, opened):
    first = opened()
    with pytest.raises(StateInUseError, match=f"process {os.getpid()} has in use"):
        State(file, patience=0.0)
    first.close()
    Path(f"{file}.lock").write_text("1\n")  # a process that died left its name
    assert opened().commit()


def test_an_older_file_gets_the_tables_that_are_new(file, opened):
    old_state = opened()
    old_state.put(fact("a", "1"))
    old_state.close()
    with sqlite3.connect(file) as link:
        link.executescript("DROP TABLE flips; PRAGMA user_version=1;")
    new_state = opened()
    assert facts(new_state) == {"a": "1"} and not new_state.set_aside
    assert new_state.commit(new_state.put(Change("flips", "clamp", ("clamp", 7, "{}"))))
    assert new_state.rows("flips") == [("clamp", 7, "{}")]


def test_newer_and_foreign_files_are_left_alone(file, opened):
    opened().close()
    with sqlite3.connect(file) as link:
        link.execute("PRAGMA user_version=7")
    with pytest.raises(RequestError, match="version 7, of a newer"):
        State(file)
    foreign_file = file.with_name("other.sqlite3")
    with sqlite3.connect(foreign_file) as link:
        link.execute("CREATE TABLE songs (name TEXT)")
    content = foreign_file.read_bytes()
    with pytest.raises(RequestError, match="another program"):
        State(foreign_file)
    assert foreign_file.read_bytes() == content


def test_messages_of_other_definitions_are_written_anew(file, opened):
    state = opened(definitions=KINDS)
    state.put(
        part(),
        Change("results", "clamp", ("clamp", b"old", b"", 7)),
        Change("jobs", "1", ("1", 3, b"event", b"old")),
        Change("jobs", "2", ("2", 3, b"event", b"unreadable")),
    )
    state.close()
    newer = {**KINDS, "PoseStatistics": "float64 y"}
    converted = []

    def convert(kind, definition, data):
        converted.append((kind, definition))
        return None if data == b"unreadable" else b"new"

    for _ in range(2):  # the second time there is nothing to be done
        state = opened(definitions=newer, convert=convert)
        assert state.rows("results") == [("clamp", b"new", b"", 7)]
        assert state.rows("jobs") == [("1", 3, b"event", b"new")]
        state.close()
    assert converted == [("PoseStatistics", "float64 x")] * 3


def test_a_file_that_is_deleted_under_the_node_is_made_anew(file, opened):
    lines = []
    state = opened(say=lines.append)
    assert state.commit(state.put(part(), fact("a", "before")))
    shutil.rmtree(file.parent)
    assert state.commit(state.put(fact("b", "after")))
    assert "is made anew" in lines[0]
    state.close()
    reopened = opened()
    assert facts(reopened) == {"a": "before", "b": "after"} and reopened.rows(
        "parts"
    ) == [part().row]


def test_a_place_that_cannot_be_written_is_said_and_tried_again(file, opened):
    file.parent.write_text("in the way")
    lines = []
    state = opened(say=lines.append)
    assert not state.commit(state.put(part())) and str(file) in state.problem
    assert state.put_mesh("clamp", LARGE) and state.mesh("clamp") == LARGE
    assert state.get("parts", "clamp") == part().row
    file.parent.unlink()
    assert state.commit() and state.problem == ""
    assert lines[0].startswith("NOT_RECORDED: cannot write the state file")
    assert "is written again" in lines[-1]
    state.close()
    reopened = opened()
    assert reopened.rows("parts") == [part().row] and reopened.mesh("clamp") == LARGE


def test_large_meshes_lie_beside_the_file_as_long_as_a_part_has_them(file, opened):
    state = opened()
    for name, mesh in (("one", LARGE), ("two", LARGE), ("small", b"mesh")):
        state.put_mesh(name, mesh)
    state.put(Change("meshes", "one", None))
    assert state.commit() and len(list(state.meshes.folder.iterdir())) == 1
    assert (state.mesh("one"), state.mesh("two"), state.mesh("small")) == (
        None,
        LARGE,
        b"mesh",
    )
    (stored,) = state.meshes.folder.iterdir()
    stored.write_bytes(LARGE[:-1] + b"?")
    assert state.mesh("two") is None  # rather than another mesh
    state.put_mesh("two", b"mesh")
    assert state.commit() and list(state.meshes.folder.iterdir()) == []


def change_in_index(file, table, found, changed):
    """Have bytes of an index's first page be others."""
    link = sqlite3.connect(file)
    (page,), (size,) = (
        link.execute(text).fetchone()
        for text in (
            "SELECT rootpage FROM sqlite_master "
            f"WHERE name='sqlite_autoindex_{table}_1'",
            "PRAGMA page_size",
        )
    )
    link.close()
    data = bytearray(file.read_bytes())
    offset = data.index(found, (page - 1) * size, page * size)
    data[offset : offset + len(found)] = changed
    file.write_bytes(data)


def test_an_index_that_leads_nowhere_is_damage(file, opened):
    """By it a row that is there would not be found, and another one put beside it."""
    state = opened()
    assert state.commit(
        state.put(*(fact(f"name {number:02d}", "") for number in range(20)))
    )
    state.close()
    change_in_index(file, "facts", b"name 07", b"name 17")
    assert opened().set_aside


def test_an_index_that_leads_elsewhere_gives_no_other_row(file, opened):
    """That of counted messages is too large to be looked through in a start."""
    state = opened()
    keys = [b"%024d" % number for number in range(0, 40, 2)]
    assert state.commit(state.put(*(Change("counted", key, (key,)) for key in keys)))
    state.close()
    other_key = b"%024d" % 15
    change_in_index(file, "counted", keys[7], other_key)
    state = opened()
    assert not state.set_aside
    assert state.get("counted", other_key) is None
    assert state.get("counted", keys[8]) == (keys[8],)


@pytest.mark.parametrize(
    ("part", "damage"), [("part_id", "part_ie"), ("series INTEGER", "series INTEGES")]
)
def test_columns_that_are_others_are_damage(file, opened, part, damage):
    """No row would be found by a column that has another name."""
    state = opened()
    assert state.commit(state.put(Change("flips", "clamp", ("clamp", 7, "{}"))))
    state.close()
    file.write_bytes(file.read_bytes().replace(part.encode(), damage.encode()))
    assert opened().set_aside


def test_a_mesh_and_its_part_come_together(file, opened, tmp_path):
    """Whatever a power cut leaves of the log."""
    state = opened()
    for number in range(3):
        name = f"clamp {number}"
        assert state.commit(state.put_mesh(name, name.encode(), part(name)))
    meshes = set()
    for cut in range(0, 40_000, 1500):
        image_state = opened(image(file, tmp_path / "left", cut))
        names = [row[0] for row in image_state.rows("parts")]
        assert [row[0] for row in image_state.rows("meshes")] == names
        meshes.add(len(names))
        image_state.close()
    assert meshes == {0, 1, 2, 3}


def test_two_writers_of_a_file_of_plates_lose_none(tmp_path):
    def write(name):
        write_profile(
            tmp_path / "plates.yaml",
            PlateProfile(
                name,
                *[0.5] * 3,
                *[0.1] * 3,
                0.01,
                0.5,
                ("clamp",),
                100,
                "2026-11-25",
                "1",
            ),
        )

    names = [f"plate {number}" for number in range(12)]
    with ThreadPoolExecutor(2) as pool:
        list(pool.map(write, names))
    assert sorted(read_profiles(tmp_path / "plates.yaml")) == sorted(names)
