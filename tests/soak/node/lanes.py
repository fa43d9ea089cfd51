"""What clients do all the time, each lane one thing after the other."""

from __future__ import annotations

from itertools import count
from typing import Any

from rclpy.serialization import serialize_message
from ros_pose_stats_msgs import srv
from ros_pose_stats_msgs.action import SimulateDrops
from ros_pose_stats_msgs.msg import PartMesh, PoseCounts
from shape_msgs.msg import Mesh

from benchmarks.node.jobs import DONE
from benchmarks.node.mesh_to_estimate import CAD_TOPIC, PART_TOPIC, rounded

from ...fuzz.messages.message_seeds import HOSTILE, Seeds
from ...fuzz.messages.messages import fuzzed
from .bodies import BODIES, METHODS, RESTITUTIONS, counted
from .life import COUNT_TOPIC, Lane, Life
from .tally import NOT_RECORDED, Simulated

SEEDS = (1, 2)
DROPS = (100, 700)
LONG = 10**6
NEVER = 2**31

_numbers = count(1)


def estimates(life: Life) -> Lane:
    """Parts carried, analytic answers compared."""
    while True:
        number, method = life.chance.randrange(len(BODIES)), life.chance.choice(METHODS)
        restitution = life.chance.choice(RESTITUTIONS)
        answer = yield from life.ask(srv.EstimatePoses, "estimate", srv.EstimatePoses.Request(
            part=BODIES[number].message(), method=method, restitution=restitution))
        if not answer.success:
            life.tally.wrong.append(f"estimate: {answer.message}")
            continue
        life.tally.told(answer.statistics)
        found = {pose.index: pose.probability for pose in answer.statistics.poses}
        life.tally.estimates.append(((number, method, restitution), found))
        yield 0.02 * life.chance.random()


def jobs(life: Life) -> Lane:
    """Simulations by the services; some are cancelled on the way."""
    while True:
        number, long = life.chance.randrange(len(BODIES)), life.chance.random() < 0.3
        wanted = _wanted(life, number, LONG if long else life.chance.choice(DROPS))
        request = srv.StartDropSimulation.Request(part=BODIES[number].message(), **_fields(wanted))
        answer = yield from life.ask(srv.StartDropSimulation, "start_drop_simulation", request)
        if not answer.success:
            life.tally.refuse(answer.message)
            yield 0.1
            continue
        _accept(life, answer)
        if long:
            yield 0.3 * life.chance.random()
            yield from life.ask(srv.CancelDropSimulation, "cancel_drop_simulation",
                                srv.CancelDropSimulation.Request(job_id=answer.job_id))
        yield from _follow(life, answer.job_id, wanted)


def goals(life: Life) -> Lane:
    """The same by the action."""
    action = life.action
    while True:
        number, long = life.chance.randrange(len(BODIES)), life.chance.random() < 0.3
        wanted = _wanted(life, number, LONG if long else life.chance.choice(DROPS))
        goal = SimulateDrops.Goal(part=BODIES[number].message(), **_fields(wanted))
        handle = yield from life.wait(lambda goal=goal: action.send_goal_async(
            goal, feedback_callback=lambda _: None), "goal")
        coming = handle.get_result_async()
        if long:
            yield 0.3 * life.chance.random()
            yield from life.wait(handle.cancel_goal_async, "cancel of a goal")
        result = (yield from life.wait(lambda coming=coming: coming, "result")).result
        if not result.job_id:
            life.tally.refuse(result.message)
            yield 0.1
        else:
            _end(life, result, result.job_id, wanted)


def failing_jobs(life: Life) -> Lane:
    """A mesh that takes a while to be found bad, so that its job fails."""
    body = rounded(2000)
    while True:
        yield 2.0
        request = srv.StartDropSimulation.Request(drops=10)
        request.part = BODIES[0].message(f"bad_{next(_numbers)}")
        vertices = body.vertices.copy()
        vertices[7] = float("nan")
        request.part.vertices.frombytes(vertices.tobytes())
        request.part.triangles.frombytes(
            (body.triangles + len(BODIES[0].vertices)).astype("<u4").tobytes())
        answer = yield from life.ask(srv.StartDropSimulation, "start_drop_simulation", request)
        if answer.success:
            life.tally.faults["job that fails"] += 1
            _accept(life, answer)
            yield from _follow(life, answer.job_id, None)
        else:
            life.tally.refuse(answer.message)


