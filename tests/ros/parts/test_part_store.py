"""The parts that the node knows, built once and recorded once; without a node."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros_pose_stats.errors import MeshError, PoseStatsError, RequestError
from ros_pose_stats.ros.parts import part_store
from ros_pose_stats.ros.parts.part_requests import PartRequest
from ros_pose_stats.ros.parts.part_store import KnownPart, PartStore

from ..harness.quiet import FakeRecorder

PLENTY = 10**9


def known(name, size=0):
    mesh = np.zeros(size, dtype=np.uint8)
    part = SimpleNamespace(part_id=name, digest="", triangles=mesh, view=mesh[1:])
    return KnownPart(part, b"", (-1.0, -1.0))


@pytest.fixture
def forgotten():
    return []


def store_that_tells(forgotten):
    """A store; what it forgets is added to a list."""
    return PartStore(FakeRecorder(), lambda one, stamp, why: forgotten.append(one.part.part_id))


@pytest.fixture
def store(forgotten):
    return store_that_tells(forgotten)


def names(store):
    return [one.part.part_id for one in store.all()]


class TestKnownParts:
    def test_the_least_recently_used_makes_room(self, store, forgotten):
        for name in "abc":
            store.put(known(name), 3, PLENTY)
        store.find("a")
        store.current("b")  # does not count
        store.put(known("d"), 3, PLENTY)
        assert (names(store), forgotten) == (["c", "a", "d"], ["b"])

    def test_the_bytes_of_all_parts_are_bounded(self, store, forgotten):
        for name in "abc":
            store.put(known(name, 300), 9, 1000)
        store.find("a")
        store.put(known("d", 400), 9, 1000)
        assert (names(store), forgotten) == (["c", "a", "d"], ["b"])
        store.put(known("e", 1000), 9, 1000)
        assert names(store) == ["e"]
        with pytest.raises(MeshError, match=r"max_part_bytes.* got 1001 bytes"):
            store.put(known("f", 1001), 9, 1000)
        assert names(store) == ["e"]

    def test_the_same_name_takes_its_place(self, store, forgotten):
        first, second = known("a"), known("a")
        store.put(first, 2, PLENTY)
        store.put(known("b"), 2, PLENTY)
        store.put(second, 2, PLENTY)
        assert store.known("a") is second and forgotten == []

    def test_forget(self, store, forgotten):
        store.put(known("a"), 2, PLENTY)
        store.forget("a")
        assert (names(store), forgotten) == ([], ["a"])
        with pytest.raises(RequestError, match="'a'"):
            store.forget("a")

    def test_a_refusal_names_some_that_are_known(self, store):
        for number in range(100):
            store.put(known(f"part_{number:02d}"), 200, PLENTY)
        with pytest.raises(RequestError, match=r"part_00, .*, part_07, …\)"):
            store.known("nobody")

    @given(st.lists(st.tuples(st.sampled_from("pfc"), st.sampled_from("abcdefgh")),
                    max_size=40), st.integers(1, 5))
    def test_is_a_list_with_the_last_used_at_the_end(self, steps, most):
        model, gone = [], []
        store = store_that_tells(gone)
        for step, name in steps:
            if step == "p":
                store.put(known(name), most, PLENTY)
            elif step == "f":
                store.find(name)
            else:
                store.current(name)
            if step == "p" or (step == "f" and name in model):
                model = [one for one in model if one != name] + [name]
            model = model[-most:]
        assert names(store) == model


def request(vertices, name="part"):
    fields = {"part_id": name, "vertices": vertices,
              "triangles": np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], np.uint32)}
    return PartRequest(**fields)


TETRAHEDRON = np.vstack([np.zeros(3), np.eye(3)]) * 0.01


def test_a_part_is_built_once_and_a_refusal_remembered(monkeypatch):
    calls = []
    real = part_store.part_of
    monkeypatch.setattr(part_store, "part_of", lambda one: calls.append(one) or real(one))
    store = PartStore(FakeRecorder(), print)
    first, again = (store.resolve(request(one))[0] for one in (TETRAHEDRON, TETRAHEDRON.copy()))
    assert first.part is again.part
    assert len(calls) == 1
    flat = TETRAHEDRON * [1, 1, 0]
    for _ in range(2):
        with pytest.raises(PoseStatsError):
            store.resolve(request(flat))
    assert len(calls) == 2


def test_a_mesh_is_recorded_once_until_the_record_is_distrusted():
    recorder = FakeRecorder()
    store = PartStore(recorder, print)
    new, is_new = store.resolve(request(TETRAHEDRON))
    assert is_new
    store.put(new, 10, PLENTY)
    assert store.resolve(request(TETRAHEDRON)) == (new, False)
    store.meshes.record(new)
    assert recorder.topics == ["/pose_stats/part_mesh"]
    recorder.trusted_from = recorder.mark = 1
    store.meshes.record(new)
    assert recorder.topics == 2 * ["/pose_stats/part_mesh"]


def test_numbers_of_results_go_on_where_a_part_comes_again():
    store = PartStore(FakeRecorder(), print)
    for size in (1.0, 2.0, 1.0):
        new, _ = store.resolve(request(size * TETRAHEDRON))
        before = new.revisions.newest
        store.put(new, 10, PLENTY)
        assert new.revisions.next() == before + 1
    store.forget("part")
    assert store.resolve(request(3.0 * TETRAHEDRON))[0].revisions.shown == 3


def test_what_makes_room_is_recorded_as_forgotten():
    recorder = FakeRecorder()
    store = PartStore(recorder, print)
    for name in "abc":
        store.put(known(name), 2, PLENTY)
    assert recorder.topics == ["/pose_stats/job_events"]
    store.shrink(1, PLENTY)
    store.forget("c")
    assert recorder.topics == 3 * ["/pose_stats/job_events"]


def test_a_mesh_in_the_bag_of_an_earlier_run_is_not_recorded_until_that_goes():
    recorder = FakeRecorder()
    store = PartStore(recorder, print)
    meshes, (new, _) = store.meshes, store.resolve(request(TETRAHEDRON))
    key = "part", new.part.digest
    meshes.count_as_recorded(key, new.scene_override, "earlier")
    store.put(new, 10, PLENTY)
    assert recorder.topics == [] and meshes.distrust("earlier") and not meshes.distrust("other")
    meshes.leave_runs(store.all())
    assert meshes.distrust("earlier")  # it could not be recorded
    meshes.record(new)
    meshes.leave_runs(store.all())
    assert meshes.distrust("earlier")  # it is still read by whoever brings it back
    meshes.coming.discard(key)
    meshes.leave_runs(store.all())
    assert recorder.topics == ["/pose_stats/part_mesh"] and not meshes.distrust("earlier")


def test_a_mesh_in_an_earlier_run_is_recorded_again_before_the_file_that_says_so_goes():
    recorder = FakeRecorder()
    store = PartStore(recorder, print)
    new, _ = store.resolve(request(TETRAHEDRON))
    store.meshes.count_as_recorded(("part", new.part.digest), new.scene_override, "earlier")
    store.put(new, 10, PLENTY)
    assert recorder.topics == []
    recorder.trusted_from = recorder.mark = 1
    store.meshes.record(new)
    store.meshes.record(new)
    assert recorder.topics == ["/pose_stats/part_mesh"]
