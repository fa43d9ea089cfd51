"""Catalogues, made once a file of tests."""

import pytest

from lab.bodies import shapes
from lab.bodies.samples import random_polyhedron
from tests.answers import write_stl
from tests.running import answer_json, call

from .parts import ASKED, REFUSED, ROCKS, set_parts


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """Where parts lie, what is none, and what is not to be looked at; `set_parts` adds
    two.
    """
    home = tmp_path_factory.mktemp("catalogue")
    parts = home / "parts"
    (parts / "below" / ".cache").mkdir(parents=True)
    for name in ("box.stl", "b\udcf6x, 1.stl"):
        write_stl(parts / name, shapes.box(1.0, 2.0, 3.0))
    for seed in range(ROCKS):
        write_stl(parts / "below" / f"rock_{seed}.STL", random_polyhedron(9, seed))
    for name, content in REFUSED.items():
        (parts / name).write_bytes(content)
    (parts / "notes.txt").write_text("no part")
    for hidden in (".hidden.stl", "below/.cache/box.stl"):
        write_stl(parts / hidden, shapes.box(1.0, 2.0, 3.0))
    (parts / "below" / "up").symlink_to("..")
    (home / "\ufeff =1+1.stl").write_text("no part")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(home)
        yield home


@pytest.fixture(scope="module")
def catalogue(home):
    """The late parts in one go: what the command prints with `--json`, and its folder.

    A file beside the parts may have the name of a module that the work needs.
    """
    set_parts(home / "parts", late=True)
    (home / "queue.py").write_text("import pathlib; pathlib.Path('ran').touch(); 1 / 0")
    values = answer_json(*ASKED, "-o", "out", "--parquet")
    (home / "queue.py").unlink()
    return values, home / "out"


@pytest.fixture
def made(tmp_path):
    """A catalogue of a box, and how to ask for it again."""
    file = tmp_path / "box.stl"
    write_stl(file, shapes.box(10.0, 20.0, 30.0))
    request = "catalogue", file, "--unit", "mm", "-o", tmp_path / "out", "--workers", 1
    assert call(*request).returncode == 0
    return tmp_path / "out", request
