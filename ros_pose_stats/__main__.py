"""`python -m ros_pose_stats` is the command `ros_pose_stats`."""

import sys

from .tools.cli import main

sys.exit(main())
