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

"""What the commands of one checkout answer for many parts; run as a script beside any
checkout.

    PYTHONPATH=CHECKOUT python answers.py PARTS OUTPUT [--only WORD ...] [--other-hull]

PARTS is a folder of mesh files (a subfolder `real` holds files in their own units),
OUTPUT the JSON file that is written: request -> answer, all numbers in full. Nothing of
the package but its command line is imported, so that this file serves checkouts whose
inside is different.
"""

import argparse
import contextlib
import hashlib
import io
import json
import re
import sys
import tempfile
from pathlib import Path

TIMED = (
    "seconds",
    "time",
    "date",
    "begin",
    "end",
    "queued",
    "started",
    "ended",
    "version",
    "job_id",
    "workers",
    "drops_per_second",
    "files",
    "bags",
    "directory",
    "path",
)
"""Keys whose values say when, how long, where, or by which version."""

UNITS = {
    "featuretype.STL": "inch",
    "angle_block.STL": "inch",
    "ariac_sensor_collision.stl": "m",
}
"""Of real meshes; the others count as millimetres, and STEP files declare theirs."""

SCENES = (("dull", "0.2", 3.0), ("even", "0.5", 20.0), ("bouncy", "0.8", 8.0))
"""Name, restitution, and release in part radii."""

DESIGNED = {"clamp": "0", "bracket": "0", "half_cylinder": "0"}
"""Parts whose wanted poses the slow commands are asked about."""

FILMED = ("clamp", "prism", "cube", "octahedron", "open_box", "pebble", "polyhedron")
"""Parts of which a drop is recorded: none that rolls for long."""

DECLARED = ".step", ".stp"
"""Kinds of files that declare their unit."""


def run(*arguments):
    """Status, output and complaints of a command."""
    from ros_pose_stats.tools.cli import main

    printed = io.StringIO()
    err = io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(err):
        try:
            status = main([str(argument) for argument in arguments])
        except SystemExit as end:
            status = end.code
    return status, printed.getvalue(), err.getvalue()


def ask(*arguments):
    """What a command answers with `--json`, less times; of a refusal its words."""
    status, printed, err = run(*arguments, "--json")
    return (
        without_times(json.loads(printed))
        if status == 0
        else {"status": status, "refusal": err}
    )


GEOMETRY = (
    "down",
    "orientation",
    "support_polygon",
    "outline",
    "height",
    "top",
    "margin",
    "barrier",
    "spread",
    "members",
    "rolls",
    "roll_axis",
    "yaw_symmetry",
    "group_size",
    "position",
    "alike_from_above",
)
"""Of a pose: the same in every answer for a part, so kept in some only."""


def without_geometry(answer):
    """Answers with no more of each pose than its numbering and its share."""
    if isinstance(answer, list):
        return [without_geometry(item) for item in answer]
    if "poses" not in answer:
        return answer
    return {
        **answer,
        "poses": [
            {key: value for key, value in pose.items() if key not in GEOMETRY}
            for pose in answer["poses"]
        ],
    }


def without_times(value):
    if isinstance(value, dict):
        return {
            key: without_times(item) for key, item in value.items() if key not in TIMED
        }
    return [without_times(item) for item in value] if isinstance(value, list) else value


def read(*arguments):
    """Lines of a table, less the one that says how long it took."""
    status, printed, err = run(*arguments)
    return {
        "status": status,
        "lines": [
            line.rstrip()
            for line in (printed + err).splitlines()
            if not line.startswith("computed in")
        ],
    }


