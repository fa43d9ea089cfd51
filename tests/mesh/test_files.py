"""Mesh files: every format, scenes, units and damaged files."""

from __future__ import annotations

import os
import socket
import zipfile
from pathlib import Path

import numpy as np
import pytest
import trimesh

from ros_pose_stats.errors import MeshFileError
from ros_pose_stats.mesh.files import read_mesh
from ros_pose_stats.mesh.parts import load_part

EXTENTS = (10.0, 20.0, 30.0)


def written(mesh, path, **options):
    mesh.export(path, **options)
    return path


def corners(vertices, triangles):
    return np.sort(np.round(vertices[triangles].reshape(-1, 9), 5), axis=0)


@pytest.fixture
def block():
    return trimesh.creation.box(EXTENTS)


@pytest.mark.parametrize(("name", "options"), [
    ("a.stl", {}), ("a.STL", {}), ("a.stl", {"file_type": "stl_ascii"}), ("a.obj", {}),
    ("a.ply", {}), ("a.ply", {"encoding": "ascii"}), ("a.off", {}), ("a.3mf", {}),
])
def test_every_format_gives_the_mesh_back(tmp_path, block, name, options):
    vertices, triangles, unit = read_mesh(written(block, tmp_path / name, **options))[:3]
    assert np.array_equal(corners(vertices, triangles), corners(block.vertices, block.faces))
    assert unit == (1e-3 if name.endswith("3mf") else 1.0)
    assert read_mesh(tmp_path / name, "inch").unit == 0.0254
    part = load_part(tmp_path / name, "mm")
    assert part.part_id == "a"
    assert part.warnings == ()
    assert np.ptp(part.surface_vertices, axis=0) == pytest.approx([0.01, 0.02, 0.03])
    assert len(part.surface_vertices) == 8


@pytest.mark.parametrize(("unit", "metres"), [
    ("micron", 1e-6), ("millimeter", 1e-3), ("centimeter", 1e-2), ("inch", 0.0254),
    ("foot", 0.3048), ("meter", 1.0), (None, 1e-3),
])
def test_a_3mf_declares_its_unit(tmp_path, block, unit, metres):
    source = written(block, tmp_path / "source.3mf")
    target = tmp_path / "target.3mf"
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w") as new:
        for name in old.namelist():
            text = old.read(name)
            if name.lower().endswith("3dmodel.model"):
                assert text.count(b'unit="millimeter"') == 1
                attribute = b"" if unit is None else f'unit="{unit}"'.encode()
                text = text.replace(b'unit="millimeter"', attribute)
            new.writestr(name, text)
    assert read_mesh(target)[2] == metres
    assert np.ptp(load_part(target).vertices[:, 2]) == pytest.approx(30.0 * metres)
    assert np.ptp(load_part(target, "cm").vertices[:, 2]) == pytest.approx(0.3)


@pytest.mark.parametrize("suffix", ["obj", "3mf", "stl", "ply"])
def test_the_objects_of_a_scene_are_put_in_place(tmp_path, block, suffix):
    scene = trimesh.Scene()
    scene.add_geometry(block, node_name="one", geom_name="block")
    move = trimesh.transformations.translation_matrix((100, 0, 0))
    scene.add_geometry(block, node_name="two", geom_name="block", transform=move)
    path = tmp_path / f"two.{suffix}"
    (scene if suffix in ("obj", "3mf") else scene.to_mesh()).export(path)
    vertices, triangles, _ = read_mesh(path)[:3]
    assert len(triangles) == 24
    assert np.ptp(vertices[triangles.ravel()], axis=0) == pytest.approx([110, 20, 30])
    part = load_part(path, "mm")
    assert part.center_of_mass == pytest.approx([0.05, 0, 0], abs=1e-9)


def test_an_ascii_stl_of_several_solids_is_one_mesh(tmp_path, block):
    other = block.copy()
    other.apply_translation((100, 0, 0))
    text = "\n".join(m.export(file_type="stl_ascii") for m in (block, other))
    path = tmp_path / "two.stl"
    path.write_text(text)
    assert len(read_mesh(path)[1]) == 24


