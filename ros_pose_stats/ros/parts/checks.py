"""Estimates checked by drops beside them: for those who ask first, else while no mesh waits."""

import threading
from collections.abc import Callable
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from typing import NamedTuple

from ros_pose_stats_msgs.msg import PoseStatistics

from ...errors import PoseStatsError, RequestError
from ...records import DropScene
from ..settings import Settings
from . import part_store, result_store
from .known_part import KnownPart, at_hand

MOST_WAITING = 256  # checks that are asked for; each takes some 50 ms
PAUSE = 0.05  # seconds between looks at whether meshes still wait
LAST_SECONDS = 0.5  # a check may go on for so long when the node ends


class _Check(NamedTuple):
    """An estimate to be checked, and where that goes."""

    known: KnownPart
    scene: DropScene
    answer: Future[PoseStatistics]

    @property
    def key(self) -> tuple[str, str, DropScene]:
        """What is equal for all who want the same check."""
        return self.known.part_id, self.known.digest, self.scene


class Checks:
    """Checks one estimate after the other in a thread of its own.

    `is_quiet`: whether no mesh waits that is soon done; `refine`: called with each part that is
    shown anew, once its estimate is checked where that is wanted.
    """

    def __init__(self, settings: Callable[[], Settings], parts: part_store.PartStore,
                 results: result_store.ResultStore, is_quiet: Callable[[], bool],
                 refine: Callable[[KnownPart], object],
                 say_failure: Callable[[str], object]) -> None:
        self._settings, self._parts, self._results = settings, parts, results
        self._is_quiet, self._refine, self._say_failure = is_quiet, refine, say_failure
        self._checks: dict[tuple[str, str, DropScene], _Check] = {}
        self._shown: dict[str, None] = {}  # names of parts that are shown anew, in their order
        self._closed = False
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="checks", daemon=True)

    def start(self) -> None:
        """Begin to work."""
        self._thread.start()

    def begin(self, known: KnownPart, scene: DropScene) -> Future[PoseStatistics]:
        """Have a built part's estimate checked; raises RequestError where too many wait."""
        with self._changed:
            message = self._results.checked(known, scene)
            if message is not None:
                return at_hand(message)
            check = _Check(known, scene, Future())
            if check.key not in self._checks and len(self._checks) >= MOST_WAITING:
                raise RequestError(f"at most {MOST_WAITING} estimates waiting to be checked",
                                   f"{len(self._checks)}",
                                   "ask again in a moment, or for the method split alone")
            check = self._checks.setdefault(check.key, check)
            if self._closed:
                check.answer.cancel()
            self._changed.notify()
            return check.answer

    def follow(self, known: KnownPart) -> None:
        """Have what a part shows checked, where it is an estimate alone, and then refined."""
        if not self._results.lacks_check(known):
            self._refine(known)
            return
        with self._changed:
            if len(self._shown) > 2 * self._settings().max_parts:  # of a flood of new parts
                self._shown = {known.part_id: None for known in self._parts.all()
                               if known.part_id in self._shown}
            self._shown[known.part_id] = None
            self._changed.notify()

    def _next(self) -> tuple[_Check, bool] | None:
        """The next check, and whether a part shows it that is to be refined then."""
        with self._changed:
            while not self._closed:
                if self._checks:  # new parts before other scenes of known ones
                    checks = list(self._checks.values())
                    return next((check for check in checks
                                 if check.known.part_id in self._shown), checks[0]), False
                if self._shown and self._is_quiet():
                    name = next(iter(self._shown))
                    del self._shown[name]
                    known = self._parts.current(name)
                    if known is not None:  # who asks from now on shares the check
                        check = _Check(known, self._settings().scene(known.scene_override),
                                       Future())
                        self._checks[check.key] = check
                        return check, True
                else:
                    self._changed.wait(PAUSE if self._shown else None)
            return None

    def _run(self) -> None:
        while (waiting := self._next()) is not None:
            check, is_shown = waiting
            try:
                outcome: PoseStatistics | Exception = self._results.check(
                    check.known, check.scene, lambda: self._closed)
            except Exception as error:  # belongs to whoever asked
                outcome = error
                if not (isinstance(error, PoseStatsError) or self._closed):
                    self._say_failure(f"an estimate of {check.known.part_id!r} could not be "
                                      f"checked: {type(error).__name__}: {error}")
            with self._changed:
                self._checks.pop(check.key, None)
            with suppress(InvalidStateError):  # closed just now
                if isinstance(outcome, Exception):
                    check.answer.set_exception(outcome)
                else:
                    check.answer.set_result(outcome)
            if is_shown:
                with suppress(PoseStatsError):  # the node ends
                    self._refine(check.known)

    def close(self) -> None:
        """Check nothing any more; whoever waits is told that the node ends."""
        with self._changed:
            self._closed = True
            for check in self._checks.values():
                check.answer.cancel()
            self._changed.notify_all()
        if self._thread.is_alive():
            self._thread.join(LAST_SECONDS)
