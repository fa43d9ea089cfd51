"""Repairs the bags of a log directory again and again, until it is killed.

    python -S -m tests.recording.repairer LOG_DIRECTORY

prints `ready`, and waits for a line on standard input before it begins.
"""

from __future__ import annotations

import sys
from pathlib import Path

from ros_pose_stats.recording.repair.repair import repair_bags

if __name__ == "__main__":
    print("ready", flush=True)
    sys.stdin.readline()
    repair_bags(Path(sys.argv[1]))
    print("done", flush=True)
