"""`dataset`: the file, the reports, the refusals, kill -9, Ctrl-C and a full disk."""

from __future__ import annotations

import os
import pty
import resource
import signal
import subprocess
import sys
import time
from contextlib import suppress

import numpy as np
import pytest

from ros_pose_stats import cli
from ros_pose_stats.commands.study.dataset import default_name
from ros_pose_stats.study.dataset import DatasetSpec, make_dataset, on_threads, read_dataset
from tests.running import ROOT, answer, command, complaints, strict_json

SMALL = ("--bodies", "70", "--drops", "4", "--restitution", "0.2", "--seed", "3")
SPEC = DatasetSpec(bodies=70, drops=4, restitutions=(0.2,), seed=3)
LONG = ("--bodies", "120", "--drops", "60", "--seed", "5")
LONG_SPEC = DatasetSpec(bodies=120, drops=60, seed=5)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The files that the library makes, by specification."""
    folder = tmp_path_factory.mktemp("whole")
    made = {}
    for name, spec in (("small", SPEC), ("long", LONG_SPEC)):
        assert make_dataset(folder / name, spec, on_threads(2))
        made[spec] = (folder / name).read_bytes()
    return made


def started(file, *options, stderr=subprocess.PIPE, **more):
    """A run in a process of its own."""
    return subprocess.Popen([sys.executable, "-m", "ros_pose_stats", "dataset", "-o", str(file),
                             *options], stdout=subprocess.PIPE, stderr=stderr, text=True,
                            cwd=ROOT, **more)


def watched(file, *options):
    """What a terminal shows of a run that succeeds."""
    terminal, stderr = pty.openpty()
    running = started(file, *options, stderr=stderr)
    os.close(stderr)
    shown = b""
    with suppress(OSError):  # the end of a terminal
        while more := os.read(terminal, 4096):
            shown += more
    os.close(terminal)
    running.communicate()
    assert running.returncode == 0, shown
    return shown.decode()


def refused(capsys, *arguments):
    """The one line on standard error of a run in this process."""
    try:
        status = cli.main(["dataset", *map(str, arguments)])
    except SystemExit as end:
        status = end.code
    out, err = capsys.readouterr()
    assert status == 2
    assert out == ""
    (line,) = complaints(err)
    return line


def pieces(file):
    return sorted(file.with_name(file.name + ".unfinished").glob("bodies_*.npz"))


def wait_for_a_piece(file, running):
    """Until one is there; the run must not be over by then."""
    while not pieces(file):
        assert running.poll() is None, running.communicate()
        time.sleep(0.005)


class TestTheFile:
    @pytest.mark.long
    def test_it_is_the_library_s_whatever_the_workers(self, whole, tmp_path):
        for workers in (1, 3):
            file = tmp_path / f"{workers}.npz"
            answer("dataset", *SMALL, "-o", file, "--workers", workers)
            assert file.read_bytes() == whole[SPEC]

    def test_what_is_printed(self, tmp_path):
        file = tmp_path / "a.npz"
        out = answer("dataset", *SMALL, "-o", file, "--shift", 1)
        found = read_dataset(file)
        assert f"70 random polyhedra with {len(found.body)} stable poses" in out
        assert "280 drops, 4 of each at each restitution; 0 did not settle" in out
        assert "released 20 m above a frictionless plate, restitution 0.2\n" in out
        assert "shift 1 (inertia)" in out
        told = strict_json(answer("dataset", *SMALL, "-o", file, "--shift", 1, "--json"))
        assert told["poses"] == len(found.body)
        assert told["drops_in_all"] == 280
        assert told["unsettled"] == 280 - int(found.arrays["settled"].sum())
        assert told["redraws"] == int(found.arrays["redraws"].sum()) > 0
        assert told["bytes"] == file.stat().st_size

    def test_the_default_name_says_what_is_in_it(self, tmp_path):
        done = subprocess.run(
            [sys.executable, "-m", "ros_pose_stats", "dataset", "--bodies", "2", "--drops", "3",
             "--shift", "0.65", "--shift-moment", "second"], capture_output=True, text=True,
            cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT)})
        assert done.returncode == 0, done.stderr
        (file,) = tmp_path.iterdir()
        assert file.name == "polyhedra_2_shift_0.65_second_drops_3_seed_1.npz"
        assert read_dataset(file).spec == DatasetSpec(2, 3, shift=0.65, shift_moment="second")

    def test_other_drops_have_another_default_name(self):
        """Two datasets that differ have two names."""
        specs = [DatasetSpec(), DatasetSpec(drops=7), DatasetSpec(seed=2), DatasetSpec(5),
                 DatasetSpec(shift=0.1), DatasetSpec(shift=0.1, shift_moment="second"),
                 DatasetSpec(restitutions=(0.2,)), DatasetSpec(restitutions=(0.5,))]
        assert len({default_name(spec) for spec in specs}) == len(specs)


class TestCutOff:
    @pytest.mark.long
    def test_killed_and_given_again(self, whole, tmp_path):
        file = tmp_path / "a.npz"
        running = started(file, *LONG, "--workers", "1")
        wait_for_a_piece(file, running)
        running.kill()
        running.communicate()
        there = len(pieces(file))
        assert there
        assert not file.exists()
        shown = watched(file, *LONG, "--workers", "1")
        assert f"bodies ({32 * there} found), " in shown
        assert file.read_bytes() == whole[LONG_SPEC]
        assert list(tmp_path.iterdir()) == [file]

    @pytest.mark.long
    def test_ctrl_c_keeps_what_is_done(self, whole, tmp_path):
        file = tmp_path / "a.npz"
        running = started(file, *LONG, "--workers", "1")
        wait_for_a_piece(file, running)
        running.send_signal(signal.SIGINT)
        out, err = running.communicate()
        assert running.returncode == 130
        assert out == ""
        assert complaints(err) == ["ros_pose_stats: interrupted; the same command goes on from "
                                   "here"]
        assert pieces(file)
        assert not file.exists()
        answer("dataset", *LONG, "-o", file)
        assert file.read_bytes() == whole[LONG_SPEC]

    @pytest.mark.long
    def test_ctrl_c_does_not_wait_for_a_long_piece(self, tmp_path):
        """One body whose drops would take hours; nothing is left of them."""
        file = tmp_path / "a.npz"
        running = started(file, "--bodies", "1", "--drops", "100000000", "--workers", "1")
        while not file.with_name("a.npz.unfinished").exists():
            assert running.poll() is None
            time.sleep(0.01)
        time.sleep(0.5)
        running.send_signal(signal.SIGINT)
        running.communicate()
        assert running.returncode == 130
        assert list(tmp_path.iterdir()) == []

    @pytest.mark.long
    def test_a_second_run_beside_the_first_is_refused(self, whole, tmp_path):
        file = tmp_path / "a.npz"
        running = started(file, *LONG, "--workers", "1")
        wait_for_a_piece(file, running)
        running.send_signal(signal.SIGSTOP)
        done = command("dataset", *LONG, "-o", file)
        running.send_signal(signal.SIGCONT)
        assert done.returncode == 2
        (line,) = complaints(done.stderr)
        assert "in use" in line
        running.communicate()
        assert file.read_bytes() == whole[LONG_SPEC]

    @pytest.mark.long
    def test_a_full_disk_is_one_line_and_nothing_is_lost(self, whole, tmp_path):
        file = tmp_path / "a.npz"
        done = started(file, *SMALL, preexec_fn=lambda: resource.setrlimit(
            resource.RLIMIT_FSIZE, (20_000, resource.RLIM_INFINITY)))
        _, err = done.communicate()
        assert done.returncode == 2
        (line,) = complaints(err)
        assert "File too large" in line
        assert not file.exists()
        answer("dataset", *SMALL, "-o", file)
        assert file.read_bytes() == whole[SPEC]
        assert list(tmp_path.iterdir()) == [file]


class TestRefusals:
    @pytest.mark.parametrize(("options", "said"), [
        (("--bodies", "0"), "bodies"), (("--bodies", "2.5"), "bodies"),
        (("--drops", "0"), "drops"), (("--drops", "many"), "drops"),
        (("--restitution", "1"), "restitution"), (("--restitution", "nan"), "restitution"),
        (("--restitution", "0.5", "0.5"), "different restitutions"),
        (("--restitution",), "restitution"),
        (("--shift", "nan"), "shift"), (("--shift", "-1"), "shift"),
        (("--shift-moment", "third"), "shift-moment"), (("--seed", "-1"), "seed"),
        (("--workers", "0"), "workers"), (("--workers", "2", "--scheduler", "x:1"), "workers"),
        (("--scheduler", "nowhere"), "scheduler"), (("--scheduler", ""), "scheduler"),
        (("--scheduler", "carrier://pigeon:1"), "scheduler")])
    def test_one_line_status_2_and_nothing_left_behind(self, tmp_path, capsys, options, said):
        assert said in refused(capsys, "-o", tmp_path / "a.npz", *options)
        assert list(tmp_path.iterdir()) == []

    def test_in_a_process_of_its_own(self, tmp_path):
        done = command("dataset", "-o", tmp_path / "a.npz", "--scheduler", "nowhere")
        assert done.returncode == 2
        assert len(complaints(done.stderr)) == 1
        assert list(tmp_path.iterdir()) == []

    def test_a_file_that_holds_something_else(self, whole, tmp_path, capsys):
        file = tmp_path / "a.npz"
        for content, said in ((whole[SPEC], "seed 3"), (b"a letter", "make it anew")):
            file.write_bytes(content)
            assert said in refused(capsys, *SMALL[:-1], "4", "-o", file)
            assert file.read_bytes() == content

    def test_places_that_cannot_be_written(self, tmp_path, capsys):
        (tmp_path / "file").write_text("")
        for place in (tmp_path, tmp_path / "file" / "a.npz", "/proc/a.npz",
                      tmp_path / ("n" * 300)):
            assert str(place) in refused(capsys, *SMALL, "-o", place)
        assert [path.name for path in tmp_path.iterdir()] == ["file"]

    def test_dask_distributed_missing(self, tmp_path):
        code = ("import sys; sys.modules['distributed'] = None\n"
                "from ros_pose_stats.cli import main\n"
                f"sys.exit(main(['dataset', '-o', {str(tmp_path / 'a.npz')!r}, "
                "'--scheduler', '127.0.0.1:1']))")
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True,
                              cwd=ROOT)
        assert done.returncode == 2
        (line,) = complaints(done.stderr)
        assert "pip install" in line


def test_the_schema_names_its_origin(whole, tmp_path):
    (tmp_path / "a.npz").write_bytes(whole[SPEC])
    with np.load(tmp_path / "a.npz", allow_pickle=False) as archive:
        assert '"ros_pose_stats.dataset"' in str(archive["schema"])


def test_a_cluster_without_dask_is_refused(monkeypatch, capsys, tmp_path):
    monkeypatch.setitem(sys.modules, "distributed", None)
    for room in ("study.dataset", "batch"):
        monkeypatch.delitem(sys.modules, f"ros_pose_stats.{room}.cluster", raising=False)
    assert cli.main(["dataset", "--scheduler", "tcp://127.0.0.1:1", "-o",
                     str(tmp_path / "a.npz")]) == 2
    assert "pip install distributed" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
