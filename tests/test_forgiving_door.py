"""Inputs that are unusual but mean something plain, and others that get one clear error."""

import copy
import os
import pickle
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ros_pose_stats import estimate, load_part, part_from_mesh, resting_poses
from ros_pose_stats.errors import MeshFileError, RequestError
from ros_pose_stats.kernels.code_cache import cache_directory
from ros_pose_stats.shapes import box
from ros_pose_stats.shapes.demo_parts import write_demo_parts


@pytest.fixture(scope="module")
def clamp(tmp_path_factory):
    return next(path for path in write_demo_parts(tmp_path_factory.mktemp("parts"))
                if path.stem == "clamp")


def ascii_stl(name: bytes) -> bytes:
    vertices, triangles = box(0.01, 0.02, 0.03)
    lines = [b"solid " + name]
    for triangle in triangles:
        lines += [b"facet normal 0 0 0", b"outer loop"]
        lines += [f"vertex {x:.9g} {y:.9g} {z:.9g}".encode() for x, y, z in vertices[triangle]]
        lines += [b"endloop", b"endfacet"]
    return b"\n".join([*lines, b"endsolid " + name, b""])


def test_a_tail_after_a_binary_stl_is_left_out(clamp, tmp_path):
    longer = tmp_path / "clamp.stl"
    longer.write_bytes(clamp.read_bytes() + b"\n trailing")
    assert load_part(longer, "mm").digest == load_part(clamp, "mm").digest


def test_a_cut_binary_stl_is_refused_by_its_length(clamp, tmp_path):
    shorter = tmp_path / "clamp.stl"
    shorter.write_bytes(clamp.read_bytes()[:-7])
    with pytest.raises(MeshFileError, match="968 triangles take 48484"):
        load_part(shorter, "mm")


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
def test_names_in_a_national_encoding(tmp_path, encoding):
    path = tmp_path / "part.stl"
    path.write_bytes(ascii_stl("Gehäuse für Klemme".encode(encoding)))
    assert len(load_part(path).triangles) == 12


def test_a_directory_is_no_mesh_file(tmp_path):
    with pytest.raises(MeshFileError, match="got the directory"):
        load_part(tmp_path)


@pytest.mark.parametrize("file", [None, 3, np.zeros(3)])
def test_a_file_must_be_a_path(file):
    with pytest.raises(MeshFileError, match="the path of a mesh file"):
        load_part(file)


@pytest.mark.parametrize("inertia", [np.eye(3), np.diag([41.7, 83.3, 108.3])])
def test_an_inertia_in_other_units_is_pointed_out(inertia):
    part = part_from_mesh(*box(0.03, 0.02, 0.01), mass=1.0, inertia=inertia)
    assert any(line.startswith("INERTIA_SUSPECT: ") for line in part.warnings)
    assert np.array_equal(part.inertia, inertia)


def test_the_largest_possible_inertia_is_not():
    # Point masses at the ends of the longest diagonal.
    part = part_from_mesh(*box(0.03, 0.02, 0.01))
    end = part.surface_vertices[np.argmax((part.surface_vertices**2).sum(axis=1))]
    inertia = end @ end * np.eye(3) - np.outer(end, end) + 1e-9 * np.eye(3)
    given = part_from_mesh(*box(0.03, 0.02, 0.01), mass=1.0, inertia=0.99 * inertia)
    assert not any("INERTIA" in line for line in given.warnings)


@pytest.mark.parametrize("options", [
    {"restitution": "hard"}, {"restitution": None}, {"restitution": True},
    {"drop_height": [1.0]}, {"cluster_tolerance": "0.1"}, {"cluster_tolerance": -1.0},
    {"cluster_tolerance": float("nan")},
])
def test_options_that_are_no_number_in_range(options):
    part = part_from_mesh(*box(1.0, 2.0, 3.0))
    with pytest.raises(RequestError):
        estimate(part, **options)


@pytest.mark.parametrize("part", [None, "clamp.stl", box(1.0, 1.0, 1.0)])
def test_what_is_estimated_must_be_a_part(part):
    with pytest.raises(RequestError, match="expected a Part"):
        estimate(part)


@pytest.mark.parametrize("tolerance", [-1.0, float("nan"), 5.0])
def test_resting_poses_checks_its_tolerance(tolerance):
    with pytest.raises(RequestError, match="cluster tolerance"):
        resting_poses(part_from_mesh(*box(1.0, 2.0, 3.0)), tolerance)


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda part: pickle.loads(pickle.dumps(part))],
                         ids=["deepcopy", "pickle"])
def test_a_copy_is_as_read_only_as_the_part(copied):
    part = part_from_mesh(*box(1.0, 2.0, 3.0))
    other = copied(part)
    assert other.digest == part.digest
    with pytest.raises(ValueError, match="read-only"):
        other.vertices[0] = 0.0


def run(clamp: Path, cache: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "ros_pose_stats", "estimate", str(clamp), "--unit", "mm",
         "--method", "csae"], env=os.environ | {"NUMBA_CACHE_DIR": str(cache)},
        capture_output=True, text=True, check=False)


@pytest.mark.long
def test_a_damaged_kernel_cache_costs_time_only(clamp, tmp_path):
    """One kernel is cut short, another altered, in a copy; all parts need both."""
    estimate(part_from_mesh(*box(1.0, 2.0, 3.0)), "csae")  # fills the cache
    known = cache_directory()
    copied = tmp_path / "ros_pose_stats" / known.name
    shutil.copytree(known, copied)
    (cut,) = copied.rglob("*.extents.bounds.code")
    (altered,) = copied.rglob("*.extents.thinness.code")
    sound = [cut.read_bytes(), altered.read_bytes()]
    cut.write_bytes(sound[0][:40])
    altered.write_bytes(sound[1][:-1] + bytes([sound[1][-1] ^ 1]))
    again = run(clamp, tmp_path)
    assert again.returncode == 0, again.stderr
    assert again.stdout.splitlines()[:-1] == run(clamp, known.parents[1]).stdout.splitlines()[:-1]
    assert "cannot be read" in again.stderr
    assert "cannot be read" not in run(clamp, tmp_path).stderr
