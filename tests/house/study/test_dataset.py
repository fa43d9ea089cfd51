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

"""Datasets: the same bytes for the same seed, whoever makes them and however often it
stops.
"""

import contextlib
import os
import resource
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from study.__main__ import main
from tests.clusters import scheduler, worker
from tests.running import ROOT, call, complaints, strict_json

from .programs import dataset, first, read, reference, refused

SMALL = ("--bodies", 40, "--drops", 4, "--restitution", 0.2, "--seed", 3)
LONG = ("--bodies", 96, "--drops", 40, "--seed", 5)
"""Of two pieces and of three: 32 bodies each at most."""
PATIENCE = 120.0


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The bytes of a dataset that was made in one go, by its options."""
    folder = tmp_path_factory.mktemp("whole")
    for name, options in (("small", SMALL), ("long", LONG)):
        dataset(*options, "-o", folder / name, "--workers", 1)
    return {
        SMALL: (folder / "small").read_bytes(),
        LONG: (folder / "long").read_bytes(),
    }


@pytest.fixture
def file(tmp_path):
    return tmp_path / "polyhedra.npz"


def started(file, *options):
    """A run in a process of its own, which gives way to whoever watches it."""
    return subprocess.Popen(
        [sys.executable, "-m", "study", "dataset", *map(str, options), "-o", str(file)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        preexec_fn=lambda: os.nice(5),
    )


def pieces(file):
    return sorted(file.with_name(file.name + ".unfinished").glob("bodies_*.npz"))


def wait_for_a_piece(file, running=None):
    end = time.monotonic() + PATIENCE
    while not pieces(file):
        assert time.monotonic() < end, "no piece of the dataset came"
        assert running is None or running.poll() is None, running.communicate()
        time.sleep(0.002)


def interrupted(file, options=LONG):
    """A run in this process that is ended by Ctrl-C once it has made a piece."""

    def interrupt():
        wait_for_a_piece(file)
        os.kill(os.getpid(), signal.SIGINT)

    handler = signal.signal(signal.SIGINT, lambda *_: None)  # were it ever late
    thread = threading.Thread(target=interrupt)
    thread.start()
    try:
        return call("dataset", *options, "-o", file, "--workers", 1, program=main)
    finally:
        thread.join()
        signal.signal(signal.SIGINT, handler)


class TestTheFile:
    def test_the_same_seed_gives_the_same_bytes_whatever_the_workers(self, whole, file):
        dataset(*SMALL, "-o", file, "--workers", 2)
        assert file.read_bytes() == whole[SMALL]
        assert list(file.parent.iterdir()) == [file]
        first, second = (file.with_name(f"{seed}.npz") for seed in (3, 4))
        for seed, one_body in ((3, first), (4, second)):
            dataset("--bodies", 1, *SMALL[2:-1], seed, "-o", one_body)
        assert first.read_bytes() != second.read_bytes()

    def test_the_reference_dataset_is_made_by_this_program(self, file):
        """On any processor, exactly; a longer dataset begins with the shorter one."""
        dataset("--bodies", 3, "--drops", 1000, "-o", file)
        for name, array in read(file).arrays.items():
            assert np.array_equal(array, first(reference(), 3).arrays[name]), name

    def test_what_is_printed_is_what_is_in_it(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        stated = strict_json(dataset(*SMALL, "--shift", 1, "--json"))
        (file,) = tmp_path.iterdir()
        assert (
            file.name
            == "polyhedra_40_shift_1_inertia_drops_4_restitution_0.2_seed_3.npz"
        )
        results = read(file)
        assert {name: stated[name] for name in results.spec} == results.spec
        assert (stated["poses"], stated["drops_in_all"]) == (
            len(results.arrays["down"]),
            160,
        )
        assert stated["unsettled"] == 160 - results.arrays["settled"].sum()
        assert stated["redraws"] == results.arrays["redraws"].sum() > 0
        assert stated["bytes"] == file.stat().st_size
        text = dataset(*SMALL, "-o", file, "--shift", 1)
        assert (
            f"40 random polyhedra with {stated['poses']} stable poses, shift 1" in text
        )


class TestCutOff:
    def test_ctrl_c_keeps_what_is_done_and_the_same_command_goes_on(self, whole, file):
        outcome = interrupted(file)
        assert (outcome.returncode, outcome.stdout) == (130, "")
        assert complaints(outcome.stderr)[-1] == (
            "ros_pose_stats: interrupted; the same command goes on from here"
        )
        contents = {entry: entry.read_bytes() for entry in pieces(file)}
        assert contents and not file.exists()
        refusal = refused("dataset", *LONG[:-1], 6, "-o", file)
        assert (
            "seed 5" in refusal
        )  # pieces of another dataset are neither mixed in nor lost
        assert {entry: entry.read_bytes() for entry in pieces(file)} == contents
        first, content = next(iter(contents.items()))
        middle = len(content) // 2  # a damaged piece is made again
        first.write_bytes(
            content[:middle] + bytes((content[middle] ^ 1,)) + content[middle + 1 :]
        )
        first.with_name("bodies_9999999_9999999.npz.half").write_bytes(b"PK")
        dataset(*LONG, "-o", file)
        assert file.read_bytes() == whole[LONG]
        assert list(file.parent.iterdir()) == [file]

    @pytest.mark.long
    def test_a_second_run_is_refused_and_a_killed_one_gone_on_with(self, whole, file):
        with started(file, *LONG, "--workers", 1) as running:
            wait_for_a_piece(file, running)
            running.send_signal(signal.SIGSTOP)
            assert "in use" in refused("dataset", *LONG, "-o", file)
            running.kill()
            running.communicate()
        assert not file.exists()
        dataset(*LONG, "-o", file)
        assert file.read_bytes() == whole[LONG]
        assert list(file.parent.iterdir()) == [file]

    def test_a_full_disk_is_one_line_and_nothing_is_lost(self, whole, file):
        most = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, most[1]))
        try:
            line = refused("dataset", *SMALL, "-o", file)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, most)
        assert "File too large" in line and not file.exists()
        dataset(*SMALL, "-o", file)
        assert file.read_bytes() == whole[SMALL]

    def test_a_complete_one_is_left_alone_and_another_file_kept(self, whole, file):
        file.write_bytes(whole[SMALL])
        modified = file.stat().st_mtime_ns
        dataset(*SMALL, "-o", file)
        assert file.stat().st_mtime_ns == modified
        for content, words in ((whole[SMALL], "seed 3"), (b"a letter", "make it anew")):
            file.write_bytes(content)
            assert words in refused("dataset", *SMALL[:-1], 4, "-o", file)
            assert file.read_bytes() == content


class TestRefusals:
    @pytest.mark.parametrize(
        ("options", "words"),
        [
            (("--bodies", "0"), "bodies"),
            (("--drops", "many"), "drops"),
            (("--restitution", "1"), "restitution"),
            (("--restitution", "nan"), "restitution"),
            (("--restitution", "0.5", "0.5"), "different restitutions"),
            (("--shift", "-1"), "shift"),
            (("--shift-moment", "third"), "shift-moment"),
            (("--seed", "-1"), "seed"),
            (("--workers", "0"), "workers"),
            (("--workers", "2", "--scheduler", "x:1"), "workers"),
            (("--scheduler", "nowhere"), "scheduler"),
        ],
    )
    def test_one_line_and_nothing_left_behind(self, file, options, words):
        assert words in refused("dataset", "-o", file, *options)
        assert list(file.parent.iterdir()) == []

    def test_places_that_cannot_be_written(self, tmp_path):
        (tmp_path / "file").write_text("")
        for output in (tmp_path, tmp_path / "file" / "a.npz", tmp_path / ("n" * 300)):
            assert str(output) in refused("dataset", *SMALL, "-o", output)
        assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.mark.long
def test_a_cluster_that_loses_a_worker_makes_the_same_bytes(
    whole, file, tmp_path_factory
):
    distributed = pytest.importorskip(
        "distributed", reason="the extra `cluster` is not there"
    )
    with contextlib.ExitStack() as cluster:
        _, address = cluster.enter_context(
            scheduler(tmp_path_factory.mktemp("cluster"))
        )
        for _ in range(2):
            cluster.enter_context(worker(address))
        client = cluster.enter_context(
            distributed.Client(address, set_as_default=False, timeout=PATIENCE)
        )
        client.wait_for_workers(2, timeout=PATIENCE)
        pids = client.run(os.getpid)
        running = cluster.enter_context(started(file, *LONG, "--scheduler", address))
        wait_for_a_piece(file, running)
        busy = client.processing()
        os.kill(pids[max(busy, key=lambda entry: len(busy[entry]))], signal.SIGKILL)
        _, err = running.communicate()
        assert running.returncode == 0, err
    assert file.read_bytes() == whole[LONG]
    assert list(file.parent.iterdir()) == [file]
