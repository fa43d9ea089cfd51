"""Command line of the benchmark of the node."""

import os

os.environ["ROS_PYTHON_CHECK_FIELDS"] = "0"  # read when the first message is imported

from .measure import main

main()
