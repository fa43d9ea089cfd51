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

"""Lanes of clients whose acknowledgements are remembered in a ledger."""

from itertools import count

from tests.contract.node.harness.camera import counted as count_message
from tests.contract.node.harness.parts import fine_box, flat, library_part

from ..soak.lanes import estimates, goals, jobs
from ..soak.told import NOT_RECORDED
from .ledger import BOXES, DIGESTS, PLATE

FINE = [fine_box(8000, 0.04 + 0.001 * number) for number in range(3)]
"""Meshes that another process builds."""

FINE_DIGESTS = [library_part(surface).digest for surface in FINE]


def _taken(life, name, surface, digest):
    """Have a part taken by a request; what is told of it."""
    life.told.ask(name, digest)
    answer = life.ask("estimate", part=flat(surface, name), method="csae")
    if not answer.success:
        life.told.wrong.append(f"estimate of {name}: {answer.message}")
    elif life.told.result(answer.statistics):
        life.told.events["parts acknowledged"] += 1
    return answer.statistics


def replaced(life, chance):
    """Meshes that take each other's place under one name, some built by another
    process.
    """
    while True:
        number = chance.randrange(len(BOXES))
        _taken(life, "replaced", BOXES[number], DIGESTS[number])
        if chance.random() < 0.1:
            number = chance.randrange(len(FINE))
            _taken(life, "fine", FINE[number], FINE_DIGESTS[number])
        life.pause(0.05 * chance.random())


def by_topic(life, chance):
    """Meshes by the topic, which nobody acknowledges: one that was sent is there, or
    none.
    """
    while True:
        number = chance.randrange(len(BOXES))
        life.told.ask("topic", DIGESTS[number])
        life.publish("part_mesh", flat(BOXES[number], "topic"))
        life.pause(0.2 * chance.random())


def _latched(life, name):
    """What is latched of a part, once there is something."""
    while not (statistics := life.ask("get_statistics", part_id=name).statistics):
        life.pause(0.02)
    life.told.show(statistics[0])
    return statistics[0]


def _camera(life, chance, name):
    """A message of a camera, remembered before it is sent."""
    model = _latched(life, name)
    numbers = [chance.randrange(6) for _ in model.poses]
    message = count_message(model, numbers, plate=PLATE)
    record = life.told
    record.sent[message.header.stamp.sec] = (
        name,
        record.lives[name],
        dict(zip(message.index, numbers, strict=True)),
    )
    record.events["counts sent"] += 1
    life.publish("pose_counts", message)
    return sum(numbers)


def counted(life, chance):
    """Parts that stay, counted all the time."""
    names = "counted_0", "counted_1"
    for number, name in enumerate(names):
        _taken(life, name, BOXES[number], DIGESTS[number])
    while True:
        for _ in range(chance.randrange(1, 8)):
            _camera(life, chance, chance.choice(names))
        life.pause(0.1 * chance.random())


def forgotten(life, chance):
    """Parts that come, are counted, go and come again as they were."""
    for number in count(chance.randrange(3)):
        name = f"passing_{number % 3}"
        _taken(life, name, BOXES[2], DIGESTS[2])
        observed = _latched(life, name).counted_parts + _camera(life, chance, name)
        while _latched(life, name).counted_parts < observed:
            life.pause(0.02)
        life.told.ask(name, None)
        answer = life.ask("forget_part", part_id=name)
        if not answer.success:
            life.told.wrong.append(f"forget_part {name}: {answer.message}")
        elif NOT_RECORDED not in answer.message:
            life.told.allowed[name] = {None}
            life.told.events["parts forgotten"] += 1
        else:  # it may be gone, and what was counted of it
            life.told.shown[name] = 0
        if chance.random() < 0.5:
            _taken(life, name, BOXES[2], DIGESTS[2])


def fits(life, chance):
    """The plate fitted to what was counted, and used from then on."""
    while True:
        life.told.fitted = life.told.fitted | {None}
        answer = life.ask("fit_plate", plate=PLATE, apply=True)
        if answer.success:
            life.told.fitted = {(answer.restitution, answer.drop_height)}
            life.told.events["plates fitted"] += 1
        life.pause(chance.random())


ALL = estimates, jobs, goals, replaced, by_topic, counted, forgotten, fits
WITHOUT_PLATES = ALL[:-1]
