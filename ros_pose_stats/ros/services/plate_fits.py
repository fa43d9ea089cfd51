"""The service `~/fit_plate`: a plate's scene out of what cameras have counted on it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ros_pose_stats_msgs.srv import FitPlate

from ... import errors, text
from ..answering_node import Steps
from ..base import Base
from ..lanes import Lane, Rank
from ..messages.part_requests import shown
from ..messages.statistics_messages import fill_bounds
from ..parts import count_store, known_part, result_store

if TYPE_CHECKING:
    from ...plates import PlateFit


class PlateFits:
    """Answers with fits, and applies them, one after the other in a lane of their own."""

    def __init__(self, base: Base, stores: result_store.Stores,
                 use_plate: Callable[[str], object]) -> None:
        self._settings, self._lanes = base.settings, base.lanes
        self._parts, self._counts, _, self._announcer = stores
        self._use_plate = use_plate
        self._log = base.node.get_logger()
        base.node.serve(FitPlate, "~/fit_plate", self.answer)

    def answer(self, request: Any, response: Any) -> Steps:
        """Fit, and work with what was found if that is wanted."""
        settings = self._settings()
        plate = request.plate or settings.plate
        if request.apply:
            from ...plates import refuse_name

            if not settings.plates:
                raise errors.RequestError("a file to write the plate into (parameter plates)",
                                          "none", "set the parameter, or ask without apply")
            refuse_name(plate)
        counted = counts_on(plate, settings.plate, self._parts.all())
        fit = yield self._lanes.put(partial(fit_counts, counted), Rank.KNOWN, Lane.FIT)
        fill_bounds(response, restitution=fit.restitution, drop_height=fit.drop_height,
                    round_sides=fit.round_sides)
        response.plate_error, response.p_value = fit.plate_error, fit.p_value
        response.counted = fit.counted
        response.parts = list(dict.fromkeys(part.part_id for part in fit.parts))
        response.message = (f"From {text.several(fit.counted, 'count')} of "
                            f"{text.several(len(fit.parts), 'part')} in {fit.seconds:.1f} s; "
                            f"{fit.verdict}")
        if request.apply:
            file, kept = yield self._lanes.put(partial(self._apply, plate, fit, settings.plates,
                                                       settings.plate), Rank.KNOWN, Lane.FIT)
            response.message += f"; written to {file} as {plate}, and used from now on"
            if not kept:
                response.message += f". {self._announcer.not_recorded().rstrip('.')}"
        response.message += "."
        self._log.info(f"~/fit_plate: effective restitution {fit.restitution[0]:.2f}, drop height "
                       f"{fit.drop_height[0]:.3g} m (-1: 20 radii). {response.message}")

    def _apply(self, plate: str, fit: PlateFit, *asked_under: str) -> tuple[Path, bool]:
        """Write the plate into its file and work with it; whether its counts are kept."""
        from ...plates import profile_of, write_profile

        now = self._settings()
        if (now.plates, now.plate) != asked_under:
            raise errors.RequestError("plates and plate as they were when the fit was asked for",
                                      "other parameters", "ask again")
        file = Path(now.plates).expanduser()
        try:
            write_profile(file, profile_of(plate, fit))
        except OSError as error:
            raise errors.RequestError("a file of plates that can be written (parameter plates)",
                                      f"{file} ({error.strerror or error})",
                                      "name another one") from error
        kept = self._counts.name_plate(plate)
        self._use_plate(plate)
        return file, kept


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


def fit_counts(counted: list[tuple[known_part.KnownPart, count_store.CellCounts]]) -> PlateFit:
    """Fit a plate to counts of parts, which are built for that where they are not yet."""
    from ...plates import count_part, fit_plate

    return fit_plate([
        count_part(known.part, dict(enumerate(seen.total.tolist())),
                   cluster_tolerance=seen.ground.numbering.cluster_tolerance,
                   round_sides=int(seen.ground.numbering.round_sides))
        for known, seen in counted])
