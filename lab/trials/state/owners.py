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

"""State files of other versions and programs, in somebody's hands, and on a disk to
read only.
"""

import fcntl
import json
import shutil
import sqlite3
import subprocess
import time
from contextlib import ExitStack

from ros_pose_stats.node.state.tables import sealed
from tests.contract.node.harness.node import NodeProcess
from tests.contract.node.harness.parts import fine_box, flat, library_part

from ..cell import cell_of, domain
from ..frame import Outcome, Setting
from .kills import small_disk, sound
from .ledger import BOXES
from .original import NAME, killed_state, numbers_of


def other_versions(setting: Setting) -> Outcome:
    """A state file of a newer version, of older messages, and of another program."""
    original = killed_state()
    broken = []

    def changed(*statements):
        file = original.copy(setting.folder / "copy")
        link = sqlite3.connect(file)
        with link:
            for statement, *values in statements:
                link.execute(statement, *values)
        link.close()
        return file

    broken += _refused(changed(("PRAGMA user_version=99",)), "newer")
    foreign = setting.folder / "foreign.sqlite3"
    link = sqlite3.connect(foreign)
    link.execute("CREATE TABLE shopping (what TEXT)")
    link.close()
    data_before = foreign.read_bytes()
    broken += _refused(foreign, "another program")
    if foreign.read_bytes() != data_before:
        broken.append("the file of another program was changed")
    link = sqlite3.connect(original.copy(setting.folder / "copy"))
    ((name, text),) = link.execute(
        "SELECT name, value FROM facts WHERE name='definitions'"
    )
    link.close()
    numbers_before = {
        kind: f"# as it once was\n{definition}"
        for kind, definition in json.loads(text).items()
    }
    row = sealed((name, json.dumps(numbers_before)))
    older = changed(
        ("UPDATE facts SET value=?, checksum=? WHERE name='definitions'", row[1:])
    )
    broken += original.start(setting.folder, older, whole=True)[0]
    link = sqlite3.connect(older)
    ((converted,),) = link.execute("SELECT value FROM facts WHERE name='definitions'")
    link.close()
    if json.loads(converted) != json.loads(text):
        broken.append("messages of older definitions were not brought up to date")
    return Outcome(
        3,
        broken,
        "a newer one refused, older messages converted, another program's "
        "file left alone",
    )


def _refused(file, word):
    """How a start fails on a file; it must with status 2 and one line."""
    with NodeProcess(
        file.with_name("bags"), "-r", "__ns:=/damaged", state_file=file
    ) as node:
        status = node.ended()
        log = [line for line in node.lines if line != "(end)"]
    good = status == 2 and len(log) == 1 and word in log[0]
    return (
        []
        if good
        else [f"status {status} on a file that should be refused ({word}): {log}"]
    )


def names_alike(setting: Setting) -> Outcome:
    """Nodes whose states have names that differ in the ending alone, and one state
    under two names.
    """
    folder = setting.folder
    states = {name: folder / f"cell.{name}" for name in ("sqlite3", "db")}
    surfaces = dict(zip(states, (fine_box(6000), fine_box(8000)), strict=True))

    def begin(stack):
        """Start both nodes; a client of each."""
        clients = {}
        for name, file in states.items():
            cell = cell_of(domain(), folder / "bags", name, state_file=file)
            _, clients[name] = stack.enter_context(cell)
        return clients

    with ExitStack() as stack:
        for name, client in begin(stack).items():
            client.good("estimate", part=flat(surfaces[name], "part"))
    broken = []
    with ExitStack() as stack:
        for name, client in begin(stack).items():
            answer = client.call("estimate", part_id="part", restitution=0.3)
            digest = library_part(surfaces[name]).digest
            if not answer.success or answer.statistics.part_digest != digest:
                broken.append(f"the part of cell.{name} is lost: {answer.message}")
        link = folder / "linked.sqlite3"
        link.symlink_to(states["sqlite3"])
        broken += _refused(link, "has in use")
    link.unlink()
    link.hardlink_to(states["sqlite3"])
    broken += _refused(link, "hard links")
    return Outcome(
        4, broken, "each keeps its part; a second name is refused with what to do"
    )


def files_in_use(setting: Setting) -> Outcome:
    """Locked by a living node, by the lock of a dead process, and by another
    program's.
    """
    original = killed_state()
    broken = []
    file = original.copy(setting.folder / "copy")
    with original.cell(setting.folder / "bags", file) as (node, _):
        begin = time.monotonic()
        broken += _refused(file, f"process {node.process.pid}")
        seconds = time.monotonic() - begin
        node.kill()
    broken += original.start(setting.folder, file, whole=True)[0]
    lock = file.with_name(f"{NAME}.lock")
    lock.write_text("1\n", "utf-8")  # a process that lives, and has no lock
    broken += original.start(setting.folder, file, whole=True)[0]
    file = original.copy(setting.folder / "copy")
    link = sqlite3.connect(file, isolation_level=None)
    link.execute("BEGIN EXCLUSIVE")  # somebody looks into the file with a tool
    with original.cell(setting.folder / "bags", file) as (node, client):
        answer = client.call(
            "estimate", part=flat(BOXES[3], "later"), method="csae"
        ).statistics
        recorded = not any(
            warning.code == "NOT_RECORDED" for warning in answer.warnings
        )
        node.assert_sound()
    link.close()
    if recorded:
        broken.append(
            "an answer was told as recorded while another program had the file"
        )
    with lock.open("r+") as lock_file:
        fcntl.flock(lock_file, fcntl.LOCK_EX)
        broken += _refused(file, "process")
    return Outcome(
        5,
        broken,
        f"refused in {seconds:.1f} s with the other's number; a dead "
        "process's lock is no lock",
    )


def a_disk_to_read_only(setting: Setting) -> Outcome:
    """A state file on a disk that can only be read: all is there, and answers say
    so.
    """
    original = killed_state()
    broken = []
    with small_disk(setting.folder / "disk", 64) as problem:
        if problem:
            return Outcome(
                0, [f"not tried, since nothing can be mounted here: {problem}"]
            )
        for ended in ("well", "by a kill"):
            file = original.copy(setting.folder / "copy")
            if ended == "well":
                original.start(setting.folder, file)
            disk = setting.folder / "disk" / ended.replace(" ", "_")
            shutil.copytree(file.parent, disk)
            subprocess.run(
                ["mount", "-o", "remount,ro", setting.folder / "disk"], check=True
            )
            with original.cell(setting.folder / "bags", disk / NAME) as (node, client):
                answer = client.good(
                    "estimate", part=flat(BOXES[3], "later"), method="csae"
                )
                if not any(
                    warning.code == "NOT_RECORDED"
                    for warning in answer.statistics.warnings
                ):
                    broken.append(f"{ended}: an answer was told as recorded")
                shown = numbers_of(client)
                shown.pop("later", None)
                node.stop()
                broken += sound(node)
            strange = [
                name
                for name, numbers in shown.items()
                if original.shown.get(name) != numbers
            ]
            if strange or (ended == "well" and shown != original.shown):
                broken.append(
                    f"{ended}: {sorted(shown)} shown, {strange} unlike before"
                )
            subprocess.run(
                ["mount", "-o", "remount,rw", setting.folder / "disk"], check=True
            )
    return Outcome(2, broken, f"{len(shown)} parts shown after a kill")
