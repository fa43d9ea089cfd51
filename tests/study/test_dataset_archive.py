"""The file of a dataset: its counts, its schema for others, and what is refused."""

from __future__ import annotations

import json
import zipfile

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ros_pose_stats import simulate
from ros_pose_stats.errors import DatasetError, RequestError
from ros_pose_stats.shapes.random_polyhedra import random_polyhedron
from ros_pose_stats.study.dataset import (
    DatasetSpec,
    make_chunk,
    make_dataset,
    on_threads,
    read_dataset,
)
from ros_pose_stats.study.dataset.archive import write_archive

SPEC = DatasetSpec(bodies=4, drops=250, restitutions=(0.2, 0.8), shift=1.0, seed=7)


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("archive") / "small.npz"
    assert make_dataset(path, SPEC, on_threads(2))
    return path


@pytest.fixture(scope="module")
def dataset(file):
    return read_dataset(file)


def altered(file, folder, **changes):
    """The same file with other arrays in it."""
    with np.load(file) as archive:
        arrays = dict(archive)
    arrays.update(changes)
    path = folder / "altered.npz"
    np.savez(path, **{name: array for name, array in arrays.items() if array is not None})
    return path


class TestWhatItHolds:
    @pytest.mark.parametrize("restitution", SPEC.restitutions)
    def test_the_counts_are_those_of_simulate(self, dataset, restitution):
        seen = dataset.simulated(restitution)
        for number in range(SPEC.bodies):
            told = simulate(dataset.part(number), SPEC.drops, restitution,
                            SPEC.drop_seed(number, restitution), SPEC.drop_height,
                            cluster_tolerance=0.0)
            counts = [pose.count for pose in sorted(told.poses, key=lambda pose: pose.index)]
            assert seen.count[seen.body == number].tolist() == counts
            assert (seen.settled[seen.body == number] == told.drops - told.unsettled).all()

    @pytest.mark.parametrize("drops", SPEC.block_ends)
    def test_the_first_drops_are_a_shorter_simulation(self, dataset, drops):
        seen = dataset.simulated(0.8, drops)
        told = simulate(dataset.part(1), drops, 0.8, SPEC.drop_seed(1, 0.8), SPEC.drop_height,
                        cluster_tolerance=0.0)
        assert seen.count[seen.body == 1].tolist() == [
            pose.count for pose in sorted(told.poses, key=lambda pose: pose.index)]

    def test_first_and_rest_are_the_whole(self, dataset):
        first, rest = dataset.simulated(0.2, 100), dataset.rest(0.2, 100)
        whole = dataset.simulated(0.2)
        assert (first.count + rest.count).tolist() == whole.count.tolist()
        assert (first.settled + rest.settled).tolist() == whole.settled.tolist()

    def test_bodies_and_poses_are_those_of_the_series(self, dataset):
        for number in range(SPEC.bodies):
            body = random_polyhedron(SPEC.seed, number, SPEC.shift, SPEC.shift_moment)
            found = dataset.polyhedron(number)
            assert np.array_equal(found.vertices, body.vertices)
            assert np.array_equal(found.triangles, body.triangles)
            assert np.array_equal(found.center_of_mass, body.center_of_mass)
            assert found.redraws == body.redraws
            assert len(dataset.resting(number).poses) == dataset.arrays["poses"][number]

    def test_a_restitution_or_a_number_of_drops_that_is_not_there(self, dataset):
        with pytest.raises(RequestError, match="restitution out of"):
            dataset.simulated(0.5)
        with pytest.raises(RequestError, match="end of a block"):
            dataset.simulated(0.2, 150)

    def test_poses_of_another_body_are_noticed(self, dataset, file, tmp_path):
        centre = dataset.arrays["center_of_mass"] * 0.9
        other = read_dataset(altered(file, tmp_path, center_of_mass=centre))
        with pytest.raises(DatasetError, match="stable poses"):
            other.resting(0)


class TestForOthers:
    def test_numpy_and_the_schema_are_enough(self, file):
        """By what the schema says alone: each stable face carries the centre of mass."""
        with np.load(file, allow_pickle=False) as archive:
            schema = json.loads(str(archive["schema"]))
            assert set(archive.files) == {"schema", *schema["fields"]}
            arrays = {name: archive[name] for name in schema["fields"]}
        spec = schema["spec"]
        sizes = {"B": spec["bodies"], "R": len(spec["restitutions"]),
                 "K": len(schema["block_ends"]), "V": arrays["vertices"].sum(),
                 "T": arrays["triangles"].sum(), "P": arrays["poses"].sum()}
        for name, field in schema["fields"].items():
            assert arrays[name].shape == tuple(sizes.get(one, one) for one in field["shape"])
            assert field["meaning"]
        ends = np.cumsum(arrays["vertices"])
        body = np.repeat(np.arange(spec["bodies"]), arrays["poses"])
        for pose, number in enumerate(body):
            vertices = arrays["vertex"][ends[number] - arrays["vertices"][number]:ends[number]]
            depths = (vertices - arrays["center_of_mass"][number]) @ arrays["down"][pose]
            assert depths.max() == pytest.approx(arrays["height"][pose], rel=1e-9)
            assert np.sort(depths)[-3] == pytest.approx(arrays["height"][pose], rel=1e-9)

    def test_the_specification_is_in_it(self, file):
        with np.load(file) as archive:
            schema = json.loads(str(archive["schema"]))
        assert schema["spec"] == {
            "bodies": 4, "drops": 250, "restitutions": [0.2, 0.8], "shift": 1.0,
            "shift_moment": "inertia", "seed": 7, "drop_height": 20.0}
        assert schema["block_ends"] == [100, 200, 250]
        assert schema["written_by"].startswith("ros_pose_stats ")


