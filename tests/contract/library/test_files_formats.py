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

"""Mesh files of every format: the mesh as it stands there, scenes put in place, damage
refused.
"""

import os
import socket
import struct
import zipfile
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from ros_pose_stats import PoseStatsError, load_part
from tests.answers import acting_codes
from tests.running import refusal, refusal_of

KINDS = {
    "binary STL": ("a.stl", {}),
    "STL in capitals": ("a.STL", {}),
    "ASCII STL": ("a.stl", {"file_type": "stl_ascii"}),
    "OBJ": ("a.obj", {}),
    "PLY": ("a.ply", {}),
    "ASCII PLY": ("a.ply", {"encoding": "ascii"}),
    "OFF": ("a.off", {}),
    "3MF": ("a.3mf", {}),
}
refused = partial(refusal_of, load_part)
every_kind = pytest.mark.parametrize("kind", KINDS)


@pytest.fixture
def block():
    return trimesh.creation.box((10.0, 20.0, 30.0))


def written(mesh, folder, kind):
    name, options = KINDS[kind]
    mesh.export(folder / name, **options)
    return folder / name


@every_kind
def test_every_format_gives_the_mesh_back(tmp_path, block, kind):
    path = written(block, tmp_path, kind)
    part = load_part(path, "mm")
    expected = block.vertices[block.faces].reshape(-1, 9) * 1e-3
    gap, partner = cKDTree(part.vertices[part.triangles].reshape(-1, 9)).query(expected)
    assert len(part.triangles) == len(np.unique(partner)) == 12 and gap.max() < 1e-8
    assert len(part.surface_vertices) == 8
    assert (part.part_id, part.warnings) == ("a", ())


@pytest.mark.parametrize(
    "suffix", ["obj", pytest.param("3mf", marks=pytest.mark.long), "stl", "ply"]
)
def test_the_objects_of_a_scene_are_put_in_place(tmp_path, block, suffix):
    scene = trimesh.Scene()
    path = tmp_path / f"two.{suffix}"
    scene.add_geometry(block, node_name="one", geom_name="block")
    move = trimesh.transformations.translation_matrix((100, 0, 0))
    scene.add_geometry(block, node_name="two", geom_name="block", transform=move)
    (scene if suffix in ("obj", "3mf") else scene.to_mesh()).export(path)
    part = load_part(path, "mm", body="all")
    assert len(part.triangles) == 24
    assert np.ptp(part.surface_vertices, axis=0) == pytest.approx([0.11, 0.02, 0.03])
    assert part.center_of_mass == pytest.approx([0.05, 0, 0], abs=1e-9)


@pytest.mark.long
def test_a_mirrored_object_is_turned_back(tmp_path, block):
    scene = trimesh.Scene()
    scene.add_geometry(block, transform=np.diag([-1.0, 1.0, 1.0, 1.0]))
    scene.export(tmp_path / "mirrored.3mf")
    part = load_part(tmp_path / "mirrored.3mf")
    assert trimesh.Trimesh(part.vertices, part.triangles).volume == pytest.approx(6e-6)


TETRAHEDRON = (
    "<mesh><vertices>"
    + "".join(
        f'<vertex x="{x}" y="{y}" z="{z}"/>'
        for x, y, z in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))
    )
    + "</vertices><triangles>"
    + "".join(
        f'<triangle v1="{a}" v2="{b}" v3="{c}"/>'
        for a, b, c in ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
    )
    + "</triangles></mesh>"
)


def archive_of(folder, objects, build, root="3D/3dmodel.model", **files):
    """A 3MF file in metres; `files`: others beside the model in `root`."""
    path = folder / "model.3mf"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
        archive.writestr(
            root,
            f'<model unit="meter"><resources>{objects}</resources>'
            f"<build>{build}</build></model>",
        )
    return path


def model_of(folder, objects, built):
    """A 3MF file of a tetrahedron, other objects (number: components), and one that is
    built.
    """
    inside = "".join(
        f'<object id="{number}"><components>{components}</components></object>'
        for number, components in objects.items()
    )
    return archive_of(
        folder,
        f'<object id="1">{TETRAHEDRON}</object>{inside}',
        f'<item objectid="{built}"/>',
    )


