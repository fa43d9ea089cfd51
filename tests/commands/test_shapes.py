"""`shapes DIR`: writes the demo parts and names the files."""

from __future__ import annotations

from pathlib import Path

from ros_pose_stats import cli, estimate, load_part
from ros_pose_stats.shapes import demo_parts
from tests.running import answer, command


def test_writes_and_names_the_files(tmp_path):
    names = answer("shapes", tmp_path / "parts").splitlines()
    assert [Path(name).stem for name in names] == list(demo_parts.DEMO_PARTS)
    assert all(Path(name).is_file() for name in names)


def test_every_file_can_be_estimated(tmp_path, capsys):
    assert cli.main(["shapes", str(tmp_path)]) == 0
    for name in capsys.readouterr().out.splitlines():
        found = estimate(load_part(name, unit="mm"))
        assert 2 < len(found.poses) < 10
        assert not any(warning.startswith(("OPEN", "BODIES", "UNIT"))
                       for warning in found.warnings)


def test_a_directory_that_cannot_be_made_is_refused(tmp_path):
    (tmp_path / "file").write_text("in the way")
    done = command("shapes", tmp_path / "file" / "parts")
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert "name another directory" in done.stderr
