"""State files that are cut, flipped, of other versions, read-only, or in somebody's hands."""

from __future__ import annotations

import fcntl
import json
import random
import shutil
import sqlite3
import subprocess
import time

from ros_pose_stats import estimate
from ros_pose_stats.errors import PoseStatsError
from ros_pose_stats.ros.state import Change, State
from ros_pose_stats.ros.state.tables import COLUMNS, sealed
from tests.contract.node.harness import parts
from tests.contract.node.harness.camera import counted, counting, learnt
from tests.contract.node.harness.cell import cell_of
from tests.contract.node.harness.client import CANCELLED
from tests.contract.node.harness.jobs import finished, start
from tests.contract.node.harness.node import NodeProcess
from tests.contract.node.harness.parts import fine_box, flat, library_part

from ..cell import domain
from ..frame import Outcome, Setting
from .kills import small_disk, sound
from .ledger import BOXES

CUTS, FLIPS, READ_FLIPS = 20, 200, 4000
NAME = "pose_stats.sqlite3"
SURFACES = {**{f"box_{number}": surface for number, surface in enumerate(BOXES)},
            "fine": fine_box(6000)}


class Original:
    """A state with parts, counts and a job, as a killed node has left it, and what it showed."""

    def __init__(self, folder):
        self.folder = folder / "original"
        with self.cell(folder / "bags", self.folder / NAME) as (node, client):
            self.shown, self.before = {}, []
            for act in (self._send, self._drop, self._count):
                act(client)
                self.before.append(self.shown)
                time.sleep(1.5)  # all is committed by then
                self.shown = _numbers(client)
            node.kill()
        self.csae = {name: parts.probabilities(estimate(library_part(surface), "csae").poses)
                     for name, surface in SURFACES.items()}

    @staticmethod
    def _send(client):
        for name, surface in SURFACES.items():
            client.good("estimate", part=flat(surface, name), method="csae")

    def _drop(self, client):
        self.job = start(client, "box_1", 500, seed=3)
        self.done = str(finished(client, self.job).statistics)

    @staticmethod
    def _count(client):
        model = learnt(client, "box_0", 0)
        counting(client).publish(counted(model, [3, 4, 5, 6, 7, 8]))
        learnt(client, "box_0", 33)

    @staticmethod
    def cell(bags, file, **values):
        """A node on a state file."""
        return cell_of(domain(), bags, "damaged", state_file=file, workers=1, **values)

    def copy(self, folder):
        """The file, its log and its meshes once more; the file."""
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(self.folder, folder)
        return folder / NAME

    def start(self, folder, file, whole=False):
        """Start a node on a file: what is wrong with it, and how many parts it knows.

        `whole`: everything is to be there; else also what was shown earlier, since a log that is
        damaged in the middle ends there.
        """
        with self.cell(folder / "bags", file) as (node, client):
            wrong = self._wrong(client, whole)
            known = len(client.call("get_statistics").statistics)
            node.stop()
            wrong += sound(node)
        return wrong, known

    def _wrong(self, client, whole):
        shown, wrong = _numbers(client), []
        for name, numbers in shown.items():
            if numbers not in [then.get(name) for then in (self.shown, *self.before)]:
                wrong.append(f"{name} shows {numbers}, and showed {self.shown.get(name)}")
        for name in shown:
            answer = client.call("estimate", part_id=name, method="csae")
            if answer.success:
                if parts.probabilities(answer.statistics.poses) != self.csae[name]:
                    wrong.append(f"{name} is another part: {answer.statistics.part_digest}")
            elif whole or "send the part again" not in answer.message:
                wrong.append(f"{name}: {answer.message}")
        job = client.call("get_drop_simulation", job_id=self.job)
        if job.success and str(job.statistics) != self.done and (
                whole or job.state != CANCELLED or job.statistics.drops):
            wrong.append(f"the job has another result: {job.statistics}")
        if whole and not (shown == self.shown and job.success):
            wrong.append(f"{len(shown)} of {len(self.shown)} parts, job: {job.message}")
        return wrong


