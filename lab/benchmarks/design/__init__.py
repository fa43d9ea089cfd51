"""How right the derivatives of `ros_pose_stats.tools.design` are, against drops."""
