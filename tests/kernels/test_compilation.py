"""Compiled and plain kernels agree; one signature each; an edit changes the cache's name."""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tempfile
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np
import pytest
from numba import types

import ros_pose_stats
from ros_pose_stats.kernels import code_cache, compilation
from ros_pose_stats.kernels.extents import bounds
from ros_pose_stats.resting.convex_body import convex_body
from ros_pose_stats.shapes import box
from tests.imports import Sources

PACKAGE = Path(ros_pose_stats.__file__).resolve().parent

ANSWERS = """
import json, sys
import numba
from ros_pose_stats import estimate_all, part_from_mesh
from ros_pose_stats.resting.convex_body import convex_body
from ros_pose_stats.resting.equilibria import equilibria
from tests.bodies import oblique_prism, random_polyhedron

found = []
for surface in (random_polyhedron(9, 5), oblique_prism(1.2, 2.0)):
    part = part_from_mesh(*surface)
    body = convex_body(part, 0)
    for statistics in estimate_all(part, cluster_tolerance=0.0):
        for pose in statistics.poses:
            found.append([pose.probability, pose.height, pose.margin, pose.top, pose.spread])
            found.append(pose.support_polygon.ravel().tolist() + pose.outline.ravel().tolist())
    # The order of equal faces is the sorting routine's own.
    for level in (0.3, 0.5, 0.7, 0.9):
        found.append(sorted(body.angles_below_r(level)))
        found.append(sorted(body.angles_below_R(level)))
    found.append([body.faces, len(equilibria(part, 0).saddles), len(equilibria(part, 0).unstable)])
json.dump([bool(numba.config.DISABLE_JIT), found], sys.stdout)
"""


def answers(**environment):
    """What a fresh process answers, and whether its kernels were plain Python."""
    done = subprocess.run([sys.executable, "-c", ANSWERS], capture_output=True, text=True,
                          cwd=PACKAGE.parent, env=os.environ | environment)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.long
def test_plain_python_gives_the_same_numbers():
    plainly, plain = answers(NUMBA_DISABLE_JIT="1")
    compiled_plainly, compiled = answers(NUMBA_DISABLE_JIT="0")
    assert (plainly, compiled_plainly) == (True, False)
    assert [len(row) for row in plain] == [len(row) for row in compiled]
    for one, other in zip(plain, compiled, strict=True):
        assert one == pytest.approx(other, rel=1e-14, abs=1e-14)


def test_the_options_keep_infinities_and_release_the_interpreter():
    assert compilation.OPTIONS["nogil"] is True
    assert "fastmath" not in compilation.OPTIONS


def load_copy(package):
    """The module `code_cache` of a copied package."""
    spec = importlib.util.spec_from_file_location(
        "copied_code_cache", package / "kernels" / "code_cache.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def copied(tmp_path):
    """A copy of the package's sources that may be edited."""
    target = tmp_path / "ros_pose_stats"
    shutil.copytree(PACKAGE, target, ignore=shutil.ignore_patterns("__pycache__"))
    return target


class TestCacheName:
    def test_a_copy_has_the_same(self, copied):
        assert load_copy(copied).source_digest() == code_cache.source_digest()

    @pytest.mark.parametrize("source", [
        "tolerances.py",
        *(str(file.relative_to(PACKAGE)) for file in sorted((PACKAGE / "kernels").rglob("*.py"))),
    ])
    def test_an_edit_of_a_kernel_or_tolerance_changes_it(self, copied, source):
        with (copied / source).open("a") as file:
            file.write("# edited\n")
        assert load_copy(copied).source_digest() != code_cache.source_digest()

    @pytest.mark.parametrize("source", ["resting/poses.py", "errors.py", "cli.py"])
    def test_an_edit_elsewhere_does_not(self, copied, source):
        with (copied / source).open("a") as file:
            file.write("# edited\n")
        assert load_copy(copied).source_digest() == code_cache.source_digest()

    def test_another_compiler_changes_it(self, copied, monkeypatch):
        here = code_cache.source_digest()
        monkeypatch.setattr(numba, "__version__", "0.0.1")
        assert load_copy(copied).source_digest() != here

    def test_every_module_that_compiles_is_covered(self):
        # Kernels import constants from `tolerances` and nothing else outside their folder.
        outside = {one.target for one in Sources(PACKAGE).internal
                   if one.importer.startswith("ros_pose_stats.kernels")
                   and not one.target.startswith("ros_pose_stats.kernels")}
        assert outside == {"ros_pose_stats.tolerances"}


class TestCacheDirectory:
    def test_is_named_after_the_digest(self, copied, tmp_path, monkeypatch):
        monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
        module = load_copy(copied)
        directory = module.cache_directory()
        assert directory == tmp_path / "cache" / "ros_pose_stats" / module.source_digest()
        assert directory.is_dir()

    def test_elsewhere_where_the_place_cannot_be_written(self, copied, tmp_path, monkeypatch):
        (tmp_path / "file").write_text("in the way")
        monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "file" / "cache"))
        monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
        monkeypatch.setenv("HOME", str(tmp_path / "file"))
        monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
        directory = load_copy(copied).cache_directory()
        assert directory.is_dir()
        assert directory.is_relative_to(tmp_path)

    def test_holds_the_outermost_kernels_after_use(self):
        part = ros_pose_stats.part_from_mesh(np.vstack((np.eye(3), np.zeros(3))),
                                             [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]])
        ros_pose_stats.estimate(part)
        stored = {file.name for file in code_cache.cache_directory().rglob("*.code")}
        for kernel in ("body.convex_body.build_body", "body.equilibria.find_equilibria"):
            assert f"ros_pose_stats.kernels.{kernel}.code" in stored


