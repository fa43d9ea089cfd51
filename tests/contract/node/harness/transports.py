"""Environments by which a process speaks DDS within this machine."""

from pathlib import Path

PROFILES = Path(__file__).parents[1]

SHARED_MEMORY = {
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    "FASTRTPS_DEFAULT_PROFILES_FILE": str(PROFILES / "quick_discovery.xml"),
}
"""As a user's: the middleware adds shared memory, whatever else it is told.

A process that is killed leaves that memory behind. Where there is much of it, Fast DDS
complains on the standard output of others, in whatever domain they are.
"""

LOOPBACK = {
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT",  # as the file has it
    "FASTRTPS_DEFAULT_PROFILES_FILE": str(PROFILES / "loopback.xml"),
}
"""UDP alone, of which nothing stays and nobody else hears."""
