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

"""Plates that are fitted to what cameras counted: the service `~/fit_plate`."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ros_pose_stats_msgs.srv import FitPlate

from ...base.errors import RequestError
from ...base.text import several
from ..answering_node import Steps, result_of
from ..equipment import Equipment
from ..lanes import Lane, Rank
from ..messages import part_requests
from ..messages.codes import NotFoundError
from ..messages.statistics_messages import fill_bounds
from ..parts.known_part import KnownPart
from ..parts.part_counts import Tally
from ..parts.registry import PartRegistry

if TYPE_CHECKING:
    from ...core.plates import PlateFit


class PlateFits:
    """Answers with fits, and applies them, one by one in a lane of their own."""

    def __init__(
        self,
        equipment: Equipment,
        parts: PartRegistry,
        use_plate: Callable[[str], object],
    ) -> None:
        self._equipment = equipment
        self._parts = parts
        self._use_plate = use_plate
        equipment.node.serve(FitPlate, "fit_plate", self.answer)

    def answer(self, request: Any, response: Any) -> Steps[None]:
        """Fit, and work with what was found if that is wanted."""
        settings = self._equipment.settings()
        lanes = self._equipment.lanes
        plate = request.plate or settings.plate
        if request.apply:
            from ...core.plates import refuse_name

            if not settings.plates:
                raise RequestError(
                    "a file to write the plate into (parameter plates)",
                    "none",
                    "set the parameter, or ask without apply",
                )
            refuse_name(plate)
        tallies = find_tallies(
            plate, settings.plate, self._parts.all(), self._equipment.node.full_name
        )
        fit = yield from result_of(
            lanes.put(partial(fit_counts, tallies), Rank.KNOWN_PART, Lane.FIT)
        )
        fill_bounds(
            response,
            restitution=fit.restitution,
            drop_height=fit.drop_height,
            round_sides=fit.round_sides,
        )
        response.plate_error = fit.plate_error
        response.p_value = fit.p_value
        response.counted = fit.total
        response.parts = list(dict.fromkeys(part.part_id for part in fit.parts))
        is_recorded = True
        response.message = (
            f"From {several(fit.total, 'count')} of "
            f"{several(len(fit.parts), 'part')} in {fit.seconds:.1f} s; "
            f"{fit.verdict}"
        )
        if request.apply:
            file, is_recorded = yield from result_of(
                lanes.put(
                    partial(self._apply, plate, fit, settings.plates, settings.plate),
                    Rank.KNOWN_PART,
                    Lane.FIT,
                )
            )
            response.message += f"; written to {file} as {plate}, and used from now on"
        response.message += "."
        if not is_recorded:
            self._equipment.say_unrecorded(response)
        self._equipment.node.get_logger().info(
            f"fit_plate: effective restitution {fit.restitution[0]:.2f}, drop height "
            f"{fit.drop_height[0]:.3g} m (-1: 20 radii). {response.message}"
        )

    def _apply(self, plate: str, fit: PlateFit, *parameters: str) -> tuple[Path, bool]:
        """Write the plate to its file and work with it; whether that is recorded."""
        from ...core.plates import profile_of, write_profile

        settings = self._equipment.settings()
        if (settings.plates, settings.plate) != parameters:
            raise RequestError(
                "plates and plate as they were when the fit was asked for",
                "other parameters",
                "ask again",
            )
        file = Path(settings.plates).expanduser()
        try:
            write_profile(file, profile_of(plate, fit))
        except OSError as error:
            raise RequestError(
                "a file of plates that can be written (parameter plates)",
                f"{file} ({error.strerror or error})",
                "name another one",
            ) from error
        is_recorded = self._parts.name_plate(plate)
        self._use_plate(plate)
        return file, is_recorded


def find_tallies(
    plate: str,
    present: str,
    parts: Iterable[KnownPart],
    full_name: Callable[[str], str],
) -> list[tuple[KnownPart, Tally]]:
    """Known parts that were counted on a plate; a count without a name is of any."""
    counted = [
        (part, tally)
        for part in parts
        if (tally := part.counts.tally) is not None and tally.total.any()
    ]
    names = {plate} if present else {plate, ""}
    chosen = [(part, tally) for part, tally in counted if tally.ground.plate in names]
    if not chosen:
        others = sorted({tally.ground.plate for _, tally in counted})
        problem = "none"
        if others:
            quoted = map(part_requests.quote_text, others)
            problem = f"only those on {', '.join(quoted)}"
        raise NotFoundError(
            f"counts of known parts on plate {part_requests.quote_text(plate)}",
            problem,
            f"publish what cameras count there on {full_name('pose_counts')}, or what "
            f"they see on {full_name('observed_parts')}",
        )
    return chosen


def fit_counts(
    tallies: list[tuple[KnownPart, Tally]],
) -> PlateFit:
    """Fit a plate to counts of parts, which are built where they are not yet."""
    from ...core.plates import count_part, fit_plate

    return fit_plate(
        [
            count_part(
                part.geometry,
                dict(enumerate(tally.total.tolist())),
                **tally.ground.numbering._asdict(),
            )
            for part, tally in tallies
        ]
    )
