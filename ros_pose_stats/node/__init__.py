"""The ROS 2 node `pose_stats`: conversions, parameters, jobs and wiring around the core."""
