"""`catalogue`: a row for every part, the same however often the run is stopped, killed
or out of room, in tables, object and words.
"""

import csv
import math
import os
import pty
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from pyarrow import parquet

from lab.bodies import shapes
from lab.bodies.samples import random_polyhedron
from lab.bodies.variants import moved
from ros_pose_stats import estimate, load_part
from tests.answers import write_stl
from tests.running import (
    ROOT,
    answer,
    answer_json,
    call,
    children,
    complaints,
    is_gone,
    refusal,
)

TABLES = "catalogue.csv", "poses.csv"
REFUSED = {
    "letter.stl": b"Dear colleague,",
    "empty.step": b"",
    "flat.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    "none.stl": b"solid\nendsolid\n",
    "bare.step": b"ISO-10303-21;\nEND-ISO-10303-21;\n",
    **dict.fromkeys(
        (
            "a\rb.stl",
            "c\nd.stl",
            'g"h,i;j\tk.stl',
            " l .stl",
            "ü\x85\u2028.stl",
            "\x1b[31mred.stl",
        ),
        b"no part",
    ),
}
ROCKS = 50
PARTS = len(REFUSED) + ROCKS + 5
ASKED = (
    "catalogue",
    "parts",
    "\ufeff =1+1.stl",
    "parts/box.stl",
    "--unit",
    "cm",
    "--restitution",
    0.2,
    "--drop-height",
    0.4,
    "--density",
    7850.0,
    "--workers",
    1,
)
PATIENCE = 60.0


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """Where parts lie, what is none, and what is not to be looked at; `set_parts` adds
    two.
    """
    home = tmp_path_factory.mktemp("catalogue")
    parts = home / "parts"
    (parts / "below" / ".cache").mkdir(parents=True)
    for name in ("box.stl", "b\udcf6x, 1.stl"):
        write_stl(parts / name, shapes.box(1.0, 2.0, 3.0))
    for seed in range(ROCKS):
        write_stl(parts / "below" / f"rock_{seed}.STL", random_polyhedron(9, seed))
    for name, content in REFUSED.items():
        (parts / name).write_bytes(content)
    (parts / "notes.txt").write_text("no part")
    for hidden in (".hidden.stl", "below/.cache/box.stl"):
        write_stl(parts / hidden, shapes.box(1.0, 2.0, 3.0))
    (parts / "below" / "up").symlink_to("..")
    (home / "\ufeff =1+1.stl").write_text("no part")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(home)
        yield home


def set_parts(parts, late):
    """Put the parts there that are changed, removed and new, as they are early or
    late.
    """
    old = parts / "a_removed.stl"
    new = parts / "a_new.stl"
    write_stl(
        parts / "a_changed.stl",
        shapes.box(*((3.0, 3.5, 4.0) if late else (1.0, 2.0, 3.0))),
    )
    write_stl(new if late else old, shapes.box(4.0, 3.0, 1.0))
    (old if late else new).unlink(missing_ok=True)


def tables(folder):
    return [(folder / name).read_bytes() for name in TABLES]


def rows_of(folder, name="catalogue.csv"):
    with (folder / name).open(
        newline="", encoding="utf-8", errors="surrogateescape"
    ) as lines:
        return list(csv.DictReader(lines))


class Run:
    """The command in a process of its own, watched on a terminal, which has time for
    that.
    """

    def __init__(self, *options, **environment):
        self.terminal, stderr = pty.openpty()
        self.process = subprocess.Popen(
            [
                sys.executable,
                "-m",
                "ros_pose_stats",
                *map(str, ASKED),
                "-o",
                "stopped",
                *options,
            ],
            stdout=subprocess.PIPE,
            stderr=stderr,
            text=True,
            start_new_session=True,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
            preexec_fn=lambda: os.nice(5),
            **environment,
        )
        os.close(stderr)

    def wait_for(self, condition):
        """Until the bar shows more parts than so many; returns how many."""
        while True:
            printed = os.read(self.terminal, 4096).decode()
            counts = [
                int(count) for count in re.findall(r"(\d+) of \d+ parts", printed)
            ]
            if counts and counts[-1] > condition:
                return counts[-1]

    def end(self):
        """Standard output, once it has ended."""
        printed, _ = self.process.communicate(timeout=PATIENCE)
        os.close(self.terminal)
        return printed


def are_gone(processes):
    deadline = time.monotonic() + PATIENCE
    while not all(map(is_gone, processes)):
        if time.monotonic() > deadline:
            return False
        time.sleep(0.01)
    return True


