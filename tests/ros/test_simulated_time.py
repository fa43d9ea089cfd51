"""A node on simulated time."""

from __future__ import annotations

import itertools

from builtin_interfaces.msg import Time
from rosgraph_msgs.msg import Clock

from .harness.cell import Health, cell_of
from .harness.client import until
from .harness.jobs import finished, start
from .harness.parts import WEDGE, flat


def test_simulated_time_that_nobody_publishes(domain, tmp_path):
    """Ready, healthy and answering; the stamps are those of a clock that stands at 0."""
    with cell_of(domain, tmp_path, "timeless", use_sim_time=True) as (_, client):
        Health(client).line("jobs")
        found = client.good("estimate", part=flat(WEDGE, "wedge")).statistics
        assert (found.header.stamp.sec, found.header.stamp.nanosec) == (0, 0)
        finished(client, start(client, "wedge", 200))
        with client.late_joiner() as joiner:
            joiner.wait("wedge")


def test_stamps_follow_simulated_time(domain, tmp_path):
    with cell_of(domain, tmp_path, "simulated", use_sim_time=True) as (_, client):
        clock = client.node.create_publisher(Clock, "/clock", 1)
        until(lambda: clock.get_subscription_count() > 0, "the node")

        def stamp(part_id):
            clock.publish(Clock(clock=Time(sec=1234)))
            return client.good("estimate", part=flat(WEDGE, part_id)).statistics.header.stamp.sec

        numbers = itertools.count()
        until(lambda: stamp(f"wedge_{next(numbers)}") == 1234, "the node's clock")
