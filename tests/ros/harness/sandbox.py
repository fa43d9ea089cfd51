"""A home of the node's own, in which nothing but its bags and logs may appear."""

from __future__ import annotations

import os
from pathlib import Path

ELSEWHERE = [Path("/etc/x"), Path("/tmp/x"), Path("/x"), Path("/x.mcap")]
"""Where some names point to."""


class Sandbox:
    """Home, folder for temporary files and working directory of a node.

    Parameters
    ----------
    root : Path
    """

    def __init__(self, root):
        self.root = root
        self.bags = root / "deep" / "er" / "bags"
        self.work = root / "work"
        self.environment = {"HOME": str(root / "home"), "TMPDIR": str(root / "tmp"),
                            "ROS_HOME": str(root / "ros"), "ROS_LOG_DIR": str(root / "ros_log"),
                            "XDG_CACHE_HOME": os.environ.get("XDG_CACHE_HOME")
                            or str(Path.home() / ".cache")}  # where the kernels are
        for name in ("home", "tmp", "ros", "ros_log", "work"):
            (root / name).mkdir()

    def listing(self):
        """All files and directories but bags and the middleware's log."""
        own = (self.bags, self.root / "ros_log")
        inside = {path for path in self.root.rglob("*")
                  if not any(path.is_relative_to(one) for one in own)}
        return inside | {path for path in ELSEWHERE if path.exists()}

    def names_in_bags(self):
        """Names of everything in the log directory."""
        return {path.name for path in self.bags.rglob("*")}
