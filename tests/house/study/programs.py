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

"""The study's and the lab's programs as their users start them, and the files of
datasets.
"""

import contextlib
import io
import json
import runpy
import sys
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from matplotlib.image import imread

from ros_pose_stats import part_from_mesh
from study.__main__ import main
from tests.running import ROOT, call, complaints, strict_json

REFERENCE = ROOT / "study" / "data" / "polyhedra_0_inertia.npz"


def study(*arguments):
    """Standard output of one of the study's programs, which must succeed."""
    outcome = call(*arguments, program=main)
    assert outcome.returncode == 0, outcome.stderr
    return outcome.stdout


def study_json(*arguments):
    return strict_json(study(*arguments, "--json"))


def dataset(*arguments):
    """Standard output of the program that makes a dataset, which must succeed."""
    return study("dataset", *arguments)


def refused(*arguments):
    """The one line by which a program of the study refuses its arguments."""
    outcome = call(*arguments, program=main)
    assert (outcome.returncode, outcome.stdout) == (2, ""), outcome
    (line,) = complaints(outcome.stderr)
    return line


def lab(name, *arguments):
    """What a program of the lab prints: `benchmarks.core` and the like."""
    printed = io.StringIO()
    words = sys.argv
    sys.argv = ["program", *map(str, arguments)]
    sys.modules.pop(f"lab.{name}", None)  # another test may have imported it
    try:
        with contextlib.redirect_stdout(printed):
            runpy.run_module(f"lab.{name}", run_name="__main__")
    finally:
        sys.argv = words
    return printed.getvalue()


class Bodies(NamedTuple):
    """A dataset, read by its own schema."""

    schema: dict
    arrays: dict

    @property
    def spec(self):
        return self.schema["spec"]

    @property
    def body(self):
        """Number of the body of each pose."""
        return np.repeat(np.arange(self.spec["bodies"]), self.arrays["poses"])

    def parts(self):
        """The bodies, a unit being a metre."""
        vertices = _spans(self.arrays["vertices"])
        triangles = _spans(self.arrays["triangles"])
        for first, second, center in zip(
            vertices, triangles, self.arrays["center_of_mass"], strict=True
        ):
            yield part_from_mesh(
                self.arrays["vertex"][first],
                self.arrays["triangle"][second],
                center_of_mass=center,
            )


def _spans(lengths):
    return [slice(*ends) for ends in pairwise([0, *np.cumsum(lengths).tolist()])]


def read(file):
    """A dataset by numpy and its schema alone."""
    with np.load(file, allow_pickle=False) as archive:
        schema = json.loads(str(archive["schema"]))
        return Bodies(schema, {name: archive[name] for name in schema["fields"]})


@lru_cache(maxsize=1)
def reference():
    """The reference dataset without shift."""
    return read(REFERENCE)


def write(file, bodies, **changes):
    """A dataset with other arrays; those that are None are left out."""
    arrays = {**bodies.arrays, **changes}
    np.savez(
        file,
        schema=np.array(json.dumps(bodies.schema)),
        **{name: array for name, array in arrays.items() if array is not None},
    )
    return file


def drawn(file, bodies, probability, seed, drops=1000):
    """A dataset of the same bodies, its counts drawn from probabilities (P,)."""
    random = np.random.default_rng(seed)
    blocks = np.diff([0, *range(100, drops, 100), drops])
    restitutions = bodies.spec["restitutions"]
    schema = {
        **bodies.schema,
        "spec": {**bodies.spec, "drops": drops},
        "block_ends": np.cumsum(blocks).tolist(),
    }
    counts = []
    for span in _spans(bodies.arrays["poses"]):
        empty = np.empty(
            (span.stop - span.start, len(restitutions), len(blocks)), np.uint32
        )
        for r in range(len(restitutions)):
            for k, size in enumerate(blocks):
                p = probability[span]
                empty[:, r, k] = random.multinomial(size, p / p.sum())
        counts.append(empty)
    settled = np.broadcast_to(
        blocks, (bodies.spec["bodies"], len(restitutions), len(blocks))
    )
    return write(
        file,
        Bodies(schema, bodies.arrays),
        count=np.concatenate(counts),
        settled=settled.astype(np.uint32),
    )


def first(bodies, number):
    """The first bodies of a dataset alone."""
    arrays = dict(bodies.arrays)
    for field, lengths in (
        ("vertex", "vertices"),
        ("triangle", "triangles"),
        ("down", "poses"),
        ("height", "poses"),
        ("count", "poses"),
    ):
        arrays[field] = arrays[field][: int(arrays[lengths][:number].sum())]
    for name in (
        "vertices",
        "triangles",
        "poses",
        "redraws",
        "center_of_mass",
        "settled",
    ):
        arrays[name] = arrays[name][:number]
    return Bodies({**bodies.schema, "spec": {**bodies.spec, "bodies": number}}, arrays)


def assert_drawn(file):
    """A picture is there and not blank."""
    picture = imread(file)
    assert min(picture.shape[:2]) > 200 and np.ptp(picture[..., :3]) > 0.5


def assert_written(file, *words):
    """A drawing (SVG) is there and names these words."""
    drawing = file.read_text(encoding="utf-8")
    assert [word for word in words if word not in drawing] == []
