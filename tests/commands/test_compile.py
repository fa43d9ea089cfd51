"""After `compile`, nothing else compiles."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from pathlib import Path

import pytest

from ros_pose_stats.cli import main
from ros_pose_stats.commands import compile
from ros_pose_stats.commands.compile import TOGETHER, _families
from ros_pose_stats.kernels.compilation import all_kernels
from ros_pose_stats.shapes.demo_parts import write_demo_parts

COMMAND = """
import sys
from ros_pose_stats.cli import main
sys.exit(main(sys.argv[1:]))
"""

DROP = """
import sys
from ros_pose_stats import load_part, record_drop
record_drop(load_part(sys.argv[1], "mm"))
"""

NODE = """
from ros_pose_stats.ros.main import warm_up
warm_up(print)
"""


def test_every_kernel_is_in_one_family():
    kernels = all_kernels()
    families = _families(kernels)
    assert sorted(name for family in families for name in family) == sorted(
        one.name for one in kernels)
    assert len(families) == len(TOGETHER) + 1


def test_says_where_all_are(monkeypatch, capsys):
    """Kernels that are there are not compiled anew."""
    monkeypatch.setattr("ros_pose_stats.kernels.compilation.EntryKernel.is_stored", lambda _: True)
    assert main(["compile"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert len(said) == 1 and said[0].startswith(f"all {len(all_kernels())} kernels are in ")


def test_kernels_that_cannot_be_kept_fail(monkeypatch):
    monkeypatch.setattr("ros_pose_stats.kernels.compilation.EntryKernel.is_stored",
                        lambda one: one.name != "bounds")
    monkeypatch.setattr("ros_pose_stats.commands.compile._compile_all", lambda _: None)
    with pytest.raises(OSError, match="1 kernels"):
        compile.run(argparse.Namespace())


@pytest.fixture(scope="module")
def start(tmp_path_factory):
    """Run Python with the kernels that `compile` has left in a folder of its own."""
    cache = tmp_path_factory.mktemp("cache")

    def run(script, *arguments):
        return subprocess.run([sys.executable, "-c", script, *arguments], text=True,
                              env=os.environ | {"NUMBA_CACHE_DIR": str(cache)},
                              cwd=Path.cwd(), capture_output=True, check=True)

    told = run(COMMAND, "compile").stdout.splitlines()
    assert len(told) == len(all_kernels()) + 2
    assert len(run(COMMAND, "compile").stdout.splitlines()) == 1

    def start(script, *arguments):
        before = {file: file.stat().st_mtime_ns for file in cache.rglob("*.code")}
        done = run(script, *arguments)
        assert "compiling" not in done.stdout + done.stderr
        assert before == {file: file.stat().st_mtime_ns for file in cache.rglob("*")
                          if file.is_file()}

    return start


def test_an_estimate_imports_no_drops_and_no_parser(clamp):
    script = ("import sys\nfrom ros_pose_stats.cli import main\nmain(sys.argv[1:])\n"
              "print(*sys.modules)")
    done = subprocess.run([sys.executable, "-c", script, "estimate", clamp, "--unit", "mm"],
                          capture_output=True, text=True, check=True)
    imported = done.stdout.splitlines()[-1].split()
    assert "ros_pose_stats.kernels.body.equilibria" in imported
    assert not {"trimesh", "networkx", "scipy.stats", "matplotlib", "mcap",
                "ros_pose_stats.kernels.drops", "ros_pose_stats.simulation.simulate"
                } & set(imported)


PREPARED = """
import sys
from ros_pose_stats.cli import main
from ros_pose_stats.kernels import compilation

prepared = set()
compilation.prepare_kernels = lambda: prepared.update(compilation._entry_kernels)
assert main(sys.argv[1:]) == 0
print(*(one.name for one in compilation._entry_kernels if one not in prepared and one.overloads))
"""


@pytest.mark.parametrize("asked", [
    ["simulate", "--drops", "10"], ["estimate"], ["estimate", "--target-error", "0.1"],
    ["estimate", "--method", "hybrid", "--drops", "10"],
], ids=" ".join)
def test_a_command_prepares_all_its_kernels_before_it_begins(asked, clamp):
    """A kernel that compiled later would not be announced, and stand still in a drop."""
    command, *options = asked
    done = subprocess.run([sys.executable, "-c", PREPARED, command, clamp, "--unit", "mm",
                           *options], capture_output=True, text=True, check=True)
    assert not done.stdout.splitlines()[-1]


@pytest.fixture(scope="module")
def clamp(tmp_path_factory):
    parts = write_demo_parts(tmp_path_factory.mktemp("parts"))
    return str(next(path for path in parts if path.stem == "clamp"))


@pytest.mark.long
class TestNothingCompiles:
    @pytest.mark.parametrize("options", [
        ["estimate"], ["estimate", "--method", "all"], ["estimate", "--target-error", "0.02"],
        ["estimate", "--method", "hybrid", "--drops", "100"], ["simulate", "--drops", "100"],
        ["simulate", "--drops", "100", "--sampling", "lattice"],
    ], ids=" ".join)
    def test_by_a_command_on_a_part(self, start, clamp, options):
        start(COMMAND, options[0], clamp, "--unit", "mm", *options[1:])

    @pytest.mark.parametrize(("command", "file"), [
        ("report", "page.html"), ("animate", "drop.gif")])
    def test_by_a_command_that_draws(self, start, clamp, tmp_path, command, file):
        start(COMMAND, command, clamp, "--unit", "mm", "--output", str(tmp_path / file))

    def test_by_a_dataset(self, start, tmp_path):
        start(COMMAND, "dataset", "--bodies", "2", "--drops", "20",
              "--output", str(tmp_path / "dataset.npz"))

    def test_by_a_recorded_drop(self, start, clamp):
        start(DROP, clamp)

    def test_by_the_node(self, start):
        start(NODE)