class Ended(NamedTuple):
    """What came of a run on a full disk, one that was killed, one with Ctrl-C, and the
    last.
    """

    full: tuple
    killed: bool
    in_use: str
    stopped: tuple
    page: str
    last: str


@pytest.fixture(scope="module")
def ended(home):
    """One catalogue that four runs make, of files that change on the way."""
    set_parts(home / "parts", late=False)
    full = subprocess.run(
        [sys.executable, "-m", "ros_pose_stats", *map(str, ASKED), "-o", "stopped"],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (30_000, 30_000)),
    )
    begun = Run()
    while not children(begun.process.pid):
        assert begun.process.poll() is None
    os.killpg(begun.process.pid, signal.SIGINT)  # also to those that just start
    assert "interrupted" in begun.end() and begun.process.returncode == 130
    first = Run()
    first.wait_for(0)
    workers = children(first.process.pid)
    first.process.kill()
    first.end()
    killed = bool(workers) and are_gone(workers)
    set_parts(home / "parts", late=True)
    second = Run()
    count = second.wait_for(0)
    os.kill(second.process.pid, signal.SIGSTOP)
    os.kill(min(children(second.process.pid)), signal.SIGKILL)
    in_use = refusal(*ASKED, "-o", "stopped")
    os.kill(second.process.pid, signal.SIGCONT)
    second.wait_for(max(count, len(REFUSED) + 1))  # refused ones are looked at again
    os.killpg(second.process.pid, signal.SIGINT)  # as a terminal sends it
    stopped = second.end(), second.process.returncode
    page = (home / "stopped" / "index.html").read_text(encoding="utf-8")
    last = call(*ASKED, "-o", "stopped")
    assert (last.returncode, complaints(last.stderr)) == (0, [])
    return Ended(
        (full.returncode, full.stderr), killed, in_use, stopped, page, last.stdout
    )


@pytest.fixture(scope="module")
def catalogue(home):
    """The late parts in one go: what the command prints with `--json`, and its folder.

    A file beside the parts may have the name of a module that the work needs.
    """
    set_parts(home / "parts", late=True)
    (home / "queue.py").write_text("import pathlib; pathlib.Path('ran').touch(); 1 / 0")
    values = answer_json(*ASKED, "-o", "out", "--parquet")
    (home / "queue.py").unlink()
    return values, home / "out"


@pytest.mark.long
class TestEnds:
    def test_a_full_disk_is_said_in_one_line(self, ended):
        status, error = ended.full
        (line,) = complaints(error)
        assert (
            status == 2
            and "parts.sqlite3 (disk I/O error)" in line
            and "make room" in line
        )

    def test_rows_that_cannot_be_read_are_refused_with_what_to_do(
        self, home, catalogue
    ):
        shutil.copytree(catalogue[1], home / "damaged")
        (home / "damaged" / "parts.sqlite3").write_bytes(b"no rows" * 1000)
        assert "delete it" in refusal(*ASKED, "-o", "damaged")

    def test_a_killed_run_leaves_no_process(self, ended):
        assert ended.killed

    def test_two_runs_at_once_are_refused(self, ended):
        assert "in use" in ended.in_use

    def test_ctrl_c_says_how_to_go_on_and_the_page_that_it_is_not_whole(
        self, home, ended
    ):
        text, status = ended.stopped
        assert (
            status == 130
            and "the same command goes on from here" in text.splitlines()[-1]
        )
        assert "not the whole catalogue" in ended.page
        assert (
            "not the whole catalogue"
            not in (home / "stopped" / "index.html").read_text()
        )

    def test_the_tables_are_those_of_one_go_and_nothing_was_done_twice(
        self, home, ended, catalogue
    ):
        """Of files as they are in the end; what the runs before did was kept."""
        assert tables(home / "stopped") == tables(catalogue[1])
        assert int(re.search(r", (\d+) of them done before", ended.last)[1]) > 0

    def test_words_say_what_was_written_and_refused(self, ended):
        first, *files, last = ended.last.splitlines()
        assert first.startswith(f"stopped/index.html: {PARTS} parts, ")
        assert f" {len(REFUSED) + 1} refused, took " in first
        assert files[:2] == [f"stopped/{name}" for name in TABLES]
        assert sum(line.startswith("refused ") for line in files) == 10
        assert last == "and 2 more, with reasons in the table"

    def test_no_name_reaches_the_terminal_as_a_command(self, ended):
        assert "\x1b" not in ended.last and "refused parts/?[31mred.stl: " in ended.last


