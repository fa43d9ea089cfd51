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

"""Pages as the commands write them, and the browser that shows them."""

import pytest
import trimesh

from lab.bodies import shapes
from lab.bodies.samples import random_polyhedron
from lab.bodies.variants import moved, rotation
from tests.answers import write_stl
from tests.running import answer, answer_json

from .browser import Browser, browser_file
from .reading import Page

NO_TRIANGLES = bytes(84)
"""A binary STL file of none."""

DROPPED = "--unit", "mm", "--drops", 300, "--seed", 1


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    if browser_file() is None:
        pytest.skip("no Chromium: apt install chromium")
    browser = Browser(tmp_path_factory.mktemp("profile"))
    yield browser
    browser.close()


@pytest.fixture(scope="session")
def parts(tmp_path_factory):
    """The demo parts, a box of 20 x 30 x 40 mm, and variants of the clamp."""
    folder = tmp_path_factory.mktemp("parts")
    answer("shapes", folder)
    write_stl(folder / "box.stl", shapes.box(20.0, 30.0, 40.0))
    clamp = trimesh.load_mesh(folder / "clamp.stl")
    surface = clamp.vertices, clamp.faces
    write_stl(folder / "long.stl", (surface[0] * (1.0, 1.0, 1.4), surface[1]))
    write_stl(folder / "turned.stl", moved(surface, rotation(3)))
    write_stl(
        folder / "<i>stone & 'co'.stl", moved(random_polyhedron(8, 2), scale=10.0)
    )
    return folder


@pytest.fixture(scope="session")
def report(parts):
    """All that a report can hold, of the box: its page, and its file."""
    file = parts / "box.html"
    answer(
        "report",
        parts / "box.stl",
        "--unit",
        "mm",
        "--wanted",
        "0,1",
        "--rate",
        60,
        "--kick",
        0.02,
        "--flips",
        100,
        "--changes",
        "-o",
        file,
        "--png",
        parts / "box.png",
    )
    return Page(file), file


@pytest.fixture(scope="session")
def estimated(parts):
    """The answer that the report is about."""
    return answer_json("estimate", parts / "box.stl", "--unit", "mm")


@pytest.fixture(scope="session")
def clamp(parts):
    """A report on the clamp."""
    file = parts / "clamp.html"
    answer("report", parts / "clamp.stl", *DROPPED, "-o", file)
    return Page(file), file


@pytest.fixture(scope="session")
def rock(parts):
    """A report on a body of many poses."""
    file = parts / "rock.html"
    write_stl(parts / "rock.stl", random_polyhedron(14, 5))
    answer("report", parts / "rock.stl", *DROPPED, "--cluster-tolerance", 0, "-o", file)
    return Page(file), file


@pytest.fixture(scope="session")
def comparison(parts):
    """Of the clamp, three variants of it and a stone; the page, its file and the
    object.
    """
    file = parts / "variants.html"
    request = (
        "compare",
        *(
            parts / f"{name}.stl"
            for name in ("clamp", "long", "turned", "<i>stone & 'co'")
        ),
        *DROPPED,
        "--wanted",
        "0,1",
    )
    values = answer_json(*request, "-o", file)
    return Page(file), file, values


SHAPES = {
    "a_cube": (10.0, 10.0, 10.0),
    "b_bar": (12.0, 14.0, 60.0),
    "c_plate": (40.0, 30.0, 3.0),
    "d_block": (20.0, 22.0, 25.0),
    "e_<i>odd</i> & 'name'": (9.0, 10.0, 11.0),
    "g_tiny": (0.10, 0.11, 0.12),
}


@pytest.fixture(scope="session")
def catalogue(tmp_path_factory):
    """Makes the catalogue of a few parts and so many files that are none: folder and
    object.
    """

    def make(others):
        folder = tmp_path_factory.mktemp("catalogue")
        (folder / "parts" / "h").mkdir(parents=True)
        for name, size in SHAPES.items():
            write_stl(
                folder / "parts" / f"{name.replace(chr(47), '_')}.stl",
                shapes.box(*size),
            )
        trimesh.creation.box((15.0, 16.0, 17.0)).export(
            folder / "parts" / "h" / "h_declared.3mf"
        )
        (folder / "parts" / "f_letter.stl").write_text("Dear colleague,")
        for k in range(others):
            # A text would be read in a process of its own: 60 ms each.
            (folder / "parts" / f"x_{k}.stl").write_bytes(NO_TRIANGLES)
        return folder / "out", answer_json(
            "catalogue",
            folder / "parts",
            "--unit",
            "mm",
            "--restitution",
            0.4,
            "--workers",
            1,
            "-o",
            folder / "out",
        )

    return make


@pytest.fixture(scope="session")
def small(catalogue):
    """A page that holds all of its parts."""
    return catalogue(0)


@pytest.fixture(scope="session")
def large(catalogue):
    """A page that takes its rows from scripts beside it."""
    return catalogue(400)