def requests_of_part(file, radius):
    """Requests about one part: name -> arguments."""
    unit = (
        []
        if file.suffix.lower() in DECLARED
        else ["--unit", UNITS.get(file.name, "mm")]
    )
    lines = {
        "methods": "estimate --method all",
        "split low": "estimate --method split --restitution 0.2 "
        f"--drop-height {2.0 * radius!r}",
        "split bouncy": "estimate --method split --restitution 0.8",
        "each face": "estimate --method meae --cluster-tolerance 0 --round-sides 0",
        "hybrid": "estimate --method hybrid --drops 100 --seed 6",
        "few": "simulate --drops 3 --seed 11 --restitution 0.5",
    }
    for name, restitution, radii in SCENES:
        for seed in (1, 2, 3):
            lines[f"drops {name} {seed}"] = (
                f"simulate --drops 300 --seed {seed} --restitution {restitution} "
                f"--drop-height {radii * radius!r}"
            )
    if file.stem in DESIGNED:
        wanted = f"--wanted {DESIGNED[file.stem]}"
        lines |= {
            "auto": "estimate --target-error 0.02 --seed 6",
            "target": "simulate --target-error 0.03 --drops 5000 --seed 6",
            "flips": f"flips --kick {radius!r} --flips 200 --seed 4 {wanted}",
            "feeding": f"feeding --plate {12.0 * radius!r} {9.0 * radius!r} "
            f"--kicks {0.5 * radius!r} {radius!r} --flips 100 --seed 4 {wanted}",
            "sensitivity": f"sensitivity {wanted} --checks 2 --drops 300 --seed 4",
        }
    return {
        name: [line.split()[0], file, *unit, *line.split()[1:]]
        for name, line in lines.items()
    }


def prefix_of(file):
    """How requests about a part begin; parts that were not made here may have names of
    others.
    """
    return f"{'real/' if file.parent.name == 'real' else ''}{file.name}: "


def answers_of_part(file, chosen):
    """Answers by request about one part."""
    prefix = prefix_of(file)
    unit = (
        []
        if file.suffix.lower() in DECLARED
        else ["--unit", UNITS.get(file.name, "mm")]
    )
    plain = ask("estimate", file, *unit, "--method", "meae")
    if "refusal" in plain:
        return {f"{prefix}poses": plain} if chosen(f"{prefix}poses") else {}
    answers = {
        prefix + name: without_geometry(ask(*arguments))
        for name, arguments in requests_of_part(file, plain["radius"]).items()
        if chosen(prefix + name)
    }
    if chosen(f"{prefix}poses"):
        answers[f"{prefix}poses"] = plain
    if chosen(f"{prefix}table"):
        answers[f"{prefix}table"] = read("estimate", file, *unit, "--each")
    if file.stem.startswith(FILMED) and chosen(f"{prefix}film"):
        answers[f"{prefix}film"] = film_of(file, unit)
    return answers


def film_of(file, unit):
    """A digest of all messages of a recorded drop: the file around them says when it
    was made.
    """
    from mcap.reader import make_reader

    with tempfile.TemporaryDirectory() as folder:
        film = Path(folder) / "film.mcap"
        status, _, err = run("animate", file, *unit, "--drop", "3", "-o", film)
        if status:
            return {"status": status, "refusal": err}
        with film.open("rb") as stream:
            content = b"".join(
                b"%s %d %s" % (channel.topic.encode(), message.log_time, message.data)
                for _, channel, message in make_reader(stream).iter_messages()
            )
    return {"bits": digest(content)}


def answers_of_commands(parts, work, chosen):
    """Answers of the commands that are about several parts, or write files."""
    by_stem = {file.stem: file for file in parts}
    clamp, prism, cylinder, half = (
        by_stem[name] for name in ("clamp", "prism", "cylinder", "half_cylinder")
    )
    counts = work / "counts.csv"
    counts.write_text(
        "part,pose,count\n"
        + "".join(
            f"{file},{pose},{count}\n"
            for file, pairs in (
                (
                    clamp,
                    ((0, 420), (1, 350), (2, 80), (3, 70), (4, 50), (6, 20), (5, 10)),
                ),
                (prism, ((0, 300), (6, 30), (1, 280))),
                (half, ((0, 210), (1, 15), (2, 40))),
            )
            for pose, count in pairs
        ),
        encoding="utf-8",
    )
    shapes = work / "shapes"
    page = work / "page.html"
    book = work / "book"
    requests = {
        "compare": lambda: ask(
            "compare",
            clamp,
            clamp,
            "--unit",
            "mm",
            "--com",
            "17mm 17mm 0",
            "--com",
            "17mm 17mm 2mm",
            "--wanted",
            "0,1",
            "--drops",
            "2000",
            "--seed",
            "3",
        ),
        "compare table": lambda: read(
            "compare", prism, cylinder, "--unit", "mm", "--drops", "1000", "--seed", "3"
        ),
        "fit": lambda: ask(
            "fit",
            counts,
            "--unit",
            "mm",
            "--plate",
            "glass",
            "--plates",
            work / "plates.yaml",
        ),
        "catalogue": lambda: _catalogue(parts, book),
        "report": lambda: _page(clamp, page),
        "shapes": lambda: read("shapes", shapes),
    }
    return {
        name: without_folder(make(), work)
        for name, make in requests.items()
        if chosen(name)
    }


