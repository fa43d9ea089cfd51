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

"""What clients do all the time, each lane one thing after the other until the life is
over.
"""

from itertools import count

import numpy as np
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.action import SimulateDrops
from ros_pose_stats_msgs.msg import PartMesh, PoseCounts
from shape_msgs.msg import Mesh

from tests.contract.node.harness.client import DONE, FAILED
from tests.contract.node.harness.parts import fine_box, flat

from ..fuzz.messages.mutations import fuzzed
from ..fuzz.messages.seeds import Seeds
from .told import METHODS, NOT_RECORDED, PARTS, RESTITUTIONS, SURFACES, Simulated

SEEDS = (1, 2)
DROPS = (100, 700)
LONG = 10**6
NEVER = 2**31
_numbers = count(1)


def carried(number, part_id=None):
    """A body as a client sends it."""
    return flat(SURFACES[number], f"part_{number}" if part_id is None else part_id)


def estimates(life, chance):
    """Parts carried, analytic answers compared."""
    while True:
        number = chance.randrange(len(PARTS))
        method = chance.choice(METHODS)
        restitution = chance.choice(RESTITUTIONS)
        answer = life.ask(
            "estimate", part=carried(number), method=method, restitution=restitution
        )
        if answer.success:
            life.told.result(answer.statistics)
            life.told.estimates.append(
                (
                    (number, method, restitution),
                    {pose.index: pose.probability for pose in answer.statistics.poses},
                )
            )
        else:
            life.told.wrong.append(f"estimate: {answer.message}")
        life.pause(0.02 * chance.random())


def _wanted(chance):
    """A body, a simulation of it, its fields, and whether it is to be cancelled."""
    long = chance.random() < 0.3
    simulated = Simulated(
        chance.randrange(len(PARTS)),
        chance.choice(RESTITUTIONS),
        chance.choice(SEEDS),
        LONG if long else chance.choice(DROPS),
        0,
    )
    return (
        simulated,
        {
            "part": carried(simulated.body),
            "drops": simulated.asked,
            "seed": simulated.seed,
            "restitution": simulated.restitution,
        },
        long,
    )


def _accepted(life, answer):
    """Whether a job was accepted; else why not is noted."""
    if not answer.job_id:
        life.told.refusal(answer.message)
        life.pause(0.1)
    return bool(answer.job_id)


def _started(life, **fields):
    """Start a job; its id if it was accepted."""
    answer = life.ask("start_drop_simulation", **fields)
    if not _accepted(life, answer):
        return ""
    if NOT_RECORDED not in answer.message:
        life.told.accepted.add(answer.job_id)
    return answer.job_id


def _ended(life, job_id):
    """What Get says of a job once it has ended."""
    while True:
        answer = life.ask("get_drop_simulation", job_id=job_id)
        if not answer.success or answer.status.state >= DONE:
            return answer
        life.pause(0.01)


def jobs(life, chance):
    """Simulations by the services; some are cancelled on the way."""
    while True:
        simulated, fields, long = _wanted(chance)
        job_id = _started(life, **fields)
        if not job_id:
            continue
        if long:
            life.pause(0.3 * chance.random())
            life.ask("cancel_drop_simulation", job_id=job_id)
        answer = _ended(life, job_id)
        if answer.success:
            life.told.end(job_id, simulated, answer)
        else:
            life.told.wrong.append(f"get {job_id}: {answer.message}")


def goals(life, chance):
    """The same by the action."""
    while True:
        simulated, fields, long = _wanted(chance)
        goal = SimulateDrops.Goal(**fields)
        handle = life.wait(
            life.run(
                lambda goal=goal: life.action.send_goal_async(
                    goal, feedback_callback=lambda _: None
                )
            ),
            "a goal",
        )
        coming = life.run(handle.get_result_async)
        if long:
            life.pause(0.3 * chance.random())
            life.wait(life.run(handle.cancel_goal_async), "the cancel of a goal")
        result = life.wait(coming, "a result").result
        if _accepted(life, result):
            life.told.end(result.job_id, simulated, result)


def failing_jobs(life, chance):
    """A mesh that takes a while to be found bad, so that its job fails."""
    vertices, triangles = fine_box(8000)
    vertices[7, 1] = np.nan
    while True:
        life.pause(1.0)
        job_id = _started(
            life, drops=10, part=flat((vertices, triangles), f"bad_{next(_numbers)}")
        )
        if job_id:
            answer = _ended(life, job_id)
            life.told.events["jobs that fail"] += 1
            if answer.status.state != FAILED:
                life.told.wrong.append(
                    f"{job_id} with a bad mesh has state {answer.status.state}"
                )


def published(life, chance):
    """Meshes on the topics: good ones until they are latched, and bad ones in
    between.
    """
    bad, bad_meshes = (
        fuzzed(kind, chance.randrange(2**31), NEVER) for kind in (PartMesh, Mesh)
    )
    while True:
        number = chance.randrange(len(PARTS))
        life.publish("part_mesh", bytes(serialize_message(carried(number))))
        life.publish("part_mesh", next(bad))
        life.publish("cad", next(bad_meshes))
        life.told.events["messages published"] += 3
        while PARTS[number].digest not in [
            statistics.part_digest
            for statistics in life.ask(
                "get_statistics", part_id=f"part_{number}"
            ).statistics
        ]:
            life.pause(0.01)
        life.pause(0.02)


def counts(life, chance):
    """A camera that counts, and sometimes sends rubbish."""
    bad = fuzzed(PoseCounts, chance.randrange(2**31), NEVER)
    while True:
        number = chance.randrange(len(PARTS))
        life.publish(
            "pose_counts",
            PoseCounts(
                part_id=f"part_{number}",
                index=[0, 1],
                count=[3, 4],
            ),
        )
        life.publish("pose_counts", next(bad))
        life.told.events["messages published"] += 2
        life.pause(0.2)


def forgotten(life, chance):
    """Parts that come and go."""
    while True:
        part_id = f"passing_{next(_numbers)}"
        answer = life.ask(
            "estimate", part=carried(chance.randrange(len(PARTS)), part_id)
        )
        life.told.result(answer.statistics)
        for expected in (True, False):
            answer = life.ask("forget_part", part_id=part_id)
            if answer.success != expected:
                life.told.wrong.append(
                    f"forget_part {part_id}: {answer.message or 'again'}"
                )
        life.pause(0.1)


def hostile(life, chance):
    """Requests with values that nobody means."""
    seeds = Seeds(chance)
    while True:
        name = chance.choice(
            (
                "estimate",
                "get_statistics",
                "forget_part",
                "get_drop_simulation",
                "cancel_drop_simulation",
            )
        )
        answer = life.send(name, seeds.make(life.client.service(name).srv_type.Request))
        if not answer.success:
            life.told.refusal(answer.message)
        elif name == "estimate":
            life.told.result(answer.statistics)
        life.pause(0.03)


def listing(life, chance):
    """Whoever looks on."""
    while True:
        life.ask("list_drop_simulations")
        life.pause(0.05)


ALL = (
    estimates,
    jobs,
    jobs,
    goals,
    goals,
    failing_jobs,
    published,
    counts,
    forgotten,
    hostile,
    listing,
)
