"""A node that has nothing to do leaves the processor to others."""

from __future__ import annotations

import os
import time
from pathlib import Path

WINDOW = 2.0


def processor_seconds(pid):
    """User and system time of a process so far."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def test_idle_costs_next_to_nothing(cell, shared_node):
    begin = time.monotonic()
    before = processor_seconds(shared_node.process.pid)
    time.sleep(WINDOW)
    used = processor_seconds(shared_node.process.pid) - before
    assert used < 0.5 * (time.monotonic() - begin)
