"""One life of the node: its process, a client, and lanes of calls that go on side by side."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Generator, Sequence
from pathlib import Path
from random import Random
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from ros_pose_stats_msgs.msg import PartMesh, PoseCounts
from shape_msgs.msg import Mesh

from benchmarks.node.client import OWN, Client
from benchmarks.node.mesh_to_estimate import CAD_TOPIC, PART_TOPIC
from benchmarks.node.processes import Child

from .tally import Sample, Tally

COUNT_TOPIC = f"{OWN}/pose_counts"
PATIENCE = 60.0
"""Seconds after which an answer counts as missing."""

SAMPLE_SECONDS = 2.0
LAST_SECONDS = 0.05

Lane = Generator[Any, None, None]
LaneMaker = Callable[["Life"], Lane]


def node(folder: Path, clock: Path) -> Child:
    """The node with small bags, so that they are often followed by others."""
    values = {"log_directory": folder, "workers": 1, "max_bag_bytes": 2**20, "max_parts": 40,
              "max_drops": 10**7, "mesh_topics": f"[cad={CAD_TOPIC}]", "refine_drops": 200}
    given = [word for name, value in values.items() for word in ("-p", f"{name}:={value}")]
    return Child("tests.soak.node.shifted_clock", str(clock), "--ros-args", *given)


class Life:
    """Drives the lanes in the calling thread.

    Parameters
    ----------
    child : Child
        The node, which is ready.
    client : Client
    action : ActionClient
    tally : Tally
    chance : Random
    number : int
        Of this life.
    began : float
        Of the soak, by the monotonic clock.
    """

    def __init__(self, child: Child, client: Client, action: Any, tally: Tally, chance: Random,
                 number: int, began: float) -> None:
        self.child, self.client, self.action = child, client, action
        self.tally, self.chance = tally, chance
        self.number, self._began, self._born = number, began, time.monotonic()
        self._next_sample = 0.0
        self._lanes: dict[Lane, tuple[Any, float]] = {}
        self._health: dict[str, str] = {}
        for kind, topic in ((PartMesh, PART_TOPIC), (Mesh, CAD_TOPIC), (PoseCounts, COUNT_TOPIC)):
            client.connect(kind, topic)
        client.node.create_subscription(DiagnosticArray, "/diagnostics", self._hear, 10)

    def start(self, makers: Sequence[LaneMaker]) -> None:
        """Begin with lanes."""
        self._lanes.update({make(self): (0.0, time.monotonic()) for make in makers})

    def ask(self, kind: type, name: str, request: Any) -> Generator[Any, None, Any]:
        """Call a service; the answer."""
        service = self.client.service(kind, f"{OWN}/{name}")
        return (yield from self.wait(lambda: service.call_async(request), name))

    def wait(self, send: Callable[[], Any], name: str) -> Generator[Any, None, Any]:
        """Send something and wait for what comes."""
        begin = time.perf_counter()
        future = send()
        yield future
        self.tally.seconds[name].append(time.perf_counter() - begin)
        return future.result()

    def publish(self, topic: str, data: bytes, kind: str) -> None:
        """Publish a serialised message."""
        self.client.publish(topic, data)
        self.tally.messages[kind] += 1

    def run_for(self, seconds: float) -> None:
        """Go on for a time."""
        until = time.monotonic() + seconds
        while (now := time.monotonic()) < until:
            self.client.spin_for(0.001)
            for lane in [lane for lane, waits in self._lanes.items() if _over(*waits, now)]:
                self._step(lane, now)
            if now >= self._next_sample:
                self._next_sample = now + SAMPLE_SECONDS
                self._sample(now)

    def end(self) -> None:
        """No answer comes any more."""
        self.tally.cut += sum(not isinstance(what, float) for what, _ in self._lanes.values())
        for lane in self._lanes:
            lane.close()
        self._lanes.clear()
        for name in ("refused", "overrun"):
            self.tally.diagnostics[name] += int(self._health.get(name, 0))

    def last_words(self) -> None:
        """Take in what a killed node had sent."""
        self._next_sample = math.inf
        self.run_for(LAST_SECONDS)

    def _step(self, lane: Lane, now: float) -> None:
        what, since = self._lanes[lane]
        if not isinstance(what, float) and not what.done() and now - since >= PATIENCE:
            self.tally.wrong.append(f"no answer within {PATIENCE:.0f} s in {lane.__name__}")
            del self._lanes[lane]
            return
        try:
            self._lanes[lane] = next(lane), now
        except StopIteration:
            del self._lanes[lane]

    def _sample(self, now: float) -> None:
        status = Path(f"/proc/{self.child.pid}/status").read_text(encoding="utf-8")
        size, threads = (int(status.partition(f"{name}:")[2].split()[0])
                         for name in ("VmRSS", "Threads"))
        self.tally.samples.append(Sample(now - self._began, now - self._born, self.number,
                                         1024 * size, threads))

    def _hear(self, message: Any) -> None:
        for line in message.status:
            self._health.update({pair.key: pair.value for pair in line.values})


def _over(what: Any, since: float, now: float) -> bool:
    """Whether a lane can go on: its time has come, its answer, or none for too long."""
    if isinstance(what, float):
        return now >= since + what
    return bool(what.done()) or now - since >= PATIENCE
