"""How right the derivatives and the suggestions of `ros_pose_stats.design` are, against drops."""
