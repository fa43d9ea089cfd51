"""Round trips of the services while the node is idle, and while it drops on every
core.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from ros_pose_stats_msgs import srv
from ros_pose_stats_msgs.srv import CancelDropSimulation

from lab.bodies.curved import Body
from lab.frame.results import Row, Section, Target
from lab.frame.timing import Contender, Pace, Timings, race

from . import jobs
from .bare import SERVICE
from .client import Client
from .mesh_to_estimate import Fresh
from .processes import cores
from .spread import p99, spread

BARE = "bare rclpy service"
NEW = "new_mesh"

TIMED = (
    "Round trip of a call from this process, nothing else asked meanwhile; the calls "
    "take turns. `full load`: a drop simulation of the clamp runs on {workers} "
    "workers, as many as there are cores; what is started meanwhile waits in the queue "
    "and is cancelled. `get`, `list` and `start` stand for `get_drop_simulation`, "
    "`list_drop_simulations` and `start_drop_simulation`. The carried part has flat "
    "arrays of {triangles} triangles, in `new mesh` others each time. `"
    + BARE
    + "`: an empty service in a process of its own, by which "
    "the others are divided, round by round. The bounds are {start:g} ms for a start "
    "and {others:g} ms for the others, held against the 99th percentile; they are "
    "meant for disks on which a sync takes at most 2 ms, see above."
)


class Known(NamedTuple):
    """Parts that the node knows.

    Attributes
    ----------
    part_id : str
        Id of the part that is asked for, and dropped meanwhile.
    carried_id : str
    carried : Body
        Part that requests carry.
    """

    part_id: str
    carried_id: str
    carried: Body


def services(client: Client, parts: Known, pace: Pace) -> Section:
    """A row for each service, idle and under full load."""
    ended = jobs.start(client, jobs.start_request(parts.part_id, 100))
    jobs.wait_for_end(client, ended)
    idle = race(_contenders(client, parts, ended, 1), pace)
    with jobs.under_way(client, parts.part_id) as running:
        loaded = race(_contenders(client, parts, running, 100), pace)
    rows = [
        call_row(timings, key, f"{key}, {load}", BARE)
        for load, timings in (("idle", idle), ("full load", loaded))
        for key in timings.seconds
    ]
    return Section(
        "services",
        "Services",
        TIMED.format(
            workers=cores(),
            triangles=len(parts.carried.triangles),
            start=START,
            others=OTHERS,
        ),
        tuple(rows),
    )


def bare_call(calls: Calls) -> Contender:
    """The service that does nothing."""
    return calls.query(
        BARE, CancelDropSimulation, SERVICE, CancelDropSimulation.Request
    )


def _contenders(
    client: Client, parts: Known, job_id: str, drops: int
) -> list[Contender]:
    """All calls in the order of the table; `drops` are those of a job that is
    started.
    """
    calls = Calls(client)
    part_id = parts.part_id
    body = parts.carried
    fresh = Fresh(parts.carried)

    def again() -> Any:
        return jobs.carry(
            jobs.start_request(parts.carried_id, drops),
            parts.carried_id,
            body.vertices,
            body.triangles,
        )

    def new() -> Any:
        return jobs.carry(jobs.start_request(NEW, drops), NEW, fresh(), body.triangles)

    return [
        bare_call(calls),
        calls.get("get", job_id),
        calls.get_statistics("get_statistics", part_id),
        calls.list("list"),
        calls.estimate("estimate, known part", part_id),
        calls.start("start, known part", lambda: jobs.start_request(part_id, drops)),
        calls.start("start, carried part", again),
        calls.start("start, carried part, new mesh", new, new_part=True),
    ]


START = 10.0
OTHERS = 50.0  # milliseconds


class Calls:
    """Maker of contenders; before each call the effect of the last one is undone,
    untimed.

    Parameters
    ----------
    client : Client
    """

    def __init__(self, client: Client) -> None:
        self._client = client
        self._started = self._coming = ""

    def query(
        self, name: str, kind: type, service: str, request: Callable[[], Any]
    ) -> Contender:
        """A call that leaves nothing behind."""

        def prepare() -> Any:
            self._settle()
            return request()

        return Contender(
            name, lambda message: self._client.call(kind, service, message), prepare
        )

    def get(self, name: str, job_id: str) -> Contender:
        """Ask for the state of a job."""
        return self.query(
            name,
            srv.GetDropSimulation,
            "get_drop_simulation",
            lambda: srv.GetDropSimulation.Request(job_id=job_id),
        )

    def get_statistics(self, name: str, part_id: str) -> Contender:
        """Ask for the latched result of a part."""
        return self.query(
            name,
            srv.GetStatistics,
            "get_statistics",
            lambda: srv.GetStatistics.Request(part_id=part_id),
        )

    def list(self, name: str) -> Contender:
        """List all jobs."""
        return self.query(
            name,
            srv.ListDropSimulations,
            "list_drop_simulations",
            srv.ListDropSimulations.Request,
        )

    def estimate(self, name: str, part_id: str) -> Contender:
        """Estimate a known part."""
        return self.query(
            name,
            srv.EstimatePoses,
            "estimate",
            lambda: srv.EstimatePoses.Request(part_id=part_id),
        )

    def start(
        self, name: str, request: Callable[[], Any], new_part: bool = False
    ) -> Contender:
        """Start a job, cancel it later, and wait for the estimate of a new part."""
        plain = self.query(
            name, srv.StartDropSimulation, "start_drop_simulation", request
        )

        def prepare() -> Any:
            message = plain.prepare()
            if new_part:
                self._client.forget_latched()
                self._coming = message.part_id
            return message

        def call(message: Any) -> None:
            self._started = jobs.accepted(plain.call(message)).job_id

        return Contender(name, call, prepare)

    def _settle(self) -> None:
        if self._started:
            jobs.cancel(self._client, self._started)
            jobs.wait_for_end(self._client, self._started)
        if self._coming:
            self._client.spin_until(
                lambda: self._client.has_latched(self._coming), "estimate"
            )
        self._started = self._coming = ""


def call_row(timings: Timings, key: str, name: str, bare: str) -> Row:
    """A row of a table of calls, judged by the bound of such a call.

    Parameters
    ----------
    timings : Timings
    key : str
        The contender.
    name : str
        Of the row.
    bare : str
        Contender by which the others are divided; not judged itself.
    """
    seconds = timings.seconds[key]
    bound = START if key.startswith("start") else OTHERS
    return Row(
        name,
        {**spread(seconds), "times bare": timings.ratio(key, bare)},
        () if key == bare else (Target("p99, ms", p99(seconds), bound),),
    )
