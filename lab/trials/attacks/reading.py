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

"""Small files that stand for far too much, in every format that is read."""

import random
import resource
import time
import zipfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

from lab.bodies.step_text import Disc, step_assembly, step_part
from ros_pose_stats import PoseStatsError
from ros_pose_stats.core.mesh.files import read_mesh

from ..frame import Outcome, Setting, judged

SECONDS = 125.0
MEGABYTES = 1536.0
UPRIGHT = (1, 0, 0), (0, 0, 1)
TETRAHEDRON = (
    b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
)
PLY = b"ply\nformat %s 1.0\nelement vertex %d\n%selement face %d\n%send_header\n%s"
XYZ = b"property float x\nproperty float y\nproperty float z\n"
CORNERS = b"property list uint int vertex_indices\n"
MESH = (
    '<object id="1"><mesh><vertices>{}<vertex x="1" y="0" z="0"/>'
    '<vertex x="0" y="1" z="0"/><vertex x="0" y="0" z="1"/></vertices>'
    '<triangles><triangle v1="0" v2="1" v3="2"/>{}</triangles></mesh></object>'
)
VERTEX = '<vertex x="0" y="0" z="0"/>'
FACET = b"facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"


def texts(millions: float) -> Iterator[tuple[str, bytes]]:
    """STL as text, OBJ, OFF and PLY files, by name."""
    length = int(1e6 * millions)
    yield "one_line.obj", b"v " + b"1 " * (8 * length)
    yield "no_line.obj", b"x" * (16 * length)
    yield "polygon.obj", TETRAHEDRON + b"f" + b" 1 2 3" * length
    yield "vertices.obj", b"v 0 0 0\n" * (2 * length) + TETRAHEDRON
    yield "faces.obj", TETRAHEDRON + b"f 1 2 3\n" * (2 * length)
    yield "digits.obj", b"v 0 0 " + b"9" * length + b"\nf 1 1 1\n"
    yield "numbers.obj", TETRAHEDRON + b"f 1 2 " + b"9" * length + b"\n"
    yield "far.obj", TETRAHEDRON + b"f 1 2 99999999999999999999\n"
    yield "back.obj", TETRAHEDRON + b"f -1 -2 -99999999999\n"
    yield "goes_on.obj", TETRAHEDRON + b"f 1 2 \\\n" * length
    yield "returns.obj", b"\r" * (8 * length) + TETRAHEDRON
    yield "zeros.obj", bytes(8 * length)
    yield "solids.stl", b"solid x\nendsolid x\n" * length
    yield "unfinished.stl", b"solid x\n" * (2 * length)
    yield "facets.stl", b"solid x\n" + FACET * (length // 2) + b"endsolid x\n"
    yield "normals.stl", b"facet normal " * length
    yield "vertex.stl", b"vertex " * (2 * length)
    yield "spaces.stl", b"vertex" + b" " * (8 * length)
    yield "counts.off", b"OFF\n999999999999 999999999999 0\n0 0 0\n"
    yield "polygon.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n999999999999 0 1 2\n"
    yield "comments.off", b"OFF\n" + b"#\n" * (4 * length) + b"1 0 0\n0 0 0\n"
    yield "digits.off", b"OFF\n" + b"9" * length + b" 1 0\n"
    for kind in (b"ascii", b"binary_little_endian", b"binary_big_endian"):
        name = kind.decode()
        yield f"counts_{name}.ply", PLY % (kind, 2**40, XYZ, 2**40, CORNERS, b"0 ")
        yield f"list_{name}.ply", PLY % (kind, 0, XYZ, 1, CORNERS, b"\xff" * 64)
        yield f"nothing_{name}.ply", PLY % (kind, 2**60, b"", 2**60, b"", b"")
    yield "list.ply", PLY % (b"ascii", 0, XYZ, 1, CORNERS, b"999999999999 0 1 2")
    yield "header.ply", b"ply\n" + b"comment x\n" * length + b"end_header\n"
    yield "elements.ply", b"ply\nformat ascii 1.0\n" + b"element x 1\n" * length


BOMBS = ("text.3mf", "components.3mf", "chain.3mf")
"""Files that unpack to far more than is read; others may be taken."""


def archives(folder: Path, millions: float, expanded: int) -> Iterator[str]:
    """Write 3MF files; their names. `expanded`: characters of the largest one."""
    length = int(1e6 * millions)
    tetrahedron = MESH.format(VERTEX, "")

    def above(levels: int, copies: int) -> str:
        return tetrahedron + "".join(
            f'<object id="{k + 2}"><components>'
            + f'<component objectid="{k + 1}"/>' * copies
            + "</components></object>"
            for k in range(levels)
        )

    circle = (
        '<object id="2"><components><component objectid="2"/><component objectid="2"/>'
        "</components></object>"
    )
    bombs = {
        "text": (tetrahedron + " " * expanded, 1),
        "vertices": (MESH.format(VERTEX * (4 * length), ""), 1),
        "triangles": (
            MESH.format(VERTEX, '<triangle v1="0" v2="1" v3="3"/>' * (4 * length)),
            1,
        ),
        "components": (above(20, 1000), 21),
        "chain": (above(3000, 1), 3001),
        "circle": (tetrahedron + circle, 2),
        "attribute": (f'<object id="{"1" * (100 * length)}"/>', 1),
        "nested": (tetrahedron + "<a>" * (4 * length), 1),
        "items": (tetrahedron, '1"/><item objectid="1' * length),
        "numbers": (MESH.format(f'<vertex x="{"9" * length}" y="0" z="0"/>', ""), 1),
    }
    for name, (objects, built) in bombs.items():
        file = f"{name}.3mf"
        with zipfile.ZipFile(folder / file, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr(
                "3D/3dmodel.model",
                f"<model><resources>{objects}</resources><build>"
                + f'<item objectid="{built}"/></build></model>',
            )
        yield file
    with zipfile.ZipFile(folder / "names.3mf", "w") as archive:
        for number in range(length // 20):
            archive.writestr(f"{number}", b"")
    yield "names.3mf"
    entities = '<!DOCTYPE m [<!ENTITY a "a"><!ENTITY b "&a;&a;">]><model>&b;</model>'
    with zipfile.ZipFile(folder / "entities.3mf", "w") as archive:
        archive.writestr("3D/3dmodel.model", entities)
    yield "entities.3mf"


def step_texts(millions: float, seed: int) -> Iterator[tuple[str, str]]:
    """STEP files, by name; those that are damaged are so at random."""
    length = int(1e6 * millions)
    whole = step_part(Disc(5.0, 2.0))
    holes = [
        (0.9 * (k % 60 - 30), 0.9 * (k // 60 - 30), 0.2)
        for k in range(max(100, length // 1000))
    ]
    yield "holes.step", step_part(Disc(60.0, 2.0, tuple(holes)))
    for count in (300, max(600, length // 200)):
        places = [((12.0 * k, 0.0, 0.0), *UPRIGHT) for k in range(count)]
        yield f"assembly_{count}.step", step_assembly(Disc(5.0, 2.0), places)
    numbers = ",".join(f"#{k}" for k in range(1, length // 3))
    context = "UNIT_ASSIGNED_CONTEXT(("
    yield "units.step", whole.replace(context, f"{context}{numbers},")
    yield "statements.step", whole.replace("DATA;", "DATA;" + "#1=" * length)
    yield "empty.step", "ISO-10303-21;\n" + ";" * (4 * length)
    yield "parentheses.step", whole.replace("DATA;", "DATA;\n#999=A(" + "(" * length)
    random_numbers = random.Random(seed)
    for number in range(4):
        damaged = list(whole)
        for _ in range(20):
            damaged[random_numbers.randrange(len(damaged))] = random_numbers.choice(
                "0#=();,'*$."
            )
        yield f"damaged_{number}.step", "".join(damaged)


def small_files_that_stand_for_much(setting: Setting) -> Outcome:
    """Archives, STEP, text and binary files that would take hours or all memory."""
    millions = 0.1 + 0.2 * setting.size
    expanded = setting.of(2**30, 2**29 + 2**27)
    names = list(archives(setting.folder, millions, expanded))
    for name, content in texts(millions):
        (setting.folder / name).write_bytes(content)
        names.append(name)
    for name, text in step_texts(millions, setting.seed):
        (setting.folder / name).write_text(text, encoding="ascii")
        names.append(name)
    files = [setting.folder / name for name in names]
    # A process begins with the peak of the one that starts it, so that is a small one.
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        outcomes = list(pool.map(_try, files))
        peak = pool.submit(_peak_of_readers).result()
    slowest = max(outcomes)
    refused = {name for _, name, is_refused in outcomes if is_refused}
    return judged(
        len(names),
        f"{len(refused)} refused, the slowest, {slowest[1]}, after {slowest[0]:.1f} s, "
        f"at most {peak:.0f} MiB in a reading process",
        in_time=slowest[0] <= SECONDS,
        within_the_memory=peak <= MEGABYTES,
        bombs_are_refused=refused.issuperset(BOMBS),
    )


def _try(file: Path) -> tuple[float, str, bool]:
    """Seconds until a file was read or refused, its name, and whether it was that."""
    begin = time.monotonic()
    is_refused = False
    try:
        read_mesh(file)
    except PoseStatsError:
        is_refused = True
    return time.monotonic() - begin, file.name, is_refused


def _peak_of_readers() -> float:
    """Most memory, MiB, that a process had which this one has started."""
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024.0
