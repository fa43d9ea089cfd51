"""Which run a bag is, told by what is inside its files, whatever its directory is called now."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from mcap.opcode import Opcode
from mcap.records import Channel, Metadata

from ...whole_files import open_file
from ..run_names import is_run_name, run_named_in
from ..writer.contents import NODE_KEY
from .raw_reader import files_of_bag, raw_messages
from .scan import UNREADABLE, frames


class RunIdentity(NamedTuple):
    """What stays with a run when it is copied or renamed."""

    run: str  # the name that its directory was made with; names in order are runs in order
    node: str  # name of the node that recorded it


def bags_in(log_directory: Path) -> list[Path]:
    """All directories with MCAP files in a log directory, by name; none where it is missing.

    Raises OSError: the log directory cannot be read.
    """
    try:
        found = sorted(path for path in log_directory.iterdir()
                       if path.is_dir() and not path.name.startswith("."))
    except (FileNotFoundError, NotADirectoryError):
        return []
    return [path for path in found if _has_files(path)]


def identity_of(bag: Path) -> RunIdentity | None:
    """Which run of which node a bag is; None for a bag of another tool, or without messages.

    Every file of a run names itself before its first message.

    Raises OSError: it cannot be read.
    """
    for path in files_of_bag(bag):
        found = _identity_in(path)
        if found is not None and (found.run or is_run_name(bag.name)):
            return RunIdentity(found.run or bag.name, found.node)
    if not is_run_name(bag.name):
        return None
    first = next(raw_messages(bag), None)  # packed into chunks by another tool, or damaged
    return None if first is None else RunIdentity(bag.name, first.node)


def _identity_in(path: Path) -> RunIdentity | None:
    """The same from one file, as far as it stands at its beginning."""
    run = ""
    with open_file(path) as file:
        for frame in frames(file, lambda begin, end: None):
            if frame.opcode in (Opcode.MESSAGE, Opcode.CHUNK):
                break
            with suppress(*UNREADABLE):
                record = frame.record()
                if isinstance(record, Metadata):
                    run = run or run_named_in(record.metadata.get("serialized_metadata", ""))
                elif isinstance(record, Channel) and NODE_KEY in record.metadata:
                    return RunIdentity(run, record.metadata[NODE_KEY])
    return None


def _has_files(path: Path) -> bool:
    with suppress(OSError):
        return bool(files_of_bag(path))
    return is_run_name(path.name)  # reading it will tell what is wrong
