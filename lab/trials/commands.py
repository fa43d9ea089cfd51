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

"""Files and words that are made to trouble a command, each handed to one.

    python -m lab.trials.commands [--write]

A command answers, or refuses in one line of its own; in either case soon, within its
memory, and with nothing of the file's that a terminal or a spreadsheet would act on.
"""

import csv
import math
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from sqlite3 import connect
from typing import NamedTuple

import numpy as np
import trimesh
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.records import Chunk
from mcap.writer import Writer

from lab.bodies.shapes import Surface
from ros_pose_stats.core.kernels.compilation import all_kernels

from . import ROOT
from .frame import Outcome, Setting, judged, program, trial

SECONDS = 30.0  # of the processor, that a command may take
MEGABYTES = 1536.0  # that it may have
TYPE = "ros_pose_stats_msgs/msg/PoseStatistics"
BYTES = 2**20
CORNERS = 20_000  # of a face
NESTED = 100_000  # brackets
LINES = 300_000  # of a definition
NOBODY = 65534  # a user
LOADING_SECONDS = 5.0  # of the processor, for all kernels
SHORT = 0.1

BOX = trimesh.creation.box((0.04, 0.03, 0.02))
VIEW = (
    "CREATE VIEW messages AS WITH RECURSIVE n(i) AS "
    "(SELECT 1 UNION ALL SELECT i + 1 FROM n) "
    "SELECT i AS id, 1 AS topic_id, i AS timestamp, x'00' AS data FROM n"
)
FORMULAS = ("=1+1", " =1+1", "\ufeff=1+1")
ESCAPES = ("\x1b]0;title\x07", "\x1b[31mred\x1b[0m field")


class Run(NamedTuple):
    """What came of a command."""

    words: str
    status: int
    seconds: float  # of the processor
    megabytes: float  # the most memory that it had
    output: str
    errors: str

    @property
    def is_sound(self) -> bool:
        """Whether it answered, or refused in one line."""
        lines = self.errors.splitlines()
        is_own = all(line.startswith("ros_pose_stats: ") for line in lines)
        return self.status == 0 or (self.status == 2 and len(lines) == 1 and is_own)


def run(folder: Path, *words: str) -> Run:
    """Run a command in a folder, for so long as it may take."""
    limit = f"ulimit -t {4 * SECONDS:.0f}; exec "
    command = " ".join([sys.executable, "-m", "ros_pose_stats", '"$@"'])
    with (
        (folder / "output").open("w+") as output,
        (folder / "errors").open("w+") as errors,
    ):
        process = subprocess.Popen(
            ["/bin/sh", "-c", limit + command, "sh", *words],
            cwd=folder,
            stdout=output,
            stderr=errors,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
        )
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        texts = []
        for stream in (output, errors):
            stream.seek(0)
            texts.append(stream.read())
    return Run(
        " ".join(words),
        process.returncode,
        usage.ru_utime + usage.ru_stime,
        usage.ru_maxrss / 1024.0,
        *texts,
    )


def outcome_of(runs: list[Run], **promises: bool) -> Outcome:
    """An outcome from commands, each of which was to end well, soon and in bounds."""
    longest = max(runs, key=lambda run: run.seconds)
    largest = max(run.megabytes for run in runs)
    strange = [run for run in runs if not run.is_sound]
    refused = sum(run.status != 0 for run in runs)
    summary = (
        f"{refused} of {len(runs)} refused; at most {longest.seconds:.1f} s of the "
        f"processor and {largest:.0f} MiB"
    )
    outcome = judged(
        len(runs),
        summary,
        in_time=longest.seconds < SECONDS,
        within_the_memory=largest < MEGABYTES,
        **promises,
    )
    outcome.broken += [f"{run.words}: {run.status}, {run.errors}" for run in strange]
    return outcome


def write_box(file: Path, surface: Surface | None = None) -> Path:
    """Write a small part in metres, or another surface, as its name says."""
    vertices, faces = (BOX.vertices, BOX.faces) if surface is None else surface
    trimesh.Trimesh(vertices, faces, process=False).export(file)
    return file