def _numbers(client):
    """What is shown of each part, but for its time and revision."""
    return {told.part_id: (told.part_digest, told.method, told.observed, told.drops,
                           sorted((pose.index, pose.count, pose.probability)
                                  for pose in told.poses))
            for told in client.call("get_statistics").statistics}


def _tried(setting, tries, damage):
    """Nodes on files that were damaged, each in a way of its own."""
    original, chance, broken, empty = Original(setting.folder), random.Random(setting.seed), [], 0
    for number in range(tries):
        file = original.copy(setting.folder / "copy")
        said = damage(file, chance)
        try:
            wrong, known = original.start(setting.folder, file)
        except AssertionError as error:
            wrong, known = [str(error)], 0
        broken += [f"{said} (try {number} of seed {setting.seed}): {line}" for line in wrong]
        empty += not known
    return Outcome(tries, broken, f"{empty} starts without anything, {tries - empty} with what "
                   "was sound")


def _any_file(file, chance):
    """One of the files of a state, the larger the likelier."""
    paths = [path for path in (file, file.with_name(f"{NAME}-wal"), *sorted(
        file.with_name(f"{file.stem}.meshes").glob("*"))) if path.exists()]
    return chance.choices(paths, [path.stat().st_size for path in paths])[0]


def _cut(file, chance):
    path = chance.choice((file, _any_file(file, chance)))
    data = path.read_bytes()
    left = chance.choice((0, 1, 100, chance.randrange(len(data)), len(data) - 1))
    path.write_bytes(data[:left])
    return f"{path.name} cut to {left} of {len(data)} bytes"


def _flip(file, chance):
    path = _any_file(file, chance)
    data = bytearray(path.read_bytes())
    place, bits = chance.randrange(len(data)), chance.randrange(1, 256)
    data[place] ^= bits
    path.write_bytes(data)
    return f"byte {place} of {path.name} ^ {bits}"


def cut_files(setting: Setting) -> Outcome:
    """State files cut anywhere: the node starts with what is sound, or with nothing."""
    return _tried(setting, setting.of(CUTS, 2), _cut)


def flipped_bytes(setting: Setting) -> Outcome:
    """A byte of the file, its log or its meshes changed: sound numbers, or none."""
    return _tried(setting, setting.of(FLIPS, 5), _flip)


def flipped_bytes_read(setting: Setting) -> Outcome:
    """The same, the state alone read: each row by its key as it was written, or none."""
    file = setting.folder / "original" / NAME
    chance, broken, aside, tries = random.Random(setting.seed), [], 0, setting.of(READ_FLIPS, 100)
    truth = {table: [] for table in COLUMNS}
    state = State(file)
    for number in range(40):
        name = f"part {number:02d}"
        for table, text in COLUMNS.items():
            values = [f"{table} {number}" if "TEXT" in column else number if "INTEGER" in column
                      else 0.1 * number if "REAL" in column else f"{table} {number}".encode() * 9
                      for column in text.split(",")]
            key = values[0] if isinstance(values[0], bytes) else name
            if table != "meshes":
                state.put(Change(table, key, (key, *values[1:])))
                truth[table].append((key, *values[1:]))
    state.close()
    for number in range(tries):
        copy = setting.folder / "copy"
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(file.parent, copy)
        said = _flip(copy / NAME, chance)
        try:
            state = State(copy / NAME)
        except PoseStatsError as refusal:
            if "newer" not in str(refusal) and "another program" not in str(refusal):
                broken.append(f"{said}: {refusal}")
            continue
        aside += bool(state.set_aside)
        broken += [f"{said} (try {number} of seed {setting.seed}): {line}"
                   for line in _strange_rows(state, truth)]
        state.close()
    return Outcome(tries, broken, f"{aside} set aside")


def _strange_rows(state, truth):
    """What a state gives that nobody put there, or does not give though the file was sound."""
    for table, rows in truth.items():
        try:
            strange = [] if table == "counted" else [
                row for row in state.rows(table) if row not in rows]
            found = [state.get(table, row[0]) for row in rows]
        except Exception as error:
            yield f"{table} cannot be read: {type(error).__name__}: {error}"
            continue
        others = sum(has not in (row, None) for has, row in zip(found, rows, strict=True))
        missing = 0 if state.set_aside else found.count(None)
        if strange or others or missing:
            yield (f"{table} has {len(strange)} strange rows, {others} of other keys, {missing} "
                   "not there by their keys")


