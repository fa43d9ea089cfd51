"""Where a command writes its file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ..errors import RequestError


def output_file(name: str, endings: Sequence[str]) -> Path:
    """Path of a file to be written, checked before anything is computed.

    Raises
    ------
    RequestError
        If its ending is none of those expected, it is a folder, or its folder cannot be
        written to.
    """
    from ..whole_files import refuse_unwritable

    path = Path(name)
    if path.suffix.lower() not in endings or path.is_dir():
        raise RequestError(f"a file name that ends in {' or '.join(endings)}", f"{name!r}",
                           f"for instance part{endings[0]}")
    refuse_unwritable(path.parent)
    return path
