"""`fit`: from tables and bags to a file of plates, and refusals."""

from __future__ import annotations

import json
from array import array

import pytest
from ros_pose_stats_msgs.msg import PartMesh

from ros_pose_stats import cli, load_part, shapes, simulate
from ros_pose_stats.plates import fit, read_profiles
from tests.bodies import write_stl
from tests.recording.analysis.bags import write_run
from tests.recording.analysis.messages import counts

SIZES = {"slab": (20.0, 30.0, 12.0), "die": (10.0, 10.0, 7.5)}


@pytest.fixture(autouse=True)
def coarse(monkeypatch):
    """Fewer scenes and drops than usual."""
    for name, value in (("FIRST_POINTS", 32), ("FIRST_DROPS", 60), ("ROUNDS", 1), ("POINTS", 12),
                        ("GRID", 20), ("FINER", 10)):
        monkeypatch.setattr(fit, name, value)


@pytest.fixture(scope="module")
def parts(tmp_path_factory):
    folder = tmp_path_factory.mktemp("parts")
    for name, size in SIZES.items():
        write_stl(folder / f"{name}.stl", shapes.box(*size))
    return {name: load_part(folder / f"{name}.stl", unit="mm") for name in SIZES}, folder


@pytest.fixture(scope="module")
def table(parts):
    known, folder = parts
    rows = ["part,pose,count"]
    for name, part in known.items():
        rows += [f"{name}.stl,{pose.index},{pose.count}"
                 for pose in simulate(part, 300, 0.4, 9, 0.05).poses]
    (folder / "counts.csv").write_text("\n".join(rows))
    return folder / "counts.csv"


def run(capsys, *arguments):
    status = cli.main(["fit", *map(str, arguments)])
    return status, *capsys.readouterr()


def test_a_table(table, tmp_path, capsys):
    file = tmp_path / "plates.yaml"
    options = table, "--unit", "mm", "--plates", file
    status, out, _ = run(capsys, *options, "--plate", "glass", "--json")
    found = json.loads(out)
    assert status == 0 and found["plate"] == "glass" and found["counted"] == 600
    assert found["parts"] == ["slab", "die"] and found["file"] == str(file)
    written = read_profiles(file)["glass"]
    assert {key: found[key] for key in written.as_dict()} == written.as_dict()
    slab = found["evidence"][0]
    assert [len(group["poses"]) for group in slab["groups"]] == [2, 2, 2]
    assert sum(group["observed"] for group in slab["groups"]) == pytest.approx(1.0)
    status, out, _ = run(capsys, *options, "--plate", "steel")
    assert status == 0 and list(read_profiles(file)) == ["glass", "steel"]
    assert read_profiles(file)["glass"] == written
    assert out.splitlines()[0] == "plate steel, from 600 counts of 2 parts"
    assert f"wrote {file}" in out


def test_a_bag(parts, tmp_path, capsys):
    messages = []
    for second, (name, part) in enumerate(parts[0].items()):
        messages.append(("part_mesh", PartMesh(
            part_id=name, vertices=array("d", part.vertices.ravel().tolist()),
            triangles=array("I", part.triangles.ravel().tolist()))))
        drops = simulate(part, 300, 0.4, 9, 0.05)
        told = sorted(drops.poses, key=lambda pose: pose.index)
        about = {"part_id": name, "part_digest": part.digest, "cluster_tolerance": 0.0025}
        messages += [
            ("pose_counts", counts(2.0 * second, [pose.count for pose in told], plate="glass",
                                   **about)),
            ("pose_counts", counts(2.0 * second + 1, [0, 0, 0, 0, 0, 999], plate="other",
                                   **about))]
    messages.append(("pose_counts", counts(9.0, (5, 5), part_id="lost", plate="glass",
                                           part_digest="0" * 64)))
    bag = write_run(tmp_path / "log", messages)
    status, out, err = run(capsys, bag, "--plate", "glass", "--plates", tmp_path / "p.yaml",
                           "--json")
    found = json.loads(out)
    assert status == 0 and found["counted"] == 600 and found["parts"] == ["slab", "die"]
    assert found["notes"] == ["10 counts of lost left out: its mesh is not in the bags"]
    assert "its mesh is not in the bags" in err
    status, out, err = run(capsys, bag, "--plate", "steel", "--plates", tmp_path / "p.yaml")
    assert (status, out) == (2, "") and "got those of glass and other" in err


@pytest.mark.parametrize(("rows", "words"), [
    ("slab.stl,0,20\ndie.stl,0,20", "at least 50 counted parts, got 40"),
    ("die.stl,0,500", "count another part"), ("slab.stl,17,500", "poses 0 to 5"),
    ("missing.stl,0,500", "missing.stl"), ("slab.stl,0", "line 1"),
])
def test_refusals(parts, tmp_path, capsys, rows, words):
    table = parts[1] / "bad.csv"
    table.write_text(rows)
    file = tmp_path / "plates.yaml"
    status, out, err = run(capsys, table, "--unit", "mm", "--plate", "x", "--plates", file)
    assert (status, out) == (2, "") and words in err and len(err.splitlines()) == 1
    assert not file.exists()


def test_the_file_of_plates_is_looked_at_first(table, tmp_path, capsys):
    file = tmp_path / "plates.yaml"
    file.write_text("other: 1\n")
    status, _, err = run(capsys, table, "--plate", "x", "--plates", file)
    assert status == 2 and "--plates" in err and file.read_text() == "other: 1\n"
    assert run(capsys, table, "--plate", "", "--plates", file)[0] == 2