def placed(number, x=0):
    return f'<component objectid="{number}" transform="1 0 0 0 1 0 0 0 1 {x} 0 0"/>'


def test_components_in_components_are_all_in_their_places(tmp_path):
    """Each object is twice the one before, so far apart that all lie in a row."""
    doubles = {k + 2: placed(k + 1) + placed(k + 1, 2 ** (k + 1)) for k in range(10)}
    part = load_part(model_of(tmp_path, doubles, 11), body="all")
    assert len(part.triangles) == 4 * 2**10
    corners = part.vertices[part.triangles].reshape(-1, 12, 3)[:, :, 0].min(axis=1)
    assert sorted(corners) == [2.0 * k for k in range(2**10)]


@pytest.mark.parametrize("kind", ["support", "solidsupport", "other"])
def test_what_a_printer_makes_beside_the_model_is_not_the_part(tmp_path, kind):
    objects = (
        f'<object id="1" type="model">{TETRAHEDRON}</object>'
        f'<object id="2" type="{kind}">{TETRAHEDRON}</object>'
        f'<object id="3"><components>{placed(1)}{placed(2, 1)}</components></object>'
    )
    beside = '<item objectid="2" transform="1 0 0 0 1 0 0 0 1 .5 0 0"/>'
    path = archive_of(tmp_path, objects, '<item objectid="3"/>' + beside)
    assert len(load_part(path).triangles) == 4
    message = refused(archive_of(tmp_path, objects, beside))
    assert "a model in its build" in message
    assert "only objects that are none" in message


def test_an_empty_build_is_said_as_it_is(tmp_path):
    path = archive_of(tmp_path, f'<object id="1">{TETRAHEDRON}</object>', "")
    assert "an empty build" in refused(path)


def test_the_model_lies_where_the_relationships_say(tmp_path):
    relationship = (
        '<Relationships><Relationship Target="/3D/{}" Id="r" Type="http://schemas.'
        'microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
    )
    build = '<item objectid="1"/>'
    objects = f'<object id="1">{TETRAHEDRON}</object>'
    for decoy in ({}, {"3D/3dmodel.model": "<model/>"}):
        files = {"_rels/.rels": relationship.format("part.model"), **decoy}
        path = archive_of(tmp_path, objects, build, "3D/part.model", **files)
        assert len(load_part(path).triangles) == 4
    assert "a model in it" in refused(
        archive_of(tmp_path, objects, build, "3D/part.model")
    )


@pytest.mark.parametrize(
    ("objects", "words"),
    [
        (
            {k + 2: placed(k + 1) * 1000 for k in range(5)},
            "at most 100000 placed objects",
        ),
        pytest.param(
            {k + 2: placed(k + 1) for k in range(3000)},
            "at most 100 objects in each other",
            marks=pytest.mark.long,
        ),
        pytest.param({2: placed(3)}, "one that is not", marks=pytest.mark.long),
    ],
)
def test_a_small_file_that_stands_for_far_too_much_is_refused(tmp_path, objects, words):
    assert words in refused(model_of(tmp_path, objects, max(objects)))