def without_folder(answer, folder):
    """An answer in which the folder that commands write to has no name."""
    return json.loads(json.dumps(answer).replace(str(folder), "FOLDER"))


def _catalogue(parts, book):
    """The table of a catalogue of the small generated parts."""
    small = [
        file
        for file in parts
        if file.stem.startswith(("polyhedron", "cube", "needle", "open", "octa"))
    ]
    answer = ask("catalogue", *small, "--unit", "mm", "-o", book, "--workers", "1")
    return {
        "said": answer,
        "poses": (book / "poses.csv").read_text(encoding="utf-8").splitlines(),
    }


def _page(part, page):
    """What a page about a part says, without its pictures and its code."""
    status, _, err = run(
        "report", part, "--unit", "mm", "-o", page, "--drops", "500", "--seed", "3"
    )
    text = page.read_text(encoding="utf-8") if status == 0 else err
    text = re.sub(r"(?s)<(head|script|style|svg).*?</\1>|<[^>]*>", " ", text)
    return {"status": status, "words": [word for word in text.split() if word]}


def digest(content):
    return hashlib.sha256(content).hexdigest()


class OtherHulls:
    """Hulls as they might come from other code: computed in another frame and order.

    Flat faces are cut along other diagonals, and planes are rounded differently.
    """

    def __init__(self, seed):
        import numpy
        import scipy.spatial

        self.hull = scipy.spatial.ConvexHull
        self.random = numpy.random.default_rng(seed)
        self.turn = numpy.linalg.qr(self.random.normal(size=(3, 3)))[0]
        if numpy.linalg.det(self.turn) < 0.0:
            self.turn = -self.turn

    def __call__(self, points, *arguments, **options):
        from types import SimpleNamespace

        import numpy

        if numpy.shape(points)[1] != 3:
            return self.hull(points, *arguments, **options)
        order = self.random.permutation(len(points))
        hull = self.hull(points[order] @ self.turn.T, *arguments, **options)
        chosen = self.random.permutation(len(hull.simplices))
        ranks = numpy.argsort(chosen)
        equations = hull.equations[chosen]
        equations[:, :3] = equations[:, :3] @ self.turn
        return SimpleNamespace(
            simplices=order[hull.simplices[chosen]].astype(numpy.int32),
            equations=equations,
            neighbors=ranks[hull.neighbors[chosen]].astype(numpy.int32),
            volume=hull.volume,
            vertices=numpy.sort(order[hull.vertices]),
            area=hull.area,
        )


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("parts", type=Path)
    parser.add_argument("output", type=Path)
    parser.add_argument(
        "--only", nargs="+", metavar="NAME", help="these requests alone"
    )
    parser.add_argument(
        "--other-hull", action="store_true", help="play another hull library"
    )
    options = parser.parse_args(arguments)
    if options.other_hull:
        import scipy.spatial

        scipy.spatial.ConvexHull = OtherHulls(1)
    names = frozenset(options.only or ())

    def chosen(name):
        return not names or name in names

    answers = {}
    parts = sorted(file for file in options.parts.iterdir() if file.is_file())
    for file in [*parts, *sorted((options.parts / "real").glob("*"))]:
        if not names or any(name.startswith(prefix_of(file)) for name in names):
            answers |= answers_of_part(file, chosen)
    with tempfile.TemporaryDirectory() as work:
        answers |= answers_of_commands(parts, Path(work), chosen)
    options.output.write_text(json.dumps(answers, indent=0), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
