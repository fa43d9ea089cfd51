"""`catalogue`: what it prints, the refusals, kill -9, Ctrl-C and parts that end their process."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ros_pose_stats import cli
from ros_pose_stats.shapes.random_parts import random_part
from tests.bodies import write_stl
from tests.catalogue import SIZES, boxes
from tests.running import ROOT, answer, complaints, strict_json

TABLES = ("catalogue.csv", "poses.csv")
PARTS = 40


@pytest.fixture(scope="module")
def parts(tmp_path_factory):
    folder = tmp_path_factory.mktemp("catalogue") / "random"
    folder.mkdir()
    for k in range(PARTS):
        write_stl(folder / f"part_{k:02d}.stl", random_part(5, k))
    return folder


@pytest.fixture(scope="module")
def whole(parts, tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole") / "catalogue"
    answer("catalogue", parts, "--unit", "mm", "-o", folder)
    return tables(folder)


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "catalogue"


def tables(folder):
    return [(folder / name).read_bytes() for name in TABLES]


def started(parts, folder, *options, **more):
    return subprocess.Popen(
        [sys.executable, "-m", "ros_pose_stats", "catalogue", str(parts), "--unit", "mm", "-o",
         str(folder), *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        cwd=ROOT, **more)


def rows_there(folder):
    try:
        return (folder / "parts.jsonl").read_bytes().count(b"\n")
    except FileNotFoundError:
        return 0


def wait_for_rows(folder, running, count):
    while rows_there(folder) < count:
        assert running.poll() is None, running.communicate()
        time.sleep(0.005)


def workers_of(running):
    """Ids of the processes that a run has started."""
    children = Path(f"/proc/{running.pid}/task/{running.pid}/children").read_text().split()
    others = [task.read_text().split() for task in Path(f"/proc/{running.pid}/task").glob(
        "*/children")]
    return {int(one) for one in [*children, *(pid for pids in others for pid in pids)]}


def refused(capsys, *arguments):
    status = cli.main(["catalogue", *map(str, arguments)])
    out, err = capsys.readouterr()
    assert (status, out) == (2, "")
    (line,) = complaints(err)
    return line


class TestWhatIsPrinted:
    def test_json(self, tmp_path, folder):
        parts = boxes(tmp_path / "parts", SIZES[:2])
        (parts / "none.stl").write_text("no part")
        found = strict_json(answer("catalogue", parts, "--unit", "mm", "-o", folder, "--json"))
        assert (found["done"], found["bound"], found["found"], found["refused"]) == (3, 3, 0, 1)
        assert (found["page"], found["tables"]) == (
            str(folder / "index.html"), [str(folder / name) for name in TABLES])
        assert all(Path(file).stat().st_size for file in (found["page"], *found["tables"]))
        assert [row["file"] for row in found["parts"]] == [
            str(parts / name) for name in ("box_0.stl", "box_1.stl", "none.stl")]
        assert sum(pose["probability"] for pose in found["parts"][0]["poses"]) == pytest.approx(1)
        assert "interrupted" not in found

    def test_words(self, tmp_path, folder):
        parts = boxes(tmp_path / "parts", SIZES[:1])
        for k in range(12):
            (parts / f"none_{k:02d}.stl").write_text("no part")
        first, *files, last = answer("catalogue", parts, "--unit", "mm", "-o", folder).splitlines()
        assert first.startswith(f"{folder / 'index.html'}: 13 parts, 12 refused, took ")
        assert files[:2] == [str(folder / name) for name in TABLES]
        assert len(files) == 12 and files[2].startswith(f"refused {parts / 'none_00.stl'}: ")
        assert last == "and 2 more, with reasons in the table"

    def test_serious_warnings_are_counted(self, tmp_path, folder):
        parts = boxes(tmp_path / "parts", [*SIZES[:2], (0.1, 0.2, 0.3)])
        text = answer("catalogue", parts, "-o", folder)
        assert text.splitlines()[3:] == ["serious warnings about 2 of 3 parts: UNIT_SUSPECT 2"]
        found = strict_json(answer("catalogue", parts, "-o", folder, "--json"))
        assert (found["doubted"], found["serious_warnings"]) == (2, {"UNIT_SUSPECT": 2})
        quiet = answer("catalogue", parts, "-o", tmp_path / "mm", "--unit", "mm")
        assert "serious warn" not in quiet

    def test_names_that_a_terminal_cannot_take(self, tmp_path, capfd):
        """Neither in the name of a file nor in the reason, which names it too."""
        parts = tmp_path / "parts"
        parts.mkdir()
        for name in (b"\x1b[31mred.stl", b"b\xf6x.stl"):
            Path(os.fsdecode(os.fsencode(parts) + b"/" + name)).write_text("no part")
        folder = Path(os.fsdecode(os.fsencode(tmp_path) + b"/\x1bout\xff"))
        assert cli.main(["catalogue", str(parts), "-o", str(folder), "--workers", "1"]) == 0
        out, err = capfd.readouterr()
        assert complaints(err) == []
        assert "\x1b" not in out
        assert f"refused {parts}/?[31mred.stl: " in out and f"refused {parts}/b?x.stl: " in out
        assert cli.main(["catalogue", str(folder / "gone"), "-o", str(folder)]) == 2
        assert "\x1b" not in capfd.readouterr().err


class TestRefusals:
    def test_no_parts(self, tmp_path, folder, capsys):
        assert "none in" in refused(capsys, tmp_path, "-o", folder)
        assert not folder.exists()

    def test_values(self, tmp_path, folder, capsys):
        parts = boxes(tmp_path / "parts", SIZES[:1])
        for option in (("--target-error", "1"), ("--density", "0"), ("--workers", "0"),
                       ("--restitution", "1"), ("--round-sides", "3")):
            assert "expected" in refused(capsys, parts, "-o", folder, *option)
            assert not folder.exists()

    def test_a_package_that_is_missing(self, tmp_path, folder, capsys, monkeypatch):
        parts = boxes(tmp_path / "parts", SIZES[:1])
        monkeypatch.setitem(sys.modules, "pyarrow", None)
        assert "pip install pyarrow" in refused(capsys, parts, "-o", folder, "--parquet")
        monkeypatch.setitem(sys.modules, "distributed", None)
        monkeypatch.delitem(sys.modules, "ros_pose_stats.batch.cluster", raising=False)
        monkeypatch.delitem(sys.modules, "ros_pose_stats.catalogue.cluster", raising=False)
        assert "pip install distributed" in refused(capsys, parts, "-o", folder, "--scheduler",
                                                    "tcp://127.0.0.1:1")
        assert not folder.exists()

    def test_a_folder_of_another_request(self, tmp_path, folder, capsys):
        parts = boxes(tmp_path / "parts", SIZES[:1])
        answer("catalogue", parts, "--unit", "mm", "-o", folder)
        before = tables(folder)
        assert "unit mm" in refused(capsys, parts, "--unit", "cm", "-o", folder)
        assert tables(folder) == before


class TestEnds:
    @pytest.mark.parametrize("after", [1, 15])
    def test_killed_and_started_again(self, parts, whole, folder, after):
        running = started(parts, folder)
        wait_for_rows(folder, running, after)
        workers = workers_of(running)
        assert workers
        running.kill()
        running.communicate()
        until = time.monotonic() + 30.0
        while any(Path(f"/proc/{pid}").exists() for pid in workers):
            assert time.monotonic() < until, "its processes stay"
            time.sleep(0.01)
        there = rows_there(folder)
        assert there < PARTS
        found = strict_json(answer("catalogue", parts, "--unit", "mm", "-o", folder, "--json"))
        assert (found["found"], found["done"]) == (there, PARTS)
        assert tables(folder) == whole

    def test_ctrl_c(self, parts, whole, folder):
        """As a terminal sends it: to the command and to all its processes."""
        running = started(parts, folder, start_new_session=True)
        wait_for_rows(folder, running, 5)
        os.killpg(running.pid, signal.SIGINT)
        out, err = running.communicate()
        assert (running.returncode, complaints(err)) == (130, [])
        assert "the same command goes on from here" in out.splitlines()[-1]
        assert "not the whole catalogue" in (folder / "index.html").read_text()
        answer("catalogue", parts, "--unit", "mm", "-o", folder)
        assert tables(folder) == whole
        assert "not the whole catalogue" not in (folder / "index.html").read_text()

    def test_a_worker_is_killed(self, parts, whole, folder):
        running = started(parts, folder)
        wait_for_rows(folder, running, 3)
        os.kill(min(workers_of(running)), signal.SIGKILL)
        out, err = running.communicate()
        assert (running.returncode, complaints(err)) == (0, [])
        assert " 0 refused" in out
        assert tables(folder) == whole

    def test_a_part_that_ends_its_process_is_refused_and_costs_no_other(self, tmp_path, folder):
        """As one does that makes a library crash: here reading it is an abort."""
        parts = boxes(tmp_path / "parts", SIZES[:3])
        shutil.copy(parts / "box_0.stl", parts / "deadly.stl")
        (tmp_path / "sitecustomize.py").write_text(
            "import os, pathlib\n"
            "read = pathlib.Path.read_bytes\n"
            "def deadly(path):\n"
            "    return os.abort() if path.name == 'deadly.stl' else read(path)\n"
            "pathlib.Path.read_bytes = deadly\n")
        path = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", str(ROOT))])
        running = started(parts, folder, env={**os.environ, "PYTHONPATH": path})
        out, _ = running.communicate()
        assert running.returncode == 0
        assert ": 4 parts, 1 refused" in out
        assert f"refused {parts / 'deadly.stl'}: the process that looked at it ended by SIGABRT" \
            in out
