"""Command line of the soak of the node."""

import os

os.environ["ROS_PYTHON_CHECK_FIELDS"] = "0"  # read when the first message is imported

from .run import main

if __name__ == "__main__":
    raise SystemExit(main())
