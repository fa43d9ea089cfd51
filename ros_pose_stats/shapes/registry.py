"""The demo parts by name, and their STL files."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh.exchange.stl import export_stl

from ..errors import MeshFileError
from . import demo_parts
from .polytopes import Surface

DEMO_PARTS: dict[str, Callable[[], Surface]] = {
    "clamp": demo_parts.clamp,
    "bracket": demo_parts.bracket,
    "hex_bolt": demo_parts.hex_bolt,
    "gear": demo_parts.gear,
    "prism": demo_parts.prism,
    "cylinder": demo_parts.cylinder,
}
"""Name to a function that makes the part: vertices (V, 3) in mm and triangles (T, 3)."""


def write_demo_parts(directory: str | os.PathLike[str]) -> list[Path]:
    """Write each demo part to `<name>.stl`, binary STL in millimetres.

    Parameters
    ----------
    directory : path
        Created when it does not exist. Files of the same names are replaced, each at once:
        a reader sees the old file or the new one, never a part of it.

    Returns
    -------
    list of Path
        The files, in the order of `DEMO_PARTS`; the same bytes in every run.

    Raises
    ------
    MeshFileError
        If the path is no directory or cannot be written to.
    """
    folder = Path(directory)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        return [
            _write_whole(folder / f"{name}.stl", _stl_bytes(*make()))
            for name, make in DEMO_PARTS.items()
        ]
    except OSError as error:
        raise MeshFileError(
            "a directory that can be written to",
            f"{folder} ({error.strerror or error})",
            "name another directory or change its permissions",
        ) from error


def _stl_bytes(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> bytes:
    """Binary STL of a surface, vertices as they are."""
    return export_stl(trimesh.Trimesh(vertices, triangles, process=False))


def _write_whole(path: Path, content: bytes) -> Path:
    """Write under a temporary name beside `path`, then rename."""
    partial = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        partial.write_bytes(content)
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)
    return path
