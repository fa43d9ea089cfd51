"""Making a dataset in pieces: the same bytes whoever makes them and however often it stops."""

from __future__ import annotations

import json
import os
import threading
from contextlib import contextmanager

import pytest

from ros_pose_stats.errors import BatchError, DatasetError, RequestError
from ros_pose_stats.study.dataset import (
    DatasetSpec,
    make_chunk,
    make_dataset,
    on_threads,
    read_dataset,
)
from ros_pose_stats.study.dataset.making import Stopped
from ros_pose_stats.study.dataset.unfinished import Unfinished

SPEC = DatasetSpec(bodies=70, drops=4, restitutions=(0.2,), seed=3)
PIECES = [(0, 32), (32, 32), (64, 6)]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The file as one thread makes it in one go."""
    path = tmp_path_factory.mktemp("whole") / "whole.npz"
    assert make_dataset(path, SPEC, on_threads(1))
    return path.read_bytes()


@pytest.fixture
def file(tmp_path):
    return tmp_path / "polyhedra.npz"


def folder(file):
    return file.with_name(file.name + ".unfinished")


def recording(made):
    """A maker that notes which pieces it is asked for."""
    def make(spec, pieces, should_stop):
        made.extend(pieces)
        yield from on_threads(1)(spec, pieces, should_stop)

    return make


def stopped_after(file, pieces):
    """A run that is stopped once it has made some pieces."""
    done = []
    assert not make_dataset(file, SPEC, on_threads(1), on_progress=done.append,
                            should_stop=lambda: len(done) > pieces)
    return done


@contextmanager
def full_disk(monkeypatch, after):
    """Writes fail from some number of files on."""
    left = [after]
    fsync = os.fsync

    def failing(number):
        left[0] -= 1
        if left[0] < 0:
            raise OSError(28, "No space left on device")
        fsync(number)

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", failing)
        yield


class TestTheSameBytes:
    @pytest.mark.parametrize("workers", [2, 3, None])
    def test_whatever_the_workers(self, whole, file, workers):
        assert make_dataset(file, SPEC, on_threads(workers))
        assert file.read_bytes() == whole
        assert list(file.parent.iterdir()) == [file]

    @pytest.mark.parametrize("pieces", [0, 1, 2])
    def test_stopped_and_gone_on_with(self, whole, file, pieces):
        stopped_after(file, pieces)
        assert not file.exists()
        assert folder(file).exists() == bool(pieces)
        made, seen = [], []
        assert make_dataset(file, SPEC, recording(made), on_progress=seen.append)
        assert len(made) == 3 - pieces
        assert seen[0].found == seen[0].bodies == SPEC.bodies - sum(n for _, n in made)
        assert seen[-1].bodies == seen[-1].bound == SPEC.bodies
        assert file.read_bytes() == whole
        assert list(file.parent.iterdir()) == [file]

    def test_in_any_order(self, whole, file):
        def backwards(spec, pieces, _):
            yield from ((piece, make_chunk(spec, *piece)) for piece in reversed(pieces))

        assert make_dataset(file, SPEC, backwards)
        assert file.read_bytes() == whole


class TestPiecesFoundThere:
    @pytest.mark.parametrize("damage", ["cut", "empty", "foreign", "flipped", "missing"])
    def test_a_damaged_one_is_made_again(self, whole, file, damage):
        stopped_after(file, 2)
        path = folder(file) / "bodies_0000032_0000063.npz"
        content = path.read_bytes()
        if damage == "missing":
            path.unlink()
        elif damage == "foreign":
            path.write_bytes((folder(file) / "bodies_0000000_0000031.npz").read_bytes()[:-1])
        else:
            middle = len(content) // 2
            path.write_bytes({"cut": content[:middle], "empty": b"", "flipped": content[:middle]
                              + bytes([content[middle] ^ 1]) + content[middle + 1:]}[damage])
        made = []
        assert make_dataset(file, SPEC, recording(made))
        assert made == [(32, 32), (64, 6)]
        assert file.read_bytes() == whole

    def test_half_written_files_of_a_killed_run_do_no_harm(self, whole, file):
        stopped_after(file, 1)
        (folder(file) / "bodies_0000032_0000063.npz.half").write_bytes(b"PK")
        (folder(file) / "spec.json.half").write_bytes(b"{")
        file.with_name(file.name + ".half").write_bytes(b"PK")
        assert make_dataset(file, SPEC, on_threads(1))
        assert file.read_bytes() == whole
        assert list(file.parent.iterdir()) == [file]

    def test_those_of_another_dataset_are_kept_and_refused(self, whole, file):
        stopped_after(file, 1)
        other = DatasetSpec(bodies=70, drops=4, restitutions=(0.2,), seed=4)
        with pytest.raises(BatchError, match="seed 3"):
            make_dataset(file, other, on_threads(1))
        made = []
        assert make_dataset(file, SPEC, recording(made))
        assert made == PIECES[1:]
        assert file.read_bytes() == whole

    @pytest.mark.parametrize("text", ["", "[]", "null", '{"bodies": 1}'])
    def test_those_of_an_unknown_dataset_are_refused(self, file, text):
        stopped_after(file, 1)
        (folder(file) / "spec.json").write_text(text)
        with pytest.raises(BatchError, match="another one"):
            make_dataset(file, SPEC, on_threads(1))
        (folder(file) / "bodies_0000000_0000031.npz").unlink()
        assert make_dataset(file, SPEC, on_threads(1))

    def test_another_version_s_are_refused(self, file):
        stopped_after(file, 1)
        spec = folder(file) / "spec.json"
        told = json.loads(spec.read_text())
        spec.write_text(json.dumps({**told, "written_by": "ros_pose_stats 0.0.1"}))
        with pytest.raises(BatchError, match=r"ros_pose_stats 0\.0\.1"):
            make_dataset(file, SPEC, on_threads(1))

    def test_files_of_others_in_the_directory_stay(self, file):
        folder(file).mkdir()
        mine = folder(file) / "notes.txt"
        mine.write_text("mine")
        stopped_after(file, 0)
        assert make_dataset(file, SPEC, on_threads(1))
        assert mine.read_text() == "mine"
        assert list(folder(file).iterdir()) == [mine]

    def test_pieces_left_beside_the_finished_file_go(self, whole, file):
        stopped_after(file, 2)
        file.write_bytes(whole)
        assert make_dataset(file, SPEC, recording([]))
        assert list(file.parent.iterdir()) == [file]


class TestTheFileIsThere:
    def test_the_same_one_is_left_alone(self, whole, file):
        file.write_bytes(whole)
        before = file.stat().st_mtime_ns
        made = []
        assert make_dataset(file, SPEC, recording(made))
        assert made == []
        assert file.stat().st_mtime_ns == before

    def test_another_one_is_refused_and_kept(self, whole, file):
        file.write_bytes(whole)
        other = DatasetSpec(bodies=70, drops=4, restitutions=(0.5,), seed=3)
        with pytest.raises(DatasetError, match=r"restitutions \[0.2\]"):
            make_dataset(file, other, on_threads(1))
        assert file.read_bytes() == whole

    def test_something_else_is_refused_and_kept(self, file):
        file.write_text("a letter")
        with pytest.raises(DatasetError):
            make_dataset(file, SPEC, on_threads(1))
        assert file.read_text() == "a letter"

    def test_one_that_another_run_finished_meanwhile(self, whole, file, monkeypatch):
        """It appears between the first look and the lock."""
        take = Unfinished.__init__

        def late(self, path, spec):
            take(self, path, spec)
            path.write_bytes(whole)

        monkeypatch.setattr(Unfinished, "__init__", late)
        made = []
        assert make_dataset(file, SPEC, recording(made))
        assert made == []
        assert list(file.parent.iterdir()) == [file]


class TestRefusals:
    @pytest.mark.parametrize("workers", [0, -1, 1025])
    def test_workers(self, workers):
        with pytest.raises(RequestError, match="workers"):
            on_threads(workers)

    def test_two_runs_at_once(self, whole, file):
        with Unfinished(file, SPEC), pytest.raises(BatchError, match="in use"):
            make_dataset(file, SPEC, on_threads(1))
        assert make_dataset(file, SPEC, on_threads(1))
        assert file.read_bytes() == whole

    def test_places_where_nothing_can_be_written(self, tmp_path):
        (tmp_path / "file").write_text("")
        for path in (tmp_path / "file" / "a.npz", tmp_path / ("n" * 250),
                     tmp_path / ("n" * 300)):
            with pytest.raises((BatchError, DatasetError), match="expected"):
                make_dataset(path, SPEC, on_threads(1))
        assert [path.name for path in tmp_path.iterdir()] == ["file"]

    @pytest.mark.parametrize("after", [0, 1, 2, 3, 5, 8, 9])
    def test_a_full_disk(self, whole, file, monkeypatch, after):
        """At the specification, a piece, or the file itself; what was done before is kept."""
        with (full_disk(monkeypatch, after),
              pytest.raises(BatchError, match="No space left on device")):
            make_dataset(file, SPEC, on_threads(1))
        assert not list(file.parent.rglob("*.half"))
        kept = list(folder(file).glob("bodies_*"))
        made = []
        assert make_dataset(file, SPEC, recording(made))
        assert len(made) == 3 - len(kept)
        assert file.read_bytes() == whole

    def test_an_accident_in_a_worker_comes_out_and_ends_the_others(self, file, monkeypatch):
        def failing(spec, first, count, should_stop):
            if first:
                raise MemoryError
            return make_chunk(spec, first, count, should_stop)

        monkeypatch.setattr("ros_pose_stats.study.dataset.making.make_chunk", failing)
        before = threading.active_count()
        with pytest.raises(MemoryError):
            make_dataset(file, SPEC, on_threads(2))
        assert threading.active_count() == before


class TestStopping:
    def test_a_piece_in_hand_is_given_up(self, file):
        """One body, whose drops would take minutes."""
        long = DatasetSpec(bodies=1, drops=10_000_000, restitutions=(0.8,))
        polled = []
        assert not make_dataset(file, long, on_threads(1),
                                should_stop=lambda: polled.append(1) or len(polled) > 5)
        assert list(file.parent.iterdir()) == []

    def test_a_chunk_asks(self):
        with pytest.raises(Stopped):
            make_chunk(SPEC, 0, 1, lambda: True)


def test_what_was_made_can_be_read(whole, file):
    file.write_bytes(whole)
    assert read_dataset(file).spec == SPEC
