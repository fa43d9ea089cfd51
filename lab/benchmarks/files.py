"""Mesh and STEP files of one's own, and the parts in them."""

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from ros_pose_stats import Part, load_part
from ros_pose_stats.base.errors import PoseStatsError
from ros_pose_stats.core.mesh.files import SUFFIXES


def files_in(folders: Sequence[Path]) -> list[Path]:
    """Every mesh and STEP file under some folders, and files given by name."""
    files = {
        file
        for folder in folders
        for file in (folder.rglob("*") if folder.is_dir() else [folder])
        if file.suffix.lower() in SUFFIXES
    }
    return sorted(files)


def loaded(files: Sequence[Path]) -> Iterator[tuple[str, Part]]:
    """Parts that can be loaded; others are told of on standard error."""
    for file in files:
        try:
            yield file.name, load_part(file, "auto")
        except PoseStatsError as error:
            print(f"left out: {error}", file=sys.stderr)
