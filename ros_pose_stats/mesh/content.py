"""What a mesh file holds, as bytes."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from ..errors import MeshFileError
from ..files import NotAFileError, read_file
from .step import STEP_SUFFIXES

SUFFIXES: Final = (".stl", ".obj", ".ply", ".off", ".3mf", *STEP_SUFFIXES)


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
        data = read_file(path)
    except NotAFileError as error:
        raise MeshFileError("a mesh file", f"{path}, which is {error.strerror}",
                            "write what comes from it to a file") from error
    except OSError as error:
        raise MeshFileError("a readable mesh file", f"{path} ({error.strerror})",
                            "check the path and its permissions") from error
    if not data:
        raise MeshFileError("a mesh file with content", f"{path}, which is empty",
                            "export it again")
    return data
