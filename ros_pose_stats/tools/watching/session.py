# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""From one save to the next: read the part, estimate it, drop it as the file rests."""

import time
from collections.abc import Callable
from dataclasses import asdict, replace

from ...base import methods
from ...base.errors import PoseStatsError
from ...base.text import several
from ...core.estimators.estimate import estimate_in
from ...core.planning.auto import MOST_DROPS, answer_with_drops
from ...core.records import DropProgress, DropScene, Part
from ...core.records.scene import DEFAULT_SEED
from ...core.resting.poses import poses_in
from ...core.simulation.request import Watch, drop_request
from ..design.sensitivity import sensitivity
from . import page
from .followed_file import FollowedFile
from .news import NewsBoard
from .pushes import Pushes, describe_pushes
from .versions import History, Version

TARGET_ERROR = 0.005
"""To which drops bring the error over the poses: a designer sees half a point."""

PUBLISH_SECONDS = 0.5  # from one look at the drops to the next


class Session:
    """Follows a file, and has a page show each version of the part in it.

    Parameters
    ----------
    file : FollowedFile
    load : callable
        Reads the part.
    scene : DropScene
    history : History
    seed : int or None
        Of the drops.
    board : NewsBoard
        Takes what the page shows.
    tell : callable
        Takes a line for the terminal for each version.

    Raises
    ------
    RequestError
        If there is no such seed.
    """

    def __init__(
        self,
        file: FollowedFile,
        load: Callable[[], Part],
        scene: DropScene,
        history: History,
        seed: int | None,
        board: NewsBoard,
        tell: Callable[[str], object],
    ) -> None:
        self._file = file
        self._load = load
        self._scene = scene
        self._history = history
        self._request = drop_request(
            MOST_DROPS, DEFAULT_SEED if seed is None else seed, TARGET_ERROR
        )
        self._board = board
        self._tell = tell
        self._drawing: page.Drawing | None = None
        self._progress = ""
        self._trouble = ""
        # Of the present version: whether all drops are done, and what changes do.
        self._is_sharp = False
        self._pushes: Pushes | None = None

    def begin(self) -> None:
        """Show the file as it is, if it is there yet.

        Raises
        ------
        PoseStatsError
            If it holds no part, or the part lacks a wanted pose.
        """
        if self._file.take():
            self._show_version(_time_of_day())
            return
        self._trouble = f"There is no file {self._file.path} yet."
        self._tell(self._trouble)
        self._publish()

    def run(self, should_stop: Callable[[], bool]) -> None:
        """Drop the part while its file rests, and show it anew with every save."""
        while not should_stop():
            self._use_rest(lambda: should_stop() or self._file.is_saved_anew())
            if not self._file.wait_for_save(should_stop):
                return
            saved = _time_of_day()
            try:
                self._show_version(saved)
            except PoseStatsError as refusal:
                if not self._file.is_saved_anew():  # else it was read half-written
                    self._refuse(saved, refusal)

    def _show_version(self, saved: str) -> None:
        """Read, estimate and show what was saved."""
        part = self._load()
        current = self._history.current
        if current is not None and part.digest == current.part.digest:
            # Saved again as it was.
            self._trouble = ""
            self._publish()
            return
        estimate = estimate_in(part, self._scene, methods.AUTO)
        resting = poses_in(part, self._scene)
        version = self._history.add(part, resting, estimate, saved)
        self._drawing = page.draw_version(version)
        self._progress = f"by {estimate.method}, an estimate"
        self._trouble = ""
        self._is_sharp = False
        self._pushes = None
        self._publish()
        self._tell(self._describe(version))

    def _describe(self, version: Version) -> str:
        """A version in a line."""
        history = self._history
        share = 100.0 * history.share(version, version.estimate).value
        change = None
        if history.previous is not None:
            change = history.change_since(history.previous)
        return (
            f"{version.saved}  version {version.number}: "
            f"{several(len(version.keys), 'pose')}, {history.subject} "
            f"{f'{share:.1f} %' if change is None else change}"
        )

    def _refuse(self, saved: str, refusal: PoseStatsError) -> None:
        """Keep what is shown, and say why."""
        self._trouble = f"What was saved at {saved} is not shown: {refusal}."
        self._publish()
        self._tell(f"{saved}  not shown: {refusal}")

    def _use_rest(self, is_over: Callable[[], bool]) -> None:
        """Drop the part, then find where to push, while the file rests."""
        version = self._history.current
        if version is None:
            return
        if not self._is_sharp:
            self._drop(version, is_over)
        if self._is_sharp and self._history.has_feeder and self._pushes is None:
            self._find_pushes(version, is_over)

    def _drop(self, version: Version, is_over: Callable[[], bool]) -> None:
        """Drop the part until its numbers are sharp."""
        next_look = time.monotonic() + PUBLISH_SECONDS

        def report(progress: DropProgress) -> None:
            nonlocal next_look
            is_sharper = progress.drops > version.answer.drops
            if is_sharper and time.monotonic() >= next_look:
                next_look = time.monotonic() + PUBLISH_SECONDS
                self._history.sharpen(progress.statistics())
                self._progress = f"by {progress.drops} drops so far"
                self._publish()

        request = self._request
        if not version.part.error_known:
            request = replace(request, target_error=0.0)
        try:
            answer = answer_with_drops(
                version.estimate,
                version.part,
                self._scene,
                request,
                # The browser, and the CAD system, go first.
                Watch(on_progress=report, should_stop=is_over, background=True),
            )
        except PoseStatsError as refusal:  # drops that hardly end
            self._progress = f"{self._progress}; not dropped: {refusal}"
            self._is_sharp = True
            self._publish()
            return
        if not is_over():
            self._history.sharpen(answer)
            if answer.drops:
                self._progress = f"by {several(answer.drops, 'drop')}"
            self._is_sharp = True
            self._publish()

    def _find_pushes(self, version: Version, is_over: Callable[[], bool]) -> None:
        """Find which changes raise the accepted share."""
        wanted = version.poses_of(self._history.wanted_keys)
        if not (wanted and version.part.error_known):
            return
        try:
            sensitivities = sensitivity(
                version.part,
                wanted,
                seed=self._request.seed,
                should_stop=is_over,
                **asdict(self._scene),
            )
        except PoseStatsError:  # drops hardly end, which the page says
            return
        if not is_over():
            self._pushes = describe_pushes(sensitivities)
            self._publish()

    def _publish(self) -> None:
        """Have the page show what is known."""
        version = self._history.current
        name = self._file.path.name
        if version is None or self._drawing is None:
            self._board.publish(0, name, page.waiting_html(name, self._trouble), "")
            return
        share = self._history.share(version, version.answer)
        self._board.publish(
            version.number,
            f"{100.0 * share.value:.1f} % {self._history.subject}: {name}",
            page.version_html(
                self._history,
                version,
                self._drawing,
                self._progress,
                self._trouble,
                self._pushes,
            ),
            self._drawing.view,
            "" if self._pushes is None else self._pushes.colors,
        )


def _time_of_day() -> str:
    return time.strftime("%H:%M:%S")
