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

"""Kill -9 at any moment, on a sound disk, on one that fills, and while bags go and
come.
"""

import random
import shutil
import subprocess
import time
from contextlib import contextmanager, suppress

from tests.contract.node.harness.bags import bags_of

from ..frame import Outcome, Setting
from ..soak.life import PREFIX, Life, node_of
from . import traffic
from .ledger import PLATE, Ledger
from .others import FilesOfOthers

KILLS = 100
SHARE_IN_START = 0.2
START_SECONDS = 4.0
LIFE_SECONDS = 5.0
DISK = 24
"""MiB of the disk that fills."""

STATE = f"{PREFIX.strip('/').replace('/', '.')}.sqlite3"
"""Of a node without another name for it, in its log directory."""


def _node(ledger, **values):
    return node_of(
        ledger.folder,
        plates=ledger.plates,
        plate=PLATE,
        max_parts=200,
        max_bag_bytes=2**22,
        **values,
    )


def _one_life(ledger, chance, lanes, look_back=True, meanwhile=None):
    """A start, which is looked at, and mixed traffic until a kill at a random
    moment.
    """
    node = _node(ledger, log_drops=chance.choice(("true", "false")))
    try:
        if chance.random() < SHARE_IN_START:
            time.sleep(START_SECONDS * chance.random())
            ledger.events["kills in a start"] += 1
            return
        life = Life(node, ledger, chance.random(), look_back)
        try:
            ledger.look_at(life.client)
            life.start(lanes)
            deadline = time.monotonic() + LIFE_SECONDS * chance.random() ** 2
            if meanwhile is not None:
                meanwhile(deadline)
            time.sleep(max(0.0, deadline - time.monotonic()))
        finally:
            life.end(kill=True)
            ledger.wrong += sound(node)
    finally:
        node.kill()


def sound(node):
    """What the node's log has of faults of the program."""
    signs = "Traceback", "internal failure", "[ERROR]", "[FATAL]", "terminate called"
    return [line for line in node.lines if any(sign in line for sign in signs)]


def _last_start(ledger, look_back=True):
    """A start after all kills, looked at in full, and a good end."""
    life = Life(_node(ledger), ledger, 0, look_back)
    try:
        ledger.look_at(life.client, every_job=True)
    finally:
        life.end(kill=False)


def _outcome(ledger, tried, note=""):
    words = ", ".join(
        f"{number} {name}" for name, number in sorted(ledger.events.items())
    )
    return Outcome(
        tried,
        list(dict.fromkeys(ledger.wrong)),
        f"{len(ledger.accepted)} jobs accepted, {len(ledger.ends)} ends, {words}{note}",
    )


def kills(setting: Setting) -> Outcome:
    """Kill -9 at random moments: parts, jobs, counts, forgetting, fits on one state
    file, beside files of somebody else.
    """
    ledger = Ledger(setting.folder / "log")
    others = FilesOfOthers(ledger.folder / STATE)
    chance = random.Random(setting.seed)
    number = setting.of(KILLS, 6)
    for _ in range(number):
        _one_life(ledger, chance, traffic.ALL)
        ledger.look_at_bags(sealed=False)
        ledger.wrong += others.touched()
    _last_start(ledger)
    ledger.look_at_bags(sealed=True)
    ledger.wrong += [*ledger.not_in([ledger.folder]), *ledger.unlike_the_library()]
    ledger.wrong += [*others.touched(), *others.leftovers()]
    if ledger.events["not recorded, and said so"]:
        ledger.wrong.append("the disk was sound, but NOT_RECORDED was said")
    return _outcome(ledger, number, f", {len(others)} files of others beside")


def bags_that_go(setting: Setting) -> Outcome:
    """Bags deleted, copied and renamed under a running node that is killed then."""
    ledger = Ledger(setting.folder / "log")
    chance = random.Random(setting.seed)
    number = setting.of(20, 2)

    def disturb(deadline):
        while time.monotonic() < deadline:
            bags = bags_of(ledger.folder)
            if bags:
                bag = chance.choice([*bags, bags[-1]])
                act = chance.randrange(3)
                with suppress(
                    FileNotFoundError, shutil.Error
                ):  # the node mends it meanwhile
                    if act == 0:
                        shutil.rmtree(bag)
                    elif act == 1:
                        bag.rename(
                            bag.with_name(f"{bag.name[:-1]}{chance.randrange(10)}x")
                        )
                    else:
                        shutil.copytree(
                            bag, bag.with_name(f"{bag.name}0"), dirs_exist_ok=True
                        )
                ledger.events["bags disturbed"] += 1
            time.sleep(0.3 * chance.random())

    for _ in range(number):
        _one_life(
            ledger, chance, traffic.WITHOUT_PLATES, look_back=False, meanwhile=disturb
        )
    _last_start(ledger, look_back=False)
    return _outcome(ledger, number)


@contextmanager
def small_disk(folder, mebibytes):
    """A file system of its own in a folder; why there is none, where that is not
    allowed.
    """
    folder.mkdir()
    process = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", f"size={mebibytes}m", "trial", folder],
        capture_output=True,
        text=True,
    )
    try:
        yield process.stderr.strip() if process.returncode else ""
    finally:
        if not process.returncode:
            subprocess.run(["umount", "--lazy", folder], check=True)


def a_disk_that_is_full(setting: Setting) -> Outcome:
    """A small disk that is filled and emptied under mixed traffic, and the node
    killed.
    """
    with small_disk(setting.folder / "disk", DISK) as problem:
        if problem:
            return Outcome(
                0, [f"not tried, since nothing can be mounted here: {problem}"]
            )
        ledger = Ledger(setting.folder / "disk" / "log", always_written=False)
        chance = random.Random(setting.seed)
        number = setting.of(20, 2)
        ballast = setting.folder / "disk" / "ballast"

        def fill(deadline):
            while time.monotonic() < deadline:
                time.sleep(chance.random())
                with suppress(OSError), ballast.open("ab", buffering=0) as file:
                    while True:
                        file.write(bytes(2**16 if chance.random() < 0.9 else 2**10))
                ledger.events["times full"] += 1
                time.sleep(chance.random())
                if chance.random() < 0.7:
                    ballast.unlink()

        for _ in range(number):
            _one_life(
                ledger, chance, traffic.WITHOUT_PLATES, look_back=False, meanwhile=fill
            )
            for bag in bags_of(ledger.folder)[:-2]:
                shutil.rmtree(bag)
        ballast.unlink(missing_ok=True)
        _last_start(ledger, look_back=False)
        return _outcome(ledger, number)
