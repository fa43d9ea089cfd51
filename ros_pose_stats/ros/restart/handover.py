"""What earlier runs leave goes on record in the bag of this one, before anything else does."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from pathlib import Path

from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import JobEvent

from ...recording.reader.run_identity import identity_of
from ..messages.times import now, time_message
from ..parts.mesh_record import MeshRecord
from ..recorder import JOB_EVENTS, Recorder
from .earlier_runs import RUNS_TAKEN_IN, EarlierRuns, Taken


class Handover:
    """Records it once, when it is due or when the first other record comes.

    A start that finds nothing new can so leave it at that: its own bag begins when there is
    something to say, and the next start finds what this one has found.

    `records`: topic and message of all that they leave.
    """

    def __init__(self, recorder: Recorder, found: EarlierRuns,
                 records: Sequence[tuple[str, bytes]]) -> None:
        self._recorder = recorder
        self._found = found
        self._records = records
        self._lock = threading.RLock()
        self._busy = False
        self._mark = 0
        self.done = False

    def settle(self) -> bool:
        """Put it on record, unless it is; whether it is. Others wait meanwhile."""
        if self.done:
            return True
        with self._lock:
            if self._busy or self.done:  # a record of its own, or another thread was first
                return True
            self._busy = True
            try:
                self.done = self._write()
            finally:
                self._busy = False
            if self.done:
                self._records = ()
            return self.done

    def repeat(self, coming: Iterable[tuple[str, bytes]]) -> None:
        """Say again which runs were taken in, where the bag may not have it any more.

        All that is known must be in the bag by then.

        `coming`: topic and message of what is not known yet.
        """
        if (self.done and self._found.taken.up_to
                and self._mark < self._recorder.trusted_from):
            mark = self._recorder.mark
            if all(self._recorder.record(*record) for record in coming) and self._say(
                    self._found.taken):
                self._mark = mark

    def needs(self, bag: Path) -> bool:
        """Whether a bag is still to be handed over."""
        return not self.done and bag in self._found.bags.values()

    def _write(self) -> bool:
        if not self._found.bags:
            return True
        return (self._say(self._found.taken._replace(done=False))
                and all(self._recorder.record(*record) for record in self._records)
                and self._say(self._found.taken))

    def _say(self, taken: Taken) -> bool:
        event = JobEvent(event=RUNS_TAKEN_IN, message=taken.text())
        event.header.stamp = time_message(now())
        return self._recorder.record(JOB_EVENTS, serialize_message(event), durable=taken.done)


class RunsInUse:
    """Which runs must stay for the present, when the oldest make room.

    A run that holds meshes of known parts stays until they are in the bag of this run too.

    `have_recorded_again`: sees to it, elsewhere, that meshes in distrusted runs are recorded
    again.
    """

    def __init__(self, handover: Handover, meshes: MeshRecord,
                 have_recorded_again: Callable[[], object]) -> None:
        self._handover = handover
        self._meshes = meshes
        self._have_recorded_again = have_recorded_again

    def __call__(self, bag: Path) -> bool:
        """Whether a run is in use; then it is seen to that it will not be."""
        if self._handover.needs(bag):
            return True
        identity = None
        with suppress(OSError):
            identity = identity_of(bag)
        in_use = self._meshes.distrust(bag.name if identity is None else identity.run)
        if in_use:
            self._have_recorded_again()
        return in_use