def write_definition(file: Path, text: str) -> None:
    """Write a bag with one message, whose type has this definition."""
    with file.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros2", "trial")
        schema = writer.register_schema(TYPE, "ros2msg", text.encode())
        channel = writer.register_channel("/pose_stats/answers", "cdr", schema)
        writer.add_message(channel, 1, bytes(64), 1)
        writer.finish()


def zeros(mebibytes: int) -> bytes:
    """So many of zeros as a frame of zstd."""
    packer = zstandard.ZstdCompressor().compressobj()
    block = bytes(BYTES)
    packed = [packer.compress(block) for _ in range(mebibytes)]
    return b"".join([*packed, packer.flush()])


def bags(folder: Path, mebibytes: int, lines: int) -> Iterator[str]:
    """Write small bags that stand for much; their names."""
    packed = zeros(mebibytes)
    builder = RecordBuilder()
    Chunk("zstd", packed, 1, 1, 0, mebibytes * BYTES).write(builder)
    with (folder / "chunk.mcap").open("wb") as stream:
        Writer(stream).start("ros2", "trial")
    with (folder / "chunk.mcap").open("ab") as stream:
        stream.write(builder.end())
    yield "chunk.mcap"
    (folder / "packed.mcap.zstd").write_bytes(packed)
    yield "packed.mcap.zstd"
    write_definition(folder / "lines.mcap", "uint8 x\n" * lines)
    yield "lines.mcap"
    link = connect(folder / "view.db3")
    link.execute(
        "CREATE TABLE topics (id INTEGER, name TEXT, type TEXT, "
        "serialization_format TEXT, offered_qos_profiles TEXT)"
    )
    link.execute(
        "INSERT INTO topics VALUES (1, '/pose_stats/answers', ?, 'cdr', '')", (TYPE,)
    )
    link.execute(VIEW)
    link.commit()
    link.close()
    yield "view.db3"


def bags_that_stand_for_much(setting: Setting) -> Outcome:
    """`bag` on 65 kB of zeros, in a chunk and packed as a whole, a definition of
    300,000 lines, and a view without an end.
    """
    mebibytes = setting.of(2048, 300)
    names = list(bags(setting.folder, mebibytes, setting.of(LINES)))
    return outcome_of([run(setting.folder, "bag", name) for name in names])


def escape_sequences(setting: Setting) -> Outcome:
    """`bag` where definitions of messages hold what a terminal obeys."""
    runs = []
    for number, text in enumerate(ESCAPES):
        name = f"{number}.mcap"
        write_definition(setting.folder / name, text)
        runs.append(run(setting.folder, "bag", name))
    return outcome_of(
        runs,
        none_reaches_the_terminal=all(
            "\x1b" not in run.output + run.errors for run in runs
        ),
    )


