"""What a mesh file holds, as bytes."""

from __future__ import annotations

import stat
from pathlib import Path
from typing import Final

from ..errors import MeshFileError
from .step import STEP_SUFFIXES

SUFFIXES: Final = (".stl", ".obj", ".ply", ".off", ".3mf", *STEP_SUFFIXES)

_KINDS: Final = {stat.S_IFIFO: "a pipe", stat.S_IFSOCK: "a socket", stat.S_IFCHR: "a device",
                 stat.S_IFBLK: "a device"}


def read_bytes(path: Path) -> bytes:
    """Read a whole mesh file.

    Raises MeshFileError if it is missing, empty, of an unknown format, or no regular file: reading
    a pipe or a device may never end.
    """
    if path.is_dir():
        raise MeshFileError("a mesh file", f"the directory {path}", "name a file in it")
    if path.suffix.lower() not in SUFFIXES:
        raise MeshFileError(f"a mesh file ({', '.join(SUFFIXES)})", f"{path}",
                            "export the part as STEP, STL or 3MF")
    try:
        mode = path.stat().st_mode
        data = path.read_bytes() if stat.S_ISREG(mode) else b""
    except OSError as error:
        raise MeshFileError("a readable mesh file", f"{path} ({error.strerror})",
                            "check the path and its permissions") from error
    if not stat.S_ISREG(mode):
        kind = _KINDS.get(stat.S_IFMT(mode), "no regular file")
        raise MeshFileError("a mesh file", f"{path}, which is {kind}",
                            "write what comes from it to a file")
    if not data:
        raise MeshFileError("a mesh file with content", f"{path}, which is empty",
                            "export it again")
    return data