class TestRows:
    def test_each_file_has_one_in_the_order_of_names_whatever_links_to_it(
        self, catalogue
    ):
        expected = (
            *REFUSED,
            "box.stl",
            "a_changed.stl",
            "a_new.stl",
            "b\udcf6x, 1.stl",
            *(f"below/rock_{seed}.STL" for seed in range(ROCKS)),
        )
        names = ["./\ufeff =1+1.stl", *sorted(f"parts/{name}" for name in expected)]
        assert [row["file"] for row in catalogue[0]["parts"]] == names
        assert [row["file"] for row in rows_of(catalogue[1])] == names

    def test_what_is_no_part_is_refused_with_a_reason_in_one_line(self, catalogue):
        values, _ = catalogue
        reasons = {
            row["file"]: row["refusal"] for row in values["parts"] if row["refusal"]
        }
        assert len(reasons) == values["refused"] == len(REFUSED) + 1
        for name, words in (
            ("letter.stl", "triangles"),
            ("empty.step", "empty"),
            ("flat.obj", "thick"),
            ("bare.step", "STEP"),
        ):
            assert words in reasons[f"parts/{name}"]
        # Names in reasons stand as they are; the reasons themselves break no line.
        assert not any(
            "\n" in reason for name, reason in reasons.items() if "\n" not in name
        )

    def test_a_box_by_its_closed_forms(self, catalogue):
        row = next(
            row for row in catalogue[0]["parts"] if row["file"] == "parts/box.stl"
        )
        assert (row["stable_poses"], row["distinct_poses"], row["triangles"]) == (
            6,
            3,
            12,
        )
        assert [row[f"size_{axis}_m"] for axis in "xyz"] == pytest.approx(
            [0.01, 0.02, 0.03]
        )
        best = [
            row[name] for name in ("footprint_length_m", "footprint_width_m", "top_m")
        ]
        assert best == pytest.approx([0.03, 0.02, 0.01])
        shares = {pose["group"]: pose["group_share"] for pose in row["poses"]}
        assert row["entropy_bits"] == pytest.approx(
            -sum(share * math.log2(share) for share in shares.values())
        )
        for end, counterpart in (("", ""), ("_low", "_high"), ("_high", "_low")):
            assert row[f"passes{end}"] == pytest.approx(
                1.0 / row[f"best_share{counterpart}"]
            )
        for pose in row["poses"]:
            sides = [
                pose[name]
                for name in ("footprint_length_m", "footprint_width_m", "top_m")
            ]
            assert sorted(sides) == pytest.approx([0.01, 0.02, 0.03])
            assert pose["height_m"] == pytest.approx(0.5 * pose["top_m"])

    def test_the_options_reach_the_estimate(self, home, catalogue):
        row = next(
            row for row in catalogue[0]["parts"] if row["file"].endswith("rock_3.STL")
        )
        part = load_part(home / row["file"], "cm", density=7850.0)
        expected = estimate(part, restitution=0.2, drop_height=0.4)
        assert row["part_digest"] == part.digest and row["warnings"] == list(
            expected.warnings
        )
        assert {pose["pose"]: pose["probability"] for pose in row["poses"]} == {
            pose.index: pose.probability for pose in expected.poses
        }


def test_guessed_units_are_counted_in_one_line(tmp_path):
    """On terminal and page; the rows keep the warning with the other lengths."""
    parts = tmp_path / "parts"
    parts.mkdir()
    for name, scale in (("a", 1.0), ("b", 2.0), ("c", 0.001), ("huge", 300.0)):
        write_stl(parts / f"{name}.stl", shapes.box(*(scale * np.array((9, 10, 11)))))
    guesses = "3 units guessed as mm, 1 unit guessed as m"
    request = ("catalogue", parts, "--workers", 1, "-o", tmp_path / "out")
    lines = answer(*request).splitlines()
    assert "warnings about 1 of 4 parts: UNIT_SUSPECT 1" in lines
    assert f"{guesses}; --unit makes sure" in lines
    values = answer_json(*request)
    assert (values["guessed"], values["warnings"]) == (
        {"mm": 3, "m": 1},
        {"UNIT_SUSPECT": 1},
    )
    assert [(row["unit_m"], row["unit_guessed"]) for row in values["parts"]] == [
        (0.001, True),
        (0.001, True),
        (1.0, True),
        (0.001, True),
    ]
    assert all(row["warnings"][0].startswith("UNIT_G") for row in values["parts"])
    page = (tmp_path / "out" / "index.html").read_text()
    assert page.replace("\xa0", " ").count(guesses) == 1
    assert "UNIT_GUESSED" not in page


