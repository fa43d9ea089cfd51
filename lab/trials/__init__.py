"""Random searches, loads and attacks: `python -m lab.trials` runs all of them in a
short form.

What is set here holds for every process of a trial, before it imports the first
message: DDS within this machine, found quickly, and messages whose fields nobody
checks.
"""

import os
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

os.environ |= {
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    "ROS_PYTHON_CHECK_FIELDS": "0",
    "FASTRTPS_DEFAULT_PROFILES_FILE": str(
        ROOT / "tests/contract/node/quick_discovery.xml"
    ),
}
