"""How kernels are compiled and where the machine code is kept.

numba's own cache keys a function by the time stamp of the file that defines it and does
not notice an edit in a helper or a constant imported from elsewhere. The cache directory
is therefore named after a digest of every source that a kernel can depend on.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
import warnings
from collections.abc import Callable
from functools import lru_cache, wraps
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba import njit
from numba.core import config as _config

config: Any = _config  # its names are made at import and unknown to type checkers

Function = TypeVar("Function", bound=Callable[..., Any])

# No fastmath: "no event" is infinity, and it would be assumed away.
OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy"}

# Without the run time of numba a helper counts no references, and can make no arrays.
INLINED: dict[str, Any] = {"forceinline": True, "_nrt": False}


def source_digest() -> str:
    """Digest of the sources that the compiled code depends on, and of the compiler."""
    package = Path(__file__).resolve().parent
    digest = hashlib.sha256(numba.__version__.encode())
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


def kernel(function: Function) -> Function:
    """Compile a helper into the kernels that call it."""
    compiled: Function = njit(**OPTIONS)(function)
    return compiled


def inlined(function: Function) -> Function:
    """Compile a helper that is merged into its caller and borrows the arrays it is handed.

    Counting their references would cost more than a short helper's arithmetic. It cannot
    make arrays of its own.
    """
    compiled: Function = njit(**INLINED, **OPTIONS)(function)
    return compiled


def entry_kernel(function: Function) -> Function:
    """Compile an outermost kernel and keep its machine code on disk."""
    previous = config.CACHE_DIR
    config.CACHE_DIR = str(cache_directory())
    try:
        compiled: Function = njit(cache=True, **OPTIONS)(function)
    finally:
        config.CACHE_DIR = previous

    @wraps(function)
    def call(*arguments: Any) -> Any:
        nonlocal compiled
        try:
            return compiled(*arguments)
        except Exception as error:
            # Kernels raise nothing: what comes here is a damaged cache or a full disk. A real
            # fault comes again below.
            warnings.warn(f"kernel cache in {cache_directory()} is of no use "
                          f"({type(error).__name__}: {error}); delete it",
                          RuntimeWarning, stacklevel=2)
            compiled = njit(**OPTIONS)(function)
            return compiled(*arguments)

    kept: Function = call  # type: ignore[assignment]
    return kept
