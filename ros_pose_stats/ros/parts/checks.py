"""Estimates checked by drops beside them: for those who ask first, else while no mesh waits."""

import threading
from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from contextlib import suppress
from functools import partial

from ros_pose_stats_msgs.msg import PoseStatistics

from ...errors import PoseStatsError
from ...records import DropScene
from ..settings import Settings
from . import part_store, result_store
from .known_part import KnownPart, at_hand
from .lanes import Lane, Lanes, Rank

Key = tuple[str, str, DropScene]


class Checks:
    """Checks estimates in a lane of their own, equal ones once; `refine` comes after a check."""

    def __init__(self, settings: Callable[[], Settings], parts: part_store.PartStore,
                 results: result_store.ResultStore, lanes: Lanes,
                 refine: Callable[[KnownPart], object],
                 report_failure: Callable[[str], object]) -> None:
        self._settings, self._parts, self._results = settings, parts, results
        self._lanes, self._refine, self._report_failure = lanes, refine, report_failure
        self._coming: dict[Key, Future[PoseStatistics]] = {}
        self._shown: dict[str, None] = {}  # names of parts that are shown anew, in their order
        self._follows = False  # whether the next one of them is in the lane
        self._lock = threading.Lock()

    def begin(self, known: KnownPart, scene: DropScene) -> Future[PoseStatistics]:
        """Have a built part's estimate checked; new parts come before scenes of known ones."""
        with self._lock:
            message = self._results.checked(known, scene)
            if message is not None:
                return at_hand(message)
            key = known.part_id, known.digest, scene
            coming = self._coming.get(key)
            if coming is None:
                rank = Rank.SENT if known.part_id in self._shown else Rank.KNOWN
                coming = self._lanes.put(partial(self._check, known, scene), rank, Lane.CHECK)
                if not coming.done():
                    self._coming[key] = coming
            return coming

    def follow(self, known: KnownPart) -> None:
        """Have what a part shows checked, where it is an estimate alone, and then refined."""
        if not self._results.lacks_check(known):
            self._refine(known)
            return
        with self._lock:
            if len(self._shown) > 2 * self._settings().max_parts:  # of a flood of new parts
                self._shown = {other.part_id: None for other in self._parts.all()
                               if other.part_id in self._shown}
            self._shown[known.part_id] = None
            follows, self._follows = self._follows, True
        if not follows:
            self._lanes.put(self._check_next, Rank.LATER, Lane.CHECK)

    def _check_next(self) -> None:
        with self._lock:
            name = next(iter(self._shown))
            del self._shown[name]
        known = self._parts.current(name)
        if known is not None:
            with suppress(Exception):  # has been reported
                self._check(known, self._settings().scene(known.scene_override))
            with suppress(PoseStatsError):  # the node ends
                self._refine(known)
        with self._lock:
            self._follows = bool(self._shown)
        if self._follows:
            self._lanes.put(self._check_next, Rank.LATER, Lane.CHECK)

    def _check(self, known: KnownPart, scene: DropScene) -> PoseStatistics:
        try:
            return self._results.check(known, scene, lambda: self._lanes.closed)
        except (PoseStatsError, CancelledError):
            raise
        except Exception as error:
            self._report_failure(f"an estimate of {known.part_id!r} could not be checked: "
                                 f"{type(error).__name__}: {error}")
            raise
        finally:
            with self._lock:
                self._coming.pop((known.part_id, known.digest, scene), None)
