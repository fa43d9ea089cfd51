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

"""Lines for a CAD system that write its part over a file that a page follows.

They use what the system has and nothing of this package. A file is written under
another name and then renamed, so that none is seen half.
"""

from pathlib import Path
from typing import NamedTuple

from ...base.errors import RequestError

_FREECAD = """\
# FreeCAD: paste this into the Python console while the document is open. From then on
# each recompute of that document writes its visible solids, in millimetres.
import os
import FreeCAD
import Part

class PartFollower:
    document = FreeCAD.ActiveDocument.Name
    def slotRecomputedDocument(self, document):
        visible = [item for item in document.RootObjects if item.Visibility]
        shapes = [Part.getShape(item) for item in visible]
        solids = sum((shape.Solids for shape in shapes if not shape.isNull()), [])
        if solids and document.Name == self.document:
            Part.makeCompound(solids).{export}({unfinished!a})
            os.replace({unfinished!a}, {file!a})

follower = PartFollower()
FreeCAD.addDocumentObserver(follower)
follower.slotRecomputedDocument(FreeCAD.ActiveDocument)
"""

_CADQUERY = """\
# CadQuery: put this at the end of the script, whose part is called `result`. Each run
# writes it, in millimetres.
import os
import cadquery

cadquery.exporters.{export}(result, {unfinished!a})
os.replace({unfinished!a}, {file!a})
"""

_BUILD123D = """\
# build123d: put this at the end of the script, whose part is called `part`. Each run
# writes it, in millimetres.
import os
import build123d

build123d.{export}(part, {unfinished!a})
os.replace({unfinished!a}, {file!a})
"""


class _System(NamedTuple):
    """What a CAD system is given, and its functions that write a file."""

    lines: str
    stl: str
    step: str


_SYSTEMS = {
    "freecad": _System(_FREECAD, "exportStl", "exportStep"),
    "cadquery": _System(_CADQUERY, "export", "export"),  # by the file's name
    "build123d": _System(_BUILD123D, "export_stl", "export_step"),
}


def cad_lines(system: str, file: Path) -> str:
    """Lines of Python for `freecad`, `cadquery`, `build123d`; they write to `file`."""
    writer = _SYSTEMS[system]
    suffix = file.suffix.lower()
    if suffix not in (".stl", ".step", ".stp"):
        raise RequestError(
            "a file that CAD systems write, .stl, .step or .stp",
            f"{file.name!r}",
            "follow one of these, for instance part.stl",
        )
    path = file.absolute()
    unfinished = path.with_name(f".{path.stem}.unfinished{path.suffix}")
    return writer.lines.format(
        export=writer.stl if suffix == ".stl" else writer.step,
        unfinished=str(unfinished),
        file=str(path),
    )