def other_versions(setting: Setting) -> Outcome:
    """A state file of a newer version, of older messages, and of another program."""
    original, broken = Original(setting.folder), []

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
    before = foreign.read_bytes()
    broken += _refused(foreign, "another program")
    if foreign.read_bytes() != before:
        broken.append("the file of another program was changed")
    link = sqlite3.connect(original.folder / NAME)
    ((name, text),) = link.execute("SELECT name, value FROM facts WHERE name='definitions'")
    link.close()
    then = {kind: f"# as it once was\n{definition}" for kind, definition in
            json.loads(text).items()}
    row = sealed((name, json.dumps(then)))
    older = changed(("UPDATE facts SET value=?, checksum=? WHERE name='definitions'", row[1:]))
    broken += original.start(setting.folder, older, whole=True)[0]
    link = sqlite3.connect(older)
    ((now,),) = link.execute("SELECT value FROM facts WHERE name='definitions'")
    link.close()
    if json.loads(now) != json.loads(text):
        broken.append("messages of older definitions were not brought up to date")
    return Outcome(3, broken, "a newer one refused, older messages converted, another program's "
                   "file left alone")


def _refused(file, word):
    """How a start fails on a file; it must with status 2 and one line."""
    with NodeProcess(file.with_name("bags"), "-r", "__ns:=/damaged", state_file=file) as node:
        status, log = node.ended(), [line for line in node.lines if line != "(end)"]
    good = status == 2 and len(log) == 1 and word in log[0]
    return [] if good else [f"status {status} on a file that should be refused ({word}): {log}"]


def files_in_use(setting: Setting) -> Outcome:
    """Locked by a living node, by the lock of a dead process, and by another program's."""
    original, broken = Original(setting.folder), []
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
        told = client.call("estimate", part=flat(BOXES[3], "later"), method="csae").statistics
        recorded = not any(line.startswith("NOT_RECORDED") for line in told.warnings)
        node.assert_sound()
    link.close()
    if recorded:
        broken.append("an answer was told as recorded while another program had the file")
    with lock.open("r+") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        broken += _refused(file, "process")
    return Outcome(5, broken, f"refused in {seconds:.1f} s with the other's number; a dead "
                   "process's lock is no lock")


def a_disk_to_read_only(setting: Setting) -> Outcome:
    """A state file on a disk that can only be read: all is there, and answers say so."""
    original, broken = Original(setting.folder), []
    with small_disk(setting.folder / "disk", 64) as problem:
        if problem:
            return Outcome(0, [f"not tried, since nothing can be mounted here: {problem}"])
        for ended in ("well", "by a kill"):
            file = original.copy(setting.folder / "copy")
            if ended == "well":
                original.start(setting.folder, file)
            disk = setting.folder / "disk" / ended.replace(" ", "_")
            shutil.copytree(file.parent, disk)
            subprocess.run(["mount", "-o", "remount,ro", setting.folder / "disk"], check=True)
            with original.cell(setting.folder / "bags", disk / NAME) as (node, client):
                said = client.good("estimate", part=flat(BOXES[3], "later"), method="csae")
                if not any(line.startswith("NOT_RECORDED") for line in said.statistics.warnings):
                    broken.append(f"{ended}: an answer was told as recorded")
                shown = _numbers(client)
                shown.pop("later", None)
                node.stop()
                broken += sound(node)
            strange = [name for name, numbers in shown.items()
                       if original.shown.get(name) != numbers]
            if strange or (ended == "well" and shown != original.shown):
                broken.append(f"{ended}: {sorted(shown)} shown, {strange} unlike before")
            subprocess.run(["mount", "-o", "remount,rw", setting.folder / "disk"], check=True)
    return Outcome(2, broken, f"{len(shown)} parts shown after a kill")
