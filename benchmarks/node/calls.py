"""Service calls as contenders of a race, and the end of what they set going."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ros_pose_stats_msgs import srv

from ..results import Row, Target
from ..timing import Contender, Timings
from . import jobs
from .client import Client
from .spread import p99, spread

START, OTHERS = 10.0, 50.0  # milliseconds


class Calls:
    """Makes contenders; before each call the last one's doing is undone, untimed.

    Parameters
    ----------
    client : Client
    """

    def __init__(self, client: Client) -> None:
        self._client = client
        self._started = self._coming = ""

    def query(self, name: str, kind: type, service: str,
              request: Callable[[], Any]) -> Contender:
        """A call that leaves nothing behind."""
        def prepare() -> Any:
            self._settle()
            return request()

        return Contender(name, lambda made: self._client.call(kind, service, made), prepare)

    def get(self, name: str, job_id: str) -> Contender:
        """How far a job is."""
        return self.query(name, srv.GetDropSimulation, "get_drop_simulation",
                          lambda: srv.GetDropSimulation.Request(job_id=job_id))

    def get_statistics(self, name: str, part_id: str) -> Contender:
        """What is latched for a part."""
        return self.query(name, srv.GetStatistics, "get_statistics",
                          lambda: srv.GetStatistics.Request(part_id=part_id))

    def list(self, name: str) -> Contender:
        """All jobs."""
        return self.query(name, srv.ListDropSimulations, "list_drop_simulations",
                          srv.ListDropSimulations.Request)

    def estimate(self, name: str, part_id: str) -> Contender:
        """An estimate of a known part."""
        return self.query(name, srv.EstimatePoses, "estimate",
                          lambda: srv.EstimatePoses.Request(part_id=part_id))

    def start(self, name: str, request: Callable[[], Any], new_part: bool = False) -> Contender:
        """A start; the job is cancelled later, and a new part's estimate waited for."""
        plain = self.query(name, srv.StartDropSimulation, "start_drop_simulation", request)

        def prepare() -> Any:
            made = plain.prepare()
            if new_part:
                self._client.forget_latched()
                self._coming = made.part_id
            return made

        def call(made: Any) -> None:
            self._started = jobs.accepted(plain.call(made)).job_id

        return Contender(name, call, prepare)

    def _settle(self) -> None:
        if self._started:
            jobs.cancel(self._client, self._started)
            jobs.wait_for_end(self._client, self._started)
        if self._coming:
            self._client.spin_until(lambda: self._client.has_latched(self._coming), "estimate")
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
    return Row(name, {**spread(seconds), "times bare": timings.ratio(key, bare)},
               () if key == bare else (Target("p99, ms", p99(seconds), bound),))