def published(life: Life) -> Lane:
    """Meshes on the topics: good ones until they are latched, and bad ones in between."""
    bad = fuzzed(PartMesh, life.number, NEVER)
    bad_meshes = fuzzed(Mesh, life.number, NEVER)
    while True:
        body = life.chance.choice(BODIES)
        life.publish(PART_TOPIC, bytes(serialize_message(body.message())), "mesh")
        life.publish(PART_TOPIC, next(bad), "fuzzed mesh")
        life.publish(CAD_TOPIC, next(bad_meshes), "fuzzed mesh")
        while True:
            answer = yield from life.ask(srv.GetStatistics, "get_statistics",
                                         srv.GetStatistics.Request(part_id=body.part_id))
            if body.part.digest in [one.part_digest for one in answer.statistics]:
                break
            yield 0.01
        yield 0.02


def counts(life: Life) -> Lane:
    """A camera that counts, and sometimes sends rubbish."""
    bad = fuzzed(PoseCounts, life.number, NEVER)
    while True:
        body = life.chance.choice(BODIES)
        life.publish(COUNT_TOPIC, bytes(serialize_message(PoseCounts(
            part_id=body.part_id, part_digest=body.part.digest, cluster_tolerance=0.0025,
            round_sides=192, index=[0, 1], count=[3, 4]))), "count")
        life.publish(COUNT_TOPIC, next(bad), "fuzzed count")
        yield 0.2


def forgotten(life: Life) -> Lane:
    """Parts that come and go."""
    while True:
        part_id = f"passing_{next(_numbers)}"
        answer = yield from life.ask(srv.EstimatePoses, "estimate", srv.EstimatePoses.Request(
            part=life.chance.choice(BODIES).message(part_id)))
        life.tally.told(answer.statistics)
        request = srv.ForgetPart.Request(part_id=part_id)
        for expected in (True, False):
            answer = yield from life.ask(srv.ForgetPart, "forget_part", request)
            if answer.success != expected:
                life.tally.wrong.append(f"forget_part {part_id}: {answer.message or 'again'}")
        yield 0.1


def hostile(life: Life) -> Lane:
    """Requests with values that nobody means."""
    seeds = Seeds(life.chance)
    kinds = ((srv.EstimatePoses, "estimate"), (srv.GetStatistics, "get_statistics"),
             (srv.ForgetPart, "forget_part"), (srv.GetDropSimulation, "get_drop_simulation"),
             (srv.CancelDropSimulation, "cancel_drop_simulation"))
    while True:
        kind, name = life.chance.choice(kinds)
        answer = yield from life.ask(kind, name, seeds.make(kind.Request))
        if not answer.success:
            life.tally.refuse(answer.message)
        elif kind is srv.EstimatePoses:
            life.tally.told(answer.statistics)
        yield HOSTILE * 0.1


def listing(life: Life) -> Lane:
    """Whoever looks on."""
    while True:
        yield from life.ask(srv.ListDropSimulations, "list_drop_simulations",
                            srv.ListDropSimulations.Request())
        yield 0.05


ALL = (estimates, jobs, jobs, goals, goals, failing_jobs, published, counts, forgotten, hostile,
       listing)


def _wanted(life: Life, number: int, drops: int) -> Simulated:
    return Simulated(number, life.chance.choice(RESTITUTIONS), life.chance.choice(SEEDS), drops, 0)


def _fields(wanted: Simulated) -> dict[str, Any]:
    return {"drops": wanted.asked, "restitution": wanted.restitution, "seed": wanted.seed}


def _accept(life: Life, answer: Any) -> None:
    if NOT_RECORDED not in answer.message:
        life.tally.accepted.add(answer.job_id)


def _follow(life: Life, job_id: str, wanted: Simulated | None) -> Lane:
    """Ask until a job has ended."""
    while True:
        found = yield from life.ask(srv.GetDropSimulation, "get_drop_simulation",
                                    srv.GetDropSimulation.Request(job_id=job_id))
        if not found.success:
            life.tally.wrong.append(f"get {job_id}: {found.message}")
            return
        if found.state >= DONE:
            break
        yield 0.01
    if wanted is None:
        if found.state != srv.GetDropSimulation.Response.FAILED:
            life.tally.wrong.append(f"{job_id} with a bad mesh ended with state {found.state}")
    else:
        _end(life, found, job_id, wanted)


def _end(life: Life, answer: Any, job_id: str, wanted: Simulated) -> None:
    """Note what came of a job; one that was cancelled at once has nothing to show."""
    statistics, tally = answer.statistics, life.tally
    if statistics.drops and tally.told(statistics):
        tally.ends[job_id] = statistics.drops
    elif not statistics.drops and NOT_RECORDED not in answer.message:
        tally.ends[job_id] = 0
    tally.simulated += 1
    if statistics.drops:
        key, found = wanted._replace(drops=statistics.drops), counted(statistics)
        if tally.simulations.setdefault(key, found) != found:
            tally.wrong.append(f"{key} gave other counts before")
