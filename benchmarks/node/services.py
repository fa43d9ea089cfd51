"""Round trips of the services, the node idle and at work on every core."""

from __future__ import annotations

from typing import Any, NamedTuple

from ros_pose_stats_msgs.srv import CancelDropSimulation

from ..bodies import Body
from ..results import Section
from ..timing import Contender, Pace, race
from . import jobs
from .bare import SERVICE
from .calls import OTHERS, START, Calls, call_row
from .client import Client
from .meshes import Fresh
from .surroundings import cores

BARE = "bare rclpy service"
NEW = "new_mesh"

TIMED = (
    "Round trip of a call from this process, nothing else asked meanwhile; the calls take turns. "
    "`full load`: a drop simulation of the clamp runs on {workers} workers, as many as there are "
    "cores; what is started meanwhile waits in the queue and is cancelled. `get`, `list` and "
    "`start` stand for `get_drop_simulation`, `list_drop_simulations` and "
    "`start_drop_simulation`. The carried part has flat arrays of {triangles} triangles, in `new "
    "mesh` others each time. `" + BARE + "`: an empty service in a process of its own, by which "
    "the others are divided, round by round. The bounds are {start:g} ms for a start and "
    "{others:g} ms for the others, held against the 99th percentile; they are meant for disks on "
    "which a sync takes at most 2 ms, see above.")


class Known(NamedTuple):
    """Parts that the node knows.

    Attributes
    ----------
    part_id : str
        Asked for, and dropped meanwhile.
    carried_id : str
    carried : Body
        What requests carry.
    """

    part_id: str
    carried_id: str
    carried: Body


def services(client: Client, known: Known, pace: Pace) -> Section:
    """A row for each service, idle and under full load."""
    ended = jobs.start(client, jobs.start_request(known.part_id, 100))
    jobs.wait_for_end(client, ended)
    idle = race(_contenders(client, known, ended, 1), pace)
    with jobs.under_way(client, known.part_id) as running:
        loaded = race(_contenders(client, known, running, 100), pace)
    rows = [call_row(timings, key, f"{key}, {when}", BARE)
            for when, timings in (("idle", idle), ("full load", loaded))
            for key in timings.seconds]
    return Section("services", "Services", TIMED.format(
        workers=cores(), triangles=len(known.carried.triangles), start=START,
        others=OTHERS), tuple(rows))


def bare_call(calls: Calls) -> Contender:
    """The service that does nothing."""
    return calls.query(BARE, CancelDropSimulation, SERVICE, CancelDropSimulation.Request)


def _contenders(client: Client, known: Known, job_id: str, drops: int) -> list[Contender]:
    """All calls, in the order of the table; `drops` of what is started."""
    calls, part_id, body, fresh = Calls(client), known.part_id, known.carried, Fresh(known.carried)

    def again() -> Any:
        return jobs.carry(jobs.start_request(known.carried_id, drops), known.carried_id,
                          body.vertices, body.triangles)

    def new() -> Any:
        return jobs.carry(jobs.start_request(NEW, drops), NEW, fresh(), body.triangles)

    return [bare_call(calls), calls.get("get", job_id),
            calls.get_statistics("get_statistics", part_id), calls.list("list"),
            calls.estimate("estimate, known part", part_id),
            calls.start("start, known part", lambda: jobs.start_request(part_id, drops)),
            calls.start("start, carried part", again),
            calls.start("start, carried part, new mesh", new, new_part=True)]
