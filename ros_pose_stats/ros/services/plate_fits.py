"""The service `~/fit_plate`: a plate's scene out of what cameras have counted on it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ros_pose_stats_msgs.srv import FitPlate

from ... import errors, text
from ..messages.part_requests import shown
from ..parts import count_store, known_part, part_store
from ..parts.announcer import Announcer
from ..settings import Settings
from ..transport.answering_node import AnsweringNode
from . import requests, services

if TYPE_CHECKING:
    from ...plates import CountedPart, PlateFit

MOST_GROUPS = 256
"""Groups of poses of all parts of a fit, each of which takes it about a megabyte."""


class PlateFits:
    """Fits one plate at a time, in a thread of its own."""

    def __init__(self, node: AnsweringNode, settings: Callable[[], Settings],
                 parts: part_store.PartStore, counts: count_store.CountStore, announcer: Announcer,
                 use_plate: Callable[[str], object]) -> None:
        self._settings = settings
        self._parts, self._counts = parts, counts
        self._announcer = announcer
        self._use_plate = use_plate
        self._log = node.get_logger()
        self.say_failure = self._log.error
        self._lock = threading.Lock()
        self._closed = False
        self._done: float | None = None
        self._thread = threading.Thread()
        node.serve(FitPlate, "~/fit_plate", self.answer)

    @services.refusing
    def answer(self, request: Any, response: Any) -> services.Later:
        """Begin to fit; the answer comes when that is done."""
        settings = self._settings()
        plate = request.plate or settings.plate
        if request.apply:
            check_applicable(plate, settings)
        counts = counts_on(plate, settings.plate, self._parts.all())
        coming: Future[PlateFit] = Future()
        with self._lock:
            if self._closed:
                raise requests.ending()
            if self._done is not None:
                raise errors.RequestError("one fit at a time", "a request while another one is "
                                          f"{100.0 * self._done:.0f} % done", "ask again later")
            self._done = 0.0
            self._thread = threading.Thread(target=self._run, args=(counts, settings, coming),
                                            name="fit of a plate", daemon=True)
            self._thread.start()
        return services.Later(coming, partial(self._go_on, request, response, plate, coming))

    def close(self, seconds: float) -> bool:
        """Give the fit up; whether nothing is computed any more after that time."""
        with self._lock:
            self._closed = True
        if self._thread.ident is not None:
            self._thread.join(seconds)
        return not self._thread.is_alive()

    def _run(self, counts: list[tuple[known_part.KnownPart, count_store.CellCounts]],
             settings: Settings,
             coming: Future[PlateFit]) -> None:
        try:
            fit = self._fit(counts, settings)
        except BaseException as error:  # is the answer
            coming.set_exception(error)
        else:
            coming.set_result(fit)

    def _fit(self, counts: list[tuple[known_part.KnownPart, count_store.CellCounts]],
             settings: Settings) -> PlateFit:
        from ...plates import count_part, fit_plate

        until = time.monotonic() + settings.max_job_seconds
        counted = choose_counts(
            count_part(known.part, dict(enumerate(seen.total.tolist())),
                       cluster_tolerance=seen.ground.numbering.cluster_tolerance,
                       round_sides=int(seen.ground.numbering.round_sides))
            for known, seen in counts)
        fit = fit_plate(counted, workers=settings.threads(), on_progress=self._note,
                          should_stop=lambda: self._closed or time.monotonic() > until,
                          background=True)
        if self._closed:
            raise requests.ending()
        if fit is None:
            raise errors.RequestError(
                f"a fit within {settings.max_job_seconds:g} s (parameter max_job_seconds)",
                f"one that is {100.0 * (self._done or 0.0):.0f} % done by then",
                "raise the parameter, or fit the bags by the command fit")
        return fit

    def _note(self, share: float) -> None:
        self._done = share

    def _go_on(self, request: Any, response: Any, plate: str, coming: Future[PlateFit]) -> None:
        """Answer, and work with what was found if that is wanted."""
        try:
            fit = coming.result()
            fill_response(response, fit)
            response.message = (f"From {text.several(fit.counted, 'count')} of "
                                f"{text.several(len(fit.parts), 'part')}, and "
                                f"{text.several(fit.drops, 'drop')} in {fit.seconds:.1f} s")
            if request.apply:
                file, kept = self._apply(plate, fit)
                response.message += f"; written to {file} as {plate}, and used from now on"
                if not kept:
                    response.message += f". {self._announcer.not_recorded().rstrip('.')}"
            response.message += "."
            self._log.info(f"~/fit_plate: restitution {fit.restitution[0]:.2f}, drop height "
                           f"{fit.drop_height[0]:.3g} m. {response.message}")
        finally:  # before the answer leaves, which may bring the next request
            self._done = None

    def _apply(self, plate: str, fit: PlateFit) -> tuple[Path, bool]:
        """Write the plate into its file and work with it; whether its counts are kept."""
        from ...plates import profile_of, write_profile

        settings = self._settings()
        check_applicable(plate, settings)
        file = Path(settings.plates).expanduser()
        try:
            write_profile(file, profile_of(plate, fit))
        except OSError as error:
            raise errors.RequestError("a file of plates that can be written (parameter plates)",
                                      f"{file} ({error.strerror or error})",
                                      "name another one") from error
        kept = self._counts.name_plate(plate)
        self._use_plate(plate)
        return file, kept


def check_applicable(plate: str, settings: Settings) -> None:
    """Refuse a plate that cannot be written and used."""
    from ...plates import refuse_name

    if not settings.plates:
        raise errors.RequestError("a file to write the plate into (parameter plates)", "none",
                                  "set the parameter, or ask without apply")
    refuse_name(plate)


def counts_on(plate: str, present: str,
              parts: Iterable[known_part.KnownPart]
              ) -> list[tuple[known_part.KnownPart, count_store.CellCounts]]:
    """Known parts that were counted on a plate; what was counted without a name is of any."""
    counted = [(known, counts) for known in parts
               if (counts := known.counts) is not None and counts.total.any()]
    names = {plate, present} if not present else {plate}
    chosen = [(known, seen) for known, seen in counted if seen.ground.plate in names]
    if not chosen:
        others = sorted({seen.ground.plate for _, seen in counted})
        raise errors.RequestError(
            f"counts of known parts on plate {shown(plate)}",
            f"only those on {', '.join(map(shown, others))}" if others else "none",
            "publish what cameras count there on ~/pose_counts, or what they see on "
            "~/observed_parts")
    return chosen


def choose_counts(counted: Iterable[CountedPart]) -> list[CountedPart]:
    """The parts that were counted most, as far as there is room for them."""
    chosen: list[CountedPart] = []
    left = MOST_GROUPS
    for part in sorted(counted, key=lambda part: -part.counted):
        groups = part.by_group.size
        if groups <= left:
            chosen.append(part)
            left -= groups
    if not chosen:
        raise errors.RequestError(f"a part with at most {MOST_GROUPS} groups of poses", "none",
                                  "count a part of a simpler shape on this plate")
    return chosen


def fill_response(response: Any, fit: PlateFit) -> None:
    """Put what was found, with the bounds, into a response."""
    for name in ("restitution", "drop_height", "round_sides"):
        for end, value in zip(("", "_low", "_high"), getattr(fit, name), strict=True):
            setattr(response, name + end, value)
    response.plate_error, response.p_value = fit.plate_error, fit.p_value
    response.counted = fit.counted
    response.parts = list(dict.fromkeys(part.part_id for part in fit.parts))
