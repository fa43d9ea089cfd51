"""The ROS 2 node `pose_stats`: parts, jobs, services, state and bags."""
