"""What a cell asks: `~/feeding`, what a feeder is to do, and `~/fit_plate`, on what plate."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ros_pose_stats_msgs.msg import PoseStatistics
from ros_pose_stats_msgs.srv import FeedingAnswer, FitPlate

from ...base.errors import RequestError
from ...base.text import several
from ...core.planning.feeding_plan import FeederCell, plan_feeding
from ...core.records import FlipStatistics, Index
from ...core.simulation.flips import check_kick, usual_kicks
from ...core.statistics import feeding, pose_groups
from ..answering_node import Steps
from ..equipment import Equipment
from ..jobs import FlipRequest, Jobs, State, run
from ..lanes import Lane, Rank, finished_future, refusal_at_end
from ..memory import Memory
from ..messages import part_messages, part_requests
from ..messages.statistics_messages import fill_bounds, statistics_of_message
from ..parts import intake, part_builder
from ..parts.known_part import KnownPart
from ..parts.part_counts import Tally
from ..parts.registry import PartRegistry

if TYPE_CHECKING:
    from ...core.plates import PlateFit

FLIP_SECONDS = (
    10.0  # longest that an answer flips for; the fewer flips, the wider its intervals
)
SEED = 1  # of the flips of an answer: the same question has the same answer
MOST_KICKS = 100
MOST_FLIPPED = 10_000  # parts, scenes and kicks that answers have flipped for


class FeedingService:
    """Answers from flips of its own `jobs`, or of goals if there are enough, or from none."""

    def __init__(
        self,
        equipment: Equipment,
        parts: PartRegistry,
        jobs: Jobs,
        reports: run.FlipReports,
        ways_in: intake.Intake,
        outlines: part_builder.Outlines,
    ) -> None:
        self._settings = equipment.settings
        self._ways_in = ways_in
        self._outlines = outlines
        self._parts = parts
        self._jobs = jobs
        self._reports = reports
        self._flipped: Memory[run.FlipKey, bool] = Memory(MOST_FLIPPED)
        equipment.node.serve(FeedingAnswer, "~/feeding", self.answer)

    def answer(self, request: Any, response: Any) -> Steps:
        """What to do and what a feeder gets, from the result that is latched now."""
        known = self._parts.require(request.part_id)
        settings = self._settings()
        result = known.latched
        if result is None:
            raise RequestError(
                "a part with a result",
                f"{part_requests.shown(request.part_id)} without one yet",
                "ask again in a moment",
            )
        latched = result.message
        scene = result.scene
        kick = settings.kick(request.kick_height)
        feeding.check_wanted_poses(request.wanted, len(latched.poses))
        feeding.check_rate(request.rate, request.cycle_time)
        cell = counted = None
        if request.plate_length != 0.0 or request.plate_width != 0.0:
            cell = FeederCell(
                request.rate,
                (request.plate_length, request.plate_width),
                request.clearance,
                request.cycle_time,
                request.pick_time,
                request.look_time,
                request.drop_time,
            )
            cell.check()
        if request.feeder_speed:
            counted = known.find_flips(latched, request.feeder_speed)
        heights = [kick] if kick else []
        if not kick and (cell is not None or counted is not None):
            heights = list(request.kick_heights) or list(usual_kicks(latched.radius))
        if len(heights) > MOST_KICKS:
            raise RequestError(
                f"at most {MOST_KICKS} kick_heights", f"{len(heights)}", "ask for fewer"
            )
        seconds = min(FLIP_SECONDS / max(1, len(heights)), settings.max_job_seconds)
        flips: list[FlipStatistics] = []
        job = None
        for height in sorted({check_kick(height) for height in heights}):
            key = run.flip_key(known.digest, scene, height)
            found = self._reports.counted.get(key)
            enough = run.flips_in_all(len(latched.poses), 0, settings)
            if found is None or (found.flips < enough and not self._flipped.get(key)):
                job = self._jobs.submit(
                    FlipRequest(
                        known.part_id,
                        known.content,
                        scene,
                        0,
                        SEED,
                        0.0,
                        seconds,
                        kick_height=height,
                    ),
                    finished_future(known),
                    settings,
                    has_room=job is not None,
                )
                yield job.finished
                found = job.flips
                if job.state is State.CANCELLED:  # nobody but the node itself cancels
                    raise refusal_at_end()
                if found is None:
                    response.success = False
                    response.message = job.message
                    return
                self._flipped.put(key, True)
            flips.append(found)
        yield from self._answer(request, response, known, latched, cell, flips, counted)

    def _answer(
        self,
        request: Any,
        response: Any,
        known: KnownPart,
        latched: PoseStatistics,
        cell: FeederCell | None,
        flips: list[FlipStatistics],
        counted: Index | None,
    ) -> Steps:
        """Fill in the plan, and what a feeder gets that kicks wrong parts or drops them afresh."""
        found = statistics_of_message(latched)
        dropped = pose_groups.pose_shares(found)
        basis = f"{latched.drops} drops" if latched.drops else "an estimate"
        if latched.observed:
            basis = f"{latched.observed} parts seen"
        basis = f"From {basis} ({latched.method})"
        if flips:
            basis += f" and {sum(kick.flips for kick in flips)} flips"
        if counted is not None:
            poses = tuple(found.by_index.values())
            flips = [
                feeding.learn_flips(
                    [replace(kick, poses=poses) for kick in flips],
                    counted,
                    request.feeder_speed,
                )
            ]
            basis += f" and {flips[0].observed} seen"
        chosen = flips[0] if flips else None
        if cell is not None:
            part = (yield self._ways_in.build_known(known)).geometry
            plan = yield self._outlines.put(
                part,
                "a plan",
                plan_feeding,
                found,
                list(request.wanted),
                cell,
                flips,
                part,
            )
            place = plan.options.index(plan.best)
            chosen = (
                flips[place - 1] if place else None
            )  # they are in that order, by height
            response.action = [
                getattr(response, action.upper()) for action in plan.actions
            ]
            response.parts_on_plate = plan.best.parts
            response.kicks = plan.best.kicks
            response.pickable = plan.best.pickable
            fill_bounds(response, parts_per_minute=plan.best.per_minute)
        if chosen is None:
            gain = feeding.drop_afresh(dropped, request.wanted, request.rate)
        else:
            gain = feeding.flip_wrong_poses(
                dropped, chosen.counts, request.wanted, request.rate, request.cycle_time
            )
            response.transition = part_messages.flat(chosen.transition)
            response.kick_height = chosen.kick_height
        fill_bounds(
            response,
            accepted=gain.accepted,
            passes=gain.passes,
            flips=gain.flips,
            accepted_per_minute=gain.per_minute,
        )
        if math.isnan(dropped.drops):
            basis += (
                f"; the error of {latched.method} is not known here, so there are no "
                f"intervals: simulate the part"
            )
        response.message = " ".join(
            [f"{basis}.", *pose_groups.warn_of_lookalikes(found, request.wanted)]
        )


class PlateFits:
    """Answers with fits, and applies them, one after the other in a lane of their own."""

    def __init__(
        self,
        equipment: Equipment,
        parts: PartRegistry,
        use_plate: Callable[[str], object],
    ) -> None:
        self._settings = equipment.settings
        self._lanes = equipment.lanes
        self._equipment = equipment
        self._parts = parts
        self._use_plate = use_plate
        self._log = equipment.node.get_logger()
        equipment.node.serve(FitPlate, "~/fit_plate", self.answer)

    def answer(self, request: Any, response: Any) -> Steps:
        """Fit, and work with what was found if that is wanted."""
        settings = self._settings()
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
        counted = counts_on(plate, settings.plate, self._parts.all())
        fit = yield self._lanes.put(
            partial(fit_counts, counted), Rank.KNOWN_PART, Lane.FIT
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
        response.message = (
            f"From {several(fit.total, 'count')} of "
            f"{several(len(fit.parts), 'part')} in {fit.seconds:.1f} s; "
            f"{fit.verdict}"
        )
        if request.apply:
            file, kept = yield self._lanes.put(
                partial(self._apply, plate, fit, settings.plates, settings.plate),
                Rank.KNOWN_PART,
                Lane.FIT,
            )
            response.message += f"; written to {file} as {plate}, and used from now on"
            if not kept:
                response.message += f". {self._equipment.not_recorded().rstrip('.')}"
        response.message += "."
        self._log.info(
            f"~/fit_plate: effective restitution {fit.restitution[0]:.2f}, drop height "
            f"{fit.drop_height[0]:.3g} m (-1: 20 radii). {response.message}"
        )

    def _apply(self, plate: str, fit: PlateFit, *asked_under: str) -> tuple[Path, bool]:
        """Write the plate into its file and work with it; whether its counts are kept."""
        from ...core.plates import profile_of, write_profile

        now = self._settings()
        if (now.plates, now.plate) != asked_under:
            raise RequestError(
                "plates and plate as they were when the fit was asked for",
                "other parameters",
                "ask again",
            )
        file = Path(now.plates).expanduser()
        try:
            write_profile(file, profile_of(plate, fit))
        except OSError as error:
            raise RequestError(
                "a file of plates that can be written (parameter plates)",
                f"{file} ({error.strerror or error})",
                "name another one",
            ) from error
        kept = self._parts.name_plate(plate)
        self._use_plate(plate)
        return file, kept


def counts_on(
    plate: str, present: str, parts: Iterable[KnownPart]
) -> list[tuple[KnownPart, Tally]]:
    """Known parts that were counted on a plate; what was counted without a name is of any."""
    counted = [
        (known, counts)
        for known in parts
        if (counts := known.counts.tally) is not None and counts.total.any()
    ]
    names = {plate, present} if not present else {plate}
    chosen = [(known, seen) for known, seen in counted if seen.ground.plate in names]
    if not chosen:
        others = sorted({seen.ground.plate for _, seen in counted})
        raise RequestError(
            f"counts of known parts on plate {part_requests.shown(plate)}",
            f"only those on {', '.join(map(part_requests.shown, others))}"
            if others
            else "none",
            "publish what cameras count there on ~/pose_counts, or what they see on "
            "~/observed_parts",
        )
    return chosen


def fit_counts(
    counted: list[tuple[KnownPart, Tally]],
) -> PlateFit:
    """Fit a plate to counts of parts, which are built for that where they are not yet."""
    from ...core.plates import count_part, fit_plate

    return fit_plate(
        [
            count_part(
                known.geometry,
                dict(enumerate(seen.total.tolist())),
                **seen.ground.numbering._asdict(),
            )
            for known, seen in counted
        ]
    )