def test_obj_materials_and_polygons_neither_split_nor_reorder(tmp_path):
    path = tmp_path / "cube.obj"
    path.write_text("mtllib x.mtl\no cube\n" + "".join(
        f"v {x} {y} {z}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1))
        + "usemtl red\nf 1 2 4 3\nf 5 7 8 6\ng side\nusemtl blue\nf 1 5 6 2\nf 3 4 8 7\n"
        + "f 1 3 7 5\nf 2 6 8 4\n")
    vertices, triangles, _ = read_mesh(path)[:3]
    assert vertices.shape == (8, 3)
    assert triangles.shape == (12, 3)
    assert load_part(path).center_of_mass == pytest.approx([0.5, 0.5, 0.5])


def test_a_mirrored_object_is_turned_back(tmp_path, block):
    scene = trimesh.Scene()
    scene.add_geometry(block, transform=np.diag([-1.0, 1.0, 1.0, 1.0]))
    path = tmp_path / "mirrored.3mf"
    scene.export(path)
    vertices, triangles, _ = read_mesh(path)[:3]
    assert trimesh.Trimesh(vertices, triangles).volume == pytest.approx(6000.0)


@pytest.mark.parametrize(("name", "content", "message"), [
    ("a.stl", b"", "which is empty"),
    ("a.igs", b"x", "expected a mesh file (.stl, .obj"),
    ("a", b"x", "expected a mesh file (.stl, .obj"),
    ("a.stl", b"not a mesh at all", "expected triangles in"),
    ("a.stl", b"\x00" * 83, "of the length that its header announces"),
    ("a.stl", b"\x00" * 80 + b"\x10\x00\x00\x00" + b"\x01" * 90, "of 174 bytes"),
    ("a.stl", b"\x00" * 84, "expected triangles in"),
    ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", "expected triangles in"),
    ("a.obj", b"hello", "a.obj"),
    ("a.off", b"hello", "readable OFF file"),
    ("a.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n", "readable OFF file"),
    ("a.ply", b"hello", "readable PLY file"),
    ("a.3mf", b"hello", "readable 3MF file"),
    ("a.3mf", b"PK\x03\x04broken", "readable 3MF file"),
])
def test_damaged_files_are_refused_in_one_line(tmp_path, name, content, message):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(MeshFileError) as refusal:
        read_mesh(path)
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(("name", "options"), [
    ("a.stl", {}), ("a.stl", {"file_type": "stl_ascii"}), ("a.obj", {}), ("a.ply", {}),
    ("a.ply", {"encoding": "ascii"}), ("a.off", {}), ("a.3mf", {}),
])
def test_a_file_cut_off_is_refused(tmp_path, block, name, options):
    data = written(block, tmp_path / name, **options).read_bytes()
    lines = data.splitlines(keepends=True)
    for share in (0.1, 0.5, 0.9):
        if name == "a.obj":  # nothing in an OBJ says how long it is: cut inside a face line
            faces = [k for k, line in enumerate(lines) if line.startswith(b"f ")]
            cut = b"".join(lines[:faces[int(share * len(faces))]]) + b"f 1 2"
        else:
            cut = data[:int(share * len(data))]
        (tmp_path / name).write_bytes(cut)
        with pytest.raises(MeshFileError):
            read_mesh(tmp_path / name)


def test_the_last_solid_of_an_ascii_stl_cut_off_is_noticed(tmp_path, block):
    text = block.export(file_type="stl_ascii")
    path = tmp_path / "two.stl"
    path.write_text(text + "\n" + text[:len(text) // 2])
    with pytest.raises(MeshFileError, match=r"expected 1[89] faces as .* announces, got 12"):
        read_mesh(path)


def test_a_missing_file_and_a_directory_are_refused(tmp_path):
    with pytest.raises(MeshFileError, match="No such file"):
        read_mesh(tmp_path / "missing.stl")
    (tmp_path / "folder.stl").mkdir()
    with pytest.raises(MeshFileError, match="got the directory"):
        read_mesh(tmp_path / "folder.stl")


@pytest.mark.parametrize(("make", "kind"), [
    (os.mkfifo, "a pipe"), (lambda path: path.symlink_to(os.devnull), "a device"),
    (lambda path: socket.socket(socket.AF_UNIX).bind(str(path)), "a socket")])
def test_what_may_never_end_is_refused(tmp_path, monkeypatch, make, kind):
    """Reading a pipe waits for whoever writes to it."""
    monkeypatch.chdir(tmp_path)  # the name of a socket has to be short
    make(Path("a.stl"))
    with pytest.raises(MeshFileError, match=f"got a.stl, which is {kind}"):
        read_mesh("a.stl")