def test_an_ascii_stl_of_several_solids_is_one_part_and_none_of_them_may_be_cut(
    tmp_path, block
):
    moved_block = block.copy()
    path = tmp_path / "two.stl"
    moved_block.apply_translation((100, 0, 0))
    first, second = (
        mesh.export(file_type="stl_ascii") for mesh in (block, moved_block)
    )
    path.write_text(first + "\n" + second)
    assert len(load_part(path, "mm", body="all").triangles) == 24
    path.write_text(first + "\n" + second[: len(second) // 2])
    with pytest.raises(
        PoseStatsError, match=r"as it announces, got .*two.stl \(18 .* cut off"
    ):
        load_part(path)


def test_obj_materials_and_polygons_neither_split_nor_reorder(tmp_path):
    path = tmp_path / "cube.obj"
    path.write_text(
        "mtllib x.mtl\no cube\n"
        + "".join(f"v {x} {y} {z}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1))
        + "usemtl red\nf 1 2 4 3\nf 5 7 8 6\n"
        + "g side\nusemtl blue\nf 1 5 6 2\nf 3 4 8 7\n"
        + "f 1 3 7 5\nf 2 6 8 4\n"
    )
    part = load_part(path, "m")
    assert (part.vertices.shape, part.triangles.shape) == ((8, 3), (12, 3))
    assert part.center_of_mass == pytest.approx([0.5, 0.5, 0.5])


def test_obj_faces_that_count_back_do_so_from_their_own_line(tmp_path, block):
    """Two objects, whose second numbers are those of the first, and end in texture
    corners.
    """
    moved = block.copy()
    back = []
    path = tmp_path / "two.obj"
    moved.apply_translation((100.0, 0.0, 0.0))
    for mesh in (block, moved):
        back += [f"v {x} {y} {z}" for x, y, z in mesh.vertices]
        back += [
            "f " + " ".join(f"{corner - 8}/1" for corner in face) for face in mesh.faces
        ]
    path.write_text("vt 0 0\n" + "\n".join(back))
    part = load_part(path, "mm", body="all")
    assert np.ptp(part.surface_vertices, axis=0) == pytest.approx([0.11, 0.02, 0.03])
    assert acting_codes(part) == []


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.stl", b"", "which is empty"),
        ("a.igs", b"x", "expected a mesh file (.stl, .obj"),
        ("a", b"x", "expected a mesh file (.stl, .obj"),
        ("a.stl", b"not a mesh at all", "expected triangles in"),
        ("a.stl", b"\x00" * 83, "of the length that its header announces"),
        ("a.stl", b"\x00" * 80 + b"\x10\x00\x00\x00" + b"\x01" * 90, "of 174 bytes"),
        ("a.stl", b"\x00" * 84, "expected triangles in"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", "expected triangles in"),
        ("a.obj", b"hello", "a.obj"),
        ("a.obj", b"v 1 2\nv 1 2 3\nv 0 0 0\nf 1 2 3\n", "readable OBJ file"),
        ("a.obj", b"v 1 2 3\nf -1 -2 -3\n", "readable OBJ file"),
        ("a.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n", "readable OFF file"),
        ("a.ply", b"hello", "readable PLY file"),
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 9\n", "no header"),
        ("a.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 9\n", "triangles between"),
        ("a.obj", b"v 1 2 3\nv root:x:0 0 0\n", "(line 2)"),
        pytest.param(
            "a.3mf", b"PK\x03\x04broken", "readable 3MF file", marks=pytest.mark.long
        ),
    ],
)
def test_what_is_no_mesh_is_refused_in_one_line(tmp_path, name, content, message):
    (tmp_path / name).write_bytes(content)
    assert message in refused(tmp_path / name)
    assert message in refusal("estimate", tmp_path / name)


@every_kind
def test_a_file_cut_off_is_refused(tmp_path, block, kind):
    path = written(block, tmp_path, kind)
    data = path.read_bytes()
    for share in (0.5,) if kind == "3MF" else (0.1, 0.5, 0.9):  # one process a 3MF file
        cut = data[: int(share * len(data))]
        if kind == "OBJ":  # nothing in one says how long it is: cut inside a face line
            cut = cut.rpartition(b"\n")[0] + b"\nf 1 2"
        path.write_bytes(cut)
        refused(path)


def test_no_file_at_all_is_refused(tmp_path):
    assert "No such file" in refused(tmp_path / "missing.stl")
    (tmp_path / "folder.stl").mkdir()
    assert "Is a directory" in refused(tmp_path / "folder.stl")
    for name in ("\0.stl", "\ud83d.stl", 300 * "a" + ".stl"):
        assert "readable mesh file" in refused(tmp_path / name)
    assert "the path of a mesh file" in refused(np.zeros(3))


@pytest.mark.parametrize(
    ("make", "kind"),
    [
        (os.mkfifo, "a pipe"),
        (lambda path: path.symlink_to(os.devnull), "a device"),
        (lambda path: socket.socket(socket.AF_UNIX).bind(str(path)), "a socket"),
    ],
)
def test_what_may_never_end_is_refused(tmp_path, monkeypatch, make, kind):
    """Reading a pipe waits for whoever writes to it."""
    monkeypatch.chdir(tmp_path)  # the name of a socket has to be short
    make(Path("a.stl"))
    assert f"got a.stl, which is {kind}" in refused("a.stl")


def test_a_file_without_bound_is_refused_unread(tmp_path):
    path = tmp_path / "a.stl"
    path.touch()
    os.truncate(path, 2**40)
    assert "at most 536.9 MB" in refused(path)


def test_a_binary_stl_of_more_than_the_arrays_may_take_is_refused(tmp_path):
    """Its arrays take nearly twice what the file does."""
    count = 6_000_000
    path = tmp_path / "a.stl"
    path.write_bytes(bytes(80) + struct.pack("<I", count))
    os.truncate(path, 84 + 50 * count)
    assert "at most 536.9 MB in memory" in refused(path)


def test_a_table_of_far_more_rows_than_there_are_is_no_matter_of_memory(tmp_path):
    path = tmp_path / "a.ply"
    path.write_bytes(
        b"ply\nformat binary_little_endian 1.0\nelement other 99999999999\n"
        b"property list uchar int values\nend_header\n" + bytes(500)
    )
    assert "fewer or other values than its header announces" in refused(path)


def test_a_transform_out_of_range_is_refused_in_one_line(tmp_path):
    """Without the warnings of what multiplies it."""
    path = archive_of(
        tmp_path,
        f'<object id="1">{TETRAHEDRON}</object>',
        '<item objectid="1" transform="1e308 0 0 0 1e308 0 0 0 1e308 1e308 0 0"/>',
    )
    assert "finite vertices" in refused(path)


@pytest.mark.parametrize("suffix", ["obj", "ply", "off", "stl", "3mf"])
def test_no_refusal_quotes_a_file(tmp_path, suffix):
    """Whoever may name a file need not be allowed to read it."""
    path = tmp_path / f"a.{suffix}"
    path.write_text("root:x:0:0:secret\nv secret 1 2\nf secret\nOFF secret\n")
    assert "secret" not in refused(path)


def test_ply_colours_quads_and_other_elements_are_passed_over(tmp_path):
    """In words and in bytes; `float` rounds the words too."""
    corners = [(x, y, z) for x in (0.1, 1) for y in (0, 1) for z in (0, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4)]
    header = (
        "ply\nformat {} 1.0\ncomment TextureFile none.png\nelement vertex 8\n"
        "property float x\nproperty float y\nproperty float z\nproperty uchar red\n"
        "element edge 1\nproperty int vertex1\n"
        "element face 6\nproperty list uchar int vertex_indices\n"
        "property list uchar float texcoord\nend_header\n"
    )
    rows = [(*corner, 7) for corner in corners]
    polygons = [*faces, (1, 5, 7, 3)]
    text = "".join(f"{x} {y} {z} {red}\n" for x, y, z, red in rows) + "5\n"
    text += "".join(f"4 {' '.join(map(str, face))} 1 0.5\n" for face in polygons)
    data = b"".join(struct.pack(">fffB", *row) for row in rows) + struct.pack(">i", 5)
    data += b"".join(struct.pack(">B4iBf", 4, *face, 1, 0.5) for face in polygons)
    (tmp_path / "text.ply").write_text(header.format("ascii") + text)
    (tmp_path / "bytes.ply").write_bytes(
        header.format("binary_big_endian").encode() + data
    )
    parts = [load_part(tmp_path / name, "m") for name in ("text.ply", "bytes.ply")]
    assert parts[0].digest == parts[1].digest
    assert (len(parts[0].vertices), len(parts[0].triangles)) == (8, 12)
    assert parts[0].center_of_mass == pytest.approx([0.55, 0.5, 0.5])


def test_an_obj_line_may_go_on_in_the_next_one(tmp_path, block):
    path = written(block, tmp_path, "OBJ")
    digest = load_part(path).digest
    text = path.read_text()
    path.write_bytes(text.replace("f ", "f \\\n").replace("\n", "\r\n").encode())
    assert load_part(path).digest == digest


def test_bytes_after_the_end_and_names_in_any_encoding_do_no_harm(tmp_path, block):
    path = written(block, tmp_path, "binary STL")
    digest = load_part(path).digest
    path.write_bytes(path.read_bytes() + b"\n trailing")
    assert load_part(path).digest == digest
    text = block.export(file_type="stl_ascii").replace("solid", "solid Gehäuse", 1)
    for encoding in ("utf-8", "latin-1"):
        path.write_bytes(text.encode(encoding))
        assert len(load_part(path).triangles) == 12
