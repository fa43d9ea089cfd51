"""Services with long answers: many poses, many jobs, a large mesh that is being received."""

from __future__ import annotations

import time
from statistics import median

from ros_pose_stats_msgs import srv

from ros_pose_stats import part_from_mesh

from ..bodies import Body
from ..results import Row, Section, Target
from ..timing import Pace, race
from . import jobs
from .client import Client
from .mesh_to_estimate import CAD_TOPIC, Fresh, mesh_bytes
from .services import BARE, OTHERS, Calls, bare_call, call_row
from .spread import p99, spread

MANY = "many_poses"
PAUSE = 0.002  # seconds

TIMED = (
    "As above, with a part of {poses} poses ({triangles} triangles), which is dropped under full "
    "load as well, and with {jobs} jobs known. Reading so many poses in the client is in the "
    "times. Last, `list` asked every {pause:g} ms while the otherwise idle node takes in a mesh "
    "of {large} triangles."
)


def limits(
    client: Client, part_id: str, body: Body, large: Body, number: int, pace: Pace
) -> Section:
    """Rows for each of the three.

    Parameters
    ----------
    client : Client
    part_id : str
        A known part, for the jobs.
    body : Body
        With many poses.
    large : Body
        With many triangles.
    number : int
        Of jobs.
    pace : Pace
    """
    jobs.make_known(client, MANY, body)
    known = client.call(
        srv.GetStatistics, "get_statistics", srv.GetStatistics.Request(part_id=MANY)
    )
    poses = len(jobs.accepted(known).statistics[0].poses)
    jobs.make_many(client, part_id, number)
    rows = [
        *_polled(client, large, pace),
        *_at_work(client, f"{poses} poses", f"{number} jobs", pace),
    ]
    return Section(
        "service_limits",
        "Services with much to tell",
        TIMED.format(
            poses=poses,
            triangles=len(body.triangles),
            jobs=number,
            pause=1e3 * PAUSE,
            large=len(large.triangles),
        ),
        tuple(rows),
    )


def _at_work(client: Client, poses: str, known: str, pace: Pace) -> list[Row]:
    calls = Calls(client)
    with jobs.under_way(client, MANY) as running:
        timings = race(
            [
                bare_call(calls),
                calls.get(f"get, {poses}", running),
                calls.get_statistics(f"get_statistics, {poses}", MANY),
                calls.estimate(f"estimate, {poses}", MANY),
                calls.list(f"list, {known}"),
                calls.start(f"start, {known}", lambda: jobs.start_request(MANY, 100)),
            ],
            pace,
        )
    return [
        call_row(timings, key, f"{key}, full load", BARE) for key in timings.seconds
    ]


def _polled(client: Client, large: Body, pace: Pace) -> list[Row]:
    """Calls while a mesh is received, for the patience of the pace."""
    calls = Calls(client)
    timings = race([bare_call(calls), calls.list("list")], pace)
    fresh = Fresh(large)
    until = time.monotonic() + pace.patience
    seconds: list[float] = []
    while not seconds or time.monotonic() < until:
        vertices = fresh()
        digest = part_from_mesh(vertices, large.triangles).digest
        data = mesh_bytes(vertices, large.triangles)
        client.forget_latched()
        client.publish(CAD_TOPIC, data)
        while not client.has_latched(digest):
            begin = time.perf_counter()
            client.call(
                srv.ListDropSimulations,
                "list_drop_simulations",
                srv.ListDropSimulations.Request(),
            )
            seconds.append(time.perf_counter() - begin)
            client.spin_for(PAUSE)
    return [
        Row(
            "list, large mesh coming",
            {**spread(seconds), "times bare": median(seconds) / timings.median(BARE)},
            (Target("p99, ms", p99(seconds), OTHERS),),
        )
    ]