def test_no_module_comes_from_where_the_command_is_started(home, catalogue):
    assert not (home / "ran").exists()


class TestTables:
    def test_they_hold_what_the_object_says(self, catalogue):
        values, folder = catalogue
        assert values["tables"] == [
            str(Path("out", name).with_suffix(kind))
            for name in TABLES
            for kind in (".csv", ".parquet")
        ]
        for row, entry in zip(rows_of(folder), values["parts"], strict=True):
            assert row["refusal"] == entry["refusal"]
            assert row["best_share"] == (
                "" if entry["refusal"] else str(entry["best_share"])
            )
        poses = rows_of(folder, "poses.csv")
        assert len(poses) == sum(len(row.get("poses", ())) for row in values["parts"])
        for name in ("parts/box.stl", "parts/below/rock_3.STL"):
            assert sum(
                float(pose["probability"]) for pose in poses if pose["file"] == name
            ) == pytest.approx(1.0)

    @pytest.mark.parametrize("name", TABLES)
    def test_parquet_holds_the_same(self, catalogue, name):
        rows = parquet.read_table(
            (catalogue[1] / name).with_suffix(".parquet")
        ).to_pylist()
        for row, text in zip(rows, rows_of(catalogue[1], name), strict=True):
            assert {
                key: "" if value is None else str(value) for key, value in row.items()
            } == {
                key: value.encode(errors="replace").decode()
                for key, value in text.items()
            }

    def test_lines_end_as_those_of_unix(self, catalogue):
        text = (catalogue[1] / "poses.csv").read_bytes()
        assert b"\r" not in text and text.endswith(b"\n")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--unit", "mm"), "unit"),
        (("--restitution", 0.3), "restitution"),
        (("--target-error", 0.1), "target_error"),
    ],
)
def test_a_folder_of_another_request_is_refused_and_kept(catalogue, options, words):
    contents = tables(catalogue[1])
    line = refusal(*ASKED, *options, "-o", "out")
    assert "the same catalogue" in line and words in line
    assert tables(catalogue[1]) == contents


@pytest.mark.parametrize("name", ["index.html", "catalogue.parquet"])
def test_a_file_of_somebody_else_is_kept(home, tmp_path, name):
    (tmp_path / name).write_text("mine")
    assert "files without a readable request.json" in refusal(*ASKED, "-o", tmp_path)
    assert (tmp_path / name).read_text() == "mine"


def test_a_part_that_ends_its_process_is_refused_and_costs_no_other(tmp_path):
    """As one does that makes a library crash: here reading it is an abort."""
    for name in ("box.stl", "deadly.stl", "other.stl"):
        write_stl(tmp_path / name, shapes.box(10.0, 20.0, 30.0))
    (tmp_path / "sitecustomize.py").write_text(
        "import os\n"
        "usual = os.open\n"
        "def deadly(path, *how, **more):\n"
        "    if str(path).endswith('deadly.stl'):\n"
        "        os.abort()\n"
        "    return usual(path, *how, **more)\n"
        "os.open = deadly\n"
    )
    outcome = subprocess.run(
        [
            sys.executable,
            "-m",
            "ros_pose_stats",
            "catalogue",
            tmp_path,
            "--unit",
            "mm",
            "--workers",
            "1",
            "-o",
            tmp_path / "out",
        ],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}"},
    )
    assert outcome.returncode == 0 and ": 3 parts, 1 refused" in outcome.stdout
    assert (
        "deadly.stl: the process that looked at it ended by SIGABRT" in outcome.stdout
    )


@pytest.mark.long
def test_drops_keep_the_target_whatever_the_workers(tmp_path):
    parts = tmp_path / "parts"
    parts.mkdir()
    for seed in range(2):
        write_stl(parts / f"rock_{seed}.stl", random_polyhedron(9, seed))
    write_stl(parts / "plate.stl", shapes.box(40.0, 30.0, 1.0))
    for workers in (1, 3):
        values = answer_json(
            "catalogue",
            parts,
            "--unit",
            "mm",
            "--target-error",
            0.02,
            "--workers",
            workers,
            "-o",
            tmp_path / str(workers),
        )
        drops = {Path(row["file"]).stem: row["drops"] for row in values["parts"]}
        assert drops["rock_0"] > 0 and drops["rock_1"] > 0
        assert all(row["expected_error"] <= 0.02 for row in values["parts"])
    assert tables(tmp_path / "1") == tables(tmp_path / "3")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--target-error", "1"), "target error"),
        (("--density", "0"), "density"),
        (("--workers", "0"), "workers"),
        (("--workers", "1025"), "workers"),
        (("--restitution", "1"), "restitution"),
        (("--round-sides", "3"), "sides"),
    ],
)
def test_values_out_of_range_are_refused(home, tmp_path, options, words):
    assert words in refusal(
        "catalogue", home / "parts", "-o", tmp_path / "out", *options
    )
    assert not (tmp_path / "out").exists()


