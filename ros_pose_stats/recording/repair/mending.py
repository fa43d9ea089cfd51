"""Making a bag whole that its writer could not finish."""

from __future__ import annotations

import errno
import os
import shutil
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Final

from mcap.opcode import Opcode

from ..durable import replace_file, sync_directory
from ..finished import finished_contents, is_described
from ..reader.scan import frames
from ..run_names import HALF, METADATA, bag_files
from ..writer.bag_metadata import metadata_yaml
from ..writer.contents import Contents
from ..writer.mcap_layout import closing
from .sound_part import SoundPart

_BLOCK: Final = 1 << 20


@dataclass(frozen=True)
class Mended:
    """What became of a bag.

    Attributes
    ----------
    kept : int
        Messages in it.
    cut_bytes : int
        Bytes that were no whole record and are gone.
    """

    kept: int
    cut_bytes: int


def mend(directory: Path) -> Mended:
    """Finish all files of a run and describe them anew. The caller has its lock.

    Every step leaves either the old file or the new one, so that this may be killed and
    repeated.

    Raises
    ------
    OSError
        It cannot be done now; nothing is lost.
    """
    files: dict[str, Contents] = {}
    cut_bytes = 0
    for path in bag_files(directory):
        contents = finished_contents(path)
        if contents is None:
            contents, cut = _mend_file(path)
            cut_bytes += cut
        files[path.name] = contents
    if files and not is_described(directory, files):
        replace_file(directory / METADATA, metadata_yaml(files).encode())
    for name in (*files, METADATA):
        with suppress(OSError):
            (directory / (name + HALF)).unlink()
    return Mended(sum(contents.messages for contents in files.values()), cut_bytes)


def _mend_file(path: Path) -> tuple[Contents, int]:
    """Write the sound part of a file, closed, in its place; return it and the bytes cut."""
    half = path.with_name(path.name + HALF)
    try:
        with path.open("rb") as old, half.open("wb") as new:
            sound = SoundPart(os.fstat(old.fileno()).st_mtime_ns)
            for frame in frames(old, sound.on_damage):
                if frame.opcode == Opcode.DATA_END:
                    break
                sound.keep(frame)
            new.write(sound.start)
            for begin, end in sound.ranges:
                _copy(old, new, begin, end)
            new.write(closing(path.name, sound.contents, sound.size))
            new.flush()
            os.fsync(new.fileno())
        shutil.copymode(path, half)
        half.replace(path)
        sync_directory(path.parent)
    except OSError:
        with suppress(OSError):
            half.unlink()
        raise
    return sound.contents, sound.cut_bytes


def _copy(old: BinaryIO, new: BinaryIO, begin: int, end: int) -> None:
    old.seek(begin)
    while begin < end:
        block = old.read(min(_BLOCK, end - begin))
        if not block:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        begin += new.write(block)
