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

"""What a catalogue is asked for: files of parts, and how to look at them."""

import os
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from ...base import errors, files, text
from ...core.mesh import mass_properties
from ...core.mesh.files import SUFFIXES
from ...core.records import DropScene
from ...core.simulation.request import drop_request


@dataclass(frozen=True)
class CatalogueRequest:
    """All that the row of a part depends on, besides its file and the program."""

    scene: DropScene = field(default_factory=DropScene)
    unit: str | None = None  # of files that declare none; as for `load_part`
    density: float | None = None  # kg/m³; as for `load_part`
    # error over the poses, a fraction: parts whose estimate is not that sure are
    # dropped; 0 asks for estimates alone
    target_error: float = 0.0

    def __post_init__(self) -> None:
        mass_properties.check_properties(None, None, None, self.density)
        drop_request(1, None, self.target_error, None, None)

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return {
            "unit": self.unit,
            "density": self.density,
            **asdict(self.scene),
            "target_error": self.target_error,
        }


class PartFile(NamedTuple):
    """A file, and by what one sees that it has changed."""

    # path as it was given, or below a folder that was given; `./` before one that a
    # spreadsheet would take for a formula
    name: str
    bytes: int  # its size; -1 for a file that cannot be looked at
    mtime_ns: int  # time of its last change


def find_parts(paths: Sequence[str | os.PathLike[str]]) -> list[PartFile]:
    """Files of parts, each once, by name.

    `paths`: files, taken whatever their kind, and folders with all parts below them
    that are not hidden. A folder to which several links lead counts once.
    """
    paths_of_parts = [str(name) for path in paths for name in _files_of(Path(path))]
    names = {f"./{name}" if text.is_formula(name) else name for name in paths_of_parts}
    if not names:
        raise errors.RequestError(
            f"files of parts ({', '.join(SUFFIXES)})",
            f"none in {', '.join(map(str, paths))}",
            "name a folder that holds some, or the files themselves",
        )
    return [_part_file(name) for name in sorted(names)]


def _files_of(path: Path) -> Iterator[Path]:
    if not path.is_dir():
        if not path.exists():
            raise errors.RequestError(
                "files of parts, and folders of such",
                f"no file {path}",
                "check the path",
            )
        yield path
        return
    for folder, file_names in files.folders_below(path):
        for name in file_names:
            if name.lower().endswith(SUFFIXES):
                yield Path(folder, name)


def _part_file(name: str) -> PartFile:
    try:
        status = os.stat(name)  # noqa: PTH116 - hundreds of thousands of times
    except OSError:  # a broken link; its row will say so
        return PartFile(name, -1, -1)
    return PartFile(name, status.st_size, status.st_mtime_ns)
