"""From a mesh to the statistics of its poses: imports no ROS, matplotlib or mcap."""