class TestPiecesOfWork:
    def test_a_piece_does_not_depend_on_its_neighbours(self, dataset):
        both, second = make_chunk(SPEC, 0, 2), make_chunk(SPEC, 1, 1)
        for name in ("vertex", "triangle", "down", "height", "count"):
            assert np.array_equal(both[name][-len(second[name]):], second[name])
            assert np.array_equal(dataset.arrays[name][:len(both[name])], both[name])

    def test_writing_twice_gives_the_same_bytes(self, file, dataset, tmp_path):
        again = tmp_path / "again.npz"
        write_archive(again, SPEC, [make_chunk(SPEC, 0, 3), make_chunk(SPEC, 3, 1)])
        assert again.read_bytes() == file.read_bytes()
        assert list(tmp_path.iterdir()) == [again]


class TestRefusedFiles:
    def refused(self, path):
        with pytest.raises(DatasetError) as refusal:
            read_dataset(path)
        assert "\n" not in str(refusal.value)
        return str(refusal.value)

    def test_no_file_and_a_directory(self, tmp_path):
        assert "No such file" in self.refused(tmp_path / "none.npz")
        assert "directory" in self.refused(tmp_path)

    def test_files_of_other_kinds(self, tmp_path):
        path = tmp_path / "other.npz"
        path.write_bytes(b"")
        self.refused(path)
        path.write_text("solid box")
        self.refused(path)
        np.savez(path, schema="[]")
        self.refused(path)
        np.savez(path, x=1)
        self.refused(path)
        np.save(tmp_path / "one.npy", np.zeros(3))
        self.refused(tmp_path / "one.npy")
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("schema.npy", "no array")
        self.refused(path)

    def test_another_version(self, file, tmp_path):
        with np.load(file) as archive:
            schema = json.loads(str(archive["schema"]))
        schema["format_version"] = 99
        said = self.refused(altered(file, tmp_path, schema=np.array(json.dumps(schema))))
        assert "of version 99" in said

    @pytest.mark.parametrize("name", ["count", "vertex", "poses", "triangle", "redraws"])
    @pytest.mark.parametrize("change", ["none", "cut", "kind", "text", "flat"])
    def test_arrays_that_do_not_fit(self, file, dataset, tmp_path, name, change):
        array = dataset.arrays[name]
        other = {"none": None, "cut": array[:-1], "kind": array.astype(np.float32),
                 "text": array.astype(str), "flat": array.reshape(1, -1)}[change]
        assert name in self.refused(altered(file, tmp_path, **{name: other}))

    def test_arrays_that_contradict_each_other(self, file, dataset, tmp_path):
        count = dataset.arrays["count"].copy()
        count[0, 0, 0] += 1
        assert "add up" in self.refused(altered(file, tmp_path, count=count))
        settled = dataset.arrays["settled"].copy()
        assert settled[0, 0, 0] == 100
        settled[0, 0, 0] += 1
        assert "more settled" in self.refused(
            altered(file, tmp_path, count=count, settled=settled))
        poses = dataset.arrays["poses"].copy()
        poses[0] += poses[-1]
        poses[-1] = 0
        assert "without poses" in self.refused(altered(file, tmp_path, poses=poses))
        triangle = dataset.arrays["triangle"].copy()
        triangle[0, 0] = 1000
        assert "without a corner" in self.refused(altered(file, tmp_path, triangle=triangle))
        centre = dataset.arrays["center_of_mass"].copy()
        centre[1, 1] = np.nan
        assert "no number" in self.refused(altered(file, tmp_path, center_of_mass=centre))

    @settings(max_examples=150)
    @given(place=st.floats(0.0, 1.0, exclude_max=True), flip=st.integers(1, 255),
           cut=st.booleans())
    def test_damage_is_refused_or_does_not_matter(self, file, dataset, tmp_path_factory, place,
                                                  flip, cut):
        content = bytearray(file.read_bytes())
        at = int(place * len(content))
        content[at] ^= flip
        path = tmp_path_factory.getbasetemp() / "damaged.npz"
        path.write_bytes(content[:at] if cut else content)
        try:
            found = read_dataset(path)
        except DatasetError:
            return
        assert found.spec == SPEC
        assert all(np.array_equal(found.arrays[name], array)
                   for name, array in dataset.arrays.items())