def things_that_are_no_files(setting: Setting) -> Outcome:
    """`catalogue` over a pipe in a picture's place, a damaged table of rows and a
    request without an end, `report --png=--`, and files with NaN or a texture.
    """
    folder = setting.folder
    file = write_box(folder / "box.stl").name
    catalogue = "catalogue", file, "--unit", "m", "-o", "pages"
    runs = [run(folder, *catalogue)]
    picture = next((folder / "pages").rglob("*.png"))
    picture.unlink()
    os.mkfifo(picture)
    runs.append(run(folder, *catalogue))
    (folder / "pages" / "request.json").write_text("[" * NESTED)
    runs.append(run(folder, *catalogue))
    shutil.rmtree(folder / "pages")
    runs.append(run(folder, *catalogue))
    rows = folder / "pages" / "parts.sqlite3"
    rows.write_bytes(b"no rows" * (rows.stat().st_size // 7))
    runs.append(run(folder, *catalogue))
    runs.append(run(folder, "report", file, "--unit", "m", "--png=--"))
    vertices = BOX.vertices.copy()
    vertices[3] = np.nan
    write_box(folder / "nan.stl", (vertices, np.asarray(BOX.faces)))
    header, end, body = write_box(folder / "box.ply").read_bytes().partition(b"\n")
    texture = folder / "texture.ply"
    texture.write_bytes(header + end + b"comment TextureFile none.png\n" + body)
    for name in ("nan.stl", texture.name):
        runs.append(run(folder, "estimate", name, "--unit", "m", "--method", "csae"))
    return outcome_of(
        runs, a_pipe_is_replaced=picture.is_file(), nan_is_refused=runs[-2].status == 2
    )


def numbers_without_measure(setting: Setting) -> Outcome:
    """`flips --kick 1e99`, and `report` of an OBJ file with faces of 20,000 corners."""
    folder = setting.folder
    write_box(folder / "box.stl")
    corners = setting.of(CORNERS)
    angles = 2.0 * math.pi * np.arange(corners) / corners
    circle = np.stack([np.cos(angles), np.sin(angles)], 1)
    lines = [f"v {x:.9f} {y:.9f} {z}" for z in (0.0, 0.3) for x, y in circle.tolist()]
    below = range(1, corners + 1)
    faces = [list(reversed(below)), [corners + k for k in below]]
    for k in below:
        after = k % corners + 1
        faces.append([k, after, corners + after, corners + k])
    lines += ["f " + " ".join(map(str, face)) for face in faces]
    (folder / "face.obj").write_text("\n".join(lines))
    return outcome_of(
        [
            run(folder, "flips", "box.stl", "--unit", "m", "--kick", "1e99"),
            run(folder, "report", "face.obj", "--unit", "mm", "-o", "page.html"),
        ]
    )


def names_that_are_formulas(setting: Setting) -> Outcome:
    """`catalogue` over parts whose names a spreadsheet would compute."""
    folder = setting.folder
    files = [write_box(folder / f"{name}.stl").name for name in FORMULAS]
    words = "catalogue", *(f"./{file}" for file in files), "--unit", "m", "-o", "pages"
    outcome = run(folder, *words)
    cells = []
    for table in (folder / "pages").glob("*.csv"):
        with table.open(encoding="utf-8-sig", newline="") as stream:
            cells += [cell for row in csv.reader(stream) for cell in row]
    computed = [
        cell for cell in cells if cell.lstrip(" \ufeff\u200b\t").startswith("=")
    ]
    return outcome_of(
        [outcome], tables_are_there=cells != [], none_computed=not computed
    )


LOADING = f"""
import os, time
from ros_pose_stats.core.kernels.compilation import all_kernels
kernels = all_kernels()
os.setuid({NOBODY})
begin = time.process_time()
for kernel in kernels:
    kernel.prepare()
print(time.process_time() - begin)
"""
"""All kernels are loaded, or compiled, by a user who can look into nothing of root's
but what all may see. The interpreter itself may lie there, so it is begun before.
"""


def kernels_of_root(setting: Setting) -> Outcome:
    """Another user loads the kernels that root has compiled, where nobody can write."""
    if os.getuid() != 0:
        return Outcome(0, [], "not tried: root alone can become another user")
    kernels = all_kernels()
    for kernel in kernels:
        kernel.prepare()
    store = kernels[0].store()
    # The folder of a trial is its user's alone.
    with tempfile.TemporaryDirectory() as name:
        cache = Path(name)
        shutil.copytree(store, cache / "ros_pose_stats" / store.name)
        for path in (cache, *cache.rglob("*")):
            path.chmod(0o555 if path.is_dir() else 0o444)
        loading = subprocess.run(
            [sys.executable, "-c", LOADING],
            cwd=ROOT,
            capture_output=True,
            text=True,
            env=os.environ
            | dict.fromkeys(("XDG_CACHE_HOME", "HOME"), os.devnull)
            | {"NUMBA_CACHE_DIR": name},
        )
    seconds = float(loading.stdout or math.inf)
    return judged(
        len(kernels),
        f"{len(kernels)} kernels loaded in {seconds:.2f} s of the processor; "
        f"{loading.stderr.strip() or 'nothing said'}",
        they_are_used=seconds < LOADING_SECONDS,
        nothing_is_said=not loading.stderr,
    )


TRIALS = (
    trial(
        bags_that_stand_for_much,
        "30 s and 2.2 GB; 30 s; 6.2 GB, and no end",
    ),
    trial(escape_sequences, "they reached the terminal"),
    trial(
        things_that_are_no_files,
        "`catalogue` waited for ever; tracebacks; warnings of numpy",
    ),
    trial(numbers_without_measure, "over 30 s each"),
    trial(names_that_are_formulas, "the last two were left as they are"),
    trial(kernels_of_root, "ignored: 45 s at every start"),
)

if __name__ == "__main__":
    raise SystemExit(program("commands", TRIALS, SHORT))
