"""Which earlier runs a node that starts takes in, each of them once.

A run that has taken in others says so on `/pose_stats/job_events`: first that it begins, and
once all that they leave is on record, that it is done, with the newest of them (`up_to`). Names
in order are runs in order, so that one name stands for all before it, and what is copied, renamed
or put back later is known by the name inside its files. Runs that could not be read then, or were
still being written, are named one by one.
"""

from __future__ import annotations

import json
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from ros_pose_stats_msgs.msg import JobEvent

from ...files import is_locked
from ...recording.finished import is_finished
from ...recording.reader.raw_reader import raw_messages
from ...recording.reader.run_identity import bags_in, identity_of
from .recorded_messages import read_recorded

RUNS_TAKEN_IN = 7
"""Kind of `JobEvent` whose message is a `Taken`."""

JOB_EVENT = "ros_pose_stats_msgs/msg/JobEvent"

class Taken(NamedTuple):
    """Which runs need not be read any more."""

    done: bool  # whether all that they leave is on record; false where that begins
    up_to: str  # the newest of them
    but: tuple[str, ...] = ()  # older ones that were not taken in

    def text(self) -> str:
        """As it is recorded."""
        return json.dumps(self._asdict())

    def covers(self, run: str) -> bool:
        """Whether a run was taken in."""
        return run <= self.up_to and run not in self.but


def taken_from(text: str) -> Taken:
    """What was recorded; ValueError, TypeError or KeyError for other texts."""
    found = json.loads(text)
    return Taken(bool(found["done"]), str(found["up_to"]), tuple(map(str, found["but"])))


@dataclass
class EarlierRuns:
    """What a node finds in its log directory."""

    bags: dict[str, Path]  # those to be read, oldest first, by what they are called inside
    taken: Taken  # what can be said of them once all that they leave is on record
    settled: bool  # whether the next start would find the same if nothing were recorded


def earlier_runs(log_directory: Path, node: str) -> EarlierRuns:
    """The runs of a node that no later one has taken in, back to the one that took in all before.

    Several nodes may share a log directory; each goes on with what it recorded itself. Of a run
    that was copied the largest copy is read.
    """
    dead, others = _runs_of(log_directory, node)
    base, taken = _newest_done(dead)
    wanted = {run: bag for run, bag in dead.items() if run == base or not taken.covers(run)}
    newest = max((taken.up_to, *wanted))
    return EarlierRuns(wanted, Taken(True, newest, tuple(sorted(
        run for run in others if run <= newest))), len(wanted) < 2 and all(
            _is_finished(bag) for bag in wanted.values()))


def _runs_of(log_directory: Path, node: str) -> tuple[dict[str, Path], set[str]]:
    """Runs of a node that nobody holds, oldest first, and names of those out of reach."""
    dead: dict[str, list[Path]] = {}
    others = set()
    try:
        bags = bags_in(log_directory)
    except OSError:  # the repair that follows says so
        return {}, set()
    for bag in bags:
        try:
            identity = identity_of(bag)
            locked = is_locked(bag)
        except OSError:
            others.add(bag.name)
            continue
        if locked and (identity is None or identity.node == node):
            others.add(bag.name if identity is None else identity.run)
        elif identity is not None and identity.node == node:
            dead.setdefault(identity.run, []).append(bag)
    return {run: max(dead[run], key=lambda bag: (_size(bag), bag.name == run))
            for run in sorted(dead) if run not in others}, others


def _newest_done(dead: dict[str, Path]) -> tuple[str, Taken]:
    """The newest run that is known to have taken in those before it, and what it says.

    Runs of versions that did not say so took in all before them if they were mended or ended.
    """
    for run in reversed(dead):
        said = _last_said(dead[run])
        if said is not None and said.done:
            return run, said
        if said is None and _is_finished(dead[run]):
            unfinished = [one for one in dead if one < run and not _is_finished(dead[one])]
            return run, Taken(True, run, tuple(unfinished))
    return "", Taken(True, "")


def _last_said(bag: Path) -> Taken | None:
    """What a run says of those before it: the first that is done, else that it began to."""
    begun = None
    with suppress(OSError):
        for message in raw_messages(bag):
            if message.type_name != JOB_EVENT:
                continue
            with suppress(Exception):  # of the bindings, about damage; reading it in will tell
                event = read_recorded(message, JobEvent)
                if event.event == RUNS_TAKEN_IN:
                    begun = taken_from(event.message)
                    if begun.done:
                        break
    return begun


def _is_finished(bag: Path) -> bool:
    with suppress(OSError):
        return is_finished(bag)
    return False


def _size(bag: Path) -> int:
    size = 0
    with suppress(OSError):
        size = sum(path.stat().st_size for path in bag.iterdir())
    return size
