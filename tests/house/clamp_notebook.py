"""The notebook docs/clamp.ipynb: its cells, run once, with what they print and draw.

.venv/bin/python -m tests.house.clamp_notebook writes it anew.
"""

from __future__ import annotations

import base64
import contextlib
import io
import json
from pathlib import Path
from typing import Any

from ros_pose_stats.plots.files import figure_png

NOTEBOOK = Path(__file__).resolve().parents[2] / "docs" / "clamp.ipynb"

CELLS: tuple[tuple[str, str], ...] = (
    ("markdown", """# One clamp, from its present best share to its best

A feeder drops a clamp onto a plate, and a robot picks those that lie on their flat side with
the counterbore up: pose 0. The others go round again. The designer may still change the part
by a millimetre or two. Which millimetre?"""),
    ("code", """from ros_pose_stats import estimate, part_from_mesh
from ros_pose_stats.shapes.demo_parts import clamp

part = part_from_mesh(*clamp(), unit="mm", part_id="clamp")
for pose in estimate(part).poses:
    down = pose.down.round(2) + 0.0
    print(f"pose {pose.index}: {100 * pose.probability:4.1f} %  down {down}")"""),
    ("markdown", """Two flat sides share most of the drops, nearly evenly. Only one is wanted.

## What does each change do?

`sensitivity` asks the fast estimator about the centre of mass, stretching, every resting face
and every edge of the hull, and checks the five best changes by drops of the part before and
after, from the same starts."""),
    ("code", """from ros_pose_stats import sensitivity
from ros_pose_stats.design.describe import name_feature, name_step

found = sensitivity(part, wanted=[0], drops=2000, seed=1)
for one in found.effects[:8]:
    points, unit = (0.1, "mm") if one.feature.is_length else (1.0, "%")
    print(f"{name_feature(found.space, one.number):32s} {points * one.slope:+.2f} "
          f"± {points * one.error:.2f} points a {unit}")
print(f"by {found.drops} drops:")
for one in sorted((one for one in found.effects if one.check), key=lambda one: -one.change):
    print(f"{name_step(found.space, one.number, one.step):42s} {100 * one.check.value:+.1f} "
          f"({100 * one.check.low:+.1f} to {100 * one.check.high:+.1f}) points")"""),
    ("markdown", """The centre of mass is the strongest lever: a wider and deeper
counterbore moves it towards the plate. On the part itself, orange is where to take away and
blue where to add; the arrow leads the centre of mass to where it is better."""),
    ("code", """from ros_pose_stats.plots.changes import changes_figure

changes_figure(found)"""),
    ("markdown", """## A change by hand

`DesignSpace` makes changed parts out of the one that it knows: hull, poses and symmetry are
found once, and an estimate of a changed part takes milliseconds. So a curve is as quick as a
number."""),
    ("code", """import numpy as np
from ros_pose_stats import DropScene
from ros_pose_stats.design.changes import DesignSpace
from ros_pose_stats.design.shares import WantedShare
from ros_pose_stats.plots.style import new_figure

space = DesignSpace(part)
share = WantedShare(space, [0], DropScene())
shifts = np.linspace(-4e-3, 4e-3, 33)
CENTRE_ALONG_Z = 2
curve = [share.estimate(space.change_one(CENTRE_ALONG_Z, shift)) for shift in shifts]
figure = new_figure(5.0, 2.6, layout="constrained")
axes = figure.add_subplot(xlabel="centre of mass along z, mm", ylabel="pose 0, %")
axes.plot(1e3 * shifts, 100 * np.array(curve))
figure"""),
    ("markdown", """## The best within a millimetre, and within two

`suggest` combines changes while outline and centre of mass stay within a bound. The estimator
chooses, so its own number flatters the choice; the drops had no say in it and are what to
believe."""),
    ("code", """from ros_pose_stats import suggest
from ros_pose_stats.design.describe import JUDGED, suggested_steps

for within in (1e-3, 2e-3):
    best = suggest(part, wanted=[0], within=within, drops=4000, seed=2)
    print(f"within {1e3 * within:g} mm:", *suggested_steps(best), sep="\\n  ")
    print(f"  by estimate {100 * best.before:.1f} -> {100 * best.after:.1f} %, by drops "
          f"{100 * best.dropped_before.value:.1f} -> {100 * best.dropped_after.value:.1f} % "
          f"(gain {100 * best.gain.low:.1f} to {100 * best.gain.high:.1f} points)")
print(JUDGED)"""),
    ("markdown", """## Back to CAD

The changed hull is an STL to lay over the model; the command does the same: `ros_pose_stats
sensitivity demo/clamp.stl --unit mm --wanted 0 --suggest --within 2 --stl hull.stl`. It is an
outline, not a design: walls, screws and what the clamp has to hold are the designer's."""),
    ("code", """from pathlib import Path
from tempfile import TemporaryDirectory
from ros_pose_stats import load_part
from ros_pose_stats.mesh.files import stl_bytes

with TemporaryDirectory() as folder:
    file = Path(folder) / "hull.stl"
    file.write_bytes(stl_bytes(1e3 * best.changed.part.vertices, best.changed.part.triangles))
    hull = load_part(file, unit="mm", center_of_mass=best.changed.part.center_of_mass)
flat = next(pose for pose in estimate(hull).poses if pose.down[2] < -0.9)
print(f"pose 0 of the hull as it is read again, with the inertia of a solid one: "
      f"{100 * flat.probability:.1f} %")
"""),
)
"""Kind and text of each."""


def run_code(text: str, names: dict[str, Any]) -> tuple[str, Any]:
    """Run a cell; returns what it printed, and the value of its last line if that has one."""
    *lines, last = text.rstrip().splitlines()
    printed = io.StringIO()
    try:
        value = compile(last, "<cell>", "eval")
    except SyntaxError:
        lines, value = [*lines, last], None
    with contextlib.redirect_stdout(printed):
        exec(compile("\n".join(lines), "<cell>", "exec"), names)
        result = None if value is None else eval(value, names)
    return printed.getvalue(), result


def write_notebook(file: Path) -> None:
    """Run all cells and write the notebook (nbformat 4.5) with their outputs."""
    names: dict[str, Any] = {}
    cells = []
    for number, (kind, text) in enumerate(CELLS):
        cell: dict[str, Any] = {"cell_type": kind, "id": f"cell-{number}", "metadata": {},
                                "source": text.splitlines(keepends=True)}
        if kind == "code":
            count = sum(one == "code" for one, _ in CELLS[:number + 1])
            cell |= {"execution_count": count, "outputs": _outputs(*run_code(text, names), count)}
        cells.append(cell)
    whole = {"cells": cells, "metadata": {
        "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
        "language_info": {"name": "python"}}, "nbformat": 4, "nbformat_minor": 5}
    file.write_text(json.dumps(whole, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def _outputs(printed: str, value: Any, count: int) -> list[dict[str, Any]]:
    outputs: list[dict[str, Any]] = []
    if printed:
        outputs.append({"output_type": "stream", "name": "stdout",
                        "text": printed.splitlines(keepends=True)})
    if hasattr(value, "savefig"):
        picture = base64.b64encode(figure_png(value)).decode()
        outputs.append({"output_type": "execute_result", "execution_count": count, "metadata": {},
                        "data": {"image/png": picture, "text/plain": ["<Figure>"]}})
    return outputs


if __name__ == "__main__":
    write_notebook(NOTEBOOK)
