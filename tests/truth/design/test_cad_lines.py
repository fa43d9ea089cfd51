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

"""The lines for CAD systems: what they say, and that real systems run them."""

import subprocess
import sys
from pathlib import Path

import pytest

from ros_pose_stats import load_part
from ros_pose_stats.tools.commands.report import CAD_SYSTEMS
from ros_pose_stats.tools.watching.cad_lines import cad_lines
from tests.running import refusal_of

NAMES = ("bracket.stl", 'it\'s "new".STEP', "part 2.stp")


@pytest.mark.parametrize("system", CAD_SYSTEMS)
@pytest.mark.parametrize("name", NAMES)
def test_they_are_python_and_few_and_rename_what_is_whole(system, name):
    file = Path("/made/up") / name
    lines = cad_lines(system, file)
    compile(lines, "lines", "exec")
    assert len(lines.splitlines()) <= 22
    unfinished = file.with_name(f".{file.stem}.unfinished{file.suffix}")
    assert f"os.replace({str(unfinished)!r}, {str(file)!r})" in lines


def test_a_file_that_no_system_writes_is_refused():
    assert ".stl, .step or .stp" in refusal_of(cad_lines, "freecad", Path("part.obj"))


SCRIPTS = {
    "cadquery": "import cadquery\nresult = cadquery.Workplane().box(20, 30, 40)\n",
    "build123d": "import build123d\npart = build123d.Box(20, 30, 40)\n",
}


@pytest.mark.parametrize("kind", ["stl", "step"])
@pytest.mark.parametrize("system", SCRIPTS)
def test_scripts_write_their_part(system, kind, tmp_path):
    pytest.importorskip(system, reason=f"{system} is not installed")
    file = tmp_path / f"box.{kind}"
    script = tmp_path / "box.py"
    script.write_text(SCRIPTS[system] + cad_lines(system, file))
    subprocess.run([sys.executable, script], check=True)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["box.py", file.name]
    assert sorted(load_part(file, "mm").vertices.max(axis=0)) == pytest.approx(
        [0.01, 0.015, 0.02], abs=1e-6
    )


FREECAD = """\
import FreeCAD
document = FreeCAD.newDocument()
box = document.addObject("Part::Box")
box.Length, box.Width, box.Height = 20, 30, 40
document.recompute()
{lines}
box.Height = 50
document.recompute()
other = FreeCAD.newDocument()
other.addObject("Part::Box")
other.recompute()
"""


@pytest.mark.parametrize("kind", ["stl", "step"])
def test_a_document_of_freecad_writes_its_part_on_every_recompute(kind, tmp_path):
    pytest.importorskip("FreeCAD", reason="FreeCAD is not on the path")
    file = tmp_path / f"box.{kind}"
    script = tmp_path / "box.py"
    script.write_text(FREECAD.format(lines=cad_lines("freecad", file)))
    subprocess.run([sys.executable, script], check=True)
    assert sorted(load_part(file, "mm").vertices.max(axis=0)) == pytest.approx(
        [0.02, 0.03, 0.05], abs=1e-6
    )
