"""How right the derivatives and the suggestions of `ros_pose_stats.tools.design` are, against drops."""
