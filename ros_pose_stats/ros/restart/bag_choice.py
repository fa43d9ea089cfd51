"""Which bags the node begins with."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from ...recording.finished import is_finished
from ...recording.reader.raw_reader import finished_runs, raw_messages


def bags_to_restore(log_directory: Path, node: str) -> list[Path]:
    """Bags of a node that nobody has mended yet and the newest of its others, oldest first.

    Several nodes may share a log directory; each goes on with what it recorded itself.

    A node mends bags only after it has put on record what they leave to it. So where nodes
    were killed while they started, their bags are here together with those before them.
    """
    try:
        dead = finished_runs(log_directory)
    except OSError:  # the repair that follows says so
        return []
    found: list[Path] = []
    newest = False
    for bag in reversed(dead):
        with suppress(OSError):
            finished = is_finished(bag)
            first = next(raw_messages(bag), None)
            if first is not None and first.node != node:
                continue
            if finished and (newest or first is None):
                continue
            newest = newest or finished
            found.insert(0, bag)
    return found
