"""A planner and a camera to begin one's own with; each file stands for itself."""