def test_a_package_that_is_missing_is_named(home, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    line = refusal(*ASKED, "-o", tmp_path / "out", "--parquet")
    assert "the module pyarrow" in line
    assert "pip install 'ros_pose_stats[parquet]'" in line
    assert not (tmp_path / "out").exists()


def test_files_of_one_name_and_another_size_are_named_however_turned(tmp_path):
    """Beside one of a name as long as can be, whose report has a shorter one."""
    (tmp_path / "out" / "reports").mkdir(parents=True)
    write_stl(tmp_path / f"{'n' * 251}.stl", shapes.box(10.0, 20.0, 30.0))
    for name, size in (("box.STL", 1.0), ("box.stl", 10.0)):
        write_stl(tmp_path / name, shapes.box(size, size, 3.0 * size))
    turn = (0.6, -0.8, 0.0), (0.8, 0.6, 0.0), (0.0, 0.0, 1.0)
    write_stl(tmp_path / "cube.STL", shapes.box(10.0, 10.0, 10.0))
    write_stl(tmp_path / "cube.stl", moved(shapes.box(10.0, 10.0, 10.0), turn))
    outcome = call(
        "catalogue", tmp_path, "--unit", "mm", "-o", tmp_path / "out", "--workers", 1
    )
    assert re.search(
        r"unit of \S*/box.stl: it is 30 mm long, \S*/box.STL 3 mm", outcome.stdout
    )
    page = (tmp_path / "out" / "index.html").read_text()
    assert (
        outcome.stdout.count("check the unit of")
        == page.count("Check the unit of")
        == 1
    )


def test_a_scheduler_that_is_none_leaves_the_folder_to_others(home, tmp_path):
    pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
    request = "catalogue", home / "parts" / "box.stl", "-o", tmp_path / "out"
    assert "a scheduler that answers" in refusal(*request, "--scheduler", "nowhere://")
    assert not (tmp_path / "out").exists()


def test_no_parts_are_refused(tmp_path):
    (tmp_path / "notes.txt").touch()
    assert "none in" in refusal("catalogue", tmp_path, "-o", tmp_path / "out")
    assert "no file" in refusal(
        "catalogue", tmp_path / "\x1bgone", "-o", tmp_path / "out"
    )
    assert [file.name for file in tmp_path.iterdir()] == ["notes.txt"]


@pytest.fixture
def made(tmp_path):
    """A catalogue of a box, and how to ask for it again."""
    file = tmp_path / "box.stl"
    write_stl(file, shapes.box(10.0, 20.0, 30.0))
    request = "catalogue", file, "--unit", "mm", "-o", tmp_path / "out", "--workers", 1
    assert call(*request).returncode == 0
    return tmp_path / "out", request


@pytest.mark.parametrize("change", ["pages", "row"])
def test_damaged_rows_are_refused_with_what_to_do(made, change):
    folder, request = made
    rows = folder / "parts.sqlite3"
    content = bytearray(rows.read_bytes())
    if change == "row":
        share = content.rfind(b'"best_share": 0.')
        content[share + len('"best_share": 0.')] ^= 1
    else:
        content[4096:] = bytes(len(content) - 4096)
    rows.write_bytes(content)
    line = refusal(*request)
    assert "the rows of an earlier run" in line and "delete it" in line


def test_a_request_nested_without_end_is_refused(made):
    folder, request = made
    (folder / "request.json").write_text("[" * 100_000)
    assert "files without a readable request.json" in refusal(*request)


def test_what_lies_under_the_name_of_a_picture_is_replaced(made, tmp_path):
    """A pipe would be written to for ever, and a link leads to a file of somebody."""
    folder, request = made
    (picture,) = (folder / "pictures").rglob("*.png")
    content = picture.read_bytes()
    picture.unlink()
    os.mkfifo(picture)
    assert call(*request).returncode == 0
    assert picture.read_bytes() == content
    (tmp_path / "mine").touch()
    picture.unlink()
    picture.symlink_to(tmp_path / "mine")
    assert call(*request).returncode == 0
    assert picture.read_bytes() == content
    assert (tmp_path / "mine").read_bytes() == b""