def meet(ready, find, *arguments):
    """What `find` gives, once the other thread is there too."""
    ready.wait()
    return find(*arguments)


class TestOneSignature:
    @pytest.mark.parametrize("points", [
        np.zeros((4, 3), dtype=np.float32), np.zeros((3, 4)).T, np.zeros(3), np.zeros((8, 3))[::2],
        np.broadcast_to(0.0, (4, 3)), [[0.0, 0.0, 0.0]],
    ])
    def test_other_arguments_are_refused(self, points):
        with pytest.raises(TypeError, match="No matching definition"):
            bounds(points)

    def test_what_is_only_read_may_be_read_only(self):
        """A part's own arrays are."""
        part = ros_pose_stats.part_from_mesh(*box(1.0, 2.0, 3.0))
        assert not part.surface_vertices.flags.writeable
        low, high = bounds(part.surface_vertices)
        assert (high - low).tolist() == [1.0, 2.0, 3.0]
        assert len(convex_body(part, 0).points) == 8
        written = {"outcome", "measure", "tape", "states", "turns"}
        for one in compilation.all_kernels():
            names = one.py_func.__code__.co_varnames[:one.py_func.__code__.co_argcount]
            for name, kind in zip(names, one.declared, strict=True):
                if isinstance(kind, types.Array):
                    assert kind.mutable == (name in written), (one.name, name)

    def test_every_kernel_declares_its_own(self):
        kernels = compilation.all_kernels()
        assert {"run_drops", "find_equilibria", "bounds"} <= {one.name for one in kernels}
        assert len({one.name for one in kernels}) == len(kernels)
        for one in kernels:
            assert len(one.declared) == one.py_func.__code__.co_argcount

    def test_types_that_two_threads_meet_at_once_are_those_declared(self):
        """numba numbers a type twice that two threads make at the same time."""
        before = sys.getswitchinterval()
        sys.setswitchinterval(1e-6)
        try:
            for _ in range(1000):
                class Point(NamedTuple):
                    x: float
                    y: float

                def kernel(point): ...

                kernel.__annotations__["point"] = Point
                made = compilation.EntryKernel(kernel)
                ready = threading.Barrier(2)
                with ThreadPoolExecutor(2) as threads:
                    met = threads.submit(meet, ready, numba.typeof, Point(1.0, 2.0))
                    declared = threads.submit(meet, ready, getattr, made, "declared")
                assert met.result()._code == declared.result()[0]._code
        finally:
            sys.setswitchinterval(before)


MADE = """
import sys
from ros_pose_stats.kernels.compilation import all_kernels, watch_compilations

told = []
wanted = sys.argv[1:]
with watch_compilations(told.append):
    for one in all_kernels():
        if one.name in wanted or not wanted:
            one.prepare()
            code = one.inspect_asm(one.declared)
            assert "ret" in code
            assert not any(word in code for word in ("vfmadd", "vfmsub", "vfnm", "fmla", "fmls",
                                                     "fmadd", "fmsub", "fnmadd", "fnmsub")), one
print(*told)
"""


def machine_code(folder, *names):
    """Compile kernels into an empty folder and look at their machine code."""
    done = subprocess.run([sys.executable, "-c", MADE, *names], capture_output=True, text=True,
                          cwd=PACKAGE.parent, env=os.environ | {"NUMBA_CACHE_DIR": str(folder)})
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


class TestMachineCode:
    """Every processor rounds alike: no product is fused with a sum."""

    def test_of_sums_of_products_has_no_fused_ones(self, tmp_path):
        assert sorted(machine_code(tmp_path, "sines_cosines", "matrices_of")) == [
            "matrices_of", "sines_cosines"]
        (folder,) = {file.parent.name for file in tmp_path.rglob("*.code")}
        assert folder in ("x86-64-v3", "x86-64", "generic")

    @pytest.mark.long
    def test_of_all_kernels_has_none(self, tmp_path):
        assert len(machine_code(tmp_path)) == len(compilation.all_kernels())

    @pytest.mark.long
    def test_is_found_by_a_copy_elsewhere(self, copied, tmp_path):
        environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
        script = ("import numpy as np\nfrom ros_pose_stats.kernels.extents import bounds\n"
                  "print(bounds.is_stored(), *bounds(np.eye(3))[1].tolist())")
        told = [subprocess.run([sys.executable, "-c", script], capture_output=True, text=True,
                               check=True, cwd=folder, env=environment).stdout.strip()
                for folder in (PACKAGE.parent, copied.parent)]
        assert told == ["False 1.0 1.0 1.0", "True 1.0 1.0 1.0"]


FIRST_CALLS = """
import sys, threading
sys.setswitchinterval(1e-7)
from ros_pose_stats import part_from_mesh, shapes
from ros_pose_stats.records import DropScene
from ros_pose_stats.simulation.drop_body import drop_body
from ros_pose_stats.simulation.drops import compute_drops, drop_rules
from ros_pose_stats.simulation.starts import random_starts
body = drop_body(part_from_mesh(*shapes.box(1.0, 2.0, 3.0)), 0.0025, 192)
rules, starts = drop_rules(DropScene(), body.radius), random_starts(1, 0, 3)
together, refused = threading.Barrier(12), []
def drop():
    together.wait()
    try:
        compute_drops(body, rules, starts)
    except TypeError as error:
        refused.append(error)
threads = [threading.Thread(target=drop) for _ in range(12)]
for one in threads:
    one.start()
for one in threads:
    one.join()
sys.exit(len(refused))
"""


@pytest.mark.long
def test_threads_that_make_the_first_call_together():
    """Without a lock one process in ten refuses one of its threads."""
    for _ in range(25):
        assert subprocess.run([sys.executable, "-c", FIRST_CALLS], check=False).returncode == 0
