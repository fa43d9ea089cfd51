"""A folder, a ROS domain and an environment that belong to one run of the benchmark."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import patch

from domain_coordinator import domain_id


@contextmanager
def surroundings() -> Iterator[Path]:
    """Set up the environment of this process and its children; gives an empty folder."""
    with tempfile.TemporaryDirectory(prefix="ros_pose_stats_") as name, _domain() as domain:
        folder = Path(name)
        own = {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
               "ROS_LOG_DIR": str(folder / "ros_log"), "ROS_PYTHON_CHECK_FIELDS": "0"}
        with patch.dict(os.environ, own):
            yield folder


@contextmanager
def _domain() -> Iterator[int]:
    """A domain that nobody else on this machine uses; `domain_id` would swallow an OSError."""
    reserved = domain_id()
    number = reserved.__enter__()
    try:
        yield number
    finally:
        reserved.__exit__(None, None, None)


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0))
