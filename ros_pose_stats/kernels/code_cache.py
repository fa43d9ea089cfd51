"""Where the machine code of kernels is kept: one file each, in a folder named after its sources.

numba's own cache goes by the path and time stamp of the file that defines a function, and
does not notice an edit in a helper or a constant imported from elsewhere. Here the name of the
folder is a digest of every source that a kernel can depend on, of the compiler, and of the
processors that the code is for: any checkout or installation of the same sources finds it.
"""

from __future__ import annotations

import hashlib
import os
import sys
import tempfile
from functools import lru_cache
from pathlib import Path

import llvmlite
import numba

SEAL = 32
"""Bytes of the digest at the head of a file."""


class DamagedCodeError(Exception):
    """A file that is not as it was written."""


def source_digest() -> str:
    """Digest of the sources that the compiled code depends on, and of the compiler."""
    package = Path(__file__).resolve().parent
    compiler = (numba.__version__, llvmlite.__version__, sys.implementation.cache_tag)
    digest = hashlib.sha256(repr(compiler).encode())
    for source in sorted([*package.rglob("*.py"), package.parent / "tolerances.py"]):
        digest.update(source.name.encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


@lru_cache(maxsize=1)
def cache_directory() -> Path:
    """Directory of the machine code: `$NUMBA_CACHE_DIR` or the user's cache, by digest.

    Where none can be written, a folder for this process alone is used. The code is unpickled,
    so a directory that somebody else owns is not taken.
    """
    name = source_digest()
    roots = [os.environ.get("NUMBA_CACHE_DIR"), os.environ.get("XDG_CACHE_HOME"), "~/.cache"]
    for root in roots:
        if not root:
            continue
        directory = Path(root).expanduser() / "ros_pose_stats" / name
        try:
            directory.mkdir(parents=True, exist_ok=True)
        except (OSError, RuntimeError):
            continue
        if os.access(directory, os.W_OK) and directory.stat().st_uid == os.getuid():
            return directory
    return Path(tempfile.mkdtemp(prefix="ros_pose_stats_"))


def read_sealed(file: Path) -> bytes | None:
    """What `write_sealed` was given; None where there is no file."""
    try:
        stored = file.read_bytes()
    except FileNotFoundError:
        return None
    seal, content = stored[:SEAL], stored[SEAL:]
    if hashlib.sha256(content).digest() != seal:
        raise DamagedCodeError("its digest is not that of its content")
    return content


def write_sealed(file: Path, content: bytes) -> None:
    """Write a file in one step, with a digest that tells whether it is whole."""
    file.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(dir=file.parent, prefix=file.name, suffix=".new")
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(hashlib.sha256(content).digest() + content)
        Path(temporary).replace(file)
    except BaseException:
        Path(temporary).unlink()
        raise
